"""Blank holders in segments: sectors of a plate with an opening, each with a force or a gap of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...process.strokes import Fixed, ForceDriven, Motion
from ..shapes import DomeOpening, rotation_matrix
from ..tool import Tool
from .opening import DomeOpeningSector

# Directions of a sector over which its area is integrated.
DIRECTION_COUNT = 7200
DOWN = (0.0, 0.0, -1.0)


class SegmentLoad(NamedTuple):
    """What drives a segment: a force [N], or without one a fixed gap in addition to the thickness [m]."""

    force: float | None
    gap: float = 0.0


class Holder(NamedTuple):
    """A blank holder around an opening, before it is cut.

    Attributes:
        opening: whose plate it is; None for one that is not cut.
        height: of the sheet's upper face [m].
        mass: of all segments of the part [kg].
        ramp: time in which forces grow [s].
        stop: gap in addition to the thickness at which spacers hold it [m]; None without spacers.
        friction: of all segments.
        colour: for drawing.
    """

    opening: DomeOpening | None
    height: float
    mass: float
    ramp: float
    stop: float | None
    friction: float
    colour: tuple[float, float, float]

    def motion(self, load: SegmentLoad, mass: float) -> Motion:
        """Of a segment, or of the whole holder: by its force, down to the spacers."""
        if load.force is None:
            return Fixed()
        return ForceDriven.constant(load.force, mass, self.ramp, stop=None if self.stop is None else 0.0)

    def lift(self, load: SegmentLoad) -> float:
        """How far above the sheet it starts: on its spacers, or at its gap [m]."""
        return load.gap if load.force is None else self.stop or 0.0

    def segments(self, whole: int, loads: Sequence[SegmentLoad], areas: np.ndarray) -> tuple[Tool, ...]:
        """Tools ``blank_holder_1`` and so on, counter-clockwise from the x axis.

        Args:
            whole: segments of a whole turn.
            loads: one for each segment.
            areas: by which they share the mass [m^2].
        """
        step, tools = 360.0 / whole, []
        face_down = rotation_matrix((1.0, 0.0, 0.0), math.pi)
        for k, (load, share) in enumerate(zip(loads, areas / areas.sum(), strict=True)):
            # turned upside down, its own angles run clockwise
            assert self.opening is not None
            own = {name: getattr(self.opening, name) for name in DomeOpening.positional}
            sector = DomeOpeningSector(**own, begin=-(k + 1) * step, end=-k * step)
            shape = sector.placed((0.0, 0.0, self.height + self.lift(load)), face_down)
            motion = self.motion(load, self.mass * float(share))
            tools.append(Tool(f"blank_holder_{k + 1}", shape, motion, self.friction, DOWN, self.colour))
        return tuple(tools)


def sector_areas(
    whole: int, count: int, inner: Callable[[np.ndarray], np.ndarray], outer: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Areas of the first sectors of a turn between two borders around the origin, (count,) [m^2].

    Args:
        whole: sectors of a whole turn, the first of which begins at the x axis.
        count: how many, counter-clockwise.
        inner, outer: distances of the borders in given directions [m].
    """
    step = 2.0 * math.pi / whole
    angle = step * (np.arange(count)[:, None] + (np.arange(DIRECTION_COUNT) + 0.5) / DIRECTION_COUNT)
    wide = np.maximum(outer(angle) ** 2 - inner(angle) ** 2, 0.0)
    areas: np.ndarray = 0.5 * step * wide.mean(axis=1)
    return areas


def loads_of(text: str, count: int, what: str) -> list[SegmentLoad]:
    """Forces and gaps of segments, such as "300, 500, gap 0.0002", as an option has them.

    Raises:
        InputError: other than one for each segment, or no number of zero or more.
    """
    items = [item.strip() for item in text.split(",")]
    if len(items) != count:
        raise InputError(
            f"{what} = {text!r}: {len(items)} values for the {count} segments of the part; give one for each, a force "
            "[N] or a gap [m] as gap 0.0002"
        )
    return [_load(item, text, what) for item in items]


def _load(item: str, text: str, what: str) -> SegmentLoad:
    is_gap = item.lower().startswith("gap")
    try:
        value = float(item[3:].lstrip(" =:") if is_gap else item)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise InputError(
            f"{what} = {text!r}: {item!r}: a force of zero or more [N] is needed, or a gap [m] as gap 0.0002"
        )
    if is_gap and value > 0.1:
        raise InputError(f"{what} = {text!r}: {item!r}: a gap of at most 0.1 m is allowed; it is in metres")
    return SegmentLoad(None, value) if is_gap else SegmentLoad(value)
