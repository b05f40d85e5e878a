"""Double-diaphragm forming: plies between two rubber sheets are drawn over a dome.

A frame holds both diaphragms. In three stages the air between them is evacuated, which presses them onto the plies; a
dome rises through them on its table; and the air below is evacuated, so that the pressure above draws all onto dome
and table. The rig is representative: its numbers are assumed, those of the rubber too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from weavesim.app.options import Need, RunOptions
from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import FABRIC_HELP, resolve_fabric
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import Coulomb
from weavesim.process.interfaces import Interface
from weavesim.process.pressure import Pressure
from weavesim.process.stages import SheetPressure, Stage
from weavesim.process.strokes import Fixed, Stroke
from weavesim.process.supports import Support
from weavesim.ranges import Quantity, unusual_values
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.sheet.stack import LayUp
from weavesim.tools.shapes import Plane, Sphere, Union
from weavesim.tools.surfaces.distance import ToolDistance
from weavesim.tools.tool import Tool

from .double_dome import SYMMETRY
from .scene import Scene
from .stack import slips

if TYPE_CHECKING:
    from weavesim.run.simulation import Simulation

LOWER, UPPER = "lower diaphragm", "upper diaphragm"
# Of silicone rubber: of the order of data sheets, not measured. Nearly incompressible.
RUBBER_MODULUS, RUBBER_DENSITY, RUBBER_POISSON_RATIO = 2.0e6, 1150.0, 0.49
# A diaphragm nearer than this touches [m].
TOUCHING = 0.5e-3
# Directors of rubber turn hardly faster than it moves: more would resist what happens [1/s].
DIRECTOR_DAMPING = 6.0e3
# Of the contact between plies: diaphragms that wrap their edges press them on each other along lines.
STIFFNESS_SHARE = 0.1
# Share of the rise in which the dome gets to its speed, and again to rest.
RAMP_SHARE = 0.2
# Over a quarter of the dome's meridian, and of the frame between dome and rim.
SMALLEST_ELEMENT_COUNT = 4


class DiaphragmParameters(RunOptions):
    """Parameters of double-diaphragm forming."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.008, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/diaphragm"), description="folder for the results")
    lay_up: str = Field(
        default="0/90", description='angles of the plies from the bottom to the top [degrees]: "0/45", "[0/90]s"'
    )
    part: Literal["quarter", "half", "full"] = Field(
        default="quarter", description="by symmetry; only plies at 0 and 90 degrees have it"
    )
    fabric: str = Field(default="glass-polypropylene", description=FABRIC_HELP)
    ply_side: Annotated[Positive, Quantity("length")] = Field(default=0.2, description="side of the square plies [m]")
    frame_side: Annotated[Positive, Quantity("length")] = Field(
        default=0.32, description="side of the square frame that holds the diaphragms [m]"
    )
    radius: Annotated[Positive, Quantity("length")] = Field(default=0.05, description="radius of the dome [m]")
    rise: Annotated[Positive, Quantity("displacement")] = Field(
        default=0.04, description="travel of dome and table from first contact, at most the radius [m]"
    )
    rise_speed: Annotated[Positive, Quantity("speed")] = Field(default=0.25, description="[m/s]")
    rubber_modulus: Annotated[Positive, Quantity("sheet modulus")] = Field(
        default=RUBBER_MODULUS, description="Young's modulus of the diaphragms, assumed [Pa]"
    )
    rubber_thickness: Annotated[Positive, Quantity("sheet thickness")] = Field(
        default=1.5e-3, description="of each diaphragm [m]"
    )
    vacuum: Annotated[NotNegative, Quantity("pressure")] = Field(
        default=2.0e4, description="pressure that clamps the plies, from the outside onto both diaphragms [Pa]"
    )
    forming_pressure: Annotated[NotNegative, Quantity("pressure")] = Field(
        default=1.5e4, description="by which the pressure below falls at the end, at most the vacuum [Pa]"
    )
    evacuation: Annotated[Positive, Quantity("duration")] = Field(
        default=0.03, description="time in which the air between the diaphragms is taken away [s]"
    )
    drawing: Annotated[Positive, Quantity("duration")] = Field(
        default=0.2, description="time in which that below is taken away [s]"
    )
    friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.3, description="Coulomb coefficient between the lower diaphragm and dome and table"
    )
    diaphragm_friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.3, description="between diaphragms and plies, and of the diaphragms on each other"
    )
    ply_friction: Annotated[NotNegative, Quantity("friction")] = Field(default=0.2, description="between plies")
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=4.0, description="mass-proportional damping rate [1/s]"
    )
    frame_count: int = Field(default=60, ge=3, description="frames after the first")

    needs: ClassVar[Mapping[str, Need]] = {
        "drawing": Need("forming_pressure", lambda options: options.forming_pressure > 0.0),
    }

    @field_validator("lay_up")
    @classmethod
    def _is_a_lay_up(cls, value: str) -> str:
        LayUp.parse(value)
        return value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.rise > self.radius:
            raise ValueError(
                f"rise = {self.rise} m: dome and table rise by at most the radius of the dome, {self.radius} m"
            )
        if self.frame_side < self.ply_side + 4.0 * self.mesh_size:
            raise ValueError(
                f"frame_side = {self.frame_side} m: the frame needs two elements beside the plies, "
                f"{self.ply_side + 4.0 * self.mesh_size:.4g} m"
            )
        if self.frame_side < 4.0 * self.radius:
            raise ValueError(
                f"frame_side = {self.frame_side} m: at least four radii of the dome, {4.0 * self.radius:.4g} m, are "
                "needed, so that the diaphragms do not tear at the frame"
            )
        if self.forming_pressure > self.vacuum:
            raise ValueError(
                f"forming_pressure = {self.forming_pressure} Pa: the pressure below can fall by at most the vacuum, "
                f"{self.vacuum} Pa"
            )
        largest = 0.5 * math.pi * self.radius / SMALLEST_ELEMENT_COUNT
        if self.mesh_size > largest:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements over a quarter of the "
                f"dome are needed; at most {largest:.4g} m is allowed"
            )
        return self

    def disproportions(self) -> Iterator[str]:
        yield from unusual_values(LayUp.parse(self.lay_up), "lay_up")
        yield from super().disproportions()

    @property
    def planes(self) -> tuple[str, ...]:
        """Symmetry planes.

        Raises:
            InputError: a part that is not symmetric.
        """
        oblique = [ply.angle for ply in LayUp.parse(self.lay_up).plies if ply.angle % 90.0 != 0.0]
        if oblique and self.part != "full":
            raise InputError(
                f"lay_up = {self.lay_up}, part = {self.part}: a ply at {oblique[0]:g} degrees is not symmetric, only "
                "plies at 0 and 90 are; choose the full part"
            )
        return SYMMETRY[self.part]

    def blank_area(self) -> float:
        """Of diaphragms and plies that are computed [m^2]."""
        plies = len(LayUp.parse(self.lay_up).plies) * self.ply_side**2
        return (2.0 * self.frame_side**2 + plies) * 0.5 ** len(self.planes)


def rubber(parameters: DiaphragmParameters) -> Fabric:
    """A diaphragm: linear and isotropic in its plane at small strains, bending as a plate."""
    modulus, thickness, ratio = parameters.rubber_modulus, parameters.rubber_thickness, RUBBER_POISSON_RATIO
    stiffness = modulus * thickness / (1.0 - ratio**2)
    shear = 0.5 * modulus / (1.0 + ratio)
    return Fabric(
        name="silicone rubber, assumed",
        areal_density=RUBBER_DENSITY * thickness,
        thickness=thickness,
        unit_cell=LinearMembrane(
            warp_stiffness=stiffness, weft_stiffness=stiffness, coupling_stiffness=ratio * stiffness
        ),
        shear=LinearShear(modulus=2.0 * shear),
        bending=IsotropicBending(modulus=modulus, poisson_ratio=ratio),
        transverse_shear_modulus=shear,
        source="none: of the order of data sheets of silicone rubber",
        assumed=("everything",),
    )


def _lower_corner(side: float, planes: tuple[str, ...]) -> tuple[float, float]:
    return 0.0 if "x" in planes else -0.5 * side, 0.0 if "y" in planes else -0.5 * side


def diaphragm_of(parameters: DiaphragmParameters, name: str, height: float) -> Sheet:
    """A diaphragm whose middle is at ``height`` [m], held at the frame."""
    half = 0.5 * parameters.frame_side
    blank = Blank.rectangle(
        _lower_corner(parameters.frame_side, parameters.planes), (half, half), parameters.mesh_size, height=height
    )
    rim = np.abs(blank.node_position[:, :2]).max(axis=1) > half * (1.0 - 1.0e-9)
    return Sheet(blank, rubber(parameters), name=name, supports=[Support(f"frame of the {name}", np.flatnonzero(rim))])


def sheets_of(parameters: DiaphragmParameters, fabric: Fabric) -> tuple[Sheet, ...]:
    """Lower diaphragm, plies and upper diaphragm on each other; the lower face of the first is at z = 0."""
    half, thickness = 0.5 * parameters.ply_side, parameters.rubber_thickness
    plies = LayUp.rectangle(
        parameters.lay_up, fabric, _lower_corner(parameters.ply_side, parameters.planes), (half, half)
    )
    between = plies.sheets(
        parameters.mesh_size, bottom=thickness, mesh_along="outline",
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip
    return (
        diaphragm_of(parameters, LOWER, 0.5 * thickness),
        *between,
        diaphragm_of(parameters, UPPER, 1.5 * thickness + plies.thickness),
    )


def interfaces_of(parameters: DiaphragmParameters, names: list[str]) -> tuple[Interface, ...]:
    """Of neighbours, and of the diaphragms beside the plies."""
    rubbing, sliding = Coulomb(parameters.diaphragm_friction), Coulomb(parameters.ply_friction)
    pairs = zip(names[1:-2], names[2:-1], strict=True)
    plies = [Interface(lower, upper, sliding, stiffness_share=STIFFNESS_SHARE) for lower, upper in pairs]
    outer = dict.fromkeys([tuple(names[:2]), tuple(names[-2:]), (LOWER, UPPER)])
    return *plies, *(Interface(lower, upper, rubbing) for lower, upper in outer)


def stages_of(parameters: DiaphragmParameters) -> tuple[Stage, ...]:
    """Evacuate between the diaphragms, raise the dome, evacuate below."""
    vacuum, left = parameters.vacuum, parameters.vacuum - parameters.forming_pressure
    rise = Stroke.smooth(parameters.rise, parameters.rise_speed, RAMP_SHARE * parameters.rise / parameters.rise_speed)

    def pressed(face: str, sheet: str, first: float, last: float, time: float) -> SheetPressure:
        return SheetPressure(Pressure(face, tuple(_smooth(first, last)), tuple(time * _SHARES)), sheet)

    evacuated = (
        pressed("bottom", LOWER, 0.0, vacuum, parameters.evacuation),
        pressed("top", UPPER, 0.0, vacuum, parameters.evacuation),
    )
    stages = [
        Stage("evacuate", 1.25 * parameters.evacuation, pressures=evacuated, moves={"dome": Fixed()}),
        Stage("rise", rise.duration, moves={"dome": rise}),
    ]
    if parameters.forming_pressure > 0.0:
        drawn = (
            pressed("bottom", LOWER, vacuum, left, parameters.drawing),
            SheetPressure(Pressure("top", (vacuum,)), UPPER),
        )
        stages.append(Stage("draw", 1.25 * parameters.drawing, pressures=drawn, moves={"dome": Fixed()}))
    return tuple(stages)


_SHARES = np.linspace(0.0, 1.0, 17)


def _smooth(first: float, last: float) -> np.ndarray:
    """From one value to another, without a kink at either end."""
    return first + (last - first) * _SHARES**2 * (3.0 - 2.0 * _SHARES)


def diaphragm(parameters: DiaphragmParameters, fabric: Fabric | None = None) -> Setup:
    """The set-up; ``fabric`` replaces that of the parameters.

    Raises:
        InputError: parameters that contradict each other or the mesh.
    """
    fabric = fabric or resolve_fabric(parameters.fabric, accept_unusual=parameters.accept_unusual)
    sheets = sheets_of(parameters, fabric)
    size = (1.1 * parameters.frame_side, 1.1 * parameters.frame_side)
    foot = (0.0, 0.0, -parameters.radius)
    dome = Union((Sphere(parameters.radius, origin=foot), Plane(display_size=size, origin=foot)))
    return Setup(
        "diaphragm", sheets=sheets,
        tools=(Tool("dome", dome, Fixed(), friction=parameters.friction, colour=(0.55, 0.58, 0.64)),),
        symmetry=parameters.planes, interfaces=interfaces_of(parameters, [sheet.name for sheet in sheets]),
        dynamics=Dynamics(damping=parameters.damping, director_damping=DIRECTOR_DAMPING),
        stages=stages_of(parameters), frame_count=parameters.frame_count, solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def formed(parameters: DiaphragmParameters, simulation: Simulation) -> dict[str, Any]:
    """Largest strain of the diaphragms, share of the lower one under the plies that touches the dome or its table, and
    slip of neighbours.
    """
    frame, (tool,) = simulation.frame, simulation.setup.tools
    sheets = dict(zip((sheet.name for sheet in frame.sheets), frame.sheets, strict=True))
    strain = {
        name: float(max(sheets[name].fields[f"{yarn}_stretch"].max() for yarn in ("warp", "weft"))) - 1.0
        for name in (LOWER, UPPER)
    }
    distance = ToolDistance(tool)
    under = np.abs(simulation.info.sheets[0].blank.material_coordinates).max(axis=1) <= 0.5 * parameters.ply_side
    gap = distance(sheets[LOWER].position[under], frame.place(0))[0] - 0.5 * parameters.rubber_thickness
    return {
        "largest_diaphragm_strain": strain, "touching_share": float((gap < TOUCHING).mean()), **slips(simulation)
    }  # fmt: skip


SCENE = Scene(
    name="diaphragm",
    help="Draw plies between two rubber diaphragms over a dome, by vacuum.",
    parameters=DiaphragmParameters,
    make=diaphragm,
    findings=lambda parameters, simulation, wanted: formed(parameters, simulation),
)
