"""Crests of two folds that cross at right angles, resolved by the elements or not: kept apart."""

import numpy as np
import pytest

from tests.support.continue_runs import continued, digests
from tests.support.folded_strips import bent_strip, zigzag
from tests.support.stacked_plies import FABRIC, THICKNESS, momentum
from weavesim import Dynamics, NodalLoads, SelfContact, Setup, Sheet, Simulation, Solver
from weavesim.engine.model import Model
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper
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
    """Known answer F. Collapsed folds turn by 72 to 86 degrees over an element, where nodes do not meet facets."""
    # a blank is of one part; these are two, which hang together nowhere
    monkeypatch.setattr("weavesim.sheet.blank.check_connection", lambda *_: None)
    case = manual(
        "Contact", "Crests of two folds that cross",
        known="Two folds are pressed onto each other, crest on crest, at right angles, by 0.1 or 0.5 N; the crests "
        "cross between nodes where the number of elements across is odd. The elements are half the radius of the "
        "fold, or the folds are collapsed, with legs a thickness apart, and turn by more than 50 degrees over an "
        "element: there nodes do not meet facets, and crests meet as edges. They stay a thickness apart, less their "
        "penetration, and no triangles cross in any frame.",
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
        assert abs(last["balance_error"]) < 0.01 * last["supplied"] and crossings == 0
        assert 0.9 * THICKNESS < distance < 1.1 * THICKNESS
    case.table(
        ["elements / thickness", "radius / thickness", "distance of the crests / thickness", "crossing triangles",
         "verdict", "balance error / work"],
        rows,
    )  # fmt: skip


def thrown_crests(friction: float, **solver) -> tuple[Setup, np.ndarray]:
    """Two free folds of collapsed crests, thrown onto each other at right angles, and their velocities [m/s]."""
    blank, upper = crossed_folds(2.0 * THICKNESS, 0.5 * THICKNESS)
    velocity = np.where(upper[:, None], (0.3, 0.1, -1.0), (0.0, 0.0, 1.0))
    contact = SelfContact(Coulomb(friction))
    sheet = Sheet(blank, FABRIC, name="folds", initial_velocity=velocity, self_contact=contact)
    setup = Setup("thrown", sheets=(sheet,), duration=3e-4, frame_count=3, accept_unusual=True,
                  dynamics=Dynamics(damping=0.0, contact_damping_ratio=0.1),
                  solver=Solver(**{"precision": "float64", "threads": 1, **solver}))  # fmt: skip
    return setup, velocity


@pytest.mark.verification
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_crests_that_collide_keep_their_momentum(monkeypatch, friction):
    """Edges alone touch: linear momentum is kept, and the ledger closes."""
    monkeypatch.setattr("weavesim.sheet.blank.check_connection", lambda *_: None)
    setup, velocity = thrown_crests(friction)
    run = Simulation(setup)
    run.run()
    (model,), (creases,) = run.model.sheets, run.state.creases
    mass = model.node_mass[:, None]
    linear, _ = momentum(run)
    assert np.abs(linear - (mass * velocity).sum(axis=0)).max() < 1e-12 * np.abs(mass * velocity).sum()
    last = run.history[-1]
    assert creases.deepest.numpy().max() > 1e-3 * THICKNESS
    assert abs(last["balance_error"]) < 0.01 * last["kinetic"]


@pytest.mark.verification
def test_threads_and_a_saved_state_do_not_matter_to_crests(monkeypatch, tmp_path):
    """The same bits on two threads, and of a state that is saved while crests press on each other."""
    monkeypatch.setattr("weavesim.sheet.blank.check_connection", lambda *_: None)
    ends = []
    for threads in (1, 2):
        setup, _ = thrown_crests(0.3, threads=threads)
        model = Model(setup)
        state = State.initial(model)
        stepper = Stepper(model, state, thread_counts=(threads,))
        stepper.load()
        stepper.start()
        while not (state.creases[0].deepest.numpy() > 0.0).any():
            stepper.advance(1)
        state.save(tmp_path / "state", model)
        stepper.advance(2)
        ends.append(digests(state))
    assert continued(setup, model, State.load(tmp_path / "state", model), 2) == ends[0] == ends[1]
