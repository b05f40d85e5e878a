"""Tables of what acts for a part of a run: pressures, and stages with their moves and ends."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ...checks import Finite, NotNegative, Positive
from ...names import Label
from ...ranges import Quantity
from ..friction import FrictionValue
from ..tables import FileUnit, JobTable, Point, one_of, without
from .paths import CarriedTable

MOTIONS = ("stroke", "fixed", "force", "forces")
ENDS = ("time", "stroke", "force", "rest")
CURVES = ("rectangle", "disc", "polygon", "file")


class PressureTable(JobTable):
    """Pressure on a face of a ply, which follows it, such as that of a bag. `[[pressure]]`."""

    ply: str | None = Field(default=None, description="that it acts on; the only one if left out")
    face: Literal["top", "bottom"] = Field(description="that it pushes against")
    pressure: Annotated[Finite, Quantity("pressure")] = Field(description="per current area; a negative one pulls")
    patch: tuple[Point, ...] | None = Field(
        default=None, description="corners of the part of the flat ply that it acts on; all of it if left out"
    )
    delay: Annotated[NotNegative, Quantity("time")] = Field(default=0.0, description="when it begins")
    ramp: Annotated[Positive, Quantity("time")] = Field(default=2.0e-3, description="time until it is reached")


class StagePressureTable(PressureTable):
    """A pressure in the time since its stage began. `[[stage.pressure]]`, below its stage."""

    before: Annotated[Finite, Quantity("pressure")] = Field(
        default=0.0, description="pressure from which it goes, such as that of the stage before"
    )


class MoveTable(CarriedTable):
    """A motion that begins with a stage, from where things then are. `[[stage.move]]`, below its stage."""

    name: str = Field(description="of a tool, a gripper or a spring; the name of a group moves all of it")
    stroke: Literal["close"] | Annotated[Finite, Quantity("displacement")] | None = Field(
        default=None,
        description='motion: travel along its axis; a negative one goes back, "close" goes to where a tool is drawn',
    )
    fixed: bool = Field(default=False, description="motion: true keeps it where it is")
    force: Annotated[NotNegative, Quantity("force")] | None = Field(
        default=None, description="motion: by a force along its axis, of the whole tool, that grows from zero"
    )
    forces: Annotated[tuple[Finite, ...], Quantity("force")] | None = Field(
        default=None, description="motion: by forces at `times`, straight between them, of the whole tool"
    )
    times: Annotated[tuple[Finite, ...], Quantity("time")] | None = Field(
        default=None, description="of `forces`, since the stage began"
    )
    speed: Annotated[Positive, Quantity("speed")] | None = Field(default=None, description="of the stroke")
    ramp: Annotated[NotNegative, Quantity("time")] | None = Field(
        default=None, description="time to reach the speed, or the force; by default 5 % of the stroke's time, or 2 ms"
    )
    delay: Annotated[NotNegative, Quantity("time")] = Field(
        default=0.0, description="when the stroke begins, since the stage began"
    )
    largest_force: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="of the whole press: near it the stroke slows down and waits"
    )
    mass: Annotated[Positive, Quantity("mass")] | None = Field(
        default=None, description="what the force moves; that in the table of the tool if left out"
    )

    @model_validator(mode="after")
    def _moves_in_one_way(self) -> Self:
        alone = self.is_carried and all(getattr(self, name) is None or getattr(self, name) is False for name in MOTIONS)
        given = "fixed" if alone else one_of(self, MOTIONS)
        if self.fixed and self.is_carried:
            raise ValueError("fixed: has no effect with a path or a rotation; leave it out")
        if given == "stroke":
            if self.stroke == 0.0:
                raise ValueError("stroke = 0: to keep it where it is, write fixed = true")
            if self.speed is None:
                raise ValueError("speed: is required with a stroke")
        else:
            without(self, ("speed", "delay", "largest_force"), "a stroke")
        if given not in ("stroke", "force"):
            without(self, ("ramp",), "a stroke or a force")
        if given not in ("force", "forces"):
            without(self, ("mass",), "a force")
        if given == "forces":
            if self.times is None:
                raise ValueError("times: is required with forces, one for each")
        else:
            without(self, ("times",), "forces")
        return self


class EndTable(JobTable):
    """What ends a stage. `end = { ... }` in its stage, or `[stage.end]` below it."""

    time: Annotated[Positive, Quantity("duration")] | None = Field(
        default=None, description="end: at this time since it began, the same as its `duration`"
    )
    stroke: Annotated[Finite, Quantity("displacement")] | None = Field(
        default=None, description="end: when `tool` has moved so far since it began; negative against its axis"
    )
    force: Annotated[Positive, Quantity("force")] | None = Field(
        default=None, description="end: when the sheets push `tool` so hard along its axis, of the whole tool"
    )
    rest: Annotated[Positive, Quantity("energy share")] | None = Field(
        default=None, description="end: when the kinetic energy is below this share of the internal energy, and `speed`"
    )
    tool: str | None = Field(default=None, description="whose stroke or force ends it")
    speed: Annotated[Positive, Quantity("speed")] = Field(
        default=0.01, description="of the plies at rest, at most; root of the mean square over their mass"
    )

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        given = one_of(self, ENDS)
        if given in ("stroke", "force"):
            if self.tool is None:
                raise ValueError(f"tool: is required with {given}: the name of the [[tool]] that decides")
        else:
            without(self, ("tool",), "a stroke or a force")
        if given != "rest":
            without(self, ("speed",), "rest")
        if self.stroke == 0.0:
            raise ValueError("stroke = 0: a displacement other than 0 is needed")
        return self


class TrimTable(JobTable):
    """A cut through a ply along closed curves, as the stage begins. `[[stage.trim]]`, below its stage."""

    ply: str | None = Field(default=None, description="that is cut; the only one if left out")
    rectangle: Annotated[tuple[Positive, Positive], Quantity("length")] | None = Field(
        default=None, description="curve: sides along x and y"
    )
    disc: Annotated[Positive, Quantity("length")] | None = Field(default=None, description="curve: diameter")
    polygon: tuple[Point, ...] | None = Field(default=None, description="curve: points in order")
    file: str | None = Field(
        default=None,
        description="curves: a DXF drawing of closed lines, a table of points, or a mesh whose border it is, beside "
        "the job; seen from above",
    )
    layer: str | None = Field(default=None, description="layer of the DXF drawing; all layers if left out")
    unit: FileUnit | None = Field(default=None, description="unit of the file, such as mm; a file may say its own")
    centre: Point = Field(default=(0.0, 0.0), description="where the middle of rectangle or disc, or the origin, lies")
    view: Literal["formed", "blank"] = Field(
        default="formed", description="what the curves are drawn on: the part as it is then, from above, or the blank"
    )
    keeps: Literal["inside", "outside"] = Field(default="inside", description="what stays")

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if one_of(self, CURVES) != "file":
            without(self, ("layer", "unit"), "a file")
        elif self.file is not None and not self.file.lower().endswith(".dxf"):
            without(self, ("layer",), "a DXF drawing as file")
        return self


class StageTable(JobTable):
    """A part of the process; what it does not say stays as in the stage before it. `[[stage]]`, in order of time."""

    name: Label = Field(description="name in all results")
    duration: Annotated[Positive, Quantity("duration")] | None = Field(
        default=None,
        description="of the stage; with an `end`, the most that it takes; without it, that of the strokes that begin",
    )
    end: EndTable | None = Field(default=None, description="ends it earlier; see below")
    tools: tuple[str, ...] | None = Field(
        default=None, description="those that act; the sheets pass through the others, which stay where they are"
    )
    grippers: tuple[str, ...] | None = Field(
        default=None, description="springs and grippers that pull; one that is left out opens for good"
    )
    move: tuple[MoveTable, ...] = Field(default=(), description="[[stage.move]]: motions that begin with it")
    pressure: tuple[StagePressureTable, ...] | None = Field(
        default=None, description="[[stage.pressure]]: all pressures from here on; [] for none"
    )
    friction: dict[str, FrictionValue] = Field(
        default={},
        description='other coefficients or laws from here on, by names of tools, or "LOWER / UPPER" of plies',
    )
    trim: tuple[TrimTable, ...] = Field(default=(), description="[[stage.trim]]: cuts through plies as it begins")
    gravity: Annotated[NotNegative, Quantity("acceleration")] | None = Field(default=None, description="downwards")
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None, description="mass-proportional damping of the nodes"
    )
    director_damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None, description="the same of the directors"
    )
    target_step: Annotated[NotNegative, Quantity("time step")] | None = Field(
        default=None, description="scale the mass until this time step is stable; 0 takes the added mass away"
    )
    frame_count: Annotated[int, Field(ge=1)] | None = Field(
        default=None, description="frames in it; its share of those of `[output]` if left out"
    )

    @model_validator(mode="before")
    @classmethod
    def _has_no_supports(cls, values: Any) -> Any:
        if isinstance(values, dict) and "supports" in values:
            raise ValueError("supports: a job has none; springs and grippers hold its plies, write grippers")
        return values

    @model_validator(mode="after")
    def _has_one_time(self) -> Self:
        if self.end is not None and self.end.time is not None and self.duration is not None:
            raise ValueError("duration and end.time: one of them is needed, both are given")
        for index, move in enumerate(self.move):
            if move.name in [other.name for other in self.move[:index]]:
                raise ValueError(f"move: {move.name} is moved twice; one motion each is needed")
        return self
