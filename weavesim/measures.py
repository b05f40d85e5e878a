"""Numbers that are read off a formed sheet: angles at points, draw-in, checkerboard, folds, parts that come close."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import InputError

if TYPE_CHECKING:
    from .blank import Blank

# Lengths below this share of the blank count as zero when a node is tested for lying on a line.
_RELATIVE_TOLERANCE = 1.0e-6
_AXES = {"x": 0, "y": 1}


def mirror_signs(symmetry: Sequence[str]) -> list[tuple[int, int]]:
    """Factors of (x, y) that turn the computed part into each copy of the whole; the first is (1, 1)."""
    return list(product((1, -1) if "x" in symmetry else (1,), (1, -1) if "y" in symmetry else (1,)))


def _tolerance(blank: Blank) -> float:
    return _RELATIVE_TOLERANCE * float(np.ptp(blank.material_coordinates, axis=0).max())


def _flat_areas(blank: Blank) -> np.ndarray:
    corner = blank.material_coordinates[blank.quads]
    p, q = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return 0.5 * np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


# ----------------------------------------------------------------------------------------------- angles at points


def nodal_shear_angle(blank: Blank, shear_angle: np.ndarray, symmetry: Sequence[str] = ()) -> np.ndarray:
    """Area-weighted mean of the signed shear angle of the elements around each node, (node_count,) [rad].

    On a symmetry plane the mirrored elements count as well. A mirror turns the sign of the angle when it maps each
    yarn family onto itself, and keeps it when it swaps the two (yarns at 45 degrees).
    """
    return nodal_mean(blank, nodal_weights(blank, symmetry), shear_angle)


def nodal_mean(blank: Blank, weights: np.ndarray, shear_angle: np.ndarray) -> np.ndarray:
    """``nodal_shear_angle`` by the ``nodal_weights`` of the blank, for who takes it of many frames."""
    return np.bincount(blank.quads.ravel(), (weights * shear_angle[:, None]).ravel(), blank.node_count)


def nodal_weights(blank: Blank, symmetry: Sequence[str] = ()) -> np.ndarray:
    """Share of each element in the nodal shear angle of its corners, (element_count, 4)."""
    area = _flat_areas(blank)
    weight = np.repeat(area[:, None], 4, axis=1)
    share = np.ones_like(weight)
    for name in symmetry:
        axis = _AXES[name]
        mirror = np.ones(3)
        mirror[axis] = -1.0
        warp, weft = blank.warp_direction, blank.weft_direction
        kept, swapped = (np.einsum("ei,ei->e", warp * mirror, other) for other in (warp, weft))
        kept_weft, swapped_weft = (np.einsum("ei,ei->e", weft * mirror, other) for other in (weft, warp))
        sign = np.where(np.abs(swapped) > np.abs(kept), np.sign(swapped * swapped_weft), np.sign(kept * kept_weft))
        on_plane = np.abs(blank.node_position[:, axis]) <= _tolerance(blank)
        share = np.where(on_plane[blank.quads], share * 0.5 * (1.0 + sign[:, None]), share)
    total = np.bincount(blank.quads.ravel(), weight.ravel(), blank.node_count)
    return weight * share / np.maximum(total, 1.0e-300)[blank.quads]


def locate(blank: Blank, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Element that holds each flat point, (k,), and the bilinear weights of its four corners, (k, 4).

    Raises:
        InputError: a point outside the blank.
    """
    corners = blank.material_coordinates[blank.quads]
    slack = 10.0 * _tolerance(blank)
    lower, upper = corners.min(axis=1) - slack, corners.max(axis=1) + slack
    elements, weights = [], []
    for point in np.atleast_2d(np.asarray(points, dtype=float)):
        candidates = np.flatnonzero(np.all((point >= lower) & (point <= upper), axis=1))
        local = np.zeros((len(candidates), 2))
        shapes = np.full((len(candidates), 4), 0.25)
        for _ in range(20):  # Newton on the bilinear map; exact after one step on parallelograms
            r, s = local.T
            shapes = 0.25 * np.stack(
                [(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)], axis=1
            )
            by_r = 0.25 * np.stack([s - 1, 1 - s, 1 + s, -1 - s], axis=1)
            by_s = 0.25 * np.stack([r - 1, -1 - r, 1 + r, 1 - r], axis=1)
            corner = corners[candidates]
            jacobian = np.stack([np.einsum("ec,ecx->ex", d, corner) for d in (by_r, by_s)], axis=2)
            miss = point - np.einsum("ec,ecx->ex", shapes, corner)
            determinant = jacobian[:, 0, 0] * jacobian[:, 1, 1] - jacobian[:, 0, 1] * jacobian[:, 1, 0]
            solvable = np.abs(determinant) > 1.0e-300
            step = (
                np.stack(
                    [
                        jacobian[:, 1, 1] * miss[:, 0] - jacobian[:, 0, 1] * miss[:, 1],
                        jacobian[:, 0, 0] * miss[:, 1] - jacobian[:, 1, 0] * miss[:, 0],
                    ],
                    axis=1,
                )
                / np.where(solvable, determinant, 1.0)[:, None]
            )
            local = np.clip(local + step, -3.0, 3.0)
        outside = np.abs(local).max(axis=1, initial=0.0)
        if not len(candidates) or outside[best := int(np.argmin(outside))] > 1.0 + 1.0e-3:
            x, y = blank.material_coordinates.min(axis=0), blank.material_coordinates.max(axis=0)
            raise InputError(
                f"point ({point[0]:.6g}, {point[1]:.6g}) m lies outside the blank, which spans {x[0]:.6g} to "
                f"{y[0]:.6g} m in x and {x[1]:.6g} to {y[1]:.6g} m in y; give a point on the flat blank"
            )
        elements.append(candidates[best])
        weights.append(shapes[best])
    return np.array(elements), np.array(weights)


def shear_angle_at(
    blank: Blank, shear_angle: np.ndarray, points: np.ndarray, symmetry: Sequence[str] = ()
) -> np.ndarray:
    """Absolute shear angle at material points, (k,) [degrees].

    Rule: signed element values are averaged to the nodes by flat area, mirrored elements included
    (``nodal_shear_angle``), and interpolated bilinearly in the element that holds the point. Where symmetry makes the
    angle odd it is zero, also at the corner of a border and a symmetry line.

    Args:
        shear_angle: one per element, (element_count,) [rad].
        points: flat coordinates, (k, 2) [m].
        symmetry: planes at which the computed part is mirrored, of "x" and "y".
    """
    element, weight = locate(blank, points)
    nodal = nodal_shear_angle(blank, shear_angle, symmetry)
    return np.abs(np.rad2deg(np.einsum("kc,kc->k", weight, nodal[blank.quads[element]])))


def ten_points(half_length: float, half_width: float) -> np.ndarray:
    """Points 1 to 10 of the double dome, (10, 2) [m]: nine equal parts from (half_length, 0) to (0, half_width)."""
    return np.linspace((half_length, 0.0), (0.0, half_width), 10)


def yarn_vectors(
    blank: Blank, position: np.ndarray, components: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Unit warp and weft directions at the element centres of the formed sheet, two of (element_count, 3).

    Args:
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        components: ``yarn_components(blank)``, for who takes the directions of many frames.
    """
    components = yarn_components(blank) if components is None else components
    current = _sides(position[blank.quads])
    warp, weft = (np.einsum("ea,eai->ei", component, current) for component in components)
    return warp / np.linalg.norm(warp, axis=1, keepdims=True), weft / np.linalg.norm(weft, axis=1, keepdims=True)


def yarn_components(blank: Blank) -> np.ndarray:
    """Components of warp and weft direction along the two mean sides of each flat element, (2, element_count, 2)."""
    along = _sides(blank.node_position[blank.quads])
    metric = np.einsum("eai,ebi->eab", along, along)
    return np.stack([
        np.linalg.solve(metric, np.einsum("eai,ei->ea", along, direction)[:, :, None])[:, :, 0]
        for direction in (blank.warp_direction, blank.weft_direction)
    ])  # fmt: skip


def _sides(corner: np.ndarray) -> np.ndarray:
    return np.stack([corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3],
                     corner[:, 2] + corner[:, 3] - corner[:, 0] - corner[:, 1]], axis=1)  # fmt: skip


# ------------------------------------------------------------------------------------------------ lines and outline


class MaterialLine(NamedTuple):
    """Points along a straight line of the flat blank, as places on mesh edges: ``start + share (end - start)``."""

    start: np.ndarray
    end: np.ndarray
    share: np.ndarray

    def of(self, values: np.ndarray) -> np.ndarray:
        """Nodal values at the points of the line, (k, ...)."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        return (1.0 - share) * values[self.start] + share * values[self.end]


def symmetry_line(blank: Blank, along: str) -> MaterialLine:
    """The flat line y = 0 (``along`` "x") or x = 0 ("y"), by rising coordinate; through nodes, or across edges.

    Raises:
        InputError: the blank does not meet the line.
    """
    axis = _AXES[along]
    across = blank.material_coordinates[:, 1 - axis]
    tolerance = _tolerance(blank)
    nodes = np.flatnonzero(np.abs(across) <= tolerance)
    edges = np.concatenate([blank.quads[:, [i, (i + 1) % 4]] for i in range(4)])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    a, b = across[edges].T
    edges = edges[(np.minimum(a, b) < -tolerance) & (np.maximum(a, b) > tolerance)]
    a, b = across[edges].T
    if not len(nodes) and not len(edges):
        raise InputError(f"the blank does not meet the line along {along}: place it over the origin")
    start, end = np.concatenate([nodes, edges[:, 0]]), np.concatenate([nodes, edges[:, 1]])
    share = np.concatenate([np.zeros(len(nodes)), a / (a - b)])
    line = MaterialLine(start, end, share)
    order = np.argsort(line.of(blank.material_coordinates[:, axis]), kind="stable")
    return MaterialLine(start[order], end[order], share[order])


def draw_in(blank: Blank, position: np.ndarray, along: str) -> float:
    """Draw-in at the positive end of a symmetry line [m]: flat coordinate minus formed plan coordinate."""
    axis = _AXES[along]
    line = symmetry_line(blank, along)
    return float(line.of(blank.material_coordinates[:, axis])[-1] - line.of(position[:, axis])[-1])


class Outline(NamedTuple):
    """Free border of the computed part.

    Attributes:
        node: in order, (k,); a symmetry plane's edges are left out.
        closed: whether the last node joins the first.
        normal: outward flat unit normal, (k, 2).
    """

    node: np.ndarray
    closed: bool
    normal: np.ndarray


def outline(blank: Blank, symmetry: Sequence[str] = ()) -> Outline:
    """Free border of the blank, counter-clockwise as the elements are."""
    loop = blank.boundary_loop()
    following = np.roll(loop, -1)
    free = np.ones(len(loop), dtype=bool)
    for name in symmetry:
        on_plane = np.abs(blank.node_position[:, _AXES[name]]) <= _tolerance(blank)
        free &= ~(on_plane[loop] & on_plane[following])
    closed = bool(free.all())
    if not closed:  # begin behind a symmetry plane
        first = int(np.flatnonzero(free & ~np.roll(free, 1))[0])
        loop, free = np.roll(loop, -first), np.roll(free, -first)
        loop = loop[: int(np.argmin(free)) + 1]
    flat = blank.material_coordinates[loop]
    edge = np.roll(flat, -1, axis=0) - flat if closed else np.diff(flat, axis=0)
    sideways = np.column_stack([edge[:, 1], -edge[:, 0]])
    sideways /= np.linalg.norm(sideways, axis=1, keepdims=True)
    if closed:
        normal = sideways + np.roll(sideways, 1, axis=0)
    else:
        normal = np.concatenate([sideways[:1], sideways[1:] + sideways[:-1], sideways[-1:]])
    return Outline(loop, closed, normal / np.linalg.norm(normal, axis=1, keepdims=True))


def whole_outline(blank: Blank, values: np.ndarray, symmetry: Sequence[str] = ()) -> np.ndarray:
    """Nodal vectors (node_count, 2 or 3) on the closed outline of the whole part, (k, 2 or 3)."""
    border = outline(blank, symmetry)
    own = values[border.node]
    if border.closed:
        return own
    flat = blank.material_coordinates[border.node]
    pieces = []
    for sign in mirror_signs(symmetry):
        step = 1 if sign[0] * sign[1] > 0 else -1
        middle = flat[len(flat) // 2] * sign
        factor = np.array([*sign, 1.0])[: values.shape[1]]
        pieces.append((np.arctan2(middle[1], middle[0]), (own * factor)[::step], (flat * sign)[::step]))
    pieces.sort(key=lambda piece: piece[0])
    chain, flat_chain = (np.concatenate([piece[i] for piece in pieces]) for i in (1, 2))
    # Where two copies meet, the node on the symmetry plane comes twice.
    repeated = np.linalg.norm(flat_chain - np.roll(flat_chain, 1, axis=0), axis=1) <= _tolerance(blank)
    return chain[~repeated]


def border_draw_in(blank: Blank, position: np.ndarray, border: Outline) -> np.ndarray:
    """Draw-in along the border, (k,) [m]: plan movement of a node against the outward normal of the flat outline."""
    movement = position[border.node, :2] - blank.material_coordinates[border.node]
    return -np.einsum("ki,ki->k", movement, border.normal)


def integrated_yarn_stretch(blank: Blank, stretch: np.ndarray, along: str) -> float:
    """Lengthening of the yarns on the positive half of a symmetry line [m]: (stretch - 1) summed over its length.

    The elements that touch the line count, each with its flat extent along it; where they lie on both sides, the two
    sides are averaged. ``stretch`` is that of the yarns along the line, (element_count,).
    """
    axis = _AXES[along]
    corner = blank.material_coordinates[blank.quads]
    across = corner[:, :, 1 - axis]
    tolerance = _tolerance(blank)
    touches = np.sum(across <= tolerance, axis=1) >= 2
    touches &= np.sum(across >= -tolerance, axis=1) >= 2
    extent = np.clip(corner[:, :, axis], 0.0, None)
    extent = np.where(touches, extent.max(axis=1) - extent.min(axis=1), 0.0)
    if extent.sum() == 0.0:
        raise InputError(f"no element touches the line along {along}: place the blank over the origin")
    length = symmetry_line(blank, along).of(blank.material_coordinates[:, axis])[-1]
    length -= max(0.0, float(corner[touches][:, :, axis].min()))
    return float(length * np.sum(extent * (stretch - 1.0)) / extent.sum())


def taut_path_draw_in(
    punch_radius: float, die_radius: float, depth: float, thickness: float, clearance: float
) -> float:
    """Draw-in of inextensible straight yarns on a symmetry line of a double dome [m].

    The mid-surface follows the punch at ``punch_radius + thickness/2``, a common tangent, the die entry at
    ``die_radius + thickness/2`` and then stays flat; the draw-in is the length of this path minus its plan length.
    ``depth`` is that of the punch's nose below the die's face, so that a sheet lying on the face is met
    ``thickness`` before. The die's wall stands at ``punch_radius + clearance``.

    Raises:
        InputError: lengths for which there is no such path.
    """
    given = (
        f"punch radius {punch_radius:g}, die radius {die_radius:g}, depth {depth:g}, thickness {thickness:g}, "
        f"clearance {clearance:g} m"
    )
    if not min(punch_radius, die_radius, depth, thickness) > 0.0 or not clearance >= thickness * (1.0 - 1.0e-9):
        raise InputError(f"taut path: {given}; lengths must be positive and the clearance at least the thickness")
    on_punch, on_die = punch_radius + 0.5 * thickness, die_radius + 0.5 * thickness
    # Centre of the die entry seen from that of the punch; heights are those of the mid-surface.
    across = punch_radius + clearance + die_radius
    up = -on_die - (-(depth + thickness) + on_punch)
    distance, radii = np.hypot(across, up), on_punch + on_die
    if distance < radii:
        raise InputError(f"taut path: {given}: punch and die overlap; lower the depth or raise the clearance")
    angle = np.arctan2(up, across) + np.arcsin(radii / distance)
    if not 0.0 < angle <= 0.5 * np.pi + 1.0e-9:
        raise InputError(f"taut path: {given}: the wall would lean over by {np.rad2deg(angle):.1f} degrees")
    return float(radii * angle + np.sqrt(distance**2 - radii**2) - across)


# ----------------------------------------------------------------------------------------------- quality of a sheet


class Checkerboard(NamedTuple):
    """Zig-zag part of the shear angle [degrees], and the node where it is largest (-1 if no block exists)."""

    rms: float
    maximum: float
    node: int


def checkerboard(blank: Blank, shear_angle: np.ndarray) -> Checkerboard:
    """Alternating part of the shear angle in every block of four elements around an interior node.

    It is (g1 - g2 + g3 - g4)/4 with the elements in cyclic order around the node.
    """
    flat = blank.quads.ravel()
    element = np.repeat(np.arange(blank.element_count), 4)
    inner = np.bincount(flat, minlength=blank.node_count) == 4
    edges = np.sort(np.concatenate([blank.quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    inner[edges[count == 1]] = False
    if not inner.any():
        return Checkerboard(0.0, 0.0, -1)
    chosen = inner[flat]
    offset = blank.material_coordinates[blank.quads].mean(axis=1)[element] - blank.material_coordinates[flat]
    polar = np.arctan2(offset[:, 1], offset[:, 0])
    order = np.lexsort((polar[chosen], flat[chosen]))
    blocks = shear_angle[element[chosen][order]].reshape(-1, 4)
    part = np.abs(np.rad2deg(blocks @ np.array([1.0, -1.0, 1.0, -1.0]) / 4.0))
    return Checkerboard(
        float(np.sqrt(np.mean(part**2))), float(part.max()), int(np.flatnonzero(inner)[np.argmax(part)])
    )


class RimFolds(NamedTuple):
    """Folds along the rim of a drape: how many, and how high [m]."""

    fold_count: int
    amplitude: float


def rim_folds(
    blank: Blank,
    position: np.ndarray,
    symmetry: Sequence[str] = (),
    threshold: float | None = None,
    smooth_radius: np.ndarray | None = None,
) -> RimFolds:
    """Folds of the free border around the z axis, seen in its distance from that axis.

    The distance is taken over the length of the flat outline, which stays single-valued when a fold overhangs. A fold
    is a maximum that rises at least ``threshold`` [m] (2 % of the mean distance by default) above the valleys on both
    sides. The amplitude is half the peak-to-peak distance.

    Args:
        smooth_radius: distance of each node from the axis without any fold, (node_count,) [m]: what is left is folds.
            Without it the Fourier harmonics 0 to 4 along the outline, which hold the shape of a smooth drape of a
            square, are taken out of the amplitude.
    """
    flat = whole_outline(blank, blank.material_coordinates, symmetry)
    radius = np.hypot(*whole_outline(blank, position, symmetry)[:, :2].T)
    mean = float(radius.mean())
    if smooth_radius is not None:
        column = np.column_stack([np.zeros(blank.node_count), np.zeros(blank.node_count), smooth_radius])
        radius = radius - whole_outline(blank, column, symmetry)[:, 2]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0, append=flat[:1]), axis=1))])
    sample_count = max(512, 4 * len(flat))
    even = np.interp(np.arange(sample_count) * length[-1] / sample_count, length, np.concatenate([radius, radius[:1]]))
    wrinkle = even
    if smooth_radius is None:
        spectrum = np.fft.rfft(even)
        spectrum[:5] = 0.0
        wrinkle = np.fft.irfft(spectrum, sample_count)
    height = 0.02 * mean if threshold is None else threshold
    return RimFolds(_count_maxima(even, height), 0.5 * float(np.ptp(wrinkle)))


def _count_maxima(values: np.ndarray, height: float) -> int:
    """Maxima of a periodic signal that rise ``height`` above the valleys on both sides."""
    values = np.roll(values, -int(np.argmin(values)))
    count, rising, extreme = 0, True, values[0]
    for value in [*values, values[0]]:
        extreme = max(extreme, value) if rising else min(extreme, value)
        if rising and value <= extreme - height:
            count, rising, extreme = count + 1, False, value
        elif not rising and value >= extreme + height:
            rising, extreme = True, value
    return count


def close_pairs(position: np.ndarray, quads: np.ndarray, distance: float) -> int:
    """Number of pairs of a node and an element closer than ``distance`` [m] that are not neighbours.

    A pair is neighbouring if one or two element edges lead from the node to a corner of the element. An element is
    taken as two triangles.

    Args:
        position: formed nodes, (node_count, 3) [m].
        quads: (element_count, 4).
    """
    if not distance > 0.0:
        raise InputError(f"distance of close pairs is {distance} m; it must be positive")
    corners = position[quads]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1) + distance
    origin, size = position.min(axis=0), reach.max()

    # nodes by cell; an element looks in the 27 cells around its centre
    node_cell, element_cell = (np.floor((points - origin) / size).astype(np.int64) + 1 for points in (position, centre))
    stride = node_cell.max(axis=0) + 3
    node_key, element_key = ((c[:, 0] * stride[1] + c[:, 1]) * stride[2] + c[:, 2] for c in (node_cell, element_cell))
    order = np.argsort(node_key, kind="stable")
    ranked = node_key[order]
    elements, nodes = [], []
    for shift in product((-1, 0, 1), repeat=3):
        step = (shift[0] * stride[1] + shift[1]) * stride[2] + shift[2]
        first, last = (np.searchsorted(ranked, element_key + step, side=side) for side in ("left", "right"))
        element, place = _join(np.arange(len(quads)), first, last)
        node = order[place]
        near = np.sum((position[node] - centre[element]) ** 2, axis=1) < reach[element] ** 2
        elements.append(element[near])
        nodes.append(node[near])
    element, node = np.concatenate(elements), np.concatenate(nodes)
    far = ~np.isin(element * len(position) + node, _neighbour_keys(quads, len(position)))
    element, node = element[far], node[far]
    if len(node) == 0:
        return 0
    from trimesh.triangles import closest_point  # takes half a second to import, and a good sheet never needs it

    gap = np.full(len(node), np.inf)
    for triangle in ((0, 1, 2), (0, 2, 3)):
        nearest = closest_point(corners[element][:, triangle], position[node])
        gap = np.minimum(gap, np.linalg.norm(nearest - position[node], axis=1))
    return int((gap < distance).sum())


def _join(left: np.ndarray, first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every (left[i], j) with first[i] <= j < last[i]."""
    count = last - first
    ends = np.cumsum(count)
    within = np.arange(int(count.sum())) - np.repeat(ends - count, count)
    return np.repeat(left, count), np.repeat(first, count) + within


def _neighbour_keys(quads: np.ndarray, node_count: int) -> np.ndarray:
    """Keys element * node_count + node of all nodes that at most two element edges join to a corner of the element."""
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]).astype(np.int64)
    itself = np.repeat(np.arange(node_count), 2).reshape(-1, 2)
    edges = np.unique(np.concatenate([edges, edges[:, ::-1], itself]), axis=0)
    element, reached = np.repeat(np.arange(len(quads)), 4), quads.ravel().astype(np.int64)
    for _ in range(2):
        first, last = (np.searchsorted(edges[:, 0], reached, side=side) for side in ("left", "right"))
        element, place = _join(element, first, last)
        keys = np.unique(element * node_count + edges[place, 1])
        element, reached = np.divmod(keys, node_count)
    return keys
