"""The edge of a part on the flat blank: which material lies under each of its points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...meshes.drawing import joined
from ...sheet.outline import Outline, checked_outline
from ...sheet.symmetry import on_plane
from ...sheet.topology import flat_areas
from ..export.nearest import nearest
from ..stored.file import StoredSheet
from .part_edge import PartEdge, border_loops, plan_area, told

# Points of the edge lie this near to each other, in elements.
STEP = 0.1
# The edge may lie this many elements away from the sheet, along its normal.
USUAL_DISTANCE = 2.0
# Beyond the border of the sheet by more than this many elements, material is missing.
BEYOND = 0.1
# Between corners of the edge, which turn by more [rad], the trim line is averaged over as many elements: material is
# interpolated linearly, with a kink at each side of an element.
CORNER_TURN, AVERAGED = np.deg2rad(15.0), 1.0
# Points of the trim line are left out where it stays within this many elements.
STRAIGHTENED = 2.0e-3
# Material between two points is no longer than this many times their distance, or an element: else there are folds.
JUMP = 4.0


@dataclass(frozen=True, eq=False)
class FlatPattern:
    """The flat blank of a ply, with what becomes the part.

    Attributes:
        name: of the sheet.
        blank: outline of the blank and its holes, corners of each, (k, 2) [m].
        slits: of the blank, points of each, (k, 2) [m].
        trim: the trim line of the part and its holes, on the flat blank; None without an edge.
        warp, weft: directions of the yarns near the middle of the pattern, (2,).
        element: size of an element [m].
        largest_distance: from the edge to the sheet [m].
    """

    name: str
    blank: tuple[np.ndarray, ...]
    slits: tuple[np.ndarray, ...]
    trim: tuple[np.ndarray, ...] | None
    warp: np.ndarray
    weft: np.ndarray
    element: float
    largest_distance: float = 0.0

    @property
    def blank_area(self) -> float:
        """Without holes [m^2]."""
        return _net_area(self.blank)

    @property
    def part_area(self) -> float | None:
        """Of the flat blank that becomes the part [m^2]."""
        if self.trim is None:
            return None
        return _net_area(self.cut)

    @property
    def cut(self) -> tuple[np.ndarray, ...]:
        """What is cut out: the trim line with the holes inside it, or the blank."""
        return self.blank if self.trim is None else (*self.trim, *self._in_trim(self.blank[1:]))

    @property
    def cut_slits(self) -> tuple[np.ndarray, ...]:
        """Slits inside what is cut out."""
        return self.slits if self.trim is None else tuple(self._in_trim(self.slits))

    def _in_trim(self, lines: tuple[np.ndarray, ...]) -> list[np.ndarray]:
        assert self.trim is not None
        outline = Outline(_counter_clockwise(self.trim[0]))
        return [line for line in lines if outline.nearest(line)[0].min() > 0.0]


def _net_area(loops: tuple[np.ndarray, ...]) -> float:
    outline, *holes = (abs(plan_area(loop)) for loop in loops)
    return outline - sum(holes)


def _counter_clockwise(loop: np.ndarray) -> np.ndarray:
    return loop if plan_area(loop) > 0.0 else loop[::-1]


@dataclass(frozen=True, eq=False)
class _Soup:
    """The whole formed sheet as triangles with their material.

    Attributes:
        formed: corners, (n, 3, 3) [m].
        flat: their material coordinates, (n, 3, 2) [m].
        at_border: whether the side from each corner to the next is a border of the sheet, (n, 3).
    """

    formed: np.ndarray
    flat: np.ndarray
    at_border: np.ndarray


def flat_pattern(sheet: StoredSheet, edge: PartEdge | None, formed: str = "") -> FlatPattern:
    """The flat blank of a sheet, whole, with the trim line of an edge.

    Args:
        sheet: formed.
        edge: of the part, if any.
        formed: what the sheet is, for messages; by default a formed sheet.

    Raises:
        InputError: an edge that leaves the sheet, does not lie on it, or lies where the sheet is in folds.
    """
    soup = _soup(sheet)
    element = float(np.sqrt(np.mean(flat_areas(sheet.blank))))
    corner = np.column_stack([soup.flat.reshape(-1, 2), np.zeros(soup.flat.size // 2)])
    loops = border_loops(corner, np.arange(len(corner)).reshape(-1, 3))
    loops = sorted((_straight(loop[:, :2], 1.0e-6 * element) for loop in loops), key=lambda loop: -abs(plan_area(loop)))
    slits = tuple(_slits(soup, 1.0e-6 * element))
    trim, largest = None, 0.0
    if edge is not None:
        formed = formed or f"formed sheet {sheet.name}"
        found = [_material(sheet, soup, curve, edge.name, element, formed) for curve in (edge.outline, *edge.holes)]
        largest = max(distance for _, distance in found)
        trim = tuple(_straight(line, STRAIGHTENED * element) for line, _ in found)
        _check(sheet, edge, trim)
    middle = (loops[0] if trim is None else trim[0]).mean(axis=0)
    centre = sheet.blank.material_coordinates[sheet.blank.quads].mean(axis=1)
    row = int(np.argmin(np.linalg.norm(centre - np.abs(middle) if sheet.symmetry.planes else centre - middle, axis=1)))
    warp, weft = (getattr(sheet.blank, f"{yarn}_direction")[row, :2] for yarn in ("warp", "weft"))
    return FlatPattern(sheet.name, tuple(loops), slits, trim, warp, weft, element, largest)


def _soup(sheet: StoredSheet) -> _Soup:
    blank = sheet.blank
    held = np.zeros((blank.node_count, 2), dtype=bool)
    for plane in sheet.symmetry.planes:
        held[:, "xy".index(plane)] = on_plane(blank, plane)
    rows = blank.quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    sides = np.stack([rows, np.roll(rows, -1, axis=1)], axis=2)
    key = np.sort(sides, axis=2).reshape(-1, 2)
    _, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    border = (count[inverse.ravel()] == 1).reshape(-1, 3) & ~held[sides].all(axis=2).any(axis=2)
    formed, flat = [], []
    for factors in sheet.symmetry.mirror_factors:
        formed.append((sheet.position * np.array([*factors, 1.0]))[rows])
        flat.append((blank.material_coordinates * np.array(factors))[rows])
    copies = len(formed)
    return _Soup(np.concatenate(formed), np.concatenate(flat), np.tile(border, (copies, 1)))


def _slits(soup: _Soup, tolerance: float) -> Iterator[np.ndarray]:
    """Lines along which the blank is open though its two sides lie on each other, (k, 2)."""
    start, end = soup.flat[soup.at_border], np.roll(soup.flat, -1, axis=1)[soup.at_border]
    side = np.stack([start, end], axis=1)
    key = np.sort(np.rint(side / tolerance).astype(np.int64).view([("x", np.int64), ("y", np.int64)])[..., 0], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    twice = [side[k] for k in first[count == 2]]
    return joined(twice, tolerance) if twice else iter(())


def _material(
    sheet: StoredSheet, soup: _Soup, curve: np.ndarray, name: str, element: float, formed: str
) -> tuple[np.ndarray, float]:
    """Material points under a closed curve, (k, 2) [m], and the largest distance to it [m]."""
    points, corners = _resampled(curve, STEP * element)
    if points.shape[1] == 2:
        points = _raised(sheet, soup, points, name, formed)
    foot, row = nearest(soup.formed, points)
    triangle = soup.formed[row]
    a, b = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    normal = np.cross(a, b)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300)
    apart = points - foot
    distance = np.linalg.norm(apart, axis=1)
    aside = np.linalg.norm(apart - np.einsum("ki,ki->k", apart, normal)[:, None] * normal, axis=1)
    share = _barycentric(triangle, foot)
    # the side across from a corner with no share begins at the next corner
    on_side = np.roll(share, 1, axis=1) < 1.0e-6
    beyond = np.where((on_side & soup.at_border[row]).any(axis=1), aside, 0.0)
    if beyond.max() > BEYOND * element:
        worst = int(beyond.argmax())
        raise InputError(
            f"{name}: at {told(points[worst])} it lies {1e3 * beyond[worst]:.3g} mm beyond the border of the "
            f"{formed}; the part needs a larger blank there, or its edge another place"
        )
    if distance.max() > USUAL_DISTANCE * element:
        worst = int(distance.argmax())
        raise InputError(
            f"{name}: at {told(points[worst])} it lies {1e3 * distance[worst]:.3g} mm away from the "
            f"{formed}, which is more than {USUAL_DISTANCE:g} elements; check its unit and place: it has to lie on "
            "the tools as the run left them"
        )
    flat = np.einsum("kc,kci->ki", share, soup.flat[row])
    way = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1)
    step = np.linalg.norm(np.roll(foot, -1, axis=0) - foot, axis=1)
    jump = way - np.maximum(JUMP * step, element)
    if jump.max() > 0.0:
        worst = int(jump.argmax())
        raise InputError(
            f"{name}: at {told(points[worst])} the material under it jumps by {1e3 * way[worst]:.3g} mm: the sheet "
            f"{sheet.name} lies in folds there, and no trim line is unique; remove the wrinkles first"
        )
    return _averaged(flat, corners, round(0.5 * AVERAGED / STEP)), float(distance.max())


def _raised(sheet: StoredSheet, soup: _Soup, points: np.ndarray, name: str, formed: str) -> np.ndarray:
    """Points (k, 2) that are seen from above, on the formed sheet, (k, 3)."""
    from scipy.spatial import cKDTree

    corner = soup.formed[:, :, :2]
    centre = corner.mean(axis=1)
    reach = float(np.linalg.norm(corner - centre[:, None], axis=2).max())
    near = cKDTree(centre).query_ball_point(points, reach * (1.0 + 1.0e-9))
    heights = np.empty(len(points))
    for k, rows in enumerate(near):
        some = np.array(rows, dtype=int)
        share = _plan_shares(corner[some], points[k])
        inside = (share > -1.0e-9).all(axis=1)
        if not inside.any():
            raise InputError(
                f"{name}: at {told(points[k])} there is no {formed} under it; the part needs a larger "
                "blank there, or its edge another place"
            )
        found = np.einsum("kc,kc->k", share[inside], soup.formed[some[inside], :, 2])
        if np.ptp(found) > sheet.thickness:
            raise InputError(
                f"{name}: at {told(points[k])} the sheet {sheet.name} lies over itself at {1e3 * found.min():.4g} "
                f"and {1e3 * found.max():.4g} mm; give the edge with its heights, as a curve in space"
            )
        heights[k] = found.mean()
    return np.column_stack([points, heights])


def _plan_shares(corner: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Shares of the corners (n, 3, 2) in a point; upright triangles have none, (n, 3)."""
    a, b, c = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0], point - corner[:, 0]
    whole = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    upright = np.abs(whole) < 1.0e-9 * np.maximum((a * a).sum(axis=1), (b * b).sum(axis=1))
    whole = np.where(upright, 1.0, whole)
    second = (c[:, 0] * b[:, 1] - c[:, 1] * b[:, 0]) / whole
    third = (a[:, 0] * c[:, 1] - a[:, 1] * c[:, 0]) / whole
    shares = np.column_stack([1.0 - second - third, second, third])
    return np.where(upright[:, None], -1.0, shares)


def _barycentric(triangle: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Shares of the corners (k, 3, 3) in points of their planes, (k, 3)."""
    from trimesh.triangles import points_to_barycentric

    return np.clip(points_to_barycentric(triangle, point), 0.0, 1.0)


def _resampled(curve: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed curve with further points, no farther than ``step`` apart, and the rows of its corners."""
    side = np.roll(curve, -1, axis=0) - curve
    length = np.linalg.norm(side, axis=1)
    curve, side, length = curve[length > 0.0], side[length > 0.0], length[length > 0.0]
    along = side / length[:, None]
    turn = np.arccos(np.clip(np.einsum("ki,ki->k", np.roll(along, 1, axis=0), along), -1.0, 1.0))
    counts = np.maximum(1, np.ceil(length / step).astype(int))
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    pieces = [
        start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * way
        for start, way, count in zip(curve, side, counts, strict=True)
    ]
    return np.concatenate(pieces), first[turn > CORNER_TURN]


def _averaged(line: np.ndarray, corners: np.ndarray, half: int) -> np.ndarray:
    """A closed line (k, 2) whose points are means of the ``half`` points on both sides; ``corners`` (rows) stay."""
    count = len(line)
    rows = np.arange(count)
    reach = np.full(count, min(half, (count - 1) // 2))
    if len(corners):
        apart = np.abs(rows[:, None] - corners[None])
        reach = np.minimum(reach, np.minimum(apart, count - apart).min(axis=1))
    total = np.concatenate([np.zeros((1, 2)), np.cumsum(np.concatenate([line, line, line]), axis=0)])
    first, last = rows + count - reach, rows + count + reach + 1
    return (total[last] - total[first]) / (2 * reach + 1)[:, None]


def _straight(loop: np.ndarray, tolerance: float) -> np.ndarray:
    """Corners of a closed line without those that lie within ``tolerance`` of a straight line (Douglas-Peucker)."""
    far = int(np.linalg.norm(loop - loop[0], axis=1).argmax())
    keep = np.zeros(len(loop) + 1, dtype=bool)
    keep[[0, far, len(loop)]] = True
    line = np.concatenate([loop, loop[:1]])
    stack = [(0, far), (far, len(loop))]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        chord, rest = line[last] - line[first], line[first + 1 : last] - line[first]
        share = np.clip(rest @ chord / max(float(chord @ chord), 1.0e-300), 0.0, 1.0)
        away = np.linalg.norm(rest - share[:, None] * chord, axis=1)
        worst = int(away.argmax())
        if away[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            stack += [(first, middle), (middle, last)]
    return loop[keep[:-1]]


def _check(sheet: StoredSheet, edge: PartEdge, trim: tuple[np.ndarray, ...]) -> None:
    """The trim line must not cross itself, and its holes lie inside."""
    for line in trim:
        try:
            checked_outline(line)
        except InputError:
            raise InputError(
                f"{edge.name}: its trim line on the flat blank of {sheet.name} crosses itself: the sheet lies in folds "
                "there, or the curve does"
            ) from None
    outline = Outline(_counter_clockwise(trim[0]))
    for hole in trim[1:]:
        if outline.nearest(hole)[0].min() <= 0.0:
            raise InputError(
                f"{edge.name}: it has several closed curves, and one about {told(hole.mean(axis=0))} of the flat "
                "blank is no hole in the longest; give one part at a time"
            )
