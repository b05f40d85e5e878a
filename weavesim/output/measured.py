"""Measured angles, outlines and curves, for comparison with results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..checks import as_typed
from ..errors import InputError
from ..input_files import shown
from ..tables import Table, Wanted, read_table
from ..tables.header import fold
from ..tables.units import parse_unit, split_header
from .curves import Curves, MeasuredPoints

# A larger number is no number of a point.
LARGEST_POINT = 1_000_000
# Angles none of which is larger are probably radians [degrees]; an outline this many times as large as the blank, or as
# small, is in another unit.
LARGEST_RADIAN, LARGEST_RATIO = 1.6, 10.0


def load_measured_angles(path: str | Path, *, accept_unusual: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Measured shear angles from a table with the columns point and angle: point numbers (k,), angles (k,) [degrees].

    The header says the unit of the angles: "angle_deg", "angle [deg]", "angle [rad]".

    Args:
        path: of the table.
        accept_unusual: take angles as they are that are so small that they may be radians.

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, an entry that is not a number, angles
            without a unit, or so small that they may be radians.
    """
    table = read_table(path, "measured angles")
    columns = table.columns(Wanted("point"), Wanted("angle", unit="deg", needs_unit=True))
    numbers, angles = columns.values
    seen: set[float] = set()
    for number, angle, line in zip(numbers.tolist(), angles.tolist(), columns.lines.tolist(), strict=True):
        place = f"measured angles {shown(path)}, line {line}"
        if number != round(number) or not 1.0 <= number <= LARGEST_POINT or number in seen:
            raise InputError(f"{place}: point {number:g}; point numbers must be integers from 1, each once")
        if abs(angle) >= 90.0:
            raise InputError(f"{place}: {angle:g} degrees; must be below 90")
        seen.add(number)
    largest = float(np.abs(angles).max())
    if 0.0 < largest <= LARGEST_RADIAN and not accept_unusual:
        raise InputError(
            f"measured angles {shown(path)}: the largest is {largest:.4g} degrees: are they radians? Then call the "
            f'column "angle [rad]"; if not, give {as_typed("accept_unusual")}'
        )
    return numbers.astype(int), angles


def load_measured_outline(path: str | Path, *, reach: float | None = None, accept_unusual: bool = False) -> np.ndarray:
    """A measured outline from a table with the columns x and y, in plan view and in order, (k, 2) [m].

    The header says their unit: "x_mm" and "y_mm", "x [mm]" and "y [mm]", "x [m]" and "y [m]".

    Args:
        path: of the table.
        reach: how far the blank reaches from the origin [m], to tell a wrong unit; None is not compared.
        accept_unusual: take an outline that is of quite another size.

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, an entry that is not a number,
            coordinates without a unit, or an outline of quite another size than the blank.
    """
    wanted = [Wanted(name, unit="m", needs_unit=True) for name in ("x", "y")]
    points = np.column_stack(read_table(path, "measured outline").columns(*wanted).values)
    place = f"measured outline {shown(path)}"
    if len(points) < 2:
        raise InputError(f"{place}: only one point; give two or more, in order along the outline")
    own = float(np.abs(points).max())
    if own > 20.0:
        raise InputError(f"{place}: it extends {own:g} m from the origin; give the right unit")
    if reach is not None and not 1.0 / LARGEST_RATIO < own / reach < LARGEST_RATIO and not accept_unusual:
        raise InputError(
            f"{place}: it extends {own:.4g} m from the origin, the blank {reach:.4g} m: give the right unit in the "
            f'names of its columns, as in "x [mm]"; if it is right, give {as_typed("accept_unusual")}'
        )
    return points


@dataclass(frozen=True)
class Comparable:
    """A computed column that a measured one can be compared with.

    Attributes:
        name: usual name of the measured column, in any case.
        unit: of the computed column; the measured one may have any unit of the same kind.
        column: the computed one.
    """

    name: str
    unit: str
    column: str

    def fits(self, name: str, table: Table) -> bool:
        """Whether the unit of a measured column can be converted."""
        unit, own = table.unit(name), parse_unit(self.unit)
        return unit is not None and own is not None and unit.dimension == own.dimension

    def __str__(self) -> str:
        return f'"{self.name} [{self.unit}]"'


def load_measured_curves(
    path: str | Path, abscissas: Sequence[Comparable], ordinates: Sequence[Comparable], names: str | None = None
) -> tuple[MeasuredPoints, ...]:
    """Measured curves from a table whose header says the units of its columns.

    Args:
        path: of the table.
        abscissas, ordinates: what can be compared. One name with two units, such as a force [N] and a force per width
            [N/m], is told apart by the unit in the header.
        names: of the columns in the table, comma-separated, the abscissa first; by default those columns that have a
            usual name.

    Raises:
        InputError: a file that is missing or unreadable, a missing column or unit, a unit of another kind, an entry
            that is not a number (with its line and column), or a curve of one point.
    """
    table = read_table(path, "measured curve")
    if names is None:
        x_name = _usual_names(table, abscissas)[0]
        y_names = _usual_names(table, ordinates)
    else:
        x_name, *y_names = [name.strip() for name in names.split(",")]
        if not y_names or not all([x_name, *y_names]):
            raise InputError(f'measured_columns = {names!r}: two names or more are needed, as in "angle, force"')
    x_of = _comparable(table, x_name, abscissas)
    result = []
    for y_name in y_names:
        y_of = _comparable(table, y_name, ordinates)
        columns = table.columns(
            Wanted(x_name, unit=x_of.unit, needs_unit=True), Wanted(y_name, unit=y_of.unit, needs_unit=True)
        )
        x, y = columns.values
        if len(x) < 2 or np.ptp(x) == 0.0:
            raise InputError(f"measured curve {shown(path)}: column {shown(x_name)} has one value only; no curve")
        label = f"measured, {shown(Path(path).stem)}"
        label += f", {shown(split_header(y_name)[0])}" if len(y_names) > 1 else ""
        result.append(MeasuredPoints(label, x_of.column, y_of.column, x, y))
    return tuple(result)


def _usual_names(table: Table, comparables: Sequence[Comparable]) -> list[str]:
    """Usual names that the table has, each once; raises InputError if it has none."""
    found: list[str] = []
    fault: InputError | None = None
    for name in dict.fromkeys(item.name for item in comparables):
        try:
            table.unit(name)
        except InputError as error:
            fault = fault or error
        else:
            found.append(name)
    if not found:
        raise InputError(f"{fault}; compared are {_listed(comparables)}, or other names given by measured_columns")
    return found


def _comparable(table: Table, name: str, comparables: Sequence[Comparable]) -> Comparable:
    """What a column is compared with: by its name, or else by its unit alone."""
    bare = fold(split_header(name)[0])
    named = [item for item in comparables if fold(item.name) == bare] or list(comparables)
    fitting = [item for item in named if item.fits(name, table)]
    if len(fitting) == 1:
        return fitting[0]
    if not fitting:
        # the reader says what is wrong with the unit
        table.columns(Wanted(name, unit=named[0].unit, needs_unit=True))
    raise InputError(
        f"measured curve {shown(table.path)}: column {shown(name)} can be any of {_listed(fitting)}; give it that name"
    )


def _listed(comparables: Sequence[Comparable]) -> str:
    return ", ".join(map(str, comparables))


# A movement back by more than this share of the range is a turn from loading to unloading, not noise.
TURN = 0.02


@dataclass(frozen=True)
class Difference:
    """How far a computed curve is from a measured one, relative to the largest measured size.

    Attributes:
        root_mean_square, largest: of the measured points that are compared.
        compared_share: of the measured points, those that the computed curve reaches.
    """

    root_mean_square: float
    largest: float
    compared_share: float


def difference(curve: MeasuredPoints, columns: Mapping[str, np.ndarray]) -> Difference | None:
    """Computed less measured at the measured points, loading against loading and unloading against unloading.

    Args:
        curve: measured.
        columns: computed, by name, (k,) each.

    Returns:
        None if the computed curve reaches no measured point.
    """
    x, y = columns[curve.x_column], columns[curve.y_column]
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    errors: list[np.ndarray] = []
    for measured, computed in zip(_branches(curve.x), _branches(x), strict=False):
        if np.sign(curve.x[measured][-1] - curve.x[measured][0]) != np.sign(x[computed][-1] - x[computed][0]):
            break
        # from the turn on: the path between it and the first point behind it is computed too
        computed = slice(max(computed.start - 1, 0), computed.stop)
        order = np.argsort(x[computed], kind="stable")
        along, value = x[computed][order], y[computed][order]
        reached = (curve.x[measured] >= along[0]) & (curve.x[measured] <= along[-1])
        errors.append(np.interp(curve.x[measured], along, value)[reached] - curve.y[measured][reached])
    error = np.concatenate([np.empty(0), *errors])
    size = float(np.abs(curve.y).max())
    if not len(error) or size == 0.0:
        return None
    return Difference(
        float(np.sqrt(np.mean(error**2))) / size, float(np.abs(error).max()) / size, len(error) / len(curve.x)
    )


def _branches(x: np.ndarray) -> list[slice]:
    """Pieces of a path that go one way, but for noise."""
    reach = TURN * float(np.ptp(x)) if len(x) else 0.0
    result, start, extreme, way = [], 0, 0, 0.0
    for k in range(1, len(x)):
        step = float(x[k] - x[extreme])
        if way == 0.0:
            way = np.sign(step) if abs(step) > reach else 0.0
        if way == 0.0:
            continue
        if step * way > 0.0:
            extreme = k
        elif abs(step) > reach:
            result.append(slice(start, extreme + 1))
            start, extreme, way = extreme + 1, k, -way
    return [*result, slice(start, len(x))] if len(x) > 1 else []


def measured_differences(curves: Curves) -> dict[str, dict[str, float | None]]:
    """Summary entries: the difference from each measured curve, by its label; {} without any."""
    found = {curve.label: difference(curve, curves.columns) for curve in curves.measured}
    if not found:
        return {}
    return {
        key: {label: getattr(item, name) if item else None for label, item in found.items()}
        for key, name in (
            ("measured_rms_difference_ratio", "root_mean_square"),
            ("measured_largest_difference_ratio", "largest"),
            ("measured_compared_share", "compared_share"),
        )
    }
