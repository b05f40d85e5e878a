"""Bending with a history: loops against the law's own path, what they lose against work minus energy."""

import numpy as np
import pytest

from tests.support.loops import SQUARE, cycle, loop_figure, rolled, walk
from weavesim.fabric.bending import BendingCurve, YarnBending


def test_bending_loop_follows_the_curve_and_books_what_it_loses(sheet, fabric, manual):
    """Softening and hysteresis of one family; the other family and the membrane stay silent."""
    law = BendingCurve(
        curvature=(0.0, 2.0, 5.0, 15.0), moment_values=(0.0, 0.03, 0.05, 0.07), friction_limit=0.01,
        friction_stiffness=0.02,
    )  # fmt: skip
    shell = sheet(SQUARE, fabric(bending=YarnBending(warp=law, weft=1e-3, twist=1e-3)))
    path = cycle(4.0, 100)
    entries = walk(shell, [rolled(curvature) for curvature in path])
    friction, slip = np.empty_like(path), 0.0
    # the curvature that one element sees between two directors: a chord of the arc
    size = 0.05
    seen = 2.0 / size * np.sin(0.5 * path * size)
    for i, kappa in enumerate(seen):
        slip = kappa - np.clip(kappa - slip, -law.friction_limit / 0.02, law.friction_limit / 0.02)
        friction[i] = 0.02 * (kappa - slip)
    expected = law.moment(seen) + friction
    area = 0.01
    work = np.array([entry["work"] for entry in entries])
    found = np.gradient(work, seen, edge_order=1)[[30, 99, 130, 199, 250]] / area
    assert found == pytest.approx(expected[[30, 99, 130, 199, 250]], rel=0.03, abs=3e-4)
    lost, stored = entries[-1]["bending_friction_loss"], entries[-1]["bending"]
    assert lost + stored == pytest.approx(area * np.trapezoid(expected, seen), rel=5e-3)
    assert lost + stored == pytest.approx(work[-1], rel=5e-3)
    assert entries[-1]["shear_friction_loss"] == 0.0
    case = manual(
        "Bending", "Softening and hysteresis of one yarn family",
        known="the moment-curvature table plus a spring-slider, integrated on the host, and the area of its loop",
    )  # fmt: skip
    case.table(
        ["quantity", "known", "weavesim"],
        [["lost and stored in the loop [J]", area * np.trapezoid(expected, seen), lost + stored]],
    )
    moving = np.flatnonzero(np.abs(np.diff(seen)) > 0.0)
    rate = np.diff(work)[moving] / np.diff(seen)[moving] / area
    case.figure(loop_figure(seen[moving], expected[moving], rate, "curvature [1/m]", "moment per width [N]"))
