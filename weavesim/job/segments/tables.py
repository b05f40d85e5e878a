"""Keys of a tool that is driven by a force, whole or in segments."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from ...checks import Finite, NotNegative
from ...process.strokes import Stroke
from ...ranges import Quantity
from ..stages.paths import CarriedTable
from ..tables import JobTable, check_knots, one_of, without

MOST_SEGMENTS = 72
LOADS = ("force", "forces", "gap", "gaps")


class SegmentTable(JobTable):
    """What drives one segment of a tool, in place of its share of the whole. `[[tool.segment]]`, below its tool."""

    number: Annotated[int, Field(ge=1, le=MOST_SEGMENTS)] = Field(
        description="of the segment, from 1 on, counter-clockwise from above"
    )
    force: Annotated[NotNegative, Quantity("force")] | None = Field(default=None, description="load: on this segment")
    forces: Annotated[tuple[Finite, ...], Quantity("force")] | None = Field(
        default=None, description="load: forces at `times`, straight between them"
    )
    times: Annotated[tuple[Finite, ...], Quantity("time")] | None = Field(
        default=None, description="of `forces` or `gaps`"
    )
    gap: Annotated[NotNegative, Quantity("gap")] | None = Field(
        default=None, description="load: fixed, so far back from where it starts"
    )
    gaps: Annotated[tuple[Finite, ...], Quantity("gap")] | None = Field(
        default=None, description="load: prescribed, so far back from there at `times`, straight between them"
    )

    @model_validator(mode="after")
    def _has_one_load(self) -> Self:
        given = one_of(self, LOADS)
        if given in ("forces", "gaps"):
            check_curve(self.times, getattr(self, given), given)
        else:
            without(self, ("times",), "forces or gaps")
        return self


class PushedTable(CarriedTable):
    """Keys of a force: its curve, spacers, and segments that share it."""

    forces: Annotated[tuple[Finite, ...], Quantity("force")] | None = Field(
        default=None, description="instead of `force`: forces at `times`, straight between them, of the whole tool"
    )
    gaps: Annotated[tuple[Finite, ...], Quantity("gap")] | None = Field(
        default=None,
        description="instead of a force or a stroke: how far back it stands from where it starts, at `times`, straight "
        "between them",
    )
    times: Annotated[tuple[Finite, ...], Quantity("time")] | None = Field(
        default=None, description="of `forces` or `gaps`"
    )
    stop: Annotated[NotNegative, Quantity("gap")] | None = Field(
        default=None,
        description="shut height: spacers stop a tool under a force when it is so far from its start",
    )
    segments: Annotated[int, Field(ge=2, le=MOST_SEGMENTS)] | None = Field(
        default=None, description="cuts a mesh into sectors NAME_1, NAME_2, ..., each of which moves on its own"
    )
    segments_from: Annotated[Finite, Quantity("angle")] = Field(
        default=0.0, description="where the first sector begins, from the x axis counter-clockwise"
    )
    segment: tuple[SegmentTable, ...] = Field(
        default=(), description="[[tool.segment]]: loads of segments that are not their shares of the whole"
    )

    @model_validator(mode="after")
    def _shares_a_force(self) -> Self:
        if self.forces is not None:
            check_curve(self.times, self.forces, "forces")
        elif self.gaps is not None:
            check_curve(self.times, self.gaps, "gaps")
        else:
            without(self, ("times",), "forces or gaps")
        if self.segments is None:
            without(self, ("segments_from",), "segments")
            if self.segment:
                raise ValueError("segment: has no effect without segments; leave it out")
            return self
        numbers = [each.number for each in self.segment]
        for number in numbers:
            if number > self.segments:
                raise ValueError(f"segment: number = {number}: the tool has {self.segments} segments")
            if numbers.count(number) > 1:
                raise ValueError(f"segment: number = {number} is given twice; one table for each is needed")
        return self


def check_curve(times: tuple[float, ...] | None, values: tuple[float, ...] | None, name: str) -> None:
    """Raise ValueError unless there are as many increasing times as forces or gaps, none of which is negative."""
    check_knots(times, values, "times", name)
    if min(values or ()) < 0.0:
        why = "they act along the tool's axis" if name == "forces" else "they are back from where the tool starts"
        raise ValueError(f"{name}: {name} of zero or more are needed; {why}")


def gap_motion(times: tuple[float, ...], gaps: tuple[float, ...]) -> tuple[Stroke, float]:
    """Motion of a tool that starts at the first of some gaps, and how far back that is [m]."""
    return Stroke(times, tuple(gaps[0] - gap for gap in gaps)), gaps[0]
