"""The curves of a fabric by its laws alone, and how far their numbers are trusted."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..fabric.bending import YarnBending
from ..fabric.bending.law import YarnName
from ..fabric.cell import UnitCell
from ..fabric.closed_forms import moment_along
from ..fabric.fabric import Fabric
from ..fabric.provenance import Number, Origin, given_numbers, with_number

logger = logging.getLogger(__name__)

POINT_COUNT = 161
# Of a law without data.
SHOWN_ANGLE, LARGEST_SHOWN_ANGLE = math.radians(60.0), math.radians(80.0)
SHOWN_CURVATURE = 60.0  # [1/m]
# Curves are shown this far beyond their data, relative to them.
BEYOND = 1.2
LEAST_STRAIN, CRIMP_STRAINS = 0.01, 2.5
PRESSURE = 100.0e3  # [Pa], that of a vacuum bag
# A band and what is extrapolated may rise to this multiple of the curves within the data before they leave a chart.
BAND_ROOM = 1.8
YARNS: tuple[YarnName, YarnName] = ("warp", "weft")


@dataclass(frozen=True)
class Line:
    """One curve: label, abscissa (n,) and ordinate (n,) in the units of its ``CurveSet``."""

    label: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class CurveSet:
    """Curves of one law.

    Attributes:
        name: "shear", "tension", "bending", "compaction", "thickening".
        title, x_label, y_label: for readers, with units.
        lines: the first one is what the band is of.
        band: abscissa, least and largest ordinate (n,) of the first line if each number of the law is at either end of
            its range, one at a time; None if no number has a range.
        trusted: part of the abscissa that is trusted; None if nobody has said.
        measured_to: abscissa of the last measured point; None for a law without data.
        note: what else one should know.
    """

    name: str
    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    band: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
    trusted: tuple[float, float] | None = None
    measured_to: float | None = None
    note: str = ""

    def shown_ordinates(self, end: float | None = None) -> tuple[float, float] | None:
        """Range of ordinates to draw: of the curves up to an abscissa, not of what is extrapolated beyond.

        Thickness is not drawn from zero.

        Args:
            end: abscissa; None takes that of the last measured point, or of the first line's end.

        Returns:
            None where all ordinates are the same.
        """
        last = end or self.measured_to or float(self.lines[0].x[-1])
        last *= 1.0 + 1.0e-9
        within = np.concatenate([line.y[line.x <= last] for line in self.lines])
        least, most = float(within.min()), float(within.max())
        low, high = least, most
        if self.band is not None:
            x, below, above = self.band
            low, high = min(low, float(below[x <= last].min())), max(high, float(above[x <= last].max()))
        if self.y_label.startswith("thickness"):
            margin = 0.1 * (high - low) or 0.1 * high
            return max(low - margin, 0.0), high + margin
        if most <= least:
            return None
        return 1.1 * min(least, 0.0), min(1.05 * high, BAND_ROOM * most) if most > 0.0 else 0.0


@dataclass(frozen=True)
class Unloading:
    """What shear does when a fabric is let go after it was sheared to ``angle`` [rad].

    Attributes:
        angle: from where.
        residual_angle: at which its moment is zero [rad].
        lost_share: of the work of loading that friction takes, on the way there and back.
    """

    angle: float
    residual_angle: float
    lost_share: float


def curves_of(fabric: Fabric) -> tuple[CurveSet, ...]:
    """All curves of a fabric. The tension of the yarns needs the kernel of its unit cell, which may be compiled."""
    return shear_curves(fabric), tension_curves(fabric), bending_curves(fabric), *thickness_curves(fabric)


def unloading_of(fabric: Fabric, angle: float) -> Unloading:
    """Loading to ``angle`` [rad] and unloading, without tension."""
    up = np.linspace(0.0, angle, 2 * POINT_COUNT)
    path = np.concatenate([up, up[::-1]])
    moment = moment_along(fabric, path)
    back, down = path[len(up) :], moment[len(up) :]
    stop = int(np.argmax(down <= 0.0)) if np.any(down <= 0.0) else len(down) - 1
    if stop > 0 and down[stop] < down[stop - 1]:
        residual = float(np.interp(0.0, down[[stop, stop - 1]], back[[stop, stop - 1]]))
    else:
        residual = float(back[stop])
    work = _area(up, moment[: len(up)])
    regained = -_area(back[: stop + 1], np.maximum(down[: stop + 1], 0.0))
    return Unloading(angle, residual, max(1.0 - regained / work, 0.0) if work > 0.0 else 0.0)


def _area(x: np.ndarray, y: np.ndarray) -> float:
    return float((0.5 * (y[1:] + y[:-1]) * np.diff(x)).sum())


def varied(fabric: Fabric, tables: Sequence[str]) -> Iterator[Fabric]:
    """The fabric with each number of these tables at either end of its range, one at a time.

    Ends of a range that the fabric cannot have are left out, and logged. Curves are scaled by their scatter.
    """
    plain = fabric.model_copy(update={"provenance": ()})
    for name, number in given_numbers(fabric).items():
        origin = fabric.origin_of(name)
        if origin is None or not any(name == table or name.startswith(f"{table}.") for table in tables):
            continue
        for end in _ends(number, origin):
            try:
                yield with_number(plain, name, end)
            except InputError as error:
                logger.info("%s at the end of its range is left out: %s", name, error)


def _ends(number: Number, origin: Origin) -> Iterator[float | tuple[float, ...]]:
    """Values of a number at both ends of its range, other than its own."""
    if origin.scatter is not None:
        for factor in (max(1.0 - origin.scatter, 0.0), 1.0 + origin.scatter):
            scaled = tuple(factor * value for value in number.values)
            yield scaled if isinstance(number.value, tuple) else scaled[0]
    elif origin.range is not None and len(number.values) == 1:  # of a curve it says where, not how much
        for end in origin.range:
            if end != number.values[0]:
                yield (end,) if isinstance(number.value, tuple) else end


def _band(
    fabric: Fabric,
    tables: Sequence[str],
    x: np.ndarray,
    factor: float,
    first: np.ndarray,
    curve: Callable[[list[Fabric]], np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """``curve`` gives the ordinates (k, n) of k fabrics in SI units."""
    others = list(varied(fabric, tables))
    if not others:
        return None
    values = np.vstack([curve(others), first])
    return x, factor * values.min(axis=0), factor * values.max(axis=0)


def _of_each(curve: Callable[[Fabric], np.ndarray]) -> Callable[[list[Fabric]], np.ndarray]:
    """The curves (k, n) of k fabrics."""
    return lambda fabrics: np.array([curve(one) for one in fabrics])


def shear_curves(fabric: Fabric) -> CurveSet:
    """Moment over shear angle, without tension."""
    measured = fabric.shear.trusted_angle
    end = min(BEYOND * (measured or SHOWN_ANGLE / BEYOND), LARGEST_SHOWN_ANGLE)
    angle = np.linspace(0.0, end, POINT_COUNT)
    degrees = np.degrees(angle)
    loading = moment_along(fabric, angle)
    lines = [Line("loading", degrees, loading)]
    note = "no friction: unloading goes back along the same curve"
    if fabric.shear_friction is not None:
        lines.append(
            Line("elastic part", degrees, moment_along(fabric.model_copy(update={"shear_friction": None}), angle))
        )
        top = measured or end
        path = np.concatenate([np.linspace(0.0, top, POINT_COUNT), np.linspace(top, 0.0, POINT_COUNT)[1:]])
        back = slice(POINT_COUNT - 1, None)
        lines.append(Line("unloading", np.degrees(path[back]), moment_along(fabric, path)[back]))
        note = "friction: unloading is lower by twice its limit"
    band = _band(
        fabric, ("shear", "shear_friction"), degrees, 1.0, loading,
        lambda fabrics: np.array([moment_along(one, angle) for one in fabrics]),
    )  # fmt: skip
    origin = fabric.origin_of("shear.angle") if hasattr(fabric.shear, "angle") else None
    trusted = origin.range if origin and not origin.assumed else None
    return CurveSet(
        "shear", "Shear", "shear angle [°]", "moment per area [N/m]", tuple(lines), band,
        None if trusted is None else (math.degrees(trusted[0]), math.degrees(trusted[1])),
        None if measured is None else math.degrees(measured), note,
    )  # fmt: skip


def tension_curves(fabric: Fabric) -> CurveSet:
    """Force per width over strain: each family pulled with the other held, and both at once."""
    cell = fabric.unit_cell
    end = max(LEAST_STRAIN, CRIMP_STRAINS * _crimp_strain(cell))
    strain = np.linspace(0.0, end, POINT_COUNT)
    zero = np.zeros_like(strain)
    warp, weft, both = (np.column_stack(pair) for pair in ((strain, zero), (zero, strain), (strain, strain)))
    pulls = {
        "warp, weft held": (warp, 0), "weft, warp held": (weft, 1),
        "warp, both pulled": (both, 0), "weft, both pulled": (both, 1),
    }  # fmt: skip
    lines: list[Line] = []
    first = zero
    for label, (strains, row) in pulls.items():
        force = _forces([cell], strains)[0][:, row]
        first = force if not lines else first
        lines.append(Line(label, 100.0 * strain, 1.0e-3 * force))
    band = _band(
        fabric, ("unit_cell",), 100.0 * strain, 1.0e-3, first,
        lambda fabrics: _forces([one.unit_cell for one in fabrics], warp)[:, :, 0],
    )  # fmt: skip
    return CurveSet("tension", "Tension of the yarns", "strain [%]", "force per width [kN/m]", tuple(lines), band)


def _crimp_strain(cell: UnitCell) -> float:
    """Strain at which the yarns are straight, of the more crimped family; 0 for a cell without crimp."""
    lengths, spacings = getattr(cell, "chord_length", ()), getattr(cell, "half_spacing", ())
    return max((length / spacing - 1.0 for length, spacing in zip(lengths, spacings, strict=True)), default=0.0)


def _forces(cells: Sequence[UnitCell], strains: np.ndarray) -> np.ndarray:
    """Forces per width [N/m] of cells at strains (n, 2), (cell, n, 2)."""
    from ..fabric.response import respond

    count = len(strains)
    every = [cell for cell in cells for _ in range(count)]
    response = respond(every, np.tile(1.0 + strains, (len(cells), 1)))
    return response.force_per_width.reshape(len(cells), count, 2)


def bending_curves(fabric: Fabric) -> CurveSet:
    """Moment per width over curvature of a strip along each family, loaded and, with friction, unloaded."""
    ends = [end for end in fabric.bending.trusted_curvature if end is not None]
    end = BEYOND * max(ends) if ends else SHOWN_CURVATURE
    curvature = np.linspace(0.0, end, POINT_COUNT)
    path = np.concatenate([curvature, curvature[-2::-1]])
    lines = []
    for yarn in YARNS:
        lines.append(Line(yarn, curvature, 1.0e3 * _bending_moment(fabric, yarn, path)[:POINT_COUNT]))
        if fabric.bending.friction_limit[YARNS.index(yarn)] > 0.0:
            back = slice(POINT_COUNT - 1, None)
            lines.append(Line(f"{yarn}, unloading", path[back], 1.0e3 * _bending_moment(fabric, yarn, path)[back]))
    band = _band(
        fabric, ("bending", "thickness"), curvature, 1.0e3, 1.0e-3 * lines[0].y,
        lambda fabrics: np.array([_bending_moment(one, "warp", curvature) for one in fabrics]),
    )  # fmt: skip
    origin = fabric.origin_of("bending.warp.curvature")
    return CurveSet(
        "bending", "Bending", "curvature [1/m]", "moment per width [N mm/m]", tuple(lines), band,
        origin.range if origin and not origin.assumed else None, min(ends) if ends else None,
    )  # fmt: skip


def _bending_moment(fabric: Fabric, yarn: YarnName, path: np.ndarray) -> np.ndarray:
    """Moment per width [N] of a strip along a path of curvatures (n,) [1/m] from rest."""
    law = fabric.bending
    if law.bends_linearly(yarn) or not isinstance(law, YarnBending):
        return law.strip_stiffness(yarn, fabric.thickness) * path
    family = law.families[YARNS.index(yarn)]
    moment = np.sign(path) * family.moment(np.abs(path))
    if family.friction_limit > 0.0 and family.friction_stiffness > 0.0:
        reach, slip = family.friction_limit / family.friction_stiffness, 0.0
        for k, curvature in enumerate(path):
            slip = curvature - min(max(curvature - slip, -reach), reach)
            moment[k] += family.friction_stiffness * (curvature - slip)
    return moment


def thickness_curves(fabric: Fabric) -> tuple[CurveSet, CurveSet]:
    """Thickness over pressure and over shear angle, at unit stretch."""
    pressure = np.linspace(0.0, PRESSURE, POINT_COUNT)

    def pressed(one: Fabric) -> np.ndarray:
        ratio = one.compaction.thickness_ratio(one.unit_cell, np.ones_like(pressure), pressure)
        return one.thickness * ratio

    angle = np.linspace(0.0, SHOWN_ANGLE, POINT_COUNT)

    def sheared(one: Fabric) -> np.ndarray:
        return one.thickness * one.compaction.thickness_ratio(one.unit_cell, np.cos(angle), np.zeros_like(angle))

    at = np.radians([0.0, 45.0])
    thickness = fabric.thickness * fabric.compaction.thickness_ratio(fabric.unit_cell, np.cos(at), np.zeros(2))
    content = fabric.compaction.fibre_volume_fraction(thickness, np.cos(at))
    note = "" if content is None else f"fibre content {content[0]:.1%} flat, {content[1]:.1%} at 45°"
    sets = []
    for name, title, x, label, curve, text in (
        ("compaction", "Compaction at the crossovers", 1.0e-3 * pressure, "pressure [kPa]", pressed, ""),
        ("thickening", "Thickening in shear", np.degrees(angle), "shear angle [°]", sheared, note),
    ):
        first = curve(fabric)
        band = _band(
            fabric, ("compaction", "thickness", "unit_cell"), x, 1.0e3, first,
            _of_each(curve),
        )  # fmt: skip
        sets.append(
            CurveSet(name, title, label, "thickness [mm]", (Line("thickness", x, 1.0e3 * first),), band, note=text)
        )
    return sets[0], sets[1]
