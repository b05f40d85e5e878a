"""Crests of two folds that cross at right angles: kept apart where elements resolve them, and told where not."""

import numpy as np
import pytest

from tests.support.folded_strips import bent_strip, zigzag
from tests.support.stacked_plies import FABRIC, THICKNESS
from weavesim import Dynamics, NodalLoads, SelfContact, Setup, Sheet, Simulation, Solver
from weavesim.process import Coulomb
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.sheet.blank import Blank

# Length of the legs, width of the strips and gap between the crests at the start, over the thickness.
LEG, WIDTH, GAP = 8.0, 6.0, 0.3


def fold(size: float, radius: float) -> Blank:
    """A strip over an edge along y, with a row of nodes on its crest; legs down."""
    arc = np.pi * radius
    length = 2.0 * size * np.ceil((LEG * THICKNESS + 0.5 * arc) / size)
    leg = 0.5 * (length - arc)

    def curve(s: np.ndarray) -> np.ndarray:
        along, across = zigzag(s, leg, 2.0 * radius, 2).T
        return np.column_stack([across - radius, along - leg - radius])

    return bent_strip(curve, length, size, width=max(3, round(WIDTH * THICKNESS / size)))


def crossed_folds(size: float, radius: float) -> tuple[Blank, np.ndarray]:
    """A fold and its image over it, turned by a right angle, as two parts of one sheet; which nodes are the upper's."""
    lower = fold(size, radius)
    position = lower.node_position - (0.0, 0.5 * lower.node_position[:, 1].max(), 0.0)
    upper = position[:, [1, 0, 2]] * (1.0, 1.0, -1.0) + (0.0, 0.0, (1.0 + GAP) * THICKNESS)
    count = len(position)
    position, quads = np.vstack([position, upper]), np.vstack([lower.quads, lower.quads + count])
    flat = np.vstack([lower.material_coordinates, lower.material_coordinates + (0.0, 1.0)])
    corner = position[quads]
    blank = Blank.from_mesh(
        position, quads, material_coordinates=flat,
        warp_direction=corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3],
    )  # fmt: skip
    return blank, np.arange(2 * count) >= count


def pressed_crests(size: float, radius: float, force: float, duration: float):
    """The run, the pairs of triangles that cross in all frames, and the distance of the crests where they cross [m]."""
    blank, upper = crossed_folds(size, radius)
    s = blank.material_coordinates[:, 0]
    end, crest = np.minimum(s, s.max() - s) < 1e-9, np.abs(s - 0.5 * s.max()) < 1e-9
    free = np.ones((len(s), 6), dtype=bool)
    free[end] = False
    free[end & upper, 2] = True
    load = np.zeros((len(s), 3))
    load[end & upper, 2] = -force / (end & upper).sum()
    sheet = Sheet(
        blank, FABRIC, name="folds", free=free, self_contact=SelfContact(Coulomb(0.2)), loads=NodalLoads(force=load)
    )
    run, record = (
        Simulation(
            Setup("crests", sheets=(sheet,), duration=duration, frame_count=20, accept_unusual=True,
                  dynamics=Dynamics(damping=2000.0, contact_damping_ratio=0.3),
                  solver=Solver(precision="float64", threads=1))
        ),
        CrossingRecord(),
    )  # fmt: skip
    run.run([record])
    position = run.frame.sheets[0].position
    low, high = (sorted(position[crest & there][:, [along, 2]].tolist()) for there, along in ((~upper, 1), (upper, 0)))
    return run, record.total, float(np.interp(0.0, *np.transpose(high)) - np.interp(0.0, *np.transpose(low)))


@pytest.mark.verification
@pytest.mark.slow
def test_crests_that_cross(manual, monkeypatch):
    """Known answer F. Collapsed folds turn by 72 to 86 degrees over an element, where no contact is computed."""
    # a blank is of one part; these are two, which hang together nowhere
    monkeypatch.setattr("weavesim.sheet.blank.check_connection", lambda *_: None)
    case = manual(
        "Contact", "Crests of two folds that cross",
        known="Two folds are pressed onto each other, crest on crest, at right angles, by 0.1 N; the crests cross "
        "between nodes where the number of elements across is odd. With elements of half the radius of the fold they "
        "stay a thickness apart, less what the crest sags between nodes, h/16 at each: no triangles cross in any "
        "frame. Collapsed folds, whose legs are a thickness apart, turn by more than 50 degrees over an element. There "
        "is no contact of facets on crests then, nor of edges with edges: they pass through each other, and the run "
        "is judged not to be used.",
    )  # fmt: skip
    rows = []
    for size, radius, force, duration in (
        (1.0, 2.0, 0.1, 4e-3), (2.0, 4.0, 0.1, 4e-3), (4.0, 8.0, 0.1, 1e-2),
        (1.0, 0.5, 0.5, 6e-3), (2.0, 0.5, 0.5, 6e-3), (4.0, 0.5, 0.5, 6e-3),
    ):  # fmt: skip
        run, crossings, distance = pressed_crests(size * THICKNESS, radius * THICKNESS, force, duration)
        last = run.history[-1]
        rows.append([size, radius, distance / THICKNESS, crossings, run.verdict,
                     f"{last['balance_error'] / last['supplied']:+.1e}"])  # fmt: skip
        assert abs(last["balance_error"]) < 0.01 * last["supplied"]
        if radius > size:
            assert crossings == 0 and distance > (0.98 - size / 8.0) * THICKNESS
        else:
            assert crossings > 50 and run.verdict == "do not use"
    case.table(
        ["elements / thickness", "radius / thickness", "distance of the crests / thickness", "crossing triangles",
         "verdict", "balance error / work"],
        rows,
    )  # fmt: skip
