"""Are the intervals of a calibration what they claim to be? A hundred random fabrics whose values are known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.coverage_study import Study
from tests.support.manual import Case

FABRIC_COUNT = 100


@pytest.mark.verification
def test_intervals_contain_the_true_values(tmp_path: Path, manual: Callable[..., Case]) -> None:
    study = Study.run(range(FABRIC_COUNT), tmp_path)
    coverage = {kind: study.coverage(kind) for kind in study.hits}
    assert 0.90 <= study.coverage() <= 0.99
    # values of one fabric are correlated: a kind may miss by two standard deviations of a hundred independent ones
    for kind, share in coverage.items():
        allowance = 2.0 * np.sqrt(0.95 * 0.05 / FABRIC_COUNT)
        assert 0.90 - allowance <= share <= 1.0, kind
    assert study.bad_fits <= 0.05 * FABRIC_COUNT * 3
    case = manual(
        chapter="Fabric tests",
        title="Intervals of a calibration",
        known="95 % intervals contain the true value in 95 % of calibrations; tests of random fabrics with noise",
    )
    rows = [
        [kind, len(study.hits[kind]), f"{100 * share:.1f} %"] for kind, share in coverage.items()
    ]  # fmt: skip
    case.table(["values", "intervals", "contain the true value"], [*rows, ["all", study.value_count,
        f"{100 * study.coverage():.1f} %"]])  # fmt: skip
    held = sum(study.held.values())
    case.text(
        f"{FABRIC_COUNT} fabrics, every property of each multiplied by a random factor of up to 1.3 to 3. Each has "
        "four biaxial ratios of strains, loops of a picture frame and bias extensions, with four specimens of each, "
        "and six cantilevers; every specimen is off by 2 %, every point by 1 % of the largest value, bending by 6 %. "
        f"The fits start from values that are off by up to a half. {held} values were held because the data of that "
        "fabric did not tell them (E I of the yarns, which is known to these fits)."
    )
