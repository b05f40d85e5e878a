"""Paths and rotations of tools in a job: their tables, and the motions that are made of them."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from ...checks import Finite, NotNegative, Positive
from ...process.motions.paths import PathMotion, Rotation
from ...process.strokes import Motion
from ...ranges import Quantity
from ..tables import Coordinate, JobTable, check_knots, without

# A ramp is this share of the time of its turn.
RAMP_SHARE = 0.05


class RotationTable(JobTable):
    """A tool that turns about an axis. `rotation = { ... }` in its tool or move, or `[tool.rotation]` below it."""

    axis: tuple[Finite, Finite, Finite] = Field(
        description="direction of the axis; angles count counter-clockwise when it points at the viewer"
    )
    point: tuple[Coordinate, Coordinate, Coordinate] = Field(
        default=(0.0, 0.0, 0.0),
        description="of the axis, where the tool then stands; its path and stroke carry the axis along",
    )
    angle: Annotated[Finite, Quantity("turn of a tool")] | None = Field(
        default=None, description="of the whole turn, at `speed`; a negative one turns clockwise"
    )
    speed: Annotated[Positive, Quantity("turning speed")] | None = Field(default=None, description="of the turn")
    ramp: Annotated[NotNegative, Quantity("time")] | None = Field(
        default=None, description="time to reach the speed; by default 5 % of the time of the turn"
    )
    delay: Annotated[NotNegative, Quantity("time")] = Field(default=0.0, description="when the turn begins")
    times: Annotated[tuple[Finite, ...], Quantity("time")] | None = Field(
        default=None, description="instead of `angle`: times of `angles`"
    )
    angles: Annotated[tuple[Finite, ...], Quantity("turn of a tool")] | None = Field(
        default=None, description="one for each of `times`; a smooth curve goes through them, at rest at both ends"
    )

    @model_validator(mode="after")
    def _is_a_turn(self) -> Self:
        if (self.angle is None) == (self.angles is None):
            raise ValueError("angle or angles: one of them is needed")
        if self.angle is not None:
            if self.speed is None:
                raise ValueError("speed: is required with angle")
            if self.angle == 0.0:
                raise ValueError("angle = 0: for a tool that does not turn leave the rotation out")
            without(self, ("times",), "angles")
        else:
            without(self, ("speed", "ramp", "delay"), "angle")
            check_knots(self.times, self.angles, "times", "angles")
        if not any(self.axis):
            raise ValueError("axis = (0, 0, 0): a direction is needed, other than zero")
        return self

    def rotation(self) -> Rotation:
        """The rotation that it describes."""
        if self.angle is None:
            return Rotation(self.axis, self.point, self.times, self.angles)
        assert self.speed is not None
        ramp = self.ramp
        if ramp is None:
            ramp = RAMP_SHARE * math.radians(abs(self.angle)) / self.speed
        return Rotation.smooth(self.axis, self.point, self.angle, self.speed, ramp, start_time=self.delay)


class WayTable(JobTable):
    """Keys of what may follow a path, beside its stroke or force."""

    path: tuple[tuple[Coordinate, Coordinate, Coordinate], ...] | None = Field(
        default=None,
        description="ways from where the tool then stands, at `path_times`; a smooth curve goes through them, at rest "
        "at both ends",
    )
    path_times: Annotated[tuple[Finite, ...], Quantity("time")] | None = Field(
        default=None, description="one for each point of `path`"
    )

    @model_validator(mode="after")
    def _is_a_path(self) -> Self:
        if self.path is None:
            without(self, ("path_times",), "a path")
        else:
            check_knots(self.path_times, self.path, "path_times", "points of the path")
        return self

    def on_path(self, along: Motion) -> Motion:
        """A motion along the axis, carried along the path if there is one."""
        return along if self.path is None else PathMotion(self.path_times or (), self.path, along=along)


class CarriedTable(WayTable):
    """Keys of what may also turn."""

    rotation: RotationTable | None = Field(default=None, description="turns it about an axis; see below")

    @property
    def is_carried(self) -> bool:
        """Whether it follows a path or turns."""
        return self.path is not None or self.rotation is not None

    def carried(self, along: Motion) -> Motion:
        """A motion along the axis, carried along the path and turned if that is wanted."""
        if not self.is_carried:
            return along
        rotation = None if self.rotation is None else self.rotation.rotation()
        return PathMotion(self.path_times or (), self.path or (), rotation, along)
