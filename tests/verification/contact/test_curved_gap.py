"""The gap over a curved ply, as the contact itself measures it (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.stacked_plies import FABRIC, pass_rows, ply, stack_setup
from weavesim import Simulation
from weavesim.process import Coulomb
from weavesim.sheet.blank import Blank

RADIUS, HEIGHT, HALF = 0.05, 5.0e-4, 0.03
# Of the plies, a little less than their distance [m].
THICKNESS = 4.8e-4


def on_sphere(blank: Blank, height: float) -> np.ndarray:
    """Nodes of a flat blank, moved along z onto a sphere ``height`` [m] outside that of the ply."""
    position = blank.node_position.copy()
    radius = RADIUS + height
    position[:, 2] = np.sqrt(radius**2 - position[:, 0] ** 2 - position[:, 1] ** 2) - RADIUS
    return position


def gaps(below: Blank, above: Blank, curved: bool) -> np.ndarray:
    """Gap of held nodes over a held ply, in the first steps of a run, (node_count,) [m]."""
    place = on_sphere if curved else lambda blank, height: blank.node_position + (0.0, 0.0, height)
    cloth = FABRIC.model_copy(update={"thickness": THICKNESS})
    sheets = [
        ply(
            name, Blank.from_mesh(place(blank, height), blank.quads), fabric=cloth,
            free=np.zeros((blank.node_count, 6), dtype=bool),
        )
        for name, blank, height in (("lower", below, 0.0), ("upper", above, HEIGHT))
    ]  # fmt: skip
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=1e-3, solver={"lane_count": 1}))
    run.stepper.advance(2)
    (k,) = [k for k, each in enumerate(run.model.passes) if each.place.slave == 1]
    return THICKNESS - pass_rows(run, k)["depth"]


def largest_error(size: float, distortion: float, curved: bool) -> float:
    """Of nodes well inside a ply of elements of ``size`` [m]."""
    below = Blank.rectangle((-HALF, -HALF), (HALF, HALF), size, distortion=distortion)
    above = Blank.rectangle((-0.011, -0.011), (0.0115, 0.012), 0.0015)
    return float(np.abs(gaps(below, above, curved) - HEIGHT).max())


@pytest.mark.verification
def test_the_gap_over_a_sphere(manual):
    """Known answer A: 0.5 mm over a sphere of 50 mm within 0.5 um, within 10 um with corners moved by a quarter."""
    rows = []
    for size in (0.01, 0.005, 0.0025):
        regular, distorted, flat = (
            largest_error(size, moved, curved) for moved, curved in ((0.0, True), (0.25, True), (0.25, False))
        )
        if size <= 0.005:
            assert regular < 5e-7 and distorted < 1e-5
        assert flat < 1e-12
        rows.append([1e3 * size, 1e6 * regular, 1e6 * distorted, f"{1e6 * flat:.0e}"])
    assert rows[0][1] > 14.0 * rows[1][1] > 196.0 * rows[2][1]  # of fourth order
    case = manual(
        "Contact", "The gap over a curved ply",
        known="Nodes 0.5 mm over a sphere of 50 mm radius, which is a ply of flat facets (120 um below the sphere for "
        "elements of 5 mm): the gap is right within 0.5 um, and within 10 um with corners moved by a quarter of an "
        "element. Over a plane it is exact.",
    )  # fmt: skip
    case.table(
        ["element size [mm]", "largest error [um]", "of a distorted mesh [um]", "of a distorted plane [um]"], rows
    )


def test_the_gap_does_not_jump_at_edges_of_facets():
    """Known answer A: continuous to 1e-9 m, on a row of nodes a tenth of a micrometre apart across an edge."""
    below, step = Blank.rectangle((-HALF, -HALF), (HALF, HALF), 0.005, distortion=0.25), 1.0e-7
    middle = below.quads[np.argmin(np.linalg.norm(below.node_position[below.quads].mean(axis=1), axis=1))]
    first, second = below.node_position[middle[1]], below.node_position[middle[2]]
    along = (second - first) / np.linalg.norm(second - first)
    across = np.array([along[1], -along[0], 0.0])
    row = Blank.rectangle((-20.0 * step, 0.0), (20.0 * step, step), step)
    x, y, _ = row.node_position.T
    above = Blank.from_mesh(0.5 * (first + second) + x[:, None] * across + y[:, None] * along, row.quads)
    gap = gaps(below, above, curved=True)[np.abs(y) < 0.5 * step][np.argsort(x[np.abs(y) < 0.5 * step])]
    assert np.abs(gap - HEIGHT).max() < 1e-5
    assert np.abs(np.diff(gap)).max() < 1e-9
