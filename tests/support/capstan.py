"""A strip that is drawn over a drum: a tool, or a ply that is held."""

from __future__ import annotations

import math

import numpy as np

from weavesim import Drive, Dynamics, Interface, NodalLoads, Setup, Sheet, Simulation, Solver, Support, Tool
from weavesim.fabric.fabric import Fabric
from weavesim.process.strokes import SmoothStroke
from weavesim.sheet.blank import Blank

RADIUS, WIDTH, SIZE, TAIL, LEAD = 0.02, 0.004, 0.002, 0.03, 0.01
FORCE, SPEED, TRAVEL, TIGHTENING, THICKNESS = 0.5, 0.05, 0.012, 0.02, 5.0e-4


def over_the_drum(turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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


def strip(fabric: Fabric, turn: float) -> Sheet:
    """A strip over a drum whose axis is x, with a dead load at its tail; its other end is drawn after a while."""
    points, lengths, back = over_the_drum(turn)
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
    return Sheet(
        blank, fabric, name="strip", free=free,
        supports=(Support("pull", np.flatnonzero(place == count - 1), (pull,)),),
        loads=NodalLoads(force, None, (0.0, TIGHTENING), (0.0, 1.0)),
    )  # fmt: skip


def drum(fabric: Fabric, turn: float, size: float) -> Sheet:
    """A ply in the shape of the drum, in facets of about ``size`` [m], that is held; wider than the strip."""
    radius = RADIUS - 0.5 * THICKNESS
    margin = 0.3
    count = round(radius * (turn + 2.0 * margin) / size)
    angle = np.linspace(0.5 * math.pi + turn + margin, 0.5 * math.pi - margin, count + 1)
    across = np.array([-0.002, 0.0013, 0.0027, 0.006])
    nodes = np.array([[x, radius * math.cos(a), radius * math.sin(a)] for a in angle for x in across])
    number = np.arange(len(nodes)).reshape(count + 1, len(across))
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    return Sheet(Blank.from_mesh(nodes, quads), fabric, name="drum", free=np.zeros((len(nodes), 6), dtype=bool))


def drawn(frames, sheets: tuple[Sheet, ...], tools: tuple[Tool, ...] = (), interfaces: tuple[Interface, ...] = ()):
    """Forces of the pull over that of the tail while the strip slides (n,), and the simulation. The strip is last."""
    setup = Setup(
        "capstan", sheets=sheets, tools=tools, interfaces=interfaces, dynamics=Dynamics(damping=20.0),
        duration=2.0 * TIGHTENING + TRAVEL / SPEED, frame_count=120, accept_unusual=bool(interfaces),
        solver=Solver(precision="float64", lane_count=1, threads=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run([frames])
    sliding = [frame for frame in frames.all if 0.3 * TRAVEL < frame.drive_displacement[0] < 0.9 * TRAVEL]
    assert len(sliding) > 20
    return np.array([frame.drive_force[0] for frame in sliding]) / FORCE, simulation
