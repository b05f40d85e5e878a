"""Small stacks of plies for tests: free squares with velocities and dead pressures."""

from __future__ import annotations

import numpy as np

from weavesim import Dynamics, NodalLoads, Setup, Sheet, Simulation, Solver
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process import Interface
from weavesim.sheet.blank import Blank
from weavesim.sheet.topology import flat_areas

FABRIC = glass_polypropylene()
THICKNESS = FABRIC.thickness


def square(
    half: float, size: float, height: float = 0.0, angle: float = 0.0, centre: tuple[float, float] = (0.0, 0.0)
) -> Blank:
    """A square of half side ``half`` with elements of ``size`` [m], its mesh turned by ``angle`` [degrees]."""
    flat = Blank.rectangle((-half, -half), (half, half), size)
    turn = np.radians(angle)
    position = flat.node_position @ np.array(
        [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    return Blank.from_mesh(position + (*centre, height), flat.quads)


def nodal_areas(blank: Blank) -> np.ndarray:
    """(node_count,) [m^2]."""
    areas = np.zeros(blank.node_count)
    np.add.at(areas, blank.quads.ravel(), np.repeat(0.25 * flat_areas(blank), 4))
    return areas


def ply(name: str, blank: Blank, velocity=(0.0, 0.0, 0.0), pressure: float = 0.0, **given) -> Sheet:
    """A ply that starts with a velocity [m/s], under a dead pressure along z [Pa]."""
    loads = None
    if pressure:
        loads = NodalLoads(force=nodal_areas(blank)[:, None] * (0.0, 0.0, pressure))
    start = np.tile(velocity, (blank.node_count, 1))
    return Sheet(blank, given.pop("fabric", FABRIC), name=name, initial_velocity=start, loads=loads, **given)


def stack_setup(sheets, friction, *, solver: dict | None = None, dynamics: dict | None = None, **given) -> Setup:
    """A run of ``sheets``, bottom to top, with one friction law, or one for each interface."""
    laws = friction if isinstance(friction, list) else [friction] * (len(sheets) - 1)
    pairs = zip(sheets[:-1], sheets[1:], laws, strict=True)
    interface = given.pop("interface", {})
    interfaces = tuple(Interface(lower.name, upper.name, law, **interface) for lower, upper, law in pairs)
    return Setup(**{
        "name": "plies", "sheets": tuple(sheets), "interfaces": interfaces, "dynamics": Dynamics(**(dynamics or {})),
        "solver": Solver(**{"precision": "float64", "threads": 1, **(solver or {})}), "accept_unusual": True,
        "frame_count": 6, **given,
    })  # fmt: skip


def run_stack(*arguments, **given) -> Simulation:
    """``stack_setup``, run to its end."""
    simulation = Simulation(stack_setup(*arguments, **given))
    simulation.run()
    return simulation


def momentum(simulation: Simulation) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum and that about the origin, of all nodes, without the directors' own [kg m/s], [kg m^2/s]."""
    linear, angular = np.zeros(3), np.zeros(3)
    for model, own in zip(simulation.model.sheets, simulation.state.sheets, strict=True):
        position, velocity = nodes(model, own)
        impulse = model.node_mass[:, None] * velocity
        linear += impulse.sum(axis=0)
        angular += np.cross(position, impulse).sum(axis=0)
    return linear, angular


def nodes(model, own) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of the nodes of a sheet, in double precision."""
    from weavesim.kernels.rows import VELOCITY_REMAINDER, MotionRow

    motion = model.read_motion(own.motion)[:, : model.blank.node_count].astype(np.float64)
    position = motion[MotionRow.position.vector] + motion[MotionRow.remainder.vector]
    return position, motion[MotionRow.velocity.vector] + motion[VELOCITY_REMAINDER]


def pass_rows(simulation: Simulation, index: int) -> dict[str, np.ndarray]:
    """Rows of one pass of the contact, without padding."""
    return simulation.state.passes[index].read_rows(simulation.model.passes[index])
