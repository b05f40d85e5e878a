"""Tables of laboratories as tests: which columns they have, what they mean, and whether they can be meant."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..checks import as_typed
from ..errors import InputError, did_you_mean
from ..fabric.closed_forms import bias_zone_areas, trellis_angle, trellis_angle_rate
from ..input_files import shown
from ..ranges import Quantity
from ..tables import Repeat, read_repeats, read_table
from .options import CalibrationOptions
from .roles import FORCES, ONE_OF, ROLES, STRAINS
from .series import Series, check_repeats, check_rows, in_order, thinned, without_offset

# An angle in degrees below which a column is rather in radians, and strains that are rather per cent.
SMALLEST_ANGLE, LARGEST_STRAIN = math.radians(3.0), 0.3
# Rows slightly before zero, as a share of the range: noise of the machine.
BEFORE_ZERO = 0.02


@dataclass(frozen=True)
class DataFile:
    """A file of a test, for the record."""

    test: str
    path: str
    sha256: str
    byte_count: int
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Biaxial:
    """A biaxial test of one specimen: strains and forces per width of warp and weft, (n, 2) each."""

    file: str
    label: str
    strain: np.ndarray
    force: np.ndarray
    lines: np.ndarray
    headers: Mapping[str, str]


def read_files(test: str, options: CalibrationOptions) -> tuple[list[tuple[str, Repeat]], list[DataFile]]:
    """All repeats in all files of a test, and the record of the files.

    Raises:
        InputError: a file that cannot be read in exactly one way.
    """
    try:
        named = options.column_names()
    except ValueError as error:
        raise InputError(str(error)) from None
    known = {role.name for roles in ROLES.values() for role in roles}
    for role in named:
        if role not in known:
            raise InputError(
                f"column: {shown(role)} is no role{did_you_mean(role, known)}; one of {', '.join(sorted(known))}"
            )
    roles = tuple(
        replace(role, names=(*role.names, named[role.name])) if role.name in named else role for role in ROLES[test]
    )
    repeats, files = [], []
    for path in getattr(options, test):
        table = read_table(path, test.replace("_", " "))
        try:
            found = read_repeats(table, roles, ONE_OF[test])
        except InputError as error:
            if "; needed are " not in str(error):
                raise
            raise InputError(f'{error}; name one with {as_typed("column")}, as "force=Standardkraft"') from None
        content = Path(path).read_bytes()
        files.append(DataFile(test, str(path), hashlib.sha256(content).hexdigest(), len(content), found.notes))
        repeats += [(str(path), repeat) for repeat in found.tests]
    return repeats, files


def frame_series(options: CalibrationOptions) -> tuple[list[Series], list[DataFile]]:
    """Picture frames: angle [rad] and shear moment per reference area [N/m].

    Raises:
        InputError: with file, line and column.
    """
    repeats, files = read_files("picture_frame", options)
    result = []
    for path, repeat in repeats:
        by = "angle" if "angle" in repeat.columns else "displacement"
        is_force = repeat.units["force"] == "N"
        if (is_force or by == "displacement") and options.frame_side is None:
            what = f"column {repeat.headers['force']!r} is a force" if is_force else "angles are given by displacements"
            raise InputError(
                f"picture frame {shown(path)}: {what}: give frame_side, and fabric_side if they differ [m]"
            )
        series = _zeroed(_looped(path, repeat, by), by, options)
        if by == "displacement":
            series = _angles_of_frame(series, options.frame_side or 0.0)
        series = _checked_angles(series, options.frame_largest_angle)
        moment = _frame_moment(series.x, is_force, options)
        result.append(_finished(replace(series, y=series.y * moment)))
    check_repeats(result, options.accept_unusual)
    return result, files


def _frame_moment(angle: np.ndarray, is_force: bool, options: CalibrationOptions) -> np.ndarray:
    """Moment per reference area over what was measured, as in the constructors of ``MomentCurve``."""
    side = options.frame_side or 1.0
    fabric = options.fabric_side or side
    if is_force:
        return side * np.sin(0.25 * math.pi - 0.5 * angle) / fabric**2
    if options.frame_convention == "frame side":
        if options.frame_side is None:
            raise InputError('frame_convention "frame side" needs frame_side and fabric_side [m]')
        return np.cos(angle) * (side / fabric) ** 2
    return np.cos(angle)


def bias_series(options: CalibrationOptions) -> tuple[list[Series], list[DataFile]]:
    """Bias extensions: kinematic angle of the central zone [rad] and force [N].

    Raises:
        InputError: with file, line and column.
    """
    repeats, files = read_files("bias_extension", options)
    result = []
    for path, repeat in repeats:
        series = _zeroed(_looped(path, repeat, "displacement"), "displacement", options)
        diagonal = (options.bias_length or 0.0) - (options.bias_width or 0.0)
        beyond = np.flatnonzero(series.x >= (math.sqrt(2.0) - 1.0) * diagonal)
        if len(beyond):
            raise series.fault(
                f"{1e3 * series.x[beyond[0]]:.4g} mm is beyond the {1e3 * (math.sqrt(2.0) - 1.0) * diagonal:.4g} mm at "
                f"which the yarns of a strip of {1e3 * (options.bias_length or 0):.4g} x "
                f"{1e3 * (options.bias_width or 0):.4g} mm are parallel; check unit and dimensions",
                int(beyond[0]), 0,
            )  # fmt: skip
        angle = trellis_angle(diagonal + np.maximum(series.x, 0.0), math.sqrt(0.5) * diagonal)
        series = _checked_angles(replace(series, x=angle), options.bias_largest_angle)
        result.append(_finished(series))
    check_repeats(result, options.accept_unusual)
    return result, files


def bias_factors(angle: np.ndarray, length: float, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Force of a bias extension over the moments at the angle and at half of it, (n,) each [m].

    F = (A_C m(gamma) + A_B m(gamma/2) / 2) dgamma/dd, the power balance of docs/theory.md, section 9.
    """
    diagonal = length - width
    side = math.sqrt(0.5) * diagonal
    rate = trellis_angle_rate(2.0 * side * np.cos(0.25 * math.pi - 0.5 * angle), side)
    _, half_zone, central_zone = bias_zone_areas(length, width)
    return central_zone * rate, 0.5 * half_zone * rate


def biaxial_tests(options: CalibrationOptions) -> tuple[list[Biaxial], list[DataFile]]:
    """Biaxial tests: strains, and forces per width [N/m].

    Raises:
        InputError: with file, line and column.
    """
    repeats, files = read_files("biaxial", options)
    result = []
    for path, repeat in repeats:
        scale = []
        for role in FORCES:
            if repeat.units[role.name] == "N" and options.biaxial_width is None:
                raise InputError(
                    f"biaxial {shown(path)}: column {repeat.headers[role.name]!r} is a force: give biaxial_width, "
                    "over which it acts [m]"
                )
            scale.append(1.0 if repeat.units[role.name] == "N/m" else 1.0 / (options.biaxial_width or 1.0))
        strain = np.column_stack([repeat.columns[role.name] for role in STRAINS])
        force = np.column_stack([repeat.columns[role.name] for role in FORCES]) * scale
        for k, (e, f) in enumerate(zip(STRAINS, FORCES, strict=True)):
            names = (repeat.headers[e.name], repeat.headers[f.name])
            checked = Series(path, repeat.label, strain[:, k], force[:, k], repeat.lines, names)
            _check_strain(checked, options.accept_unusual)
        test = Biaxial(path, repeat.label, strain, force, repeat.lines, repeat.headers)
        result.append(_thinned_biaxial(test))
    return result, files


def _check_strain(series: Series, accept_unusual: bool) -> None:
    if len(series.x) < 3:
        raise series.fault(f"{len(series.x)} rows; at least 3 are needed", len(series.x) - 1, 0)
    row = int(np.argmax(np.abs(series.x)))
    if series.x[row] <= -1.0:
        raise series.fault(f"a strain of {series.x[row]:.4g}: nothing is left; is it in %?", row, 0)
    if abs(series.x[row]) > LARGEST_STRAIN and not accept_unusual:
        raise series.fault(
            f"a strain of {series.x[row]:.4g}, that is {series.x[row]:.0%}; woven yarns break before "
            f"{LARGEST_STRAIN:.0%}: write [%] in the header if it is per cent",
            row, 0,
        )  # fmt: skip
    if not np.any(series.y) and np.any(series.x > 0.0):
        raise series.fault("all values are zero: is it the right column?", 0)
    pulled = np.where(series.x > 0.0, series.y, 0.0)
    if -pulled.min() > max(pulled.max(), 0.0):
        row = int(np.argmin(pulled))
        raise series.fault(f"{series.y[row]:.4g}: forces are negative on the whole; change the sign", row)
    question = Quantity("yarn tension").unusual(float(np.abs(series.y).max()))
    if question and np.any(series.y) and not accept_unusual:
        raise series.fault(
            f"up to {np.abs(series.y).max():.4g} N/m is unusual: {question}", int(np.argmax(np.abs(series.y)))
        )


def _thinned_biaxial(test: Biaxial, largest: int = 120) -> Biaxial:
    if len(test.lines) <= largest:
        return test
    starts = np.arange(0, len(test.lines), -(-len(test.lines) // largest))
    count = np.diff([*starts, len(test.lines)])[:, None]
    return replace(
        test, strain=np.add.reduceat(test.strain, starts) / count, force=np.add.reduceat(test.force, starts) / count,
        lines=test.lines[starts],
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ common to shear tests


def _looped(path: str, repeat: Repeat, by: str) -> Series:
    """The rows of a specimen; an unloading of its own column is appended, from the largest abscissa down."""
    x, y = repeat.columns[by], repeat.columns["force"]
    names = (repeat.headers[by], repeat.headers["force"])
    series = Series(path, repeat.label, x, y, repeat.lines, names)
    if "unloading" not in repeat.columns:
        return in_order(series)
    if repeat.units["unloading"] != repeat.units["force"]:
        raise series.fault(f"loading and unloading have different units, as {repeat.headers['unloading']!r} shows", 0)
    order = np.argsort(x, kind="stable")
    up, down = y[order], repeat.columns["unloading"][order]
    if np.mean(down - up) > 0.0:
        worst = int(np.argmax(down - up))
        raise replace(series, lines=repeat.lines[order], names=(names[0], repeat.headers["unloading"])).fault(
            f"{down[worst]:.4g} is above the loading, {up[worst]:.4g}, as is the column by its mean: exchange the two",
            worst,
        )
    back = order[::-1]
    return Series(
        path, repeat.label, np.concatenate([x[order], x[back]]), np.concatenate([up, down[::-1]]),
        np.concatenate([repeat.lines[order], repeat.lines[back]]), names, ("unloading from its own column",),
    )  # fmt: skip


def _zeroed(series: Series, by: str, options: CalibrationOptions) -> Series:
    """Without slack, from the preload on, or from where a crosshead begins; and without offset of the force."""
    check_rows(series, options.accept_unusual)
    if by == "displacement":
        series = _from_preload(series, options.preload) if options.preload else _from_start(series, options)
    series = _without_negative(series)
    # with a preload there is a force at the start, as meant
    return series if by == "displacement" and options.preload else without_offset(series, options.offset)


def _from_preload(series: Series, preload: float) -> Series:
    reached = np.flatnonzero(series.y >= preload)
    if not len(reached):
        raise series.fault(f"the preload of {preload:.4g} N is never reached", int(np.argmax(series.y)))
    k = int(reached[0])
    note = f"{k} rows before the preload of {preload:.4g} N left out, displacements counted from there"
    series = series.rows(np.arange(k, len(series.x)), note)
    return replace(series, x=series.x - series.x[0])


def _from_start(series: Series, options: CalibrationOptions) -> Series:
    start, reach = float(series.x[0]), float(np.ptp(series.x))
    if start == 0.0 or series.x.min() < start - 0.2 * reach:
        return series
    share = abs(float(series.y[0])) / float(np.abs(series.y).max())
    if share <= SMALL_FORCE:
        return replace(series, x=series.x - start).noted(f"displacements begin at {1e3 * start:.4g} mm, shifted to 0")
    if abs(start) > 0.1 * reach and not options.accept_unusual:
        raise series.fault(
            f"it begins at {1e3 * start:.4g} mm with {share:.0%} of the largest force: where is zero? Give preload, or "
            "leave out what the machine adds",
            0, 0,
        )  # fmt: skip
    return series


# A force that counts as none, as a share of the largest.
SMALL_FORCE = 0.02


def _without_negative(series: Series) -> Series:
    """Rows slightly before zero are left out; more of it is a mistake."""
    before = series.x < 0.0
    if not before.any():
        return series
    row = int(np.argmin(series.x))
    if series.x[row] < -BEFORE_ZERO * np.ptp(series.x):
        raise series.fault(f"{series.x[row]:.4g} is below zero: a test begins at 0; shift or mirror the column", row, 0)
    return series.rows(np.flatnonzero(~before), f"{int(before.sum())} rows slightly below zero left out")


def _angles_of_frame(series: Series, side: float) -> Series:
    beyond = np.flatnonzero(series.x >= (2.0 - math.sqrt(2.0)) * side)
    if len(beyond):
        raise series.fault(
            f"{1e3 * series.x[beyond[0]]:.4g} mm is more than a frame of side {1e3 * side:.4g} mm can go; check unit "
            "and frame_side",
            int(beyond[0]), 0,
        )  # fmt: skip
    return replace(series, x=trellis_angle(math.sqrt(2.0) * side + series.x, side))


def _checked_angles(series: Series, largest: float) -> Series:
    """Up to the largest angle [degrees], and refused if they are hardly angles of a test."""
    top = float(series.x.max())
    if top >= math.radians(89.0):
        row = int(np.argmax(series.x))
        raise series.fault(f"{math.degrees(top):.4g} degrees: no fabric shears so far; check the unit", row, 0)
    if top < SMALLEST_ANGLE:
        raise series.fault(
            f"the largest angle is {math.degrees(top):.4g} degrees: is the column in another unit?",
            int(np.argmax(series.x)), 0,
        )  # fmt: skip
    limit = math.radians(largest)
    if top <= limit * (1.0 + 1.0e-9):
        return series
    kept = np.flatnonzero(series.x <= limit)
    note = f"{len(series.x) - len(kept)} rows beyond {largest:g} degrees left out (up to {math.degrees(top):.3g})"
    return series.rows(kept, note)


def _finished(series: Series) -> Series:
    if len(series.x) < 6:
        raise series.fault(
            f"{len(series.x)} rows are left; at least 6 are needed", len(series.x) - 1 if len(series.x) else None, 0
        )
    return thinned(series)


def check_moments(series: Sequence[Series], size: Callable[[Series], np.ndarray], accept_unusual: bool) -> None:
    """Raise InputError for moments [N/m] that no fabric has; ``size`` makes them of a series."""
    for test in series:
        moment = size(test)
        question = Quantity("shear moment").unusual(float(np.abs(moment).max()))
        if question and not accept_unusual:
            raise test.fault(
                f"a shear moment of up to {np.abs(moment).max():.4g} N/m is unusual: {question}; check the units",
                int(np.argmax(np.abs(moment))),
            )
