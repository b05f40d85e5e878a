"""Bending stiffness of cantilevers: Peirce's bending length, or the heavy elastica at any chord angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..checks import as_typed
from ..errors import InputError
from ..fabric.bending import IsotropicBending, YarnBending
from ..fabric.closed_forms import heavy_elastica
from ..fabric.fabric import Fabric
from ..fabric.proportions import GRAVITY, USUAL_BENDING_LENGTH
from ..input_files import shown
from .fitting.fit import LEVEL
from .options import CalibrationOptions
from .readings import DataFile, read_files

# Chord angle of the standards, at which the bending length is half the overhang [rad], and the angles that a strip
# can have so that its stiffness can be told.
STANDARD_ANGLE = math.radians(41.5)
LEAST_ANGLE, LARGEST_ANGLE = math.radians(3.0), math.radians(85.0)
YARNS = ("warp", "weft")


@dataclass(frozen=True)
class Strip:
    """A specimen: along which yarn ("both" if they are alike), overhang and chord angle, and what they give.

    Attributes:
        place: file and line, or the option.
        yarn: along the strip.
        overhang: [m].
        angle: of the chord below the horizontal [rad].
        stiffness: D per width [N m].
    """

    place: str
    yarn: str
    overhang: float
    angle: float
    stiffness: float


@dataclass(frozen=True)
class BendingEstimate:
    """Mean stiffness of a family [N m], with its interval; NaN for one specimen alone."""

    yarn: str
    value: float
    low: float
    high: float
    deviation: float
    count: int


def strips(options: CalibrationOptions, fabric: Fabric) -> tuple[list[Strip], list[DataFile]]:
    """All specimens of cantilevers and bending lengths.

    Raises:
        InputError: with file, line and column.
    """
    weight = fabric.areal_density * GRAVITY
    found: list[Strip] = []
    repeats, files = read_files("cantilever", options) if options.cantilever else ([], [])
    for path, repeat in repeats:
        columns = repeat.columns
        angles = columns.get("angle")
        for role, values in columns.items():
            if role == "angle":
                continue
            yarn = next((yarn for yarn in YARNS if role.startswith(yarn)), options.cantilever_yarn)
            is_bending_length = role.endswith("bending_length")
            for row, (value, line) in enumerate(zip(values, repeat.lines, strict=True)):
                place = f"cantilever {shown(path)}, line {line}"
                column = f"column {repeat.headers[role]!r}"
                if value <= 0.0 or value > 2.0:
                    raise InputError(f"{place}: {column}: {1e3 * value:.4g} mm; above 0 and at most 2 m is needed")
                angle = STANDARD_ANGLE if angles is None or is_bending_length else float(angles[row])
                if not LEAST_ANGLE <= angle <= LARGEST_ANGLE:
                    raise InputError(
                        f"{place}: column {repeat.headers['angle']!r}: {math.degrees(angle):.4g} degrees; "
                        f"{math.degrees(LEAST_ANGLE):g} to {math.degrees(LARGEST_ANGLE):g} are needed"
                    )
                length = 2.0 * float(value) if is_bending_length else float(value)
                strip = Strip(place, yarn, length, angle, _stiffness(length, angle, weight))
                _check(strip, weight, column, options.accept_unusual)
                found.append(strip)
    for name, yarn in (("bending_length", "warp"), ("bending_length_weft", "weft")):
        lengths = getattr(options, name)
        alone = not options.bending_length_weft and options.cantilever_yarn == "both" and not options.cantilever
        for value in lengths:
            strip = Strip(as_typed(name), "both" if alone else yarn, 2.0 * value, STANDARD_ANGLE, weight * value**3)
            _check(strip, weight, f"{value:g} m", options.accept_unusual)
            found.append(strip)
    return found, files


def _stiffness(overhang: float, angle: float, weight: float) -> float:
    if abs(angle - STANDARD_ANGLE) < 1.0e-9:
        return weight * (0.5 * overhang) ** 3
    return weight * overhang**3 / float(np.exp(_log_loads()(math.log(math.tan(angle)))))


@lru_cache(maxsize=1)
def _log_loads() -> Any:
    """Spline of log(w L^3 / D) of the heavy elastica over log(tan(chord angle)), nearly a straight line."""
    from scipy.interpolate import CubicSpline

    slopes = np.concatenate([np.geomspace(0.03, 1.2, 40), 0.5 * math.pi - np.geomspace(0.36, 1.0e-5, 30)])
    loads, angles = zip(*(heavy_elastica(float(slope), 400) for slope in slopes), strict=True)
    return CubicSpline(np.log(np.tan(angles)), np.log(loads))


def _check(strip: Strip, weight: float, column: str, accept_unusual: bool) -> None:
    length = (strip.stiffness / weight) ** (1.0 / 3.0)
    low, high = USUAL_BENDING_LENGTH
    if not low <= length <= high and not accept_unusual:
        raise InputError(
            f"{strip.place}: {column}: a bending length of {1e3 * length:.4g} mm; usual are {1e3 * low:g} to "
            f"{1e3 * high:g} mm: check its unit"
        )


def estimates(found: Sequence[Strip]) -> list[BendingEstimate]:
    """Mean of each family; "both" alone, or counted in warp and weft."""
    families = [yarn for yarn in YARNS if any(strip.yarn == yarn for strip in found)] or ["both"]
    result = []
    for yarn in families:
        values = np.array([strip.stiffness for strip in found if strip.yarn in (yarn, "both")])
        result.append(_mean(yarn, values))
    return result


def _mean(yarn: str, values: np.ndarray) -> BendingEstimate:
    from scipy.stats import t

    mean, count = float(values.mean()), len(values)
    if count < 2:
        return BendingEstimate(yarn, mean, math.nan, math.nan, math.nan, count)
    deviation = float(values.std(ddof=1))
    half = float(t.ppf(0.5 + 0.5 * LEVEL, count - 1)) * deviation / math.sqrt(count)
    return BendingEstimate(yarn, mean, max(mean - half, 0.0), mean + half, deviation, count)


def trend(found: Sequence[Strip]) -> str:
    """A sentence if the stiffness changes with the overhang, as a moment that is no straight line makes it; or ""."""
    from scipy.stats import linregress

    for yarn in dict.fromkeys(strip.yarn for strip in found):
        strip = [s for s in found if s.yarn == yarn]
        lengths, values = (np.log([getattr(s, name) for s in strip]) for name in ("overhang", "stiffness"))
        # the same angle at other lengths is only scatter of the specimens
        if len(strip) < 5 or np.ptp(lengths) < 0.2 or np.ptp([s.angle for s in strip]) < 0.05:
            continue
        line = linregress(lengths, values)
        if line.pvalue < 0.01 and abs(line.slope) > 0.3:
            return (
                f"bending: the stiffness along {yarn} changes with the overhang (power {line.slope:.2g}): the moment "
                "is no straight line over the curvature; measure it (Kawabata) and give a BendingCurve"
            )
    return ""


def with_bending(base: Fabric, found: Sequence[BendingEstimate]) -> tuple[Fabric, list[str], list[str]]:
    """The fabric with these stiffnesses, what is said of it, and what is assumed.

    Raises:
        InputError: a bending law of the given fabric that has no twist to scale.
    """
    values = {estimate.yarn: float(f"{estimate.value:.7g}") for estimate in found}
    old = base.bending
    if isinstance(old, IsotropicBending) and (set(values) == {"both"} or values.get("warp") == values.get("weft")):
        stiffness = next(iter(values.values()))
        # a strip that is free to bend across has E t^3 / 12, whatever the Poisson ratio
        modulus = float(f"{12.0 * stiffness / base.thickness**3:.7g}")
        return base.model_copy(update={"bending": old.model_copy(update={"modulus": modulus})}), [], []
    before = [old.strip_stiffness(yarn, base.thickness) for yarn in ("warp", "weft")]
    if isinstance(old, YarnBending):
        twist = old.twist
    elif isinstance(old, IsotropicBending):
        twist = 0.5 * (1.0 - old.poisson_ratio) * old.stiffness(base.thickness)
    else:
        raise InputError(f"bending: {type(old).__name__} cannot be calibrated; give a fabric with YarnBending")
    warp = values.get("warp", values.get("both", before[0]))
    weft = values.get("weft", values.get("both", before[1]))
    scale = math.sqrt(warp * weft / (before[0] * before[1])) if min(before) > 0.0 else 0.0
    law = YarnBending(warp=warp, weft=weft, twist=float(f"{twist * scale:.7g}"))
    notes = []
    if isinstance(old, YarnBending) and old.curved:
        notes.append("bending: the curves of the given fabric are replaced by constant stiffnesses, which strips give")
    missing = [yarn for yarn in YARNS if yarn not in values and "both" not in values]
    notes += [f"bending: the {yarn} was not measured and is that of the given fabric" for yarn in missing]
    notes.append("bending.twist is scaled with warp and weft: strips do not show it")
    return base.model_copy(update={"bending": law}), notes, ["bending.twist", *(f"bending.{yarn}" for yarn in missing)]
