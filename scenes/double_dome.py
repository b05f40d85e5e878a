"""The double dome: a punch of two half-balls and a half-cylinder forms a woven blank through a flat blank holder.

The paper uses the tool of a benchmark and does not print its drawing. This tool is a parametric, representative double
dome; it can be replaced by tool meshes of your own.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from weavesim.app.options import Need
from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import FABRIC_HELP, resolve_fabric
from weavesim.measures.angles import ten_points
from weavesim.measures.border import taut_path_draw_in
from weavesim.output import load_measured_angles, load_measured_outline
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import Coulomb
from weavesim.process.self_contact import SelfContact
from weavesim.process.stages import AtRest, Stage
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Support
from weavesim.ranges import Quantity
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import DomeOpening, DomePunch, Shape, rotation_matrix
from weavesim.tools.tool import Tool

from .dome_holder import (
    BLANK_HOLDER_RAMP,
    BLANK_LENGTH,
    BLANK_WIDTH,
    DIE_ENTRY_RADIUS,
    DOME_DISTANCE,
    PUNCH_RADIUS,
    SYMMETRY,
    HolderOptions,
    clearance,
    make_holder,
    raised,
)
from .scene import Scene

if TYPE_CHECKING:
    from weavesim.run.simulation import Simulation

logger = logging.getLogger(__name__)

# Sizes of elements whose surface sinks more than 0.1 mm between nodes that touch (0.19 mm at 5 mm), and which are not
# so large that friction between nodes, over the edge of the die, sets the blank holder vibrating (decision 53) [m].
BETWEEN_NODES = (3.5e-3, 7.5e-3)
PUNCH_RAMP = 6.0e-3
REST = 2.0e-3
# Of a free sheet at rest [m/s]: about a millimetre is left to its slowest bending then; single precision makes 1 mm/s.
REST_SPEED = 4.0e-3
# Names of the stages of a run with a release, and of the supports that hold the free sheet.
FORMING, RELEASE = "forming", "release"
MIDDLE, LONG_AXIS = "middle", "long_axis"
# Rigid motions that symmetry leaves to a sheet without tools: components of the middle node that are held, and the axes
# about which its director is; about z one more node holds.
FREE_MOTIONS: Mapping[str, tuple[str, str]] = {"quarter": ("z", ""), "half": ("xz", "y"), "full": ("xyz", "xy")}
# Directors vibrate at about 1e5 rad/s; this damps them within tenths of a millisecond and hardly affects the sheet
# [1/s].
DIRECTOR_DAMPING = 1.0e4


class DoubleDomeParameters(HolderOptions):
    """Parameters of a double-dome run."""

    out: Path = Field(default=Path("out/double_dome"), description="folder for the results")
    part: Literal["quarter", "half", "full"] = Field(default="quarter", description="share of the blank, by symmetry")
    yarn_angle: Annotated[float, Quantity("angle")] = Field(
        default=0.0, ge=-90.0, le=90.0, description="angle from the long axis to the warp [degrees]"
    )
    fabric: str = Field(default="glass-polypropylene", description=FABRIC_HELP)
    shear_law: Literal["curve", "linear"] = Field(
        default="curve", description="published moment curve, or the paper's linear law, equation (4)"
    )
    shear_modulus: Annotated[Positive, Quantity("shear modulus")] = Field(
        default=0.25e6, description="G_12 of the linear law, twice the stress over the angle [Pa]"
    )
    contact_thickness: Literal["initial", "current"] = Field(
        default="initial", description="sheet thickness used for contact with the tools"
    )
    self_contact: bool = Field(
        default=False, description="the sheet meets itself in folds, with its friction on the tools"
    )
    contact_samples: Literal["auto", "surface", "nodes"] = Field(
        default="auto",
        description="where the sheet meets tools: at its nodes, or between them too, on its surface; auto: there too "
        "if elements are larger than 3.5 mm, up to 7.5 mm, and no tool is a mesh",
    )
    contact_allowance: Annotated[NotNegative, Quantity("contact allowance")] = Field(
        default=0.04, description="depth of the surface over the thickness from which it is pushed out between nodes"
    )
    punch_speed: Annotated[Positive, Quantity("speed")] = Field(default=0.5, description="[m/s]")
    stroke: Annotated[Positive, Quantity("displacement", at_most=0.3)] = Field(
        default=0.0612,
        description="travel of the punch from first contact [m]; by default 60 mm below the die face, plus thickness",
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=100.0, description="mass-proportional damping rate [1/s]"
    )
    frame_count: int = Field(default=80, ge=1, description="frames after the first")
    release: bool = Field(
        default=False,
        description="release the formed sheet: no tool acts and there is no gravity, until it is at rest; the summary "
        "tells the springback",
    )
    release_duration: Annotated[Positive, Quantity("duration")] = Field(
        default=2.0, description="the longest that the release takes [s]; it warns if the sheet is not at rest by then"
    )
    release_damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=12.0,
        description="damping rate in the release [1/s]: a free sheet swings slowly, and creeps if it is high",
    )
    punch: Path | None = Field(default=None, description="mesh file for the punch, its lowest point at z = 0")
    die: Path | None = Field(default=None, description="mesh file for the die, its flange at z = 0")
    blank_holder: Path | None = Field(default=None, description="mesh file for the blank holder, its flange at z = 0")
    unit_scale: Annotated[Positive, Quantity("unit scale")] = Field(
        default=1.0, description="metres per unit of the tool meshes: 0.001 for millimetres"
    )
    tools_are_cut: bool = Field(default=False, description="the tool meshes end at the symmetry planes of the part")
    measured_angles: Path | None = Field(
        default=None, description="CSV of measured angles (point, angle_deg) to draw with the result"
    )
    measured_outline: Path | None = Field(
        default=None, description="CSV of a measured outline (x_mm, y_mm) to draw with the result"
    )

    needs: ClassVar[Mapping[str, Need]] = {
        "contact_allowance": Need("contact_samples = surface", lambda options: options.meets_between_nodes),
        "shear_modulus": Need("shear_law = linear", lambda options: options.shear_law == "linear"),
        "release_duration": Need("release", lambda options: options.release),
        "release_damping": Need("release", lambda options: options.release),
        "unit_scale": Need("a mesh for punch, die or blank_holder", lambda options: options.has_meshes),
        "tools_are_cut": Need(
            "a mesh for punch, die or blank_holder, and part = quarter or half",
            lambda options: options.has_meshes and options.part != "full",
        ),
    }

    @property
    def has_meshes(self) -> bool:
        """Whether a tool is the user's."""
        return any((self.punch, self.die, self.blank_holder))

    @property
    def meets_between_nodes(self) -> bool:
        """Whether tools are met on the surface between nodes too."""
        if self.contact_samples == "auto":
            return BETWEEN_NODES[0] < self.mesh_size <= BETWEEN_NODES[1] and not self.has_meshes
        return self.contact_samples == "surface"

    def blank_area(self) -> float:
        """Of the part that is computed [m^2]."""
        return BLANK_LENGTH * BLANK_WIDTH * 0.5 ** len(SYMMETRY[self.part])


def tool_shapes(
    parameters: DoubleDomeParameters, thickness: float, symmetry: tuple[str, ...]
) -> tuple[Shape, Shape, Shape]:
    """Punch, die and blank holder closed on a sheet of zero thickness at z = 0: the user's meshes, or the defaults."""
    half_length = 0.5 * DOME_DISTANCE
    opening = DomeOpening(
        radius=PUNCH_RADIUS + clearance(thickness),
        half_length=half_length,
        edge_radius=DIE_ENTRY_RADIUS,
        display_size=(0.52, 0.32),
    )
    punch: Shape = DomePunch(radius=PUNCH_RADIUS, half_length=half_length).placed((0.0, 0.0, PUNCH_RADIUS))
    die: Shape = opening
    blank_holder: Shape = opening.placed((0.0, 0.0, 0.0), rotation_matrix((1.0, 0.0, 0.0), math.pi))
    mirror = symmetry if parameters.tools_are_cut else ()

    def own(path: Path, side: float) -> Shape:
        return MeshShape.from_file(path, unit_scale=parameters.unit_scale, side=(0.0, 0.0, side), mirror=mirror)

    return (
        own(parameters.punch, -1.0) if parameters.punch else punch,
        own(parameters.die, 1.0) if parameters.die else die,
        own(parameters.blank_holder, -1.0) if parameters.blank_holder else blank_holder,
    )


def make_tools(parameters: DoubleDomeParameters, thickness: float, symmetry: tuple[str, ...]) -> tuple[Tool, ...]:
    """Punch, die and blank holder around a sheet or stack of ``thickness`` [m] whose middle is at z = 0."""
    half = 0.5 * thickness
    down = (0.0, 0.0, -1.0)
    punch, die, blank_holder = tool_shapes(parameters, thickness, symmetry)
    holders = make_holder(parameters, blank_holder, die, thickness, 2 ** len(symmetry))
    return (
        Tool(
            "punch", raised(punch, half),
            Stroke.smooth(parameters.stroke, parameters.punch_speed, PUNCH_RAMP, start_time=BLANK_HOLDER_RAMP),
            friction=parameters.friction, axis=down, colour=(0.75, 0.76, 0.80),
        ),
        Tool("die", raised(die, -half), friction=parameters.friction, colour=(0.45, 0.52, 0.62)),
        *holders,
    )  # fmt: skip


def held_free(parameters: DoubleDomeParameters, blank: Blank) -> tuple[Support, ...]:
    """What holds a sheet without tools against rigid motions, and against nothing else: at rest its forces are zero.

    Raises:
        InputError: no node in the middle, whose director is upright in the formed sheet: the free sheet would tilt.
    """

    def nearest(x: float, y: float) -> list[int]:
        return [int(np.argmin(np.hypot(blank.node_position[:, 0] - x, blank.node_position[:, 1] - y)))]

    if np.hypot(*blank.node_position[nearest(0.0, 0.0)[0], :2]) > 1.0e-6 * BLANK_LENGTH:
        raise InputError(
            f"release: with mesh_size = {parameters.mesh_size:g} m the {parameters.part} blank has no node in its "
            "middle, which holds the free sheet upright; choose a size with an even number of elements along length "
            "and width, such as 0.005 m, or part = quarter"
        )
    displacements, rotations = FREE_MOTIONS[parameters.part]
    middle = Support(MIDDLE, nearest(0.0, 0.0), displacements=displacements, rotations=rotations)
    if parameters.part != "full":
        return (middle,)
    return middle, Support(LONG_AXIS, nearest(0.5 * BLANK_LENGTH, 0.0), displacements="y", rotations="")


def process(parameters: DoubleDomeParameters, duration: float, supports: tuple[Support, ...]) -> dict[str, Any]:
    """Duration, frames and stages of the set-up, of a forming that takes ``duration`` [s]."""
    count = parameters.frame_count
    if not parameters.release:
        return {"duration": duration, "frame_count": count}
    free = Stage(
        RELEASE, parameters.release_duration, AtRest(speed=REST_SPEED), tools=(),
        supports=tuple(held.name for held in supports), gravity=(0.0, 0.0, 0.0),
        damping=parameters.release_damping, frame_count=count,
    )  # fmt: skip
    return {"stages": (Stage(FORMING, duration, supports=(), frame_count=count), free), "frame_count": 2 * count}


def double_dome(parameters: DoubleDomeParameters, fabric: Fabric | None = None) -> Setup:
    """The double dome; ``fabric`` replaces the preset and shear law in the parameters.

    Raises:
        InputError: parameters that contradict each other or the mesh.
    """
    if fabric is None:
        fabric = resolve_fabric(parameters.fabric, accept_unusual=parameters.accept_unusual)
        if parameters.shear_law == "linear":
            fabric = fabric.with_linear_shear(parameters.shear_modulus)
    symmetry = SYMMETRY[parameters.part]
    if parameters.part != "full" and parameters.yarn_angle % 90.0 != 0.0:
        raise InputError(
            f"yarn angle {parameters.yarn_angle} degrees: a {parameters.part} blank is symmetric only at 0 or 90; "
            "choose the full part"
        )
    lower = (0.0 if "x" in symmetry else -0.5 * BLANK_LENGTH, 0.0 if "y" in symmetry else -0.5 * BLANK_WIDTH)
    blank = Blank.rectangle(
        lower, (0.5 * BLANK_LENGTH, 0.5 * BLANK_WIDTH), parameters.mesh_size, yarn_angle=parameters.yarn_angle
    )
    tools = make_tools(parameters, fabric.thickness, symmetry)
    supports = held_free(parameters, blank) if parameters.release else ()
    own = SelfContact(Coulomb(parameters.friction)) if parameters.self_contact else None
    return Setup(
        "double_dome", sheets=(Sheet(blank, fabric, supports=supports, self_contact=own),), tools=tools,
        symmetry=symmetry,
        dynamics=Dynamics(
            damping=parameters.damping,
            director_damping=DIRECTOR_DAMPING,
            contact_thickness=parameters.contact_thickness,
            contact_samples="surface" if parameters.meets_between_nodes else "nodes",
            contact_allowance=parameters.contact_allowance if parameters.meets_between_nodes else 0.0,
        ),
        **process(parameters, tools[0].motion.duration + REST, supports), solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def wanted(parameters: DoubleDomeParameters, setup: Setup) -> Wanted:
    """The ten points of the paper, and the measured data.

    Raises:
        InputError: a file that cannot be read, or is probably in another unit.
    """
    angles, outline, accept = parameters.measured_angles, parameters.measured_outline, parameters.accept_unusual
    return Wanted(
        points=ten_points(0.5 * BLANK_LENGTH, 0.5 * BLANK_WIDTH),
        measured_angles=load_measured_angles(angles, accept_unusual=accept) if angles else None,
        measured_outline=load_measured_outline(outline, reach=0.5 * BLANK_LENGTH, accept_unusual=accept)
        if outline
        else None,
    )


def expected_draw_in(parameters: DoubleDomeParameters, simulation: Simulation) -> dict[str, Any]:
    """Draw-in of the taut path on both symmetry lines [mm], for the default tool at the depth reached.

    Empty where the path is not defined: with the user's tools, with yarns oblique to the symmetry lines, beyond the
    rounded depth of the punch, or for a sheet that the tools have left.
    """
    if parameters.release or parameters.has_meshes or parameters.yarn_angle % 90.0 != 0.0:
        return {}
    fabric = simulation.setup.sheet.fabric
    thickness = fabric.thickness
    depth = simulation.frame.stroke - thickness
    if not 0.0 < depth <= PUNCH_RADIUS:
        return {}
    try:
        taut = taut_path_draw_in(PUNCH_RADIUS, DIE_ENTRY_RADIUS, depth, thickness, clearance(thickness))
    except InputError as error:  # a comparison, which the results do not need
        logger.info("there is no taut path to compare with: %s", error)
        return {}
    return {"taut_path_draw_in_mm": 1.0e3 * taut}


def springback(simulation: Simulation) -> dict[str, float]:
    """What the release changed; empty before the release has ended.

    Returns:
        ``springback_mm``: largest distance that a node moved from the end of forming to the end of the release, with
            the middle node held and no rigid motion removed.
        ``formed_max_shear_angle_deg``: largest shear angle at the end of forming.
        ``springback_max_shear_angle_deg``: what the release changed the largest shear angle by; below zero where yarns
            turned back.
    """
    frames = simulation.stages.frames
    if [told["name"] for told in simulation.stages.ended] != [FORMING, RELEASE]:
        return {}
    formed, released = (frames[name].sheet for name in (FORMING, RELEASE))
    before, after = (float(np.rad2deg(np.abs(sheet.fields["shear_angle"]).max())) for sheet in (formed, released))
    moved = np.linalg.norm(released.position - formed.position, axis=1)
    return {
        "springback_mm": 1.0e3 * float(moved.max()),
        "formed_max_shear_angle_deg": before,
        "springback_max_shear_angle_deg": after - before,
    }


SCENE = Scene(
    name="double-dome",
    help="Form a woven blank over a double dome.",
    parameters=DoubleDomeParameters,
    make=double_dome,
    wanted=wanted,
    findings=lambda parameters, simulation, wanted: {
        **expected_draw_in(parameters, simulation),
        **springback(simulation),
    },
)
