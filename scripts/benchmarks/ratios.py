"""Table of ratios of contestants that ran in turns."""

from __future__ import annotations

import numpy as np

from ..shared.report import table


def ratio_table(names: list[str], times: np.ndarray) -> str:
    """Medians, and ratios to the first contestant in paired turns with quartiles; times (turns, contestants) [ns]."""
    head = ["", "ns per element and step", "minimum", f"ratio to {names[0].split(':')[0]}", "quartiles"]
    rows = []
    for name, column in zip(names, times.T, strict=True):
        low, middle, high = np.quantile(column / times[:, 0], [0.25, 0.5, 0.75])
        rows.append(
            [name, f"{np.median(column):.0f}", f"{column.min():.0f}", f"{middle:.3f}", f"{low:.3f} to {high:.3f}"]
        )
    return table(head, rows)
