"""Sheets that twist, and that fall in folds, never pass through themselves (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.folded_strips import bent_strip
from tests.support.stacked_plies import FABRIC, THICKNESS
from weavesim import Drive, Dynamics, Observer, SelfContact, Setup, Sheet, Simulation, Solver, Support, Tool
from weavesim.kernels.pass_entries import PassEntry
from weavesim.process import Coulomb
from weavesim.process.strokes import Fixed, Stroke
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.sheet.blank import Blank
from weavesim.tools import Plane

# The twisted strip: length, width, elements over the thickness; turns; share of its length by which its ends approach.
LENGTH, WIDTH, TWIST_SIZE, TURNS, APPROACH, TWISTING = 120.0, 9.0, 1.5, 2.0, 0.15, 0.04
# The falling square: side, length and height of its waves [m], speed [m/s], time [s], elements over the thickness.
SIDE, WAVE, AMPLITUDE, SPEED, FALLING, FALLING_SIZE = 0.12, 0.06, 0.01, 8.0, 0.02, 1.5


class Pressed(Observer):
    """Counts nodes under contact in every frame."""

    def __init__(self, run: Simulation) -> None:
        self._run, self.most = run, 0

    def frame(self, frame) -> None:
        count = sum(int((own.standing.numpy() >= 0).sum()) for own in self._run.state.passes)
        self.most = max(self.most, count)


def run_and_count(sheet: Sheet, duration: float, damping: float, tools: tuple[Tool, ...] = (), gravity: float = 0.0):
    """The run, pairs of triangles that cross in all frames, and the most nodes under contact in one."""
    dynamics = Dynamics(damping=damping, contact_damping_ratio=0.3, gravity=(0.0, 0.0, -gravity))
    run = Simulation(
        Setup("folds", sheets=(sheet,), tools=tools, duration=duration, frame_count=60, accept_unusual=True,
              dynamics=dynamics, solver=Solver(precision="float64"))
    )  # fmt: skip
    record, pressed = CrossingRecord(), Pressed(run)
    run.run([record, pressed])
    return run, record.total, pressed.most


def twisted_strip(self_contact: SelfContact | None) -> Sheet:
    """A strip whose ends turn against each other and approach."""
    length, half = LENGTH * THICKNESS, 0.5 * WIDTH * THICKNESS
    blank = Blank.rectangle((0.0, -half), (length, half), TWIST_SIZE * THICKNESS)
    time = np.linspace(0.0, TWISTING, 401)
    share = np.clip(time / (0.8 * TWISTING), 0.0, 1.0)
    angle = np.pi * TURNS * share

    def grip(name: str, x: float, sign: float) -> Support:
        nodes = np.flatnonzero(np.abs(blank.node_position[:, 0] - x) < 1e-9)
        y = blank.node_position[nodes, 1]
        none = np.zeros(len(nodes))
        drives = [
            Drive(Stroke(time, np.cos(angle) - 1.0), np.column_stack([none, y, none])),
            Drive(Stroke(time, sign * np.sin(angle)), np.column_stack([none, none, y])),
        ]
        if x > 0.0:
            drives.append(Drive(Stroke(time, -APPROACH * length * share), (1.0, 0.0, 0.0)))
        return Support(name, nodes, tuple(drives), rotations="")

    supports = grip("left", 0.0, 1.0), grip("right", length, -1.0)
    return Sheet(blank, FABRIC, name="strip", supports=supports, self_contact=self_contact)


def waved_square(self_contact: SelfContact | None) -> Sheet:
    """An upright square in waves that is thrown down onto its edge."""
    height = np.linspace(0.0, SIDE, 8001)
    wave = AMPLITUDE * np.sin(2.0 * np.pi * height / WAVE) * np.minimum(1.0, 4.0 * height / WAVE)
    arc = np.append(0.0, np.cumsum(np.hypot(np.diff(height), np.diff(wave))))
    size = FALLING_SIZE * THICKNESS
    blank = bent_strip(
        lambda s: np.column_stack([np.interp(s, arc, wave), np.interp(s, arc, height)]), arc[-1], size,
        width=round(SIDE / size),
    )  # fmt: skip
    velocity = np.tile([0.3, 0.0, -SPEED], (blank.node_count, 1))
    return Sheet(blank, FABRIC, name="square", initial_velocity=velocity, self_contact=self_contact)


def judge(found, case, what: str) -> None:
    run, crossings, pressed = found
    entries = np.array([own.entry.numpy() for own in run.state.passes])
    last = run.history[-1]
    error = last["balance_error"] / last["supplied"]
    deepest = entries[:, PassEntry.deepest].max() / THICKNESS
    assert crossings == 0 and not entries[:, PassEntry.late].any()
    assert pressed >= 5 and deepest < 0.3
    assert abs(error) < 0.01
    case.table(
        [what, "crossing triangles in all frames", "most nodes in contact", "deepest / thickness", "balance error"],
        [[run.setup.sheet.blank.element_count, crossings, pressed, deepest, f"{error:+.1e}"]],
    )


@pytest.mark.verification
@pytest.mark.slow
def test_a_strip_twisted_by_two_turns_does_not_pass_through_itself(manual):
    """With a tenth of the directors' stiffness it folded over, for three of four dampings through itself.

    It is sound elements that keep it whole: without contact, but with the whole stiffness, 0, 2, 0 and 1 pairs of
    triangles cross. That contact is what holds folds apart is shown by the tests beside this one.
    """
    case = manual(
        "Contact", "A strip twisted by two turns",
        known="The ends of a strip turn against each other by two turns and approach by 15 %: it snaps and touches "
        "itself. Dampings that differ by a thousandth differ in rounding. No triangles cross in any frame, judged by a "
        "test of all pairs; no element is folded, or turned over against its directors; the ledger closes within 0.1 % "
        "of the work.",
    )  # fmt: skip
    rows = []
    for damping in (999.0, 1000.0, 1000.1, 1001.0):
        run, crossings, pressed = run_and_count(twisted_strip(SelfContact(Coulomb(0.2))), TWISTING, damping)
        last, levels = run.history[-1], {doubt.guard for doubt in run.doubts()}
        error = last["balance_error"] / last["supplied"]
        assert crossings == 0 and abs(error) < 1e-3
        assert not levels & {"self_intersection", "folded_elements", "inverted_elements", "hourglass_energy"}
        deepest = float(run.state.creases[0].deepest.numpy().max()) / THICKNESS
        assert pressed > 0 or deepest > 1e-4
        entries = np.array([own.entry.numpy() for own in run.state.passes])
        assert not entries[:, PassEntry.late].any() and entries[:, PassEntry.deepest].max() < 0.3 * THICKNESS
        rows.append([damping, crossings, pressed, deepest, f"{error:+.1e}", run.verdict])
    case.table(
        ["damping [1/s]", "crossing triangles in all frames", "most nodes in contact", "edges, deepest / thickness",
         "balance error", "verdict"],
        rows,
    )  # fmt: skip


@pytest.mark.verification
@pytest.mark.slow
def test_a_square_that_falls_in_folds_does_not_pass_through_itself(manual):
    """Known answer 7; without contact thousands of pairs of triangles cross."""
    floor = Tool("floor", Plane(origin=(0.0, 0.0, -0.5 * THICKNESS - 1e-5)), Fixed(), friction=0.3)
    case = manual(
        "Contact", "A square falls onto a floor in folds",
        known="An upright square of 120 mm in waves is thrown onto a floor at 8 m/s and folds up: no triangles of it "
        "cross in any frame, judged by a test of all pairs. The ledger closes within 1 % of the work.",
    )  # fmt: skip
    found = run_and_count(waved_square(SelfContact(Coulomb(0.3))), FALLING, 50.0, (floor,), gravity=9.81)
    judge(found, case, "elements")
