"""The drape that all contestants run, as arrays and numbers."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

FABRICS = {
    "cloth": "the cloth of the scene hemisphere, in the range of Newton's own examples",
    "glass": "glass/polypropylene weave, crimped",
    "glass-straight": "the same with straight yarns",
}


@dataclasses.dataclass(frozen=True)
class Problem:
    """The drape, in SI units: arrays and numbers only, so that another interpreter can read it.

    Attributes:
        position: flat nodes over the ball, whose centre is the origin, (node_count, 3) [m].
        velocity: initial, (node_count, 3) [m/s].
        quads: corners, (quad_count, 4); the first two lie along the warp.
        membrane, shear, bending: stiffness of the sheet at rest along a yarn, in shear [N/m] and in bending [N m].
        damping: mass-proportional drag [1/s].
    """

    fabric: str
    position: np.ndarray
    velocity: np.ndarray
    quads: np.ndarray
    areal_density: float
    thickness: float
    membrane: float
    shear: float
    bending: float
    radius: float
    friction: float
    gravity: float
    damping: float
    duration: float

    def save(self, path: Path) -> None:
        """Write it as ``.npz``."""
        np.savez(path, **dataclasses.asdict(self))

    @classmethod
    def load(cls, path: Path) -> Problem:
        """Read what ``save`` wrote."""
        with np.load(path) as data:
            return cls(**{name: value if value.ndim else value.item() for name, value in data.items()})

    @property
    def triangles(self) -> np.ndarray:
        """Two triangles per quadrilateral, (2 quad_count, 3)."""
        return self.quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    @property
    def cell_area(self) -> float:
        """Area of a quadrilateral [m^2]; all are equal."""
        first, second, _, last = self.position[self.quads[0]]
        return float(np.linalg.norm(np.cross(second - first, last - first)))


def fabric_of(name: str) -> Any:
    """The Fabric of one of ``FABRICS``."""
    from weavesim.fabric.cell.weaves import PlainWeave
    from weavesim.fabric.presets import glass_polypropylene
    from weavesim.scenes.hemisphere import cloth

    if name == "cloth":
        return cloth("low-bending")
    fabric = glass_polypropylene()
    if name == "glass":
        return fabric
    return fabric.model_copy(
        update={"unit_cell": PlainWeave.straight(stiffness_per_width=fabric.unit_cell.yarn_stiffness_per_width[0])}
    )


def make_problem(fabric_name: str, quads_per_side: int, duration: float) -> Problem:
    """The scene hemisphere with one of ``FABRICS``, on a mesh of ``quads_per_side`` squared elements."""
    from weavesim.fabric.response import respond
    from weavesim.scenes.hemisphere import GRAVITY, unevenness

    fabric = fabric_of(fabric_name)
    parameters, blank = hemisphere_scene(quads_per_side, fabric.thickness)
    stiffness = respond(fabric.unit_cell, np.array([[1.0 + 1.0e-7, 1.0]])).tangent[0]
    return Problem(
        fabric=fabric_name,
        position=blank.node_position,
        velocity=unevenness(blank, parameters.seed),
        quads=blank.quads,
        areal_density=fabric.areal_density,
        thickness=fabric.thickness,
        # one yarn family is pulled and the other is free
        membrane=float(stiffness[0, 0] - stiffness[0, 1] * stiffness[1, 0] / stiffness[1, 1]),
        shear=fabric.shear.moment_values[1] / fabric.shear.angle[1],
        bending=fabric.bending.stiffness(fabric.thickness),
        radius=parameters.radius,
        friction=parameters.friction,
        gravity=GRAVITY,
        damping=parameters.damping,
        duration=duration,
    )


def hemisphere_scene(quads_per_side: int, thickness: float) -> tuple[Any, Any]:
    """Parameters of the scene, and its blank on a mesh of ``quads_per_side`` squared elements."""
    from weavesim.scenes.hemisphere import HemisphereParameters
    from weavesim.sheet.blank import Blank

    parameters = HemisphereParameters()
    half = 0.5 * parameters.side
    size = parameters.side / quads_per_side
    return parameters, Blank.rectangle((-half, -half), (half, half), size, height=parameters.radius + 0.5 * thickness)
