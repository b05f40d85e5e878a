"""The tables of a job file. Documents (docs/job.md) and the schema for editors are generated from them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from ..checks import Finite, NotNegative, Positive
from ..device import LARGEST_THREAD_COUNT, Precision
from ..meshes.numbering import Numbering
from ..names import FileName, Label
from ..ranges import Quantity
from ..sheet.lay_up_code import angles_of
from .friction import LAWS, FrictionValue
from .segments.tables import PushedTable
from .stages.paths import WayTable
from .stages.tables import PressureTable, StageTable
from .tables import Coordinate, FileUnit, JobTable, Point, one_of, without

Direction = Literal["+x", "-x", "+y", "-y", "+z", "-z"]

# How a blank, and a tool, may be given.
OUTLINES = ("rectangle", "disc", "polygon", "outline")
SURFACES = ("file", "shape", "offset_of", "ring_of")


class PlyTable(JobTable):
    """A ply: its outline, fabric and angle. `[[ply]]`, one table per ply, from below to above."""

    name: Label = Field(default="ply", description="name in all results")
    layup: str | None = Field(
        default=None,
        description="several plies of this outline, such as [0/90]s or 0/45/-45/90, from below to above, in degrees; "
        "instead of an angle. They are named NAME_1, NAME_2, ...",
    )
    fabric: str = Field(
        description="a preset, the name of a file in your own folder of fabrics, a .toml file beside the job, or the "
        "NAME of a table [fabric.NAME]"
    )
    angle: Annotated[Finite, Quantity("angle")] = Field(default=0.0, description="from the x axis to the warp")
    rectangle: Annotated[tuple[Positive, Positive], Quantity("length")] | None = Field(
        default=None, description="outline: sides along x and y"
    )
    disc: Annotated[Positive, Quantity("length")] | None = Field(default=None, description="outline: diameter")
    polygon: tuple[Point, ...] | None = Field(default=None, description="outline: corners in order")
    outline: str | None = Field(
        default=None,
        description="outline: a DXF drawing of closed lines, or a mesh of quadrilaterals or triangles, beside it",
    )
    layer: str | None = Field(default=None, description="layer of the DXF drawing; all layers if left out")
    unit: FileUnit | None = Field(
        default=None, description="unit of the outline's file, such as mm; a DXF drawing may say its own"
    )
    numbering: Numbering | None = Field(
        default=None,
        description="of a mesh of quadrilaterals: whether nodes and elements stay in its order (kept, the default), or "
        "are put in one in which neighbours follow each other, up to twice as fast; results have its numbers as labels",
    )
    holes: tuple[tuple[Point, ...], ...] = Field(default=(), description="corners of each hole, in order")
    slits: tuple[tuple[Point, ...], ...] = Field(default=(), description="points of each slit, in order")
    centre: Point = Field(default=(0.0, 0.0), description="where the origin of the outline lies")
    turn: Annotated[Finite, Quantity("angle")] = Field(
        default=0.0, description="turns the outline about its origin, counter-clockwise; the yarns stay"
    )
    self_contact: bool = Field(
        default=False, description="whether it may touch itself, as in folds, with the friction between plies"
    )
    height: Coordinate | None = Field(
        default=None, description="z of its middle; without it, the plies lie on the tools below them"
    )
    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(description="edge length of an element")
    mesh_along: Literal["yarns", "outline"] = Field(
        default="yarns", description="whether the elements are parallel to the yarns, or to the longest side"
    )

    @model_validator(mode="after")
    def _has_one_angle(self) -> Self:
        if self.layup is not None:
            if "angle" in self.model_fields_set:
                raise ValueError("angle and layup: one of them is needed, both are given")
            angles_of(self.layup)
        return self

    @model_validator(mode="after")
    def _has_one_outline(self) -> Self:
        one_of(self, OUTLINES)
        if self.outline is None:
            without(self, ("layer", "unit", "numbering"), "a file as outline")
        elif not self.outline.lower().endswith(".dxf"):
            without(self, ("layer",), "a DXF drawing as outline")
        else:
            without(self, ("numbering",), "a mesh as outline")
        return self


class ToolTable(PushedTable):
    """A rigid tool: its surface, where it starts, and how it moves. `[[tool]]`, one table per tool."""

    name: Label = Field(description="name in all results")
    file: str | None = Field(
        default=None, description="surface: a mesh (STL, OBJ, PLY, ...) or a CAD file (STEP, IGES) beside the job"
    )
    unit: FileUnit | None = Field(default=None, description="unit of the file, such as mm; some formats say their own")
    up: Direction = Field(default="+z", description="direction in the file that points up, from the die to the punch")
    mirror: tuple[Literal["x", "y"], ...] = Field(
        default=(), description="planes at which the file ends, and behind which it is mirrored"
    )
    offset: Annotated[Finite, Quantity("displacement")] = Field(
        default=0.0, description="moves the file's surface along its normal, towards the sheet"
    )
    shape: dict[str, Any] | None = Field(
        default=None, description="surface: a built-in shape, {kind = ..., ...} with the names of its dimensions"
    )
    offset_of: str | None = Field(
        default=None, description="surface: that of another tool, at the distance `gap` when both are closed"
    )
    ring_of: str | None = Field(
        default=None, description="surface: a ring over the flat rim around the opening of another tool"
    )
    gap: Annotated[Positive, Quantity("gap")] | None = Field(
        default=None, description="distance of an offset surface from the other tool, when both are closed"
    )
    faces: Literal["up", "down"] | None = Field(
        default=None, description="towards the sheet: up for a tool below it, down for one above"
    )
    move: tuple[Coordinate, Coordinate, Coordinate] = Field(default=(0.0, 0.0, 0.0), description="shifts the surface")
    start: Literal["drawn", "touching"] = Field(
        default="drawn", description="at time zero: where it is drawn, or moved along its axis until it meets the sheet"
    )
    clearance: Annotated[NotNegative, Quantity("displacement")] = Field(
        default=0.0, description="moved back by this from there"
    )
    axis: tuple[Finite, Finite, Finite] | None = Field(
        default=None, description="direction of its stroke or force; without it, vertically towards the sheet"
    )
    stroke: Literal["close"] | Annotated[Finite, Quantity("displacement")] | None = Field(
        default=None, description='travel along its axis; "close" goes to where it is drawn'
    )
    speed: Annotated[Positive, Quantity("speed")] | None = Field(default=None, description="of the stroke")
    ramp: Annotated[NotNegative, Quantity("time")] | None = Field(
        default=None, description="time to reach the speed, or the force; by default 5 % of the stroke's time, or 2 ms"
    )
    delay: Annotated[NotNegative, Quantity("time")] = Field(default=0.0, description="when the stroke begins")
    largest_force: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="of the whole press: near it the stroke slows down and waits"
    )
    force: Annotated[NotNegative, Quantity("force")] | None = Field(
        default=None, description="along its axis, of the whole tool; instead of a stroke"
    )
    mass: Annotated[Positive, Quantity("mass")] = Field(default=2.0, description="what the force moves")
    friction: FrictionValue = Field(default=0.2, description=f"between tool and sheet: {LAWS}")

    @model_validator(mode="after")
    def _has_one_surface(self) -> Self:
        surface = one_of(self, SURFACES)
        if surface != "file":
            without(self, ("unit", "up", "mirror", "offset"), "a file")
        if surface == "offset_of" and self.gap is None:
            raise ValueError("gap: is required with offset_of: the distance of both surfaces when they are closed")
        if surface != "offset_of":
            without(self, ("gap",), "offset_of")
        if surface in ("offset_of", "ring_of"):
            without(self, ("faces",), "a file or a shape: it faces the other tool")
        if surface == "file" and self.faces is None:
            raise ValueError('faces: is required with a file: "up" for a tool below the sheet, "down" for one above it')
        return self

    @model_validator(mode="after")
    def _moves_in_one_way(self) -> Self:
        if sum(given is not None for given in (self.stroke, self.force, self.forces, self.gaps)) > 1:
            raise ValueError("stroke, force, forces and gaps: a tool moves by one of them, several are given")
        pushed = self.force is not None or self.forces is not None
        loaded = pushed or any(each.gap is None and each.gaps is None for each in self.segment)
        if self.stroke is None:
            without(self, ("speed", "delay", "largest_force"), "a stroke")
        elif self.speed is None:
            raise ValueError("speed: is required with a stroke")
        if not loaded:
            without(self, ("mass", "stop"), "a force")
        if self.stroke is None and self.force is None and all(each.force is None for each in self.segment):
            without(self, ("ramp",), "a stroke or a force")
        if self.stroke == 0.0:
            raise ValueError("stroke = 0: for a tool at rest leave it out")
        return self


class SpringTable(JobTable):
    """Springs that pull at the edge of a ply; beyond a largest force it slips. `[[spring]]`, one table per group."""

    name: Label = Field(description="name in all results; several places get NAME_1, NAME_2, ...")
    ply: str | None = Field(default=None, description="the ply that it pulls at; the only one if left out")
    edge: Direction | None = Field(default=None, description="place: the edge of the ply that is furthest along this")
    corners: bool = Field(default=False, description="place: every corner of the outline, each on its own")
    points: tuple[Point, ...] | None = Field(default=None, description="place: these points, each on its own")
    radius: Annotated[NotNegative, Quantity("length")] = Field(
        default=0.0, description="of the patch around each corner or point; the nearest node if zero"
    )
    direction: tuple[Finite, Finite, Finite] | None = Field(
        default=None, description="from the ply to the anchors; without it, outwards in the plane"
    )
    stiffness: Annotated[Positive, Quantity("spring stiffness")] = Field(description="at each place")
    length: Annotated[Positive, Quantity("length")] = Field(default=0.1, description="of the springs at the start")
    pretension: Annotated[NotNegative, Quantity("force")] = Field(
        default=0.0, description="force at each place at the start"
    )
    ramp: Annotated[NotNegative, Quantity("time")] = Field(
        default=2.0e-3, description="time in which the pretension is applied"
    )
    largest_force: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="at each place: beyond it the ply slips through"
    )
    release: Annotated[Positive, Quantity("time")] | None = Field(
        default=None, description="when it opens; it stays if left out"
    )

    @model_validator(mode="after")
    def _has_one_place(self) -> Self:
        given = [name for name in ("edge", "corners", "points") if getattr(self, name)]
        if len(given) != 1:
            what = f"{' and '.join(given)} are given" if given else "none is given"
            raise ValueError(f"edge, corners or points: one of them is needed, {what}")
        if self.edge is not None:
            without(self, ("radius",), "corners or points")
            if self.edge[1] == "z":
                raise ValueError("edge: +x, -x, +y or -y is needed")
        return self


class GripperTable(SpringTable, WayTable):
    """A gripper that moves: springs whose anchors have a stroke or a path. `[[gripper]]`, one table per group."""

    stroke: Annotated[Finite, Quantity("displacement")] = Field(
        default=0.0, description="of the anchors, away from the ply; negative follows it"
    )
    speed: Annotated[Positive, Quantity("speed")] | None = Field(default=None, description="of the stroke")

    @model_validator(mode="after")
    def _has_a_speed(self) -> Self:
        if self.stroke != 0.0 and self.speed is None:
            raise ValueError("speed: is required with a stroke")
        if self.stroke == 0.0:
            without(self, ("speed",), "a stroke")
        return self


class PairTable(JobTable):
    """Contact of one pair of neighbours, where it differs from `[interface]`. `[[interface.pair]]`."""

    lower: str = Field(description="name of the lower ply")
    upper: str = Field(description="name of the ply upon it")
    friction: FrictionValue | None = Field(default=None, description="of this pair; that of all if left out")
    passes: Literal["both", "one"] | None = Field(default=None, description="as above; those of all if left out")


class InterfaceTable(JobTable):
    """Contact between neighbouring plies. `[interface]`."""

    friction: FrictionValue = Field(default=0.2, description=f"between plies: {LAWS}")
    passes: Literal["both", "one"] = Field(
        default="both", description="whether the nodes of either ply meet the other, or only those of the finer one"
    )
    pair: tuple[PairTable, ...] = Field(default=(), description="[[interface.pair]]: pairs that differ")


class ProcessTable(JobTable):
    """What acts on all plies, and how long. `[process]`."""

    symmetry: tuple[Literal["x", "y"], ...] = Field(
        default=(),
        description="planes x = 0 and y = 0 at which plies end: half or a quarter is drawn, forces are of the whole",
    )
    gravity: Annotated[NotNegative, Quantity("acceleration")] = Field(default=0.0, description="downwards")
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=100.0, description="mass-proportional damping of the nodes"
    )
    director_damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=1.0e4, description="the same of the directors, which vibrate a thousand times faster"
    )
    contact_thickness: Literal["initial", "current"] = Field(
        default="initial", description="thickness of the sheet where it meets tools"
    )
    contact_samples: Literal["nodes", "surface"] = Field(
        default="nodes", description="whether tools are met at the nodes only, or on the surface between them too"
    )
    contact_allowance: Annotated[NotNegative, Quantity("contact allowance")] = Field(
        default=0.0, description="depth of that surface in a tool, over the thickness, from which it is pushed out"
    )
    hold: Annotated[NotNegative, Quantity("time")] = Field(
        default=2.0e-3, description="time at the end, after the last stroke; stages have their own"
    )
    duration: Annotated[Positive, Quantity("duration")] | None = Field(
        default=None, description="of the run; without it, that of the strokes and `hold`, or of the stages"
    )


class SolverTable(JobTable):
    """How and where the run is computed. `[solver]`."""

    device: str = Field(default="cpu", description='"cpu", or "cuda:0", "cuda:1", ...')
    precision: Precision = Field(default=Precision.SINGLE, description="scalar type of state and kernels")
    threads: Annotated[int, Field(ge=1, le=LARGEST_THREAD_COUNT)] | None = Field(
        default=None, description="CPU threads; the fastest number if left out; results are the same for any"
    )
    time_step: Annotated[Positive, Quantity("time step")] | None = Field(
        default=None, description="largest time step; must be stable"
    )
    target_step: Annotated[Positive, Quantity("time step")] | None = Field(
        default=None, description="scale the mass until this time step is stable; the added mass is reported"
    )
    mass_scaling_angle: Annotated[Positive, Quantity("angle error")] | None = Field(
        default=None,
        description="instead of `target_step`: the largest change of shear angles by a mass scaling, which is sought "
        "by runs on elements 1.5 times as large; 0.5 degrees if only the other is given",
    )
    mass_scaling_draw_in: Annotated[Positive, Quantity("position error")] | None = Field(
        default=None, description="the same for the border of the plies; 0.5 mm if only the other is given"
    )

    @model_validator(mode="after")
    def _scales_in_one_way(self) -> Self:
        if self.mass_scaling_angle is not None or self.mass_scaling_draw_in is not None:
            for name in ("target_step", "time_step"):
                if getattr(self, name) is not None:
                    raise ValueError(
                        f"{name}: it is what a search by mass_scaling_angle or mass_scaling_draw_in is to find; give "
                        "one of them"
                    )
        return self


class OutputTable(JobTable):
    """What is written. `[output]`."""

    frame_count: Annotated[int, Field(ge=1)] = Field(default=60, description="frames after the first")
    write: tuple[str, ...] | None = Field(default=None, description="results to write; all if left out")
    without: tuple[str, ...] | None = Field(default=None, description="results to leave out")
    checkpoint_interval: Annotated[NotNegative, Quantity("wall time")] = Field(
        default=600.0, description="wall time between two checkpoints, from which weavesim resume goes on; 0: none"
    )
    stop_on: tuple[str, ...] = Field(
        default=(),
        description="guards that end the run: `GUARD`, `GUARD:do-not-use`, or `do-not-use` for any (docs/results.md)",
    )
    solver_fields: bool = Field(
        default=False, description="frames for ParaView have the fields of the solver too, `unit_cell_*`"
    )

    @field_validator("stop_on")
    @classmethod
    def _are_guards(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if value:
            from ..run.watch.stops import stop_levels

            stop_levels(value)
        return value


class Job(JobTable):
    """A job file."""

    name: FileName = Field(default="job", description="of the run; without it, that of the file")
    accept_unusual: bool = Field(
        default=False, description="take unusual values as meant, such as a thickness that looks like millimetres"
    )
    fabric: dict[str, dict[str, Any]] = Field(
        default={},
        description="[fabric.NAME]: a fabric as in a fabric file (docs/fabrics.md), in SI units; `based_on` a preset",
    )
    ply: tuple[PlyTable, ...] = Field(default=(), description="[[ply]], from below to above")
    tool: tuple[ToolTable, ...] = Field(default=(), description="[[tool]], in the order of all results")
    spring: tuple[SpringTable, ...] = Field(default=(), description="[[spring]]")
    gripper: tuple[GripperTable, ...] = Field(default=(), description="[[gripper]]")
    pressure: tuple[PressureTable, ...] = Field(default=(), description="[[pressure]]")
    stage: tuple[StageTable, ...] = Field(
        default=(), description="[[stage]], one after the other; without any, everything acts all the time"
    )
    interface: InterfaceTable = Field(default=InterfaceTable(), description="[interface]")
    process: ProcessTable = Field(default=ProcessTable(), description="[process]")
    solver: SolverTable = Field(default=SolverTable(), description="[solver]")
    output: OutputTable = Field(default=OutputTable(), description="[output]")
    scene: dict[str, Any] | None = Field(
        default=None,
        description="[scene]: a scene by its `name`, with its options by theirs; instead of plies and tools",
    )
