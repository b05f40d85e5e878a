"""A sheet that meets its mirror image at a symmetry plane (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.folded_strips import bent_strip, zigzag
from tests.support.stacked_plies import FABRIC, THICKNESS, nodal_areas, pass_rows
from weavesim import Dynamics, NodalLoads, SelfContact, Setup, Sheet, Simulation, Solver
from weavesim.engine.plies.ply_launches import PlyLaunches
from weavesim.kernels.plies.data import NO_DEPTH
from weavesim.kernels.rows import PlyRow
from weavesim.process import Coulomb
from weavesim.sheet.blank import Blank

LEG, GAP, WIDTH = 20.0 * THICKNESS, 12.0 * THICKNESS, 8.0 * THICKNESS
PRESSURE, PRESSED, DURATION = 6.0e3, 6.0 * THICKNESS, 12.0e-3


def hairpin(size: float, whole: bool) -> Blank:
    """A strip folded around the plane x = 0, legs along z, or its half with x > 0; elements of ``size`` [m]."""
    length = 2.0 * LEG + 0.5 * np.pi * GAP
    start = 0.0 if whole else 0.5 * length
    count = 2 * round(0.5 * length / size)  # so that a row of nodes lies on the plane

    def curve(s: np.ndarray) -> np.ndarray:
        along, height = zigzag(start + s, LEG, GAP, 2).T
        x = height - 0.5 * GAP
        x[np.abs(x) < 1e-12] = 0.0
        return np.column_stack([x, -along])

    return bent_strip(curve, length - start, length / count, width=round(WIDTH / size))


def squeezed(size: float, whole: bool, pressure: float = PRESSURE, duration: float = DURATION, **solver) -> Simulation:
    """A dead pressure moves the ends of both legs onto each other, or that of one leg onto the plane."""
    blank = hairpin(size, whole)
    x, _, z = blank.node_position.T
    force = np.zeros((blank.node_count, 3))
    force[:, 0] = np.where(z > -PRESSED, -np.sign(x) * pressure, 0.0) * nodal_areas(blank)
    sheet = Sheet(
        blank, FABRIC, name="strip", self_contact=SelfContact(Coulomb(0.0)),
        loads=NodalLoads(force, None, (0.0, 0.3 * duration), (0.0, 1.0)),
    )  # fmt: skip
    run = Simulation(
        Setup("hairpin", sheets=(sheet,), symmetry=() if whole else ("x",), duration=duration, accept_unusual=True,
              dynamics=Dynamics(damping=1500.0, contact_damping_ratio=0.3), frame_count=10,
              solver=Solver(**{"precision": "float64", "threads": 1, **solver}))
    )  # fmt: skip
    run.run()
    return run


def mirror_rows(run: Simulation) -> list[dict[str, np.ndarray]]:
    return [pass_rows(run, k) for k, each in enumerate(run.model.passes) if each.place.plane]


def compared(size: float) -> list[object]:
    """Half a fold against the whole: a row of the manual."""
    half, whole = (squeezed(size * THICKNESS, each) for each in (False, True))
    position, other = (run.frame.sheets[0].position for run in (half, whole))
    # the symmetric part of the whole, which nothing keeps from moving and turning
    row = round(WIDTH / (size * THICKNESS)) + 1
    right, left = other[len(other) - len(position) :], other.reshape(-1, row, 3)[::-1].reshape(-1, 3)
    mirrored = left[len(other) - len(position) :] * (-1.0, 1.0, 1.0)
    apart = np.abs(position - 0.5 * (right + mirrored)).max() / THICKNESS
    rows = mirror_rows(half)
    pressed = [int((each["push"] > 0.0).sum()) for each in rows]
    assert pressed[0] == 0 and pressed[1] >= 3  # the face that looks at the plane
    nearest = position[position[:, 2] > -PRESSED, 0].min() / THICKNESS
    force = sum(each["push"].sum() for each in rows)
    of_whole = sum(pass_rows(whole, k)["push"].sum() for k in range(len(whole.model.passes)))
    last = half.history[-1]
    error = last["balance_error"] / last["supplied"]
    assert nearest == pytest.approx(0.5, abs=0.01)
    # the contact of few nodes still rings, by some per cent
    assert force == pytest.approx(of_whole, rel=0.05) and apart < 0.02
    assert abs(error) < 0.01
    return [size, nearest, force, of_whole, apart, f"{error:+.1e}"]


@pytest.mark.verification
def test_a_fold_that_closes_on_a_symmetry_plane_meets_its_image(manual):
    """Half a fold closes as the whole, on three meshes."""
    rows = [compared(size) for size in (3.0, 2.0, 1.5)]
    case = manual(
        "Contact", "A fold closes on a symmetry plane",
        known="A strip is folded around a symmetry plane, and a dead pressure moves the ends of its legs onto each "
        "other. Half of it meets its mirror image: its leg ends up half a thickness from the plane, and force and "
        "shape are those of the whole. The ledger closes within 1 % of the work.",
    )  # fmt: skip
    case.table(
        ["element size / thickness", "least distance from the plane / thickness", "force on the plane [N]",
         "between the legs of the whole [N]", "largest difference of a node / thickness", "balance error / work"],
        rows,
    )  # fmt: skip


def test_half_a_fold_closes_as_the_whole():
    compared(3.0)


def test_a_node_that_turned_away_begins_its_contact_anew():
    """Its block may sleep before it is met again; a spring that still pushes is released there, and booked."""
    sheet = Sheet(hairpin(2.0 * THICKNESS, False), FABRIC, self_contact=SelfContact(Coulomb(0.0)))
    setup = Setup("hairpin", sheets=(sheet,), symmetry=("x",), duration=1e-6, accept_unusual=True)
    run = Simulation(setup)
    model, state = run.model, run.state
    places = [k for k, each in enumerate(model.passes) if each.place.plane]
    count = model.sheet.blank.node_count
    push = np.where(np.arange(model.sheet.node_count) % 3 == 0, 1.0e-3, 0.0)
    for k in places:
        rows = model.passes[k].rows.read(state.passes[k].rows)
        rows[PlyRow.depth], rows[PlyRow.push] = 0.1 * THICKNESS, push
        state.passes[k].rows.assign(model.passes[k].rows.flat(rows))
    plies = PlyLaunches(model, state)
    plies.watch_speeds()
    for _ in plies.search():
        pass
    turned = 0
    for k in places:
        rows = state.passes[k].read_rows(model.passes[k])
        gone = (rows["stray"] > 0.0) & (push[:count] == 0.0)
        assert (rows["depth"][gone] == NO_DEPTH).all()
        assert rows["depth"][~gone] == pytest.approx(0.1 * THICKNESS)
        turned += int(gone.sum())
    # of the outer face all nodes, of the inner one some
    assert count / 2 < turned < 4 * count / 3


def test_the_same_bits_for_any_number_of_threads():
    ends = []
    for threads in (1, 3):
        # fast and short: three threads on two cores wait for each other in every step
        run = squeezed(4.0 * THICKNESS, False, 20.0 * PRESSURE, 0.1 * DURATION, threads=threads, precision="float32")
        assert max(each["push"].max() for each in mirror_rows(run)) > 0.0
        ends.append([(name, array.numpy().tobytes()) for name, array in run.state.arrays()])
    assert ends[0] == ends[1]
