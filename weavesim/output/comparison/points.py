"""A formed sheet beside measured points: in space, or at material points of the flat blank, with measured values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, did_you_mean
from ...input_files import shown
from ...tables.table import Table, Wanted, read_table
from ..export.nearest import nearest
from ..files import write_summary
from ..measured import LARGEST_RADIAN
from ..stored.file import StoredSheet
from ..tables import write_table
from .fields import FIELDS, UNITS, keyed
from .runs import LARGEST_RATIO, interpolated, nearest_rows, statistics

# Points farther from the sheet than this share of its diagonal were not measured on it.
FAR = 0.2
# Of measured angles that may be radians, the sheet's are this many times as large.
RATIO_OF_RADIANS = 20.0

TABLES = (".csv", ".txt", ".tsv", ".dat", ".xyz")


@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Points of a table.

    Attributes:
        name: of the table, for messages.
        space: places in space, (k, 3) [m]; None if the table has none.
        flat: their places on the flat blank, (k, 2) [m]; None if the table has none.
        values: measured fields by their names in files, (k,) each.
        notes: what was converted.
    """

    name: str
    space: np.ndarray | None
    flat: np.ndarray | None
    values: dict[str, np.ndarray]
    notes: tuple[str, ...] = ()


def read_points(path: str | Path, *, metres_per_unit: float | None = None) -> MeasuredPoints:
    """Measured points: the columns x, y, z (in space), flat_x, flat_y (on the flat blank), or both; and fields.

    Fields have the names of ``FIELDS``, such as ``shear_angle``, with or without ``_deg``.

    Args:
        path: of the table.
        metres_per_unit: of the coordinates; None takes the units of their columns.

    Raises:
        InputError: a table that cannot be read, without places, or without their unit.
    """
    table = read_table(path, "measured points")
    name = f"measured points {shown(path)}"

    def places(columns: tuple[str, ...]) -> tuple[np.ndarray | None, tuple[str, ...]]:
        there = [column for column in columns if table.has(column)]
        if not there:
            return None, ()
        if len(there) < len(columns):
            missing = [column for column in columns if column not in there]
            raise InputError(f"{name}: it has a column {there[0]}, but none {', '.join(missing)}")
        wanted = (Wanted(each, "m", metres_per_unit, needs_unit=metres_per_unit is None) for each in columns)
        found = table.columns(*wanted)
        return np.column_stack(found.values), found.notes

    (flat, notes), (space, more) = places(("flat_x", "flat_y")), places(("x", "y", "z"))
    if flat is None and space is None:
        raise InputError(
            f"{name}: it has no places; columns x, y, z (in space) or flat_x, flat_y (on the flat blank) are needed, "
            f"and for values any of {', '.join(_plain(key) for key in FIELDS)}"
        )
    values, told = {}, [*notes, *more]
    for key in FIELDS:
        for column in dict.fromkeys((_plain(key), key)):
            if table.has(column):
                columns = table.columns(Wanted(column, UNITS.get(key, ""), needs_unit=key in UNITS))
                values[key], told = columns.values[0], [*told, *columns.notes]
                break
    unused = _unused(table, "flat_x" if space is None else "x", values)
    if space is None and not values:
        raise InputError(
            f"{name}: nothing was measured at its points: beside flat_x and flat_y, columns x, y, z or any of "
            f"{', '.join(_plain(key) for key in FIELDS)} are needed{unused}"
        )
    if unused:
        told.append(unused.removeprefix("; "))
    return MeasuredPoints(name, space, flat, values, tuple(dict.fromkeys(told)))


def _unused(table: Table, place: str, values: Mapping[str, np.ndarray]) -> str:
    """What columns stand beside those that are compared, in the header of the column ``place``."""
    taken = {"flat_x", "flat_y", "x", "y", "z", *values, *(_plain(key) for key in values)}
    names = [name for name in table.names_beside(place) if name not in taken]
    if not names:
        return ""
    hint = did_you_mean(names[0], [_plain(key) for key in FIELDS])
    return f"; not compared: {', '.join(map(shown, names[:12]))}{hint}"


def _plain(key: str) -> str:
    return key.removesuffix("_deg")


@dataclass(frozen=True, eq=False)
class PointComparison:
    """Differences of a sheet to measured points.

    Attributes:
        sheet: that is compared.
        points: that were measured.
        flat: material points of the sheet that they are compared with, (k, 2) [m]; NaN where it has none.
        position: these, formed, (k, 3) [m].
        distance: to the measured places, (k,) [m]; None without such.
        values: of the sheet and as measured, by field, two of (k,) each.
        notes: what a user must know of the comparison.
    """

    sheet: StoredSheet
    points: MeasuredPoints
    flat: np.ndarray
    position: np.ndarray
    distance: np.ndarray | None
    values: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def other(self) -> str:
        """What it is compared with, in words."""
        return self.points.name

    def differences(self) -> Iterator[tuple[str, np.ndarray]]:
        """Of every field, (k,), by name; first the distance [mm]."""
        if self.distance is not None:
            yield "distance_mm", 1.0e3 * self.distance
        for name, (own, measured) in self.values.items():
            yield name, own - measured

    def numbers(self) -> dict[str, Any]:
        """As ``comparison.json`` has them."""
        out: dict[str, Any] = {"sheet": self.sheet.name, "other": self.other, "point_count": len(self.flat)}
        return out | {keyed(name): statistics(values, self.flat) for name, values in self.differences()}


def compare_points(sheet: StoredSheet, points: MeasuredPoints) -> PointComparison:
    """Compare at measured points; those beyond planes of symmetry are taken at their mirror images.

    A point with a place on the flat blank is compared with that material; others with the nearest point of the surface,
    unless they are farther from it than a fifth of the sheet's diagonal: these do not count, and are told.

    Raises:
        InputError: no point lies on the sheet, or they are of another size, so that the unit is wrong.
    """
    blank, quads = sheet.blank, sheet.blank.quads
    mirrors = ["xy".index(plane) for plane in sheet.symmetry.planes]
    # the side of each plane on which the sheet lies
    side = np.where(blank.material_coordinates.mean(axis=0) < 0.0, -1.0, 1.0)[mirrors]
    flat = None if points.flat is None else points.flat.copy()
    space = None if points.space is None else points.space.copy()
    for places in (flat, space):
        if places is not None:
            places[:, mirrors] = side * np.abs(places[:, mirrors])
    _check_size(points, flat, blank.material_coordinates)
    _check_size(points, space, sheet.position)
    distance, notes = None, []
    if flat is None:
        assert space is not None
        flat, position, distance = _under(sheet, space)
        far = distance > FAR * np.linalg.norm(np.ptp(sheet.position, axis=0))
        if far.all():
            raise InputError(
                f"compare: {points.name}: none of its points lies on {sheet.name}; the nearest is "
                f"{1e3 * distance.min():.4g} mm off: bring them into the place of the tools"
            )
        if far.any():
            notes.append(
                f"{points.name}: {far.sum()} of {len(far)} points are not on {sheet.name}, up to "
                f"{1e3 * distance.max():.4g} mm off; they do not count"
            )
            flat[far], position[far], distance[far] = np.nan, np.nan, np.nan
    else:
        position = interpolated(blank.material_coordinates, sheet.position, flat)
        flat = np.where(np.isfinite(position[:, :1]), flat, np.nan)
        if not np.isfinite(flat).any():
            raise InputError(f"compare: {points.name}: none of its points lies on the flat blank of {sheet.name}")
        if space is not None:
            distance = np.linalg.norm(position - space, axis=1)
    centre = blank.material_coordinates[quads].mean(axis=1)
    known = np.isfinite(flat[:, 0])
    values = {}
    for key, measured in points.values.items():
        if key not in sheet.values:
            continue
        own, unsigned = sheet.values[key].values, FIELDS[key]
        own, measured = (np.abs(own), np.abs(measured)) if unsigned else (own, measured)
        found = np.full(len(flat), np.nan)
        inside = interpolated(centre, own, flat[known])
        found[known] = np.where(np.isfinite(inside), inside, own[nearest_rows(centre, flat[known])])
        values[key] = found, measured
        if UNITS.get(key) == "degrees":
            notes += _radians(key, found, measured)
    return PointComparison(sheet, points, flat, position, distance, values, tuple(notes))


def _radians(key: str, own: np.ndarray, measured: np.ndarray) -> Iterator[str]:
    """A note if measured angles look like radians that were called degrees."""
    known = np.isfinite(own)
    if not known.any():
        return
    top, typical = np.abs(measured[known]).max(), np.abs(own[known]).mean()
    if 0.0 < top <= LARGEST_RADIAN and typical > RATIO_OF_RADIANS * np.abs(measured[known]).mean():
        yield (
            f"{_plain(key)}: measured are {top:.3g} degrees at most, where the sheet has {typical:.3g} on average: are "
            f'they radians? Then call the column "{_plain(key)} [rad]"'
        )


def _check_size(points: MeasuredPoints, given: np.ndarray | None, own: np.ndarray) -> None:
    """Ask about a unit: points that reach much farther than the sheet, or lie together in a spot of it."""
    if given is None or len(given) < 2:
        return
    ratio = float(np.abs(given).max() / max(np.abs(own).max(), 1.0e-300))
    if ratio > LARGEST_RATIO or ratio < 1.0 / LARGEST_RATIO**2:
        raise InputError(
            f"compare: {points.name} reaches {np.abs(given).max():.4g} m from the origin, the sheet "
            f"{np.abs(own).max():.4g} m: give the unit of its coordinates (--unit mm), or in the names of its columns"
        )


def _under(sheet: StoredSheet, space: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Material points, places and distances of the sheet's points that are nearest to points in space."""
    from trimesh.triangles import points_to_barycentric

    rows = sheet.blank.quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    triangles = sheet.position[rows]
    foot, which = nearest(triangles, space)
    share = np.clip(points_to_barycentric(triangles[which], foot), 0.0, 1.0)
    flat = np.einsum("kc,kci->ki", share, sheet.blank.material_coordinates[rows[which]])
    return flat, foot, np.linalg.norm(foot - space, axis=1)


def write_point_comparison(folder: Path, comparison: PointComparison, ending: str = "") -> list[Path]:
    """Write ``comparison.json``, ``.csv`` and ``.png``; returns the files."""
    from ..pictures.comparison import points_picture
    from ..pictures.style import write_picture

    files = [folder / f"comparison{ending}.{kind}" for kind in ("json", "csv", "png")]
    write_summary(files[0], comparison.numbers())
    columns: dict[str, np.ndarray] = dict(
        zip(("flat_x_mm", "flat_y_mm", "x_mm", "y_mm", "z_mm"),
            1.0e3 * np.column_stack([comparison.flat, comparison.position]).T, strict=True)
    )  # fmt: skip
    if comparison.distance is not None:
        columns["distance_mm"] = 1.0e3 * comparison.distance
    for name, (own, measured) in comparison.values.items():
        key = keyed(name)
        columns |= {key: own, f"{key}_measured": measured, f"{key}_difference": own - measured}
    write_table(files[1], list(columns), zip(*(values.tolist() for values in columns.values()), strict=True))
    write_picture(points_picture(comparison), files[2])
    return files
