"""Contact of a sheet with itself: folds, rolls, and neighbours that are none (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.folded_strips import bent_strip, fold_blank, pressed_fold, spiral
from tests.support.stacked_plies import FABRIC, THICKNESS, momentum, pass_rows, square
from weavesim import Drive, Dynamics, SelfContact, Setup, Sheet, Simulation, Solver, Support
from weavesim.kernels.pass_entries import PassEntry
from weavesim.process import Coulomb
from weavesim.process.strokes import Stroke
from weavesim.run.watch.crossing_record import CrossingRecord


def run_with_record(setup: Setup) -> tuple[Simulation, CrossingRecord]:
    run, record = Simulation(setup), CrossingRecord()
    run.run([record])
    return run, record


def entries(run: Simulation) -> np.ndarray:
    """PassEntry of all passes, (pass, entry)."""
    return np.array([own.entry.numpy() for own in run.state.passes])


def pressed(run: Simulation) -> list[int]:
    """Nodes under pressure, for every pass."""
    return [int((own.standing.numpy() >= 0).sum()) for own in run.state.passes]


@pytest.mark.parametrize("size", [1.0, 2.0, 4.0])
def test_a_folded_strip_is_pressed_flat(size, manual):
    """Legs a thickness apart, no crossing, the ledger closes, and the contact carries what the plate presses."""
    run, record = run_with_record(pressed_fold(size * THICKNESS))
    assert record.total == 0
    position = run.frame.sheets[0].position
    assert np.ptp(position[:, 2]) == pytest.approx(THICKNESS, rel=0.02)
    found = entries(run)
    assert not found[:, PassEntry.late].any() and found[:, PassEntry.deepest].max() < 0.05 * THICKNESS
    force = run.frame.tool_reaction[:, 2]
    assert force[0] < -10.0 and force[0] == pytest.approx(-force[1], rel=0.05)
    assert [count > 0 for count in pressed(run)] == [True, False, False, False]
    last = run.history[-1]
    assert abs(last["balance_error"]) < 0.01 * last["supplied"]
    forces = sum(pass_rows(run, k)["force"] for k in range(4))
    total = np.zeros((3, run.model.sheet.blank.node_count)) + forces
    upper = position[:, 2] > 0.5 * THICKNESS
    carried = 2.0 * total[2, upper].sum()  # the other half acts through the facets
    assert carried == pytest.approx(force[1], rel=0.3)
    case = manual(
        "Contact", f"A strip folded over and pressed flat, elements of {size:g} thicknesses",
        known="Legs of 20 thicknesses are pressed onto each other: they end up a thickness apart, 2 t high with their "
        "faces, no triangles cross in any frame, and the ledger closes within 1 % of the work.",
    )  # fmt: skip
    case.table(
        ["height of the middles / thickness", "crossing triangles", "deepest / thickness", "largest entry / thickness",
         "balance error / work"],
        [[np.ptp(position[:, 2]) / THICKNESS, record.total, found[:, PassEntry.deepest].max() / THICKNESS,
          max(pass_rows(run, k)["largest_entry"].max() for k in range(4)) / THICKNESS,
          f"{last['balance_error'] / last['supplied']:+.1e}"]],
    )  # fmt: skip


def test_the_middle_leg_of_three_touches_on_both_sides(manual):
    run, record = run_with_record(pressed_fold(2.0 * THICKNESS, legs=3))
    assert record.total == 0
    assert np.ptp(run.frame.sheets[0].position[:, 2]) == pytest.approx(2.0 * THICKNESS, rel=0.02)
    assert [count > 20 for count in pressed(run)] == [True, True, False, False]
    assert not entries(run)[:, PassEntry.late].any()
    above, below = (pass_rows(run, k)["depth"] > 0.0 for k in (0, 1))
    assert (above & below).sum() > 20
    last = run.history[-1]
    assert abs(last["balance_error"]) < 0.01 * last["supplied"]
    case = manual(
        "Contact", "A strip in three legs, pressed flat",
        known="Both faces of the middle leg touch, and no triangles cross; the legs end up a thickness apart, though "
        "creases become as sharp as the elements. The ledger closes within 1 % of the work.",
    )  # fmt: skip
    case.table(
        ["height of the middles / thickness", "nodes that touch on both faces", "crossing triangles",
         "balance error / work"],
        [[np.ptp(run.frame.sheets[0].position[:, 2]) / THICKNESS, int((above & below).sum()), record.total,
          f"{last['balance_error'] / last['supplied']:+.1e}"]],
    )  # fmt: skip


def closing_fold() -> Simulation:
    """A strip in two legs far apart, the upper one thrown onto the lower one."""
    blank = fold_blank(2.0 * THICKNESS, 20.0 * THICKNESS, 6.0 * THICKNESS)
    velocity = np.zeros((blank.node_count, 3))
    velocity[:, 2] = -10.0 * (blank.node_position[:, 2] > 5.0 * THICKNESS)
    sheet = Sheet(blank, FABRIC, initial_velocity=velocity, self_contact=SelfContact(Coulomb(0.3)))
    return Simulation(
        Setup("fold", sheets=(sheet,), duration=1.0e-3, solver=Solver(precision="float64", threads=1),
              accept_unusual=True)
    )  # fmt: skip


def test_a_search_that_is_passed_over_would_find_nothing():
    """Legs that come near and meet: the same bits as with a search of all groups at every update."""
    lazy, eager = closing_fold(), closing_fold()
    sought = []
    most = 0
    for _ in range(44):
        first = eager.state.passes[0].entry
        values = first.numpy()
        values[[PassEntry.quiet, PassEntry.apart]] = 0.0
        first.assign(values)
        for run in (lazy, eager):
            run.stepper.advance(1)
        sought.append([run.state.passes[0].entry.numpy()[PassEntry.sought] for run in (lazy, eager)])
        motions = [run.state.sheets[0].motion.numpy().tobytes() for run in (lazy, eager)]
        assert motions[0] == motions[1]
        most = max(most, *pressed(lazy))
    assert np.all(np.array(sought)[:, 1] == 2.0)
    assert 0.1 < np.mean(np.array(sought)[:, 0] == 2.0) < 0.9
    assert most > 0


def test_turns_of_a_roll_meet_back_to_face(manual):
    """The outer turn of a spiral is thrown inwards: it stops on the inner one, and momentum is kept."""
    gap, radius = 1.5 * THICKNESS, 10.0 * THICKNESS
    length = 2.0 * np.pi * (radius + gap) * 1.7
    blank = bent_strip(lambda s: spiral(s, radius, gap), length, 2.0 * THICKNESS)
    outward = blank.node_position * (1.0, 0.0, 1.0)
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    # all of the outer turn, and none of the inner one
    speed = -3.0 * np.clip((blank.material_coordinates[:, 0] / length - 0.4) / 0.2, 0.0, 1.0)
    sheet = Sheet(blank, FABRIC, initial_velocity=speed[:, None] * outward, self_contact=SelfContact(Coulomb(0.3)))
    run = Simulation(
        Setup("roll", sheets=(sheet,), duration=6e-4, solver=Solver(precision="float64"), accept_unusual=True,
              frame_count=12)
    )  # fmt: skip
    before, active = momentum(run)[0], []

    class Watched(CrossingRecord):
        def frame(self, frame):
            super().frame(frame)
            active.append(pressed(run))

    record = Watched()
    run.run([record])
    assert record.total == 0
    most = np.max(active, axis=0)
    assert most[2] >= 4 and most[3] >= 4 and most[0] == most[1] == 0
    mass = run.model.sheet.node_mass.sum()
    change = np.abs(momentum(run)[0] - before).max() / mass
    assert change < 1e-11
    last = run.history[-1]
    assert last["ply_friction_loss"] > 0.0 and abs(last["balance_error"]) < 0.01 * last["supplied"]
    assert not entries(run)[:, PassEntry.late].any()
    case = manual(
        "Contact", "Turns of a roll meet",
        known="The outer turn of a spiral is thrown inwards at 3 m/s: it stops on the inner one, back to face, without "
        "crossing it; linear momentum is kept to round-off, and the ledger closes within 1 % of the energy.",
    )  # fmt: skip
    case.table(
        ["crossing triangles", "most nodes in contact", "change of momentum over the mass [m/s]", "balance error"],
        [[record.total, int(most.sum()), change, f"{last['balance_error'] / last['supplied']:+.1e}"]],
    )


def sheared(self_contact: SelfContact | None) -> Simulation:
    """A square of elements of 1.7 thicknesses, its edges driven as a picture frame to 60 degrees in 20 ms."""
    half, size, duration = 0.0102, 1.7 * THICKNESS, 0.02
    blank = square(half, size)
    edge = np.unique(blank.boundary_loop())
    x, y = blank.node_position[edge, 0], blank.node_position[edge, 1]
    time = np.linspace(0.0, duration, 21)
    angle = np.radians(30.0) * time / duration
    none = np.zeros(len(edge))
    drives = (
        Drive(Stroke(time, np.cos(angle) - 1.0), np.column_stack([x, y, none])),
        Drive(Stroke(time, np.sin(angle)), np.column_stack([y, x, none])),
    )
    # so soft in shear that the frame can close, and no wrinkle comes
    sheet = Sheet(blank, FABRIC, supports=(Support("frame", edge, drives),), self_contact=self_contact)
    run = Simulation(
        Setup("frame", sheets=(sheet,), duration=duration, frame_count=4, accept_unusual=True,
              dynamics=Dynamics(damping=2000.0), solver=Solver(precision="float64", time_step=2e-7, threads=1))
    )  # fmt: skip
    run.run()
    return run


def test_neighbours_that_shear_brings_together_do_not_touch(manual):
    """Known answer E: nodes across a diagonal come nearer than the thickness: no force, the same bits."""
    with_contact, without = sheared(SelfContact()), sheared(None)
    position = with_contact.frame.sheets[0].position
    corner = position[with_contact.model.sheet.blank.quads]
    diagonal = np.linalg.norm(corner[:, 3] - corner[:, 1], axis=1)
    assert diagonal.min() < THICKNESS
    for own in with_contact.state.passes:
        assert own.entry.numpy()[PassEntry.deepest] == 0.0 and (own.standing.numpy() < 0).all()
    np.testing.assert_array_equal(position, without.frame.sheets[0].position)
    case = manual(
        "Contact", "Neighbours that shear brings together",
        known="A flat square of elements of 1.7 thicknesses is sheared in a frame to 60 degrees: its short diagonals "
        "become less than the thickness, but neighbours do not touch: no force, the same bits as without self-contact.",
    )  # fmt: skip
    case.table(["shortest diagonal / thickness", "largest difference of a node [m]"], [[diagonal.min() / THICKNESS, 0]])


def test_the_same_bits_for_any_number_of_threads():
    ends = []
    for threads in (1, 3):
        # fast and short: three threads on two cores wait for each other in every step
        setup = pressed_fold(4.0 * THICKNESS, duration=0.001, solver={"threads": threads})
        run = Simulation(setup)
        run.run()
        assert pressed(run)[0] > 10
        ends.append([(name, array.numpy().tobytes()) for name, array in run.state.arrays()])
    assert ends[0] == ends[1]
