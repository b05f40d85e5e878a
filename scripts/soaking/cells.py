"""Random states of random plain weaves: each converges or is flagged, and none of a sample is wrong."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from tests.support.plain_weaves import INCREMENT_COUNT, Reference, half_cell, random_cell
from weavesim.run.fields import UNIT_CELL_FAILURE

# States at once, of how many cells, and how many of them an independent solver minimises too.
BATCH, CELL_COUNT, SAMPLE = 10_000, 250, 200
SMALLEST, LARGEST = 0.5, 1.3
# Of the forces of the sample, over the largest.
LARGEST_DIFFERENCE = 1.0e-6
LINE_COUNT = 20


def cells(folder: Path, count: int, seed: int) -> bool:
    """``count`` states, stretches of both yarns from 0.5 to 1.3, in batches."""
    rng, started = np.random.default_rng(seed), time.monotonic()
    flagged = wrong = silent = done = 0
    worst, batch_count = 0.0, max(1, -(-count // BATCH))
    for batch in range(batch_count):
        size = min(BATCH, count - done)
        kinds = [random_cell(rng) for _ in range(CELL_COUNT)]
        chosen = rng.integers(CELL_COUNT, size=size)
        stretch = rng.uniform(SMALLEST, LARGEST, (size, 2))
        response = half_cell([kinds[k] for k in chosen], stretch, increment_count=INCREMENT_COUNT)
        failed = ~(response.residual < UNIT_CELL_FAILURE)
        finite = np.isfinite(response.force).all(axis=1) & np.isfinite(response.height_change).all(axis=1)
        flagged += int(failed.sum())
        silent += int((~finite & ~failed).sum())
        sample = rng.choice(size, min(SAMPLE, size), replace=False)
        sample = sample[~failed[sample]]
        reference = Reference.of([kinds[k] for k in chosen[sample]])
        w = reference.follow(stretch[sample])
        force = reference.gradient((stretch[sample] - 1.0) * reference.spacing, w)[0]
        difference = np.abs(force - response.force[sample]).max(axis=1) / np.abs(force).max(axis=1)
        worst = max(worst, float(difference.max(initial=0.0)))
        for k in np.flatnonzero(~(difference < LARGEST_DIFFERENCE)):
            wrong += 1
            print(f"FAILED: {difference[k]:.2g} at {stretch[sample[k]].tolist()}: {kinds[chosen[sample[k]]].to_json()}")
        done += size
        if batch % max(1, batch_count // LINE_COUNT) == 0 or batch == batch_count - 1:
            print(f"{done:,} states, {flagged} flagged, {silent} not finite in silence, {wrong} wrong, largest "
                  f"difference of a force {worst:.1e}, {time.monotonic() - started:.0f} s", flush=True)  # fmt: skip
    return not wrong and not silent
