"""Coulomb friction and contact forces with known answers: an incline, a sheet pulled from under a holder."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import Fixed, ForceDriven
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, rotation_matrix
from weavesim.tools.tool import Tool

FRICTION = 0.3


@pytest.fixture
def soft(fabric):
    """Soft, so that a second takes few steps."""
    return fabric(
        areal_density=0.5, thickness=1.0e-3, unit_cell=PlainWeave.straight(stiffness_per_width=500.0),
        shear=LinearShear(modulus=1.0e5), bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e5,
        stabilisation=Stabilisation(),
    )  # fmt: skip


def resting(blank: Blank, angle: float, tilted: str) -> tuple[Blank, Plane, np.ndarray, np.ndarray]:
    """A sheet on a plane and gravity, ``angle`` between plane and horizontal; what is tilted does not matter.

    Returns the blank, the plane, gravity, and the direction down the plane.
    """
    gravity = np.array([0.0, 0.0, -9.81])
    turn = np.array(rotation_matrix((0.0, 1.0, 0.0), angle))
    lifted = blank.node_position + [0.0, 0.0, 0.5e-3]
    if tilted == "gravity":
        blank = Blank.from_mesh(lifted, blank.quads)
        return blank, Plane(), turn.T @ gravity, np.array([1.0, 0.0, 0.0])
    blank = Blank.from_mesh(lifted @ turn.T, blank.quads, warp_direction=turn[:, 0])
    return blank, Plane(rotation=turn), gravity, turn[:, 0]


def on_incline(
    fabric: Fabric, frames, ratio: float, tilted: str, duration: float
) -> tuple[np.ndarray, np.ndarray, Simulation]:
    """Times [s] and mean travel down the plane [m] of a sheet on tan(angle) = ``ratio`` mu."""
    angle = np.arctan(ratio * FRICTION)
    flat = Blank.rectangle((-0.02, -0.01), (0.02, 0.01), 0.005)
    blank, plane, gravity, down = resting(flat, angle, tilted)
    simulation = one_sheet_run(
        name="incline", blank=blank, fabric=fabric, tools=[Tool("plane", plane, friction=FRICTION)], duration=duration,
        precision="float64", lane_count=1, threads=1, frame_count=20, dynamics=Dynamics(gravity=tuple(gravity)),
    )  # fmt: skip
    simulation.run([frames])
    ways = [float(((frame.position - blank.node_position) @ down).mean()) for frame in frames.all]
    return np.array([frame.time for frame in frames.all]), np.array(ways), simulation


@pytest.mark.parametrize("tilted", ["gravity", "plane"])
def test_sheet_sticks_below_the_friction_angle(tilted, soft, frames):
    times, ways, simulation = on_incline(soft, frames, 0.8, tilted, 1.0)
    assert times[-1] >= 1.0
    assert np.abs(ways).max() < 0.01e-3
    weight = float(simulation.model.sheet.node_mass.sum()) * 9.81
    # the sheet swings a little on its friction springs
    reaction = np.mean([frame.tool_reaction[0] for frame in frames.all[5:]], axis=0)
    assert np.linalg.norm(reaction) == pytest.approx(weight, rel=0.01)


@pytest.mark.parametrize("tilted", ["gravity", "plane"])
def test_sheet_slides_above_the_friction_angle(tilted, soft, frames, manual):
    times, ways, simulation = on_incline(soft, frames, 1.25, tilted, 0.5)
    acceleration = 2.0 * np.polynomial.Polynomial.fit(times, ways, 2).convert().coef[2]
    angle = np.arctan(1.25 * FRICTION)
    expected = 9.81 * (np.sin(angle) - FRICTION * np.cos(angle))
    assert acceleration == pytest.approx(expected, rel=0.01)
    energies = simulation.frame.energies
    lost = FRICTION * np.cos(angle) * 9.81 * float(simulation.model.sheet.node_mass.sum()) * ways[-1]
    assert energies["friction_loss"] == pytest.approx(lost, rel=0.02)
    case = manual(
        "Contact", f"Sliding down an incline, the {tilted} tilted",
        known="tan(angle) = 1.25 mu, mu = 0.3: acceleration g (sin - mu cos), and mu times the normal force times "
        "the distance is lost. At 0.8 mu the same sheet sticks for a second.",
    )  # fmt: skip
    case.table(
        ["quantity", "expected", "got", "deviation"],
        [[name, a, b, f"{100 * (b / a - 1):+.2g} %"] for name, a, b in (
            ("acceleration [m/s^2]", expected, acceleration), ("friction loss [J]", lost, energies["friction_loss"]))],
    )  # fmt: skip
    assert abs(energies["balance_error"]) < 0.01 * energies["gravity_work"]


def under_holder(fabric: Fabric, force: float, *, pull: float, duration: float, damping: float = 0.0) -> Simulation:
    """A sheet between a fixed plate and one that ``force`` [N] presses down; ``pull`` [m/s] moves one edge along x."""
    blank = Blank.rectangle((-0.02, -0.01), (0.02, 0.01), 0.005)
    half = 0.5 * fabric.thickness
    upside_down = rotation_matrix((1.0, 0.0, 0.0), np.pi)
    tools = [
        Tool("die", Plane(origin=(0.0, 0.0, -half)), Fixed(), friction=FRICTION),
        Tool(
            "blank_holder", Plane(origin=(0.0, 0.0, half), rotation=upside_down),
            ForceDriven.constant(-force, mass=0.002, ramp_time=0.02), friction=FRICTION,
        ),
    ]  # fmt: skip
    free = np.ones((blank.node_count, 6), dtype=bool)
    velocity = np.zeros((blank.node_count, 3))
    if pull:
        edge = blank.node_position[:, 0] > 0.0199
        free[edge, 0] = False
        velocity[edge, 0] = pull
    return one_sheet_run(
        name="holder", blank=blank, fabric=fabric, tools=tools, duration=duration, free=free, initial_velocity=velocity,
        precision="float64", lane_count=1, threads=1, frame_count=40, dynamics=Dynamics(damping=damping),
    )  # fmt: skip


def test_reaction_of_a_pressed_sheet_equals_the_force(soft):
    force = 2.0
    simulation = under_holder(soft, force, pull=0.0, duration=0.3)
    simulation.run()
    die, holder = simulation.frame.tool_reaction
    assert holder[2] == pytest.approx(force, rel=1e-3)
    assert die[2] == pytest.approx(-force, rel=1e-3)
    assert np.abs(simulation.frame.tool_reaction[:, :2]).max() < 1e-6 * force
    assert simulation.frame.tool_displacement[1] < 0.0
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["driving_force_work"]


def test_pull_out_friction_is_twice_mu_times_the_force(soft, frames):
    force = 2.0
    simulation = under_holder(soft, force, pull=0.05, duration=0.3, damping=20.0)
    simulation.run([frames])
    moved = simulation.frame.position - simulation.setup.sheet.blank.node_position
    assert moved[:, 0].min() > 0.005
    late = np.array([frame.tool_reaction[:, 0] for frame in frames.all[20:]])
    assert late.sum(axis=1).mean() == pytest.approx(2.0 * FRICTION * force, rel=0.01)
    assert late.mean(axis=0) == pytest.approx([FRICTION * force] * 2, rel=0.02)
    slid = moved[:, 0].mean()
    assert simulation.frame.energies["friction_loss"] == pytest.approx(2.0 * FRICTION * force * slid, rel=0.1)
