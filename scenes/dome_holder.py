"""The tool of the double dome around its punch: sizes, and the blank holder, whole or in segments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from weavesim.app.options import Need, RunOptions
from weavesim.checks import NotNegative
from weavesim.errors import InputError
from weavesim.ranges import Quantity
from weavesim.tools.segments.holder import DOWN, Holder, SegmentLoad, loads_of, sector_areas
from weavesim.tools.shapes import DomeOpening, Shape
from weavesim.tools.tool import Tool

# Full blank of the paper [m].
BLANK_LENGTH = 0.470
BLANK_WIDTH = 0.270
# Representative tool [m].
PUNCH_RADIUS = 0.060
DOME_DISTANCE = 0.170
DIE_ENTRY_RADIUS = 0.010
SMALLEST_CLEARANCE = 0.0012
# Symmetry planes of each part, every one of which halves the blank.
SYMMETRY: Mapping[str, tuple[str, ...]] = {"quarter": ("x", "y"), "half": ("y",), "full": ()}
# For the whole holder; a quarter of the blank carries a quarter.
BLANK_HOLDER_MASS = 2.0
BLANK_HOLDER_PRESSURE = 20.0e3
BLANK_HOLDER_RAMP = 2.0e-3


class HolderOptions(RunOptions):
    """What holds the blank, as options."""

    friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.2, description="Coulomb coefficient between sheet and tools"
    )
    blank_holder_force: Annotated[NotNegative, Quantity("force")] | None = Field(
        default=None, description="force of the whole holder [N]; the default is 20 kPa on the initial flange area"
    )
    blank_holder_gap: Annotated[NotNegative, Quantity("gap")] | None = Field(
        default=None, description="fixed gap of the holder in addition to the thickness [m], instead of a force"
    )
    blank_holder_stop: Annotated[NotNegative, Quantity("gap")] | None = Field(
        default=None, description="gap in addition to the thickness at which spacers stop a holder under a force [m]"
    )
    blank_holder_segments: int = Field(
        default=1,
        ge=1,
        le=72,
        description="sectors of the whole holder, each of which moves on its own; a multiple of 2 for a half, of 4 for "
        "a quarter",
    )
    blank_holder_loads: str | None = Field(
        default=None,
        description="force of each segment of the part [N], or its fixed gap as 'gap 0.0002' [m], comma-separated, "
        "counter-clockwise from the long axis [default: blank_holder_force by their areas]",
    )

    needs: ClassVar[Mapping[str, Need]] = {
        "blank_holder_loads": Need("blank_holder_segments", lambda options: options.blank_holder_segments > 1),
    }


def clearance(thickness: float) -> float:
    """Between the default punch and die [m]: a thicker sheet or stack gets an opening that is made for it."""
    return max(SMALLEST_CLEARANCE, thickness)


def blank_holder_area(thickness: float) -> float:
    """Flat area of the undeformed blank, of ``thickness`` [m], between die and holder [m^2].

    Raises:
        InputError: there is none, since the fabric is too thick for these tools.
    """
    rim = PUNCH_RADIUS + clearance(thickness) + DIE_ENTRY_RADIUS
    if rim > 0.5 * BLANK_WIDTH:
        raise InputError(
            f"double dome: the fabric is {1e3 * thickness:.3g} mm thick, and an opening made for it is wider "
            f"than the blank; at most {1e3 * (0.5 * BLANK_WIDTH - PUNCH_RADIUS - DIE_ENTRY_RADIUS):.3g} mm is allowed"
        )
    return BLANK_LENGTH * BLANK_WIDTH - (math.pi * rim**2 + 2.0 * rim * DOME_DISTANCE)


def raised(shape: Shape, height: float) -> Shape:
    """``shape`` moved up by ``height`` [m]."""
    x, y, z = shape.origin
    return shape.model_copy(update={"origin": (x, y, z + height)})


def make_holder(options: HolderOptions, whole: Shape, die: Shape, thickness: float, parts: int) -> tuple[Tool, ...]:
    """The blank holder on a sheet or stack of ``thickness`` [m] whose middle is at z = 0, whole or in segments.

    Args:
        options: of the run.
        whole: closed on a sheet of zero thickness.
        die: under it; its opening is cut into segments.
        thickness: of the sheet [m].
        parts: into which symmetry planes cut the blank.

    Raises:
        InputError: options that contradict each other.
    """
    force, gap, loads = options.blank_holder_force, options.blank_holder_gap, options.blank_holder_loads
    if sum(given is not None for given in (force, gap, loads)) > 1:
        names = "loads of its segments and a force or a gap of all" if loads is not None else "both a force and a gap"
        raise InputError(f"blank holder: {names} are given; choose one")
    if gap is not None and options.blank_holder_stop is not None:
        raise InputError("blank holder: it has a fixed gap, and no use for a stop; choose one")
    if gap is None and force is None:
        force = BLANK_HOLDER_PRESSURE * blank_holder_area(thickness)
    load = SegmentLoad(None if force is None else force * (1.0 / parts), gap or 0.0)
    cut = options.blank_holder_segments > 1
    if cut and not (isinstance(die, DomeOpening) and isinstance(whole, DomeOpening)):
        raise InputError("blank_holder_segments: the default holder is cut, not a mesh; leave die and blank_holder out")
    holder = Holder(
        die if isinstance(die, DomeOpening) else None, 0.5 * thickness, BLANK_HOLDER_MASS / parts, BLANK_HOLDER_RAMP,
        options.blank_holder_stop, options.friction, (0.62, 0.55, 0.45),
    )  # fmt: skip
    if cut:
        return segments(options, holder, load, thickness, parts)
    shape = raised(whole, holder.height + holder.lift(load))
    return (Tool("blank_holder", shape, holder.motion(load, holder.mass), holder.friction, DOWN, holder.colour),)


def segments(
    options: HolderOptions, holder: Holder, load: SegmentLoad, thickness: float, parts: int
) -> tuple[Tool, ...]:
    """The segments of the holder that lie on the part; ``load`` is that of the whole part.

    Raises:
        InputError: segments that a symmetry plane cuts, or loads that are not theirs.
    """
    whole = options.blank_holder_segments
    if whole % parts:
        raise InputError(
            f"blank_holder_segments = {whole}: a symmetry plane would cut one; take a multiple of {parts}, or another "
            "part"
        )
    rim, half_length = PUNCH_RADIUS + clearance(thickness) + DIE_ENTRY_RADIUS, 0.5 * DOME_DISTANCE

    def inner(angle: np.ndarray) -> np.ndarray:
        x, y = np.abs(np.cos(angle)), np.abs(np.sin(angle))
        beside = rim / np.maximum(y, 1.0e-12)
        round_end = half_length * x + np.sqrt(np.maximum(rim**2 - (half_length * y) ** 2, 0.0))
        return np.where(beside * x <= half_length, beside, round_end)

    def outer(angle: np.ndarray) -> np.ndarray:
        x, y = np.abs(np.cos(angle)), np.abs(np.sin(angle))
        return np.minimum(0.5 * BLANK_LENGTH / np.maximum(x, 1e-12), 0.5 * BLANK_WIDTH / np.maximum(y, 1e-12))

    areas = sector_areas(whole, whole // parts, inner, outer)
    if options.blank_holder_loads is not None:
        loads = loads_of(options.blank_holder_loads, len(areas), "blank_holder_loads")
    else:
        shares = (areas / areas.sum()).tolist()
        loads = [load if load.force is None else SegmentLoad(load.force * each) for each in shares]
    return holder.segments(whole, loads, areas)
