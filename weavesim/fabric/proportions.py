"""Values of a fabric that hardly fit each other: the likely slip is the unit of one of them."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from .bending.law import YarnName
from .bending.yarns import YarnBending
from .cell.contract import UnitCell
from .cell.membrane import LinearMembrane
from .cell.tape import UnidirectionalTape
from .cell.weaves import CrossedYarns

if TYPE_CHECKING:
    from .fabric import Fabric

logger = logging.getLogger(__name__)

# From loose knits and nonwovens to meshes of metal wire [kg/m^3].
USUAL_DENSITY = (100.0, 4000.0)
# (D / weight per area)^(1/3), over which a strip droops under its weight: from silk to stiff prepregs [m].
USUAL_BENDING_LENGTH = (2.0e-3, 0.4)
# 12 D / t^3: yarns and fibres slide on each other, so that a fabric is softer than a plate of its fibres; a ply of
# carbon in cold resin is about as stiff [Pa].
USUAL_BENDING_MODULUS = (1.0e2, 2.0e11)
# A sheet has about the height of two crossed yarns; flattened, spread ones are far apart only in the direction of z.
USUAL_THICKNESS_RATIO = (0.3, 200.0)
# Height of a crossover over the distance of the yarns.
LARGEST_USUAL_CRIMP = 1.5
# Twist over the mean of warp and weft: 0.5 of a plate, less of yarns that slide on each other.
LARGEST_USUAL_TWIST = 3.0
# Stiffness of one yarn family over that of the other: beyond it, one is probably in another unit (N/mm, N mm).
LARGEST_USUAL_FAMILY_RATIO = 300.0
GRAVITY = 9.81


def disproportionate_values(fabric: Fabric) -> Iterator[str]:
    """Sentences on values of a fabric that hardly fit each other."""
    density = fabric.areal_density / fabric.thickness
    low, high = USUAL_DENSITY
    if not low <= density <= high:
        yield (
            f"areal_density = {fabric.areal_density:.4g} kg/m^2 over thickness = {fabric.thickness:.4g} m is a density "
            f"of {density:.4g} kg/m^3; usual are {low:g} to {high:g}: check both units (g/m^2, mm)"
        )
    yield from _bending(fabric)
    if isinstance(fabric.bending, YarnBending):
        yield from _twist(fabric.bending, fabric.thickness)
    for sentence in families_apart(fabric.unit_cell):
        if isinstance(fabric.unit_cell, CrossedYarns):
            yield sentence
        else:  # a ply of parallel fibres has it too
            logger.warning("%s: %s; right for fibres of one direction, not for a weave", fabric.name, sentence)
    if isinstance(fabric.bending, YarnBending) and isinstance(fabric.unit_cell, CrossedYarns):
        both = [fabric.bending.strip_stiffness(yarn, fabric.thickness) for yarn in ("warp", "weft")]
        yield from _families("the bending stiffness", "N m", both, "N mm")
    if isinstance(fabric.unit_cell, CrossedYarns):
        yield from _crossovers(fabric, fabric.unit_cell)


def _bending(fabric: Fabric) -> Iterator[str]:
    """Of the stiffer family, and of the softer one if it has any stiffness."""
    yarns: tuple[YarnName, ...] = ("warp", "weft")
    families = [fabric.bending.strip_stiffness(yarn, fabric.thickness) for yarn in yarns]
    for stiffness in sorted({value for value in families if value > 0.0}, reverse=True):
        if found := list(_stiffness(fabric, stiffness)):
            yield from found
            return


def _stiffness(fabric: Fabric, stiffness: float) -> Iterator[str]:
    length = (stiffness / (GRAVITY * fabric.areal_density)) ** (1.0 / 3.0)
    low, high = USUAL_BENDING_LENGTH
    if not low <= length <= high:
        yield (
            f"the bending stiffness, {stiffness:.4g} N m, and areal_density = {fabric.areal_density:.4g} kg/m^2 let a "
            f"strip droop over {length:.3g} m; usual are {low:g} to {high:g} m: check the bending law (N mm, MPa), "
            "thickness (mm) and areal_density (g/m^2)"
        )
    modulus = 12.0 * stiffness / fabric.thickness**3
    low, high = USUAL_BENDING_MODULUS
    if not low <= modulus <= high:
        yield (
            f"the bending stiffness, {stiffness:.4g} N m, of a sheet {fabric.thickness:.4g} m thick is that of a solid "
            f"plate with a modulus of {modulus:.3g} Pa; usual for fabrics are {low:g} to {high:g} Pa: check the "
            "bending law (N mm, MPa) and thickness (mm)"
        )


def families_apart(cell: UnitCell) -> Iterator[str]:
    """A sentence on warp and weft of a cell whose stiffnesses are so far apart that a unit is likely wrong."""
    if isinstance(cell, CrossedYarns | LinearMembrane):
        yield from _families("the yarn stiffness per width", "N/m", cell.yarn_stiffness_per_width, "N/mm, MPa, mm^2")


def families_alike(fabric: Fabric) -> bool:
    """Whether warp and weft may be exchanged: every number of the one is that of the other.

    Of parts that do not call them by name, such as a bending modulus, it is taken for granted; not so of a tape.
    """
    cell = fabric.unit_cell
    if isinstance(cell, UnidirectionalTape) or getattr(cell, "warp_crimp_share", 0.5) != 0.5:
        return False
    for part in (cell, fabric.bending):
        for name in type(part).model_fields:
            other = name.replace("warp", "weft")
            if other != name and hasattr(part, other) and getattr(part, name) != getattr(part, other):
                return False
    return True


def _families(what: str, unit: str, both: Sequence[float], slip: str) -> Iterator[str]:
    warp, weft = both
    if min(both) > 0.0 and max(both) > LARGEST_USUAL_FAMILY_RATIO * min(both):
        stiff, soft = ("warp", "weft") if warp > weft else ("weft", "warp")
        yield (
            f"{what} is {warp:.4g} {unit} along the warp and {weft:.4g} {unit} along the weft: the {stiff} is "
            f"{max(both) / min(both):.4g} times as stiff as the {soft}, usual are up to "
            f"{LARGEST_USUAL_FAMILY_RATIO:g} times; check the units of both ({slip})"
        )


def _twist(bending: YarnBending, thickness: float) -> Iterator[str]:
    warp, weft = bending.strip_stiffness("warp", thickness), bending.strip_stiffness("weft", thickness)
    if min(warp, weft) > 0.0 and bending.twist > LARGEST_USUAL_TWIST * math.sqrt(warp * weft):
        yield (
            f"bending.twist = {bending.twist:.4g} N m is {bending.twist / math.sqrt(warp * weft):.3g} times the "
            f"stiffness of warp and weft, {warp:.4g} and {weft:.4g} N m; usual are up to {LARGEST_USUAL_TWIST:g} "
            "times: check the units (N mm)"
        )


def _crossovers(fabric: Fabric, cell: CrossedYarns) -> Iterator[str]:
    height = cell.crossover_height
    if height == 0.0:
        return
    ratio = fabric.thickness / height
    low, high = USUAL_THICKNESS_RATIO
    if not low <= ratio <= high:
        yield (
            f"thickness = {fabric.thickness:.4g} m is {ratio:.3g} times crossover_height = {height:.4g} m; usual are "
            f"{low:g} to {high:g} times: check both units (mm)"
        )
    for yarn, half_spacing in zip(("warp", "weft"), cell.half_spacing, strict=True):
        if height > LARGEST_USUAL_CRIMP * 2.0 * half_spacing:
            yield (
                f"crossover_height = {height:.4g} m is {height / (2.0 * half_spacing):.3g} times the distance of the "
                f"crossovers, 2 {yarn}_half_spacing = {2.0 * half_spacing:.4g} m; usual are up to "
                f"{LARGEST_USUAL_CRIMP:g} times: check both units (mm)"
            )
