"""Supports: held nodes follow their curves, and their forces and work are right."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank

WHOLE = Blank.rectangle((0.0, 0.0), (0.1, 0.05), 0.01)


def end_nodes(blank: Blank) -> tuple[np.ndarray, np.ndarray]:
    x = blank.node_position[:, 0]
    return np.flatnonzero(x < 1e-9), np.flatnonzero(x > x.max() - 1e-9)


def strip(supports, *, duration, fabric=None, blank=WHOLE, **given) -> Simulation:
    settings = {"precision": "float64", "lane_count": 1, "threads": 1, "frame_count": 10}
    return one_sheet_run(
        name="strip", blank=blank, fabric=fabric or glass_polypropylene(), supports=supports, duration=duration,
        **(settings | given),
    )  # fmt: skip


def test_work_of_moving_supports_closes_the_balance():
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.05), 0.01)
    free = np.ones((blank.node_count, 6), dtype=bool)
    x = blank.node_position[:, 0]
    ends = (x < 1e-9) | (x > 0.1 - 1e-9)
    free[ends] = False
    velocity = np.zeros((blank.node_count, 3))
    velocity[x > 0.1 - 1e-9, 0] = 0.5
    # the rest starts along, so that no wave is launched
    velocity[:, 0] = 0.5 * x / 0.1
    simulation = one_sheet_run(
        name="strip", blank=blank, fabric=glass_polypropylene(), duration=4e-3, free=free, initial_velocity=velocity,
        dynamics=Dynamics(damping=50.0), precision="float64", lane_count=1, frame_count=10,
    )  # fmt: skip
    simulation.run()
    energies = simulation.frame.energies
    assert energies["support_work"] > 10.0 * energies["initial_kinetic"]
    assert abs(energies["balance_error"]) < 2e-3 * energies["supplied"]
    # 2 mm of 100 mm in 4 ms
    np.testing.assert_allclose(simulation.frame.fields["warp_stretch"].mean(), 1.02, atol=1e-3)


@pytest.mark.parametrize(("precision", "tolerance"), [("float32", 2e-9), ("float64", 1e-15)])
@pytest.mark.parametrize("lane_count", [1, 16])
def test_driven_nodes_follow_their_curves_without_drift(precision, tolerance, lane_count, frames):
    """Two drives per node, one bent in the other's displacement, forth and back over thousands of steps."""
    first, last = end_nodes(WHOLE)
    along = SmoothStroke.ramped(2e-3, speed=0.5, ramp_time=1e-3).and_back(rest=1e-3)
    across = along.mapped(lambda s: 400.0 * s**2, lambda s: 800.0 * s)
    height = np.linspace(0.5, 1.5, len(last))
    directions = np.column_stack([np.zeros_like(height), np.zeros_like(height), height])
    grip = Support("grip", last, (Drive(along, (1.0, 0.0, 0.0)), Drive(across, directions)))
    simulation = strip(
        (Support("clamp", first), grip), duration=along.duration + 1e-3, precision=precision, lane_count=lane_count
    )
    simulation.run([frames])
    assert simulation.stepper.step_count > 3000
    largest = 0.0
    for frame in frames.all:
        s = [drive.at(frame.time) for drive in grip.drives]
        expected = WHOLE.node_position[last] + s[0] * np.array([1.0, 0.0, 0.0]) + s[1] * directions
        assert np.abs(frame.position[last] - expected).max() < tolerance
        np.testing.assert_allclose(frame.drive_displacement, s, rtol=0, atol=tolerance)
        np.testing.assert_allclose(frame.position[first], WHOLE.node_position[first], rtol=0, atol=1e-16)
        largest = max(largest, s[1])
    assert largest > 1e-3
    assert abs(frames.all[-1].drive_displacement[0]) < tolerance


def test_force_of_supports_accelerates_the_sheet():
    """Every node held and driven: the force is mass times acceleration, less the weight, and no work is lost."""
    everywhere = np.arange(WHOLE.node_count)
    stroke = SmoothStroke.ramped(3e-3, speed=2.0, ramp_time=1e-3)
    simulation = strip(
        (Support("all", everywhere, (Drive(stroke, (0.0, 0.6, 0.8)),)),), duration=0.5e-3, frame_count=5,
        dynamics=Dynamics(gravity=(0.0, 0.0, -9.81), damping=100.0),
    )  # fmt: skip
    simulation.run()
    frame, mass = simulation.frame, 0.743 * 0.1 * 0.05
    # the speed rises as 3s^2 - 2s^3
    share = frame.time / 1e-3
    acceleration = 2.0 / 1e-3 * 6.0 * share * (1.0 - share)
    expected = mass * (acceleration * np.array([0.0, 0.6, 0.8]) + [0.0, 0.0, 9.81])
    np.testing.assert_allclose(frame.support_force[0], expected, rtol=1e-4, atol=1e-9)
    assert frame.drive_force[0] == pytest.approx(expected @ [0.0, 0.6, 0.8], rel=1e-4)
    energies = frame.energies
    assert energies["internal"] < 1e-12 * energies["kinetic"]
    assert energies["damping_loss"] == 0.0
    # velocities are half a step behind the travel of the weight
    behind = mass * 9.81 * 2.0 * simulation.state.step
    assert energies["support_work"] == pytest.approx(energies["kinetic"] - energies["gravity_work"], abs=behind)
    assert behind < 1e-3 * energies["support_work"]


def test_pulled_strip_gives_the_force_of_its_yarns(frames, fabric):
    """At rest both grips hold n = c (lambda - 1) per width, whatever the grips' own mass did before."""
    stiffness, pull = 2.0e4, 1e-3
    laws = fabric(unit_cell=PlainWeave.straight(stiffness_per_width=stiffness))
    first, last = end_nodes(WHOLE)
    stroke = SmoothStroke.ramped(pull, speed=0.4, ramp_time=2e-3)
    simulation = strip(
        (Support("clamp", first), Support("grip", last, (Drive(stroke, (1.0, 0.0, 0.0)),))), fabric=laws,
        duration=stroke.duration + 20e-3, dynamics=Dynamics(damping=800.0),
    )  # fmt: skip
    simulation.run([frames])
    expected = stiffness * (pull / 0.1) * 0.05
    for frame in frames.all[-2:]:
        np.testing.assert_allclose(frame.support_force[:, 0], [-expected, expected], rtol=1e-4)
        assert frame.drive_force[0] == pytest.approx(frame.support_force[1, 0], rel=1e-12)
        assert frame.stroke == pytest.approx(pull, rel=1e-12)
        assert abs(frame.energies["balance_error"]) < 1e-3 * frame.energies["supplied"]


def test_same_bits_for_any_number_of_threads():
    first, last = end_nodes(WHOLE)
    stroke = SmoothStroke.ramped(2e-3, speed=1.0, ramp_time=1e-3)
    grip = Support("grip", last, (Drive(stroke, (1.0, 0.0, 0.3)),))
    results = []
    for threads in (1, 2, 3):
        simulation = strip(
            (Support("clamp", first), grip), duration=2e-3, precision="float32", lane_count=None, threads=threads
        )
        simulation.run()
        frame = simulation.frame
        results.append(
            (
                simulation.model.sheet.read_motion(simulation.state.sheet.motion),
                frame.support_force,
                frame.drive_displacement,
            )
        )
    for other in results[1:]:
        for one, same in zip(results[0], other, strict=True):
            assert np.array_equal(one, same)


def test_symmetry_halves_the_force():
    """A strip cut at its middle: the grip of the half carries what that of the whole one does."""
    stroke = SmoothStroke.ramped(1e-3, speed=0.2, ramp_time=2e-3)
    half = Blank.rectangle((0.0, 0.0), (0.1, 0.025), 0.0125)
    whole = Blank.rectangle((0.0, -0.025), (0.1, 0.025), 0.0125)
    forces = []
    for blank, symmetry in ((half, ("y",)), (whole, ())):
        first, last = end_nodes(blank)
        grip = Support("grip", last, (Drive(stroke, (1.0, 0.0, 0.0)),), rotations="")
        simulation = strip(
            (Support("clamp", first, rotations=""), grip), blank=blank,
            symmetry=symmetry, duration=stroke.duration, dynamics=Dynamics(damping=100.0), time_step=1e-6,
        )  # fmt: skip
        simulation.run()
        forces.append(simulation.frame.support_force[1, 0])
    assert forces[0] == pytest.approx(0.5 * forces[1], rel=1e-6)
