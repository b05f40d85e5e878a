"""A blank held by springs at its edges is formed over a hemisphere and released.

Grippers along the edges pull outwards with springs, as in frames of thermoforming; a punch pushes
down between them. Then the grippers open, the punch goes back, and the sheet springs back. The rig is representative:
its numbers are assumed.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.app.options import RunOptions
from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import FABRIC_HELP, resolve_fabric
from weavesim.process.dynamics import Dynamics
from weavesim.process.grippers import Gripper
from weavesim.process.strokes import Stroke
from weavesim.ranges import Quantity
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

from .scene import Scene

if TYPE_CHECKING:
    from weavesim.run.simulation import Simulation

# Times for the springs to tighten, for the punch to start and to stop, and between the steps of the release [s].
TIGHTENING = 0.01
PUNCH_RAMP = 0.01
PAUSE = 0.01
# For the released sheet to come to rest [s].
REST = 0.04
# Directors vibrate far faster than anything that happens [1/s].
DIRECTOR_DAMPING = 1.0e4
# Over a quarter of the punch, and along an edge for each gripper.
SMALLEST_ELEMENT_COUNT = 5
LEAST_OF_A_GRIPPER = 2


class GrippersParameters(RunOptions):
    """Parameters of forming with grippers."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.005, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/grippers"), description="folder for the results")
    fabric: str = Field(default="glass-polypropylene", description=FABRIC_HELP)
    side: Annotated[Positive, Quantity("length")] = Field(default=0.3, description="side of the square blank [m]")
    radius: Annotated[Positive, Quantity("length")] = Field(default=0.05, description="radius of the punch [m]")
    stroke: Annotated[Positive, Quantity("displacement")] = Field(
        default=0.05, description="travel of the punch from first contact [m]"
    )
    punch_speed: Annotated[Positive, Quantity("speed")] = Field(default=0.5, description="[m/s]")
    friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.2, description="Coulomb coefficient between blank and punch"
    )
    gripper_count: int = Field(default=2, ge=1, le=50, description="grippers along half of an edge")
    gripped_share: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        default=0.6, description="share of the edges that is gripped"
    )
    stiffness: Annotated[Positive, Quantity("spring stiffness")] = Field(
        default=5.0e3, description="of the springs of one gripper [N/m]"
    )
    spring_length: Annotated[Positive, Quantity("length")] = Field(
        default=0.1, description="length of the springs at the start [m]"
    )
    pretension: Annotated[NotNegative, Quantity("force")] = Field(
        default=10.0, description="force of one gripper before the punch moves [N]"
    )
    gripper_force: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="force at which the blank slips through a gripper [N] [default: it never does]"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=30.0, description="mass-proportional damping rate [1/s]"
    )
    frame_count: int = Field(default=80, ge=1, description="frames after the first")

    @model_validator(mode="after")
    def _is_fine_enough(self) -> Self:
        largest = min(
            0.5 * math.pi * self.radius / SMALLEST_ELEMENT_COUNT,
            0.5 * self.side * self.gripped_share / (LEAST_OF_A_GRIPPER * self.gripper_count),
        )
        if self.mesh_size > largest:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements over a quarter of the "
                f"punch, and {LEAST_OF_A_GRIPPER} along each gripper, are needed; at most {largest:.4g} m is allowed"
            )
        return self

    @model_validator(mode="after")
    def _has_room(self) -> Self:
        if self.stroke > self.side / 2.0:
            raise ValueError(
                f"stroke = {self.stroke} m: at most half the side, {0.5 * self.side:.4g} m, can be formed of this blank"
            )
        return self

    @property
    def release_time(self) -> float:
        """At which the grippers open [s]."""
        return TIGHTENING + self.punch_stroke(self.stroke).duration + PAUSE

    def punch_stroke(self, distance: float) -> Stroke:
        """A stroke of the punch that starts at time zero."""
        return Stroke.smooth(distance, self.punch_speed, PUNCH_RAMP)

    def blank_area(self) -> float:
        """Of the quarter that is computed [m^2]."""
        return 0.25 * self.side**2


def punch_motion(parameters: GrippersParameters) -> Stroke:
    """Down after the springs have tightened, and back after the grippers have opened."""
    down = parameters.punch_stroke(parameters.stroke)
    start, back = TIGHTENING, parameters.release_time + PAUSE
    times = [start + time for time in down.times] + [back + time for time in down.times]
    travel = [*down.displacements, *(parameters.stroke - value for value in down.displacements)]
    return Stroke(tuple(times), tuple(travel))


def edge_grippers(parameters: GrippersParameters, blank: Blank) -> tuple[Gripper, ...]:
    """Grippers of the quarter: of the edge at the largest x, then of that at the largest y, each from its middle on."""
    half = 0.5 * parameters.side
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    tolerance = 1e-6 * parameters.side
    result = []
    for axis, direction, across, along in (("x", (1.0, 0.0, 0.0), x, y), ("y", (0.0, 1.0, 0.0), y, x)):
        edge = np.flatnonzero((across > half - tolerance) & (along <= parameters.gripped_share * half + tolerance))
        parts = np.array_split(edge[np.argsort(along[edge])], parameters.gripper_count)
        result += [
            Gripper(
                f"gripper_{axis}{number}", nodes, direction, parameters.stiffness, length=parameters.spring_length,
                pretension=parameters.pretension, ramp_time=TIGHTENING, largest_force=parameters.gripper_force,
                release_time=parameters.release_time,
            )
            for number, nodes in enumerate(parts, start=1)
        ]  # fmt: skip
    return tuple(result)


def grippers(parameters: GrippersParameters, fabric: Fabric | None = None) -> Setup:
    """The set-up of a quarter; ``fabric`` replaces that of the parameters.

    Raises:
        InputError: parameters that contradict each other.
    """
    fabric = fabric or resolve_fabric(parameters.fabric, accept_unusual=parameters.accept_unusual)
    half = 0.5 * parameters.side
    blank = Blank.rectangle((0.0, 0.0), (half, half), parameters.mesh_size)
    motion = punch_motion(parameters)
    above = parameters.radius + 0.5 * fabric.thickness
    punch = Tool(
        "punch", Sphere(parameters.radius, origin=(0.0, 0.0, above)), motion, friction=parameters.friction,
        axis=(0.0, 0.0, -1.0), colour=(0.75, 0.76, 0.80),
    )  # fmt: skip
    return Setup(
        "grippers", sheets=(Sheet(blank, fabric, grippers=edge_grippers(parameters, blank)),), tools=(punch,),
        symmetry=("x", "y"), dynamics=Dynamics(damping=parameters.damping, director_damping=DIRECTOR_DAMPING),
        duration=motion.duration + REST, frame_count=parameters.frame_count, solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def dome_depth(blank: Blank, position: np.ndarray) -> float:
    """How far the pole lies below the middles of the edges [m]."""
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    pole = int(np.argmin(x + y))
    middles = [int(np.argmax(x - 10.0 * y)), int(np.argmax(y - 10.0 * x))]
    return float(position[middles, 2].mean() - position[pole, 2])


def release(simulation: Simulation) -> dict[str, Any]:
    """What is left of the dome after the release, and what slipped through the grippers."""
    frame, setup = simulation.frame, simulation.setup
    slip = {gripper.name: 1e3 * float(value) for gripper, value in zip(setup.grippers, frame.gripper_slip, strict=True)}
    return {"dome_depth_mm": 1e3 * dome_depth(setup.sheet.blank, frame.position), "gripper_slip_mm": slip}


SCENE = Scene(
    name="grippers",
    help="Form a blank on springs at its edges over a hemisphere, and release it.",
    parameters=GrippersParameters,
    make=grippers,
    findings=lambda parameters, simulation, wanted: release(simulation),
)
