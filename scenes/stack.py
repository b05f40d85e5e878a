"""A stack of plies that slip on each other: any lay-up, on the double dome or in a round die with a ball as punch.

The ball is a public two-ply deck: a punch of 75 mm radius, a die with an opening of 80 mm radius and an edge of 7.5 mm,
a blank of 300 mm by 300 mm, 50 mm of stroke, no blank holder, no friction. It forms plies at 0 and 45 degrees.
The double dome is that of the scene ``double-dome``, with room for the stack.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator

from weavesim.app.options import Need, RunOptions
from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import FABRIC_HELP, resolve_fabric
from weavesim.measures.angles import ten_points
from weavesim.measures.slip import slip
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import Coulomb
from weavesim.process.interfaces import Interface
from weavesim.process.self_contact import SelfContact
from weavesim.process.strokes import Stroke
from weavesim.ranges import Quantity, unusual_values
from weavesim.sheet.stack import LayUp, MeshAlong
from weavesim.tools.shapes import DomeOpening, DomePunch
from weavesim.tools.tool import Tool

from . import double_dome
from .scene import Scene

if TYPE_CHECKING:
    from collections.abc import Iterator

    from weavesim.run.simulation import Simulation

# The round deck [m].
SIDE = 0.300
PUNCH_RADIUS = 0.075
DIE_RADIUS = 0.080
DIE_EDGE_RADIUS = 0.0075
GRAVITY = 9.81
# Distances of points from the middle, along the x axis and the diagonal [m].
POINT_DISTANCES = (0.02, 0.04, 0.06, 0.08, 0.10, 0.12)
# What an option is by default depends on the tools: without a holder the stack swings longer, and little but its
# bending takes energy up.
DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "hemisphere": {"friction": 0.0, "ply_friction": 0.0, "stroke": 0.05, "punch_speed": 0.25, "damping": 10.0},
    "double-dome": {"friction": 0.2, "ply_friction": 0.2, "stroke": 0.06, "punch_speed": 0.5, "damping": 100.0},
}


class StackParameters(RunOptions):
    """Parameters of a stack of plies."""

    out: Path = Field(default=Path("out/stack"), description="folder for the results")
    lay_up: str = Field(
        default="0/45",
        description='angles of the plies from the bottom to the top [degrees]: "0/45/-45/90", "[0/90]s", "[45/-45]2s"',
    )
    tools: Literal["hemisphere", "double-dome"] = Field(
        default="hemisphere", description="a ball and a round die without holder, or the double dome with its holder"
    )
    part: Literal["quarter", "half", "full"] | None = Field(
        default=None,
        description="by symmetry; by default a quarter if all plies are at 0 or 90 degrees, else the whole",
    )
    fabric: str = Field(default="glass-polypropylene", description=FABRIC_HELP)
    ply_thickness: Annotated[Positive, Quantity("sheet thickness")] | None = Field(
        default=None, description="of every ply [m]; by default that of the fabric"
    )
    mesh_along: MeshAlong = Field(
        default="yarns",
        description="each ply has a mesh along its yarns, or all have one along the outline, which is up to 1.6 times "
        "as fast",
    )
    ply_friction: Annotated[NotNegative, Quantity("friction")] | None = Field(
        default=None, description="Coulomb coefficient between plies; by default 0 in the hemisphere, 0.2 on the dome"
    )
    friction: Annotated[NotNegative, Quantity("friction")] | None = Field(
        default=None,
        description="Coulomb coefficient between plies and tools; by default 0 in the hemisphere, 0.2 on the dome",
    )
    contact_samples: Literal["nodes", "surface"] = Field(
        default="nodes", description="where plies meet tools: at their nodes, or between them too, on their surface"
    )
    contact_allowance: Annotated[NotNegative, Quantity("contact allowance")] = Field(
        default=0.04, description="depth of the surface over the thickness from which it is pushed out between nodes"
    )
    self_contact: bool = Field(
        default=False, description="every ply meets itself in folds too, with the friction between plies"
    )
    passes: Literal["both", "one"] = Field(
        default="both", description="nodes of both plies meet the other, or those of the finer one only"
    )
    blank_holder_force: Annotated[NotNegative, Quantity("force")] | None = Field(
        default=None, description="of the double dome, force of the whole holder [N]; by default that of its scene"
    )
    punch_speed: Annotated[Positive, Quantity("speed")] | None = Field(
        default=None, description="[m/s]; by default 0.25 in the hemisphere, 0.5 on the dome"
    )
    stroke: Annotated[Positive, Quantity("displacement", at_most=0.3)] | None = Field(
        default=None, description="travel of the punch from first contact [m]; by default 0.05, or 0.06 on the dome"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None,
        description="mass-proportional damping rate [1/s]; by default 10 in the hemisphere, 100 on the dome",
    )
    frame_count: int = Field(default=60, ge=1, description="frames after the first")

    needs: ClassVar[Mapping[str, Need]] = {
        "contact_allowance": Need("contact_samples = surface", lambda options: options.contact_samples == "surface"),
        "blank_holder_force": Need("tools = double-dome", lambda options: options.tools == "double-dome"),
    }

    @field_validator("lay_up")
    @classmethod
    def _is_a_lay_up(cls, value: str) -> str:
        LayUp.parse(value)
        return value

    def disproportions(self) -> Iterator[str]:
        yield from unusual_values(LayUp.parse(self.lay_up), "lay_up")
        yield from super().disproportions()

    def blank_area(self) -> float:
        """Of all plies that are computed [m^2]."""
        own = SIDE**2 if self.tools == "hemisphere" else double_dome.BLANK_LENGTH * double_dome.BLANK_WIDTH
        return own * len(LayUp.parse(self.lay_up).plies) * 0.5 ** len(self.planes)

    @property
    def planes(self) -> tuple[str, ...]:
        """Symmetry planes.

        Raises:
            InputError: a part that is not symmetric.
        """
        oblique = [ply.angle for ply in LayUp.parse(self.lay_up).plies if ply.angle % 90.0 != 0.0]
        if oblique and self.part not in (None, "full"):
            raise InputError(
                f"part = {self.part}: a ply at {oblique[0]:g} degrees is not symmetric, only plies at 0 and 90 are; "
                "choose the full part"
            )
        return double_dome.SYMMETRY[self.part or ("full" if oblique else "quarter")]

    def chosen(self, name: str) -> float:
        """An option of ``DEFAULTS``: as given, or what it is with these tools."""
        given = getattr(self, name)
        return DEFAULTS[self.tools][name] if given is None else float(given)


def lay_up(parameters: StackParameters, fabric: Fabric) -> LayUp:
    """The plies, of the part that is computed."""
    length, width = SIDE, SIDE
    if parameters.tools == "double-dome":
        length, width = double_dome.BLANK_LENGTH, double_dome.BLANK_WIDTH
    planes = parameters.planes
    lower = (0.0 if "x" in planes else -0.5 * length, 0.0 if "y" in planes else -0.5 * width)
    return LayUp.rectangle(parameters.lay_up, fabric, lower, (0.5 * length, 0.5 * width))


def hemisphere_tools(parameters: StackParameters, thickness: float) -> tuple[Tool, ...]:
    """Punch and die around a stack of ``thickness`` [m] whose middle is at z = 0.

    Raises:
        InputError: a stack that is too thick for the gap between them.
    """
    gap = DIE_RADIUS - PUNCH_RADIUS
    if thickness > gap:
        raise InputError(
            f"stack of {1e3 * thickness:.3g} mm: punch and die leave {1e3 * gap:.3g} mm; give fewer or thinner plies"
        )
    friction, top = parameters.chosen("friction"), 0.5 * thickness
    stroke = Stroke.smooth(parameters.chosen("stroke"), parameters.chosen("punch_speed"), double_dome.PUNCH_RAMP)
    punch = DomePunch(radius=PUNCH_RADIUS, half_length=0.0).placed((0.0, 0.0, PUNCH_RADIUS + top))
    die = DomeOpening(
        radius=DIE_RADIUS, half_length=0.0, edge_radius=DIE_EDGE_RADIUS, display_size=(1.1 * SIDE, 1.1 * SIDE)
    )
    return (
        Tool("punch", punch, stroke, friction=friction, axis=(0.0, 0.0, -1.0), colour=(0.75, 0.76, 0.80)),
        Tool("die", double_dome.raised(die, -top), friction=friction, colour=(0.45, 0.52, 0.62)),
    )


def dome_tools(parameters: StackParameters, thickness: float) -> tuple[Tool, ...]:
    """Punch, die and blank holder of the double dome around a stack of ``thickness`` [m]."""
    of_dome = double_dome.DoubleDomeParameters(
        friction=parameters.chosen("friction"), blank_holder_force=parameters.blank_holder_force,
        punch_speed=parameters.chosen("punch_speed"), stroke=parameters.chosen("stroke"),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip
    return double_dome.make_tools(of_dome, thickness, parameters.planes)


def stack(parameters: StackParameters, fabric: Fabric | None = None) -> Setup:
    """The stack; ``fabric`` replaces that of the parameters.

    Raises:
        InputError: parameters that contradict each other or the mesh.
    """
    fabric = fabric or resolve_fabric(parameters.fabric, accept_unusual=parameters.accept_unusual)
    if parameters.ply_thickness is not None:
        fabric = fabric.model_copy(update={"thickness": parameters.ply_thickness})
    plies = lay_up(parameters, fabric)
    tools = (hemisphere_tools if parameters.tools == "hemisphere" else dome_tools)(parameters, plies.thickness)
    friction = Coulomb(parameters.chosen("ply_friction"))
    sheets = plies.sheets(
        parameters.mesh_size, bottom=-0.5 * plies.thickness, mesh_along=parameters.mesh_along,
        self_contact=SelfContact(friction) if parameters.self_contact else None,
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip
    interfaces = tuple(
        Interface(lower, upper, friction, passes=parameters.passes)
        for lower, upper in zip(plies.names, plies.names[1:], strict=False)
    )
    gravity = GRAVITY if parameters.tools == "hemisphere" else 0.0  # nothing else holds the stack down there
    return Setup(
        "stack", sheets=sheets, tools=tools, symmetry=parameters.planes, interfaces=interfaces,
        dynamics=Dynamics(
            damping=parameters.chosen("damping"), director_damping=double_dome.DIRECTOR_DAMPING,
            contact_samples=parameters.contact_samples,
            contact_allowance=parameters.contact_allowance if parameters.contact_samples == "surface" else 0.0,
            gravity=(0.0, 0.0, -gravity),
        ),
        duration=tools[0].motion.duration + double_dome.REST, frame_count=parameters.frame_count,
        solver=parameters.solver(), accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def wanted(parameters: StackParameters, setup: Setup) -> Wanted:
    """Points at which the shear angle of every ply is shown: the ten of the double dome, or along axis and diagonal."""
    if parameters.tools == "double-dome":
        return Wanted(points=ten_points(0.5 * double_dome.BLANK_LENGTH, 0.5 * double_dome.BLANK_WIDTH))
    distance = np.array(POINT_DISTANCES)
    along = np.column_stack([distance, np.zeros_like(distance)])
    return Wanted(points=np.concatenate([along, np.tile(distance[:, None] / math.sqrt(2.0), (1, 2))]))


def slips(simulation: Simulation) -> dict[str, Any]:
    """Slip at every interface at the last frame, mean and largest [mm], by the names of its plies.

    It is that of points that lay on each other at the start (``weavesim.measures.slip``).
    """
    sheets, frames = simulation.info.sheets, simulation.frame.sheets
    mean: dict[str, float] = {}
    largest: dict[str, float] = {}
    for k, (lower, upper) in enumerate(zip(sheets, sheets[1:], strict=False)):
        vectors = slip(lower.blank, frames[k].position, upper.blank, frames[k + 1].position)
        size = 1.0e3 * np.linalg.norm(vectors[np.isfinite(vectors).all(axis=1)], axis=1)
        name = f"{lower.name} and {upper.name}"
        mean[name], largest[name] = float(size.mean()), float(size.max())
    return {"mean_slip_mm": mean, "largest_slip_mm": largest} if mean else {}


SCENE = Scene(
    name="stack",
    help="Form a stack of plies that slip on each other.",
    parameters=StackParameters,
    make=stack,
    wanted=wanted,
    findings=lambda parameters, simulation, wanted: slips(simulation),
)
