"""A formed sheet beside another run of it, or beside a scan: differences at the same material points."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...meshes.reading import read_mesh
from ...sheet.topology import flat_areas
from ..export.nearest import nearest
from ..files import write_summary
from ..stored.file import StoredSheet
from ..tables import write_table
from .fields import FIELDS, keyed

# A scan is not as much larger or smaller than the sheet as this: its unit is wrong.
LARGEST_RATIO = 20.0


@dataclass(frozen=True, eq=False)
class Comparison:
    """Differences of a sheet A to something else B.

    Attributes:
        sheet: A.
        other: what B is, in words.
        values: of A and of B at A's element centres, by field, two of (element_count,); NaN where B has no such point.
        distance: from A's nodes to the same material points of B, or to the nearest point of a scan, (node_count,) [m].
    """

    sheet: StoredSheet
    other: str
    distance: np.ndarray
    values: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)

    def numbers(self) -> dict[str, Any]:
        """As ``comparison.json`` has them."""
        flat = self.sheet.blank.material_coordinates
        centre = flat[self.sheet.blank.quads].mean(axis=1)
        out: dict[str, Any] = {"sheet": self.sheet.name, "other": self.other}
        out["distance_mm"] = statistics(1.0e3 * self.distance, flat)
        for name, (own, other) in self.values.items():
            out[keyed(name)] = statistics(own - other, centre)
        return out


def statistics(difference: np.ndarray, place: np.ndarray) -> dict[str, Any]:
    """Of the differences that there are."""
    known = np.flatnonzero(np.isfinite(difference))
    if not len(known):
        return {"compared_share": 0.0}
    some = difference[known]
    worst = known[int(np.argmax(np.abs(some)))]
    return {
        "compared_share": len(known) / len(difference),
        "mean": float(some.mean()),
        "mean_absolute": float(np.abs(some).mean()),
        "root_mean_square": float(np.sqrt(np.mean(some**2))),
        "largest_absolute": float(np.abs(difference[worst])),
        "largest_at_flat_mm": [1.0e3 * float(x) for x in place[worst]],
    }


def compare_sheets(sheet: StoredSheet, other: StoredSheet, name: str) -> Comparison:
    """Compare with a sheet of another run, at common points of the flat blank.

    Between its nodes and element centres the other sheet is interpolated linearly; beyond the outermost centres, up to
    its border, its nearest element counts.

    Raises:
        InputError: the flat blanks have no point in common.
    """
    own_flat, other_flat = sheet.blank.material_coordinates, other.blank.material_coordinates
    there = interpolated(other_flat, other.position, own_flat)
    if not np.isfinite(there).any():
        raise InputError(f"compare: the flat blanks of {sheet.name} and of {name} have no point in common")
    distance = np.linalg.norm(sheet.position - there, axis=1)
    own_centre = own_flat[sheet.blank.quads].mean(axis=1)
    other_centre = other_flat[other.blank.quads].mean(axis=1)
    # inside the other's outline
    inside = np.isfinite(interpolated(other_flat, other_flat, own_centre)).all(axis=1)
    nearby = nearest_rows(other_centre, own_centre)
    reach = float(np.sqrt(flat_areas(other.blank).max()))
    inside &= np.linalg.norm(other_centre[nearby] - own_centre, axis=1) < reach
    values = {}
    for key, unsigned in FIELDS.items():
        if key not in sheet.values or key not in other.values:
            continue
        pair = [np.abs(s.values[key].values) if unsigned else s.values[key].values for s in (sheet, other)]
        found = interpolated(other_centre, pair[1], own_centre)
        found = np.where(np.isfinite(found), found, pair[1][nearby])
        values[key] = pair[0], np.where(inside, found, np.nan)
    return Comparison(sheet, name, distance, values)


def compare_scan(sheet: StoredSheet, path: str | Path, unit_scale: float | None) -> Comparison:
    """Compare with a scanned surface: distance of the nodes to its nearest point.

    Args:
        sheet: formed.
        path: of a mesh file of the scan, in the same place as the tools.
        unit_scale: metres per unit of the file; None takes what it says itself.

    Raises:
        InputError: a file that cannot be read, has no unit, or is of quite another size.
    """
    mesh = read_mesh(path, "scan")
    scale = mesh.metres_per_unit if unit_scale is None else unit_scale
    if scale is None:
        raise InputError(f"unit: is required with {Path(path).name}, whose format does not say it: --unit mm, inch, m")
    mesh.check_unit(scale)
    triangles, _ = mesh.triangles()
    corners = scale * mesh.vertices[triangles]
    ratio = float(np.linalg.norm(np.ptp(corners, axis=(0, 1))) / np.linalg.norm(np.ptp(sheet.position, axis=0)))
    if not 1.0 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        raise InputError(
            f"scan {Path(path).name}: it is {ratio:.3g} times as large as the sheet {sheet.name}; check its unit "
            f"(--unit mm), {scale:g} m was taken"
        )
    points, which = nearest(corners, sheet.position)
    distance = np.linalg.norm(points - sheet.position, axis=1)
    size = float(np.linalg.norm(np.ptp(sheet.position, axis=0)))
    if distance.min() > 0.5 * size:
        raise InputError(
            f"scan {Path(path).name}: it is {1e3 * distance.min():.4g} mm away from the sheet {sheet.name}, which is "
            f"{1e3 * size:.4g} mm across; move it to the place of the tools, and check its unit ({scale:g} m was taken)"
        )
    reach = 0.25 * float(np.sqrt(flat_areas(sheet.blank).mean()))
    distance[beside_border(corners, points, which, sheet.position, reach)] = np.nan
    return Comparison(sheet, f"scan {Path(path).name}", distance)


def beside_border(
    corners: np.ndarray, feet: np.ndarray, which: np.ndarray, points: np.ndarray, reach: float
) -> np.ndarray:
    """Whether a surface ends before it comes to lie over or under points, (k,) bool.

    Their nearest points of the surface are then on its border, and off the foot of the perpendicular.

    Args:
        corners: of the triangles of the surface, (n, 3, 3) [m].
        feet: nearest points of the surface, (k, 3) [m].
        which: triangles that they lie in, (k,).
        points: (k, 3) [m].
        reach: how far beside the border a point still counts as over it [m].
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    off, up = points - feet, normal[which]
    beside = np.linalg.norm(off - np.einsum("ki,ki->k", off, up)[:, None] * up, axis=1)
    (doubtful,) = np.nonzero(beside > reach)
    found = np.zeros(len(points), dtype=bool)
    start, end = _open_edges(corners) if len(doubtful) else (corners[:0, 0],) * 2
    if len(start):
        near, _ = nearest(np.stack([start, end, end], axis=1), feet[doubtful])
        found[doubtful] = np.linalg.norm(near - feet[doubtful], axis=1) < 1e-3 * reach
    return found


def _open_edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the edges that belong to one triangle only, (m, 3) each [m]; corners at the same place are one."""
    size = float(np.ptp(corners, axis=(0, 1)).max())
    places = np.round(corners.reshape(-1, 3) / (1e-7 * max(size, 1e-300))).astype(np.int64)
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    faces = number.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    pairs, count = np.unique(edges, axis=0, return_counts=True)
    vertices = corners.reshape(-1, 3)[first]
    single = pairs[(count == 1) & (pairs[:, 0] != pairs[:, 1])]
    return vertices[single[:, 0]], vertices[single[:, 1]]


def interpolated(places: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Linear between scattered places (k, 2); NaN outside their hull."""
    from scipy.interpolate import LinearNDInterpolator

    # a hair larger: points of the border are inside
    middle = places.mean(axis=0)
    return LinearNDInterpolator(middle + (places - middle) * (1.0 + 1.0e-9), values)(at)


def nearest_rows(places: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Row of the place that is nearest to each point."""
    from scipy.spatial import cKDTree

    return cKDTree(places).query(at)[1]


def write_comparison(folder: Path, comparison: Comparison, ending: str = "") -> list[Path]:
    """Write ``comparison.json``, ``.csv`` and ``.png``; returns the files."""
    from ..pictures.comparison import comparison_picture
    from ..pictures.style import write_picture

    files = [folder / f"comparison{ending}.{kind}" for kind in ("json", "csv", "png")]
    write_summary(files[0], comparison.numbers())
    sheet = comparison.sheet
    columns = dict(zip(("flat_x_mm", "flat_y_mm"), (
        1.0e3 * sheet.blank.material_coordinates[sheet.blank.quads].mean(axis=1)).T, strict=True))  # fmt: skip
    columns["distance_mm"] = 1.0e3 * comparison.distance[sheet.blank.quads].mean(axis=1)
    for name, (own, other) in comparison.values.items():
        key = keyed(name)
        columns |= {f"{key}_a": own, f"{key}_b": other, f"{key}_difference": own - other}
    write_table(files[1], list(columns), zip(*(values.tolist() for values in columns.values()), strict=True))
    write_picture(comparison_picture(comparison), files[2])
    return files
