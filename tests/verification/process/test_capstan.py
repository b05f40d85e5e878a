"""A strip that is drawn over a cylinder: Euler and Eytelwein."""

import math

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Capsule
from weavesim.tools.tool import Tool

FRICTION, RADIUS, WIDTH, SIZE, TAIL, LEAD = 0.25, 0.02, 0.004, 0.002, 0.03, 0.01
FORCE, SPEED, TRAVEL, TIGHTENING, THICKNESS = 0.5, 0.05, 0.012, 0.02, 5.0e-4


def over_the_cylinder(turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of a strip in the plane y z from its tail on (n, 2), lengths to them (n,), direction of the tail (2,)."""
    radius = RADIUS + 0.5 * THICKNESS
    count = round(radius * turn / SIZE)
    angle = np.linspace(0.5 * math.pi + turn, 0.5 * math.pi, count + 1)
    arc = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    back = -np.array([math.sin(angle[0]), -math.cos(angle[0])])
    tail = arc[0] + np.arange(TAIL, 0.5 * SIZE, -SIZE)[:, None] * back
    lead = arc[-1] + np.arange(SIZE, LEAD + 0.5 * SIZE, SIZE)[:, None] * np.array([1.0, 0.0])
    points = np.concatenate([tail, arc, lead])
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    return points, lengths, back


def drawn(fabric, frames, turn: float):
    """Mean force of the pull over that of the tail while the strip slides, and the simulation."""
    points, lengths, back = over_the_cylinder(turn)
    count = len(points)
    nodes = np.concatenate([np.column_stack([np.full(count, x), points]) for x in (0.0, 0.5 * WIDTH, WIDTH)])
    first = np.concatenate([np.arange(count - 1) + row * count for row in (0, 1)])
    quads = np.column_stack([first, first + count, first + count + 1, first + 1])
    along = np.tile(np.diff(points, axis=0), (2, 1))
    warp = np.column_stack([np.zeros(len(along)), along])
    blank = Blank.from_mesh(
        nodes, quads, warp_direction=warp, material_coordinates=np.column_stack([nodes[:, 0], np.tile(lengths, 3)])
    )
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[:, [0, 4, 5]] = False
    place = np.arange(blank.node_count) % count
    share = np.where((np.arange(blank.node_count) // count) == 1, 0.5, 0.25)
    force = np.zeros((blank.node_count, 3))
    force[:, 1:] = np.where(place == 0, FORCE * share, 0.0)[:, None] * back
    pull = Drive(SmoothStroke.ramped(TRAVEL, SPEED, 0.02, start_time=2.0 * TIGHTENING), (0.0, 1.0, 0.0))
    cylinder = Capsule(RADIUS, 0.1)
    simulation = one_sheet_run(
        name="capstan", blank=blank, fabric=fabric, free=free, tools=(Tool("cylinder", cylinder, friction=FRICTION),),
        supports=(Support("pull", np.flatnonzero(place == count - 1), (pull,)),),
        loads=NodalLoads(force, None, (0.0, TIGHTENING), (0.0, 1.0)), dynamics=Dynamics(damping=20.0),
        duration=2.0 * TIGHTENING + TRAVEL / SPEED, frame_count=120, precision="float64", lane_count=1, threads=1,
    )  # fmt: skip
    simulation.run([frames])
    sliding = [frame for frame in frames.all if 0.3 * TRAVEL < frame.drive_displacement[0] < 0.9 * TRAVEL]
    assert len(sliding) > 20
    return float(np.mean([frame.drive_force[0] for frame in sliding])) / FORCE, simulation


@pytest.mark.parametrize("degrees", [90, 180])
def test_the_tension_grows_exponentially_with_the_angle(degrees, fabric, frames, manual):
    strip = fabric(
        areal_density=0.5, thickness=THICKNESS, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=1.0e4), transverse_shear_modulus=1.0e5,
    )  # fmt: skip
    turn = math.radians(degrees)
    ratio, simulation = drawn(strip, frames, turn)
    expected = math.exp(FRICTION * turn)
    energies = simulation.frame.energies
    error = abs(energies["balance_error"]) / energies["support_work"]
    assert ratio == pytest.approx(expected, rel=0.01)
    assert error < 0.01
    case = manual(
        "Process", f"A strip drawn over a cylinder by {degrees} degrees",
        known="Euler and Eytelwein: the tension grows by exp(mu theta), with mu = 0.25. A dead load at the tail, the "
        "other end is drawn at 50 mm/s; radius 20 mm, elements of 2 mm.",
    )  # fmt: skip
    case.table(
        ["expected ratio of tensions", "got", "deviation", "balance error / work"],
        [[f"{expected:.5g}", f"{ratio:.5g}", f"{100.0 * (ratio / expected - 1.0):+.2g} %", f"{error:.1e}"]],
    )
