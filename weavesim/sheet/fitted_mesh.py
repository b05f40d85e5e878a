"""Quadrilaterals that fill an outline, with a mesh direction independent of the outline.

A regular grid, rotated by any angle, is kept well inside the outline; one layer of quadrilaterals connects its
staircase edge to the outline, and nodes near that layer are smoothed. So the mesh direction in the interior is exact,
and no staircase is left at the edge.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..quantities import finite, positive
from .mesh_checks import check_count
from .outline import Outline, Region, checked_outline, cross
from .topology import checked_distortion
from .untangling import corner_sines, untangled

# Where the outline turns left by more than this, one element fills the corner; elsewhere two meet in it [rad].
FILLED_TURN = np.deg2rad(60.0)
# Nodes of the grid keep this distance from the outline, in element sizes.
LEAST_DISTANCE = 0.6
# Nodes up to this distance from the outline are smoothed, in element sizes.
SMOOTHED_DISTANCE = 3.0
SMOOTHING_COUNT = 60
# Distortion reduces no element below this quality, unless it was worse before.
CAREFUL_QUALITY = 0.4
# Elements below this quality are improved where an outline has corners that point inwards.
WISHED_QUALITY = 0.5
# There the grid is tried at these shifts, in element sizes, until an element of this quality is the poorest.
SHIFTS = (
    (0.0, 0.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.5), (0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75), (0.35, 0.1)
)  # fmt: skip
GOOD_QUALITY = 0.35
# Smallest accepted sine of a corner angle; forces of flatter elements are inaccurate.
LEAST_QUALITY = 0.2


def fitted_mesh(
    outline: np.ndarray,
    element_size: float,
    *,
    holes: Sequence[np.ndarray] = (),
    mesh_angle: float = 0.0,
    distortion: float = 0.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 2) [m] and quadrilaterals (m, 4) that fill a polygon, which may have holes.

    Args:
        outline: corners in order, (k, 2) [m].
        element_size: edge length in the regular interior [m].
        holes: corners of each hole in order, (k, 2) [m].
        mesh_angle: from the x axis to the grid [degrees].
        distortion: random displacement of the inner nodes, as a share of the element size.
        seed: of the displacement.

    Raises:
        InputError: an outline that crosses itself, is too small for the elements, or has corners that they cannot
            fill well.
    """
    try:
        loops = [checked_outline(outline), *(checked_outline(hole)[::-1] for hole in holes)]
    except InputError as error:
        raise InputError(f"fitted mesh: {error}") from None
    outline = loops[0]
    element_size, mesh_angle = positive("element_size", element_size), finite("mesh_angle", mesh_angle)
    distortion = checked_distortion(distortion)
    cosine, sine = np.cos(np.deg2rad(mesh_angle)), np.sin(np.deg2rad(mesh_angle))
    turn = np.array([[cosine, -sine], [sine, cosine]])
    centre = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
    check_count(0.5 * float(np.prod(np.ptp(outline, axis=0) / element_size)), f"elements of {element_size:g} m")
    # in the frame of the grid, in element sizes
    region = Region([Outline((loop - centre) @ turn / element_size) for loop in loops])
    _check_holes(region)
    if region.has_hollows:
        node, quads, on_border, shift = _best_of_shifts(region)
        centre = centre + shift * element_size @ turn.T
    else:
        node, quads = _inner_grid(region)
        node, quads, on_border = _joined(node, quads, region)
        node = _smoothed(node, quads, region, on_border)
    if distortion:
        random = np.random.default_rng(seed).uniform(-distortion, distortion, node.shape)
        node = _careful(node, node + random * ~on_border[:, None], quads)
    quality = corner_sines(node, quads)
    if quality.min() < LEAST_QUALITY:
        where = (node[quads[np.argmin(quality)]].mean(axis=0) * element_size) @ turn.T + centre
        raise InputError(
            f"fitted mesh: an element near ({where[0]:.4g}, {where[1]:.4g}) m has a corner angle with the sine "
            f"{quality.min():.2f}, below {LEAST_QUALITY}; use smaller elements than {element_size} m, less distortion "
            f"than {distortion}, or an outline without sharp corners"
        )
    return node * element_size @ turn.T + centre, quads


def _best_of_shifts(region: Region) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, elements, which nodes are on an outline, and the shift of the grid that suits inward corners and holes.

    Raises:
        InputError: no grid fits.
    """
    best: tuple[float, tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] | None = None
    problem: InputError | None = None
    for shift in map(np.array, SHIFTS):
        moved = Region([Outline(border.vertex - shift) for border in region.borders])
        try:
            node, quads = _inner_grid(moved)
            node, quads, on_border = _joined(node, quads, moved)
        except InputError as error:
            problem = problem or error
            continue
        # at an inward corner the centre of the neighbours may lie beyond the outline
        smooth = _careful(node, _smoothed(node, quads, moved, on_border), quads)
        smooth = untangled(smooth, quads, ~on_border, WISHED_QUALITY)
        quality = float(corner_sines(smooth, quads).min())
        if best is None or quality > best[0]:
            best = quality, (smooth, quads, on_border, shift)
        if quality >= GOOD_QUALITY:
            break
    if best is None:
        assert problem is not None
        raise problem
    return best[1]


def _check_holes(region: Region) -> None:
    """Check that holes lie within the outline, and apart.

    Raises:
        InputError: one does not.
    """
    for index, hole in enumerate(region.borders[1:]):
        if region.borders[0].nearest(hole.vertex)[0].min() <= 0.0:
            raise InputError(f"fitted mesh: hole {index} is not within the outline")
        for other, border in enumerate(region.borders[1:]):
            if other != index and border.nearest(hole.vertex)[0].max() >= 0.0:
                raise InputError(f"fitted mesh: holes {min(index, other)} and {max(index, other)} overlap")


def _inner_grid(region: Region) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and unit squares well inside, without squares connected by a single corner only."""
    reach = np.ceil(np.abs(region.borders[0].vertex).max(axis=0)).astype(int)
    x, y = (np.arange(-r, r + 1) for r in reach)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).astype(float)
    distance = region.distance(grid.reshape(-1, 2))
    good = (distance >= LEAST_DISTANCE).reshape(grid.shape[:2])
    kept = np.zeros((len(x) + 1, len(y) + 1), dtype=bool)  # with a rim of squares that are not kept
    kept[1:-1, 1:-1] = good[:-1, :-1] & good[1:, :-1] & good[1:, 1:] & good[:-1, 1:]
    while True:
        a, b, c, d = kept[:-1, :-1], kept[1:, :-1], kept[1:, 1:], kept[:-1, 1:]
        touching = np.argwhere((a & c & ~b & ~d) | (b & d & ~a & ~c))
        # a square with at most one neighbour is a spike of the staircase
        neighbours = np.zeros(kept.shape, dtype=int)
        for axis in range(2):
            for shift in (1, -1):
                neighbours += np.roll(kept, shift, axis=axis)
        needles = kept & (neighbours < 2)
        if not len(touching) and not needles.any():
            break
        kept &= ~needles
        for i, j in touching:
            kept[i : i + 2, j : j + 2] = False
    kept = _largest_part(kept)[1:-1, 1:-1]
    if not kept.any():
        raise InputError(
            "fitted mesh: fewer than two by two elements fit into the outline; use smaller ones, at most about a "
            "quarter of its width"
        )
    index = np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)[kept]
    used, quads = np.unique(quads, return_inverse=True)
    return grid.reshape(-1, 2)[used], quads.reshape(-1, 4)


def _largest_part(kept: np.ndarray) -> np.ndarray:
    """The largest set of squares connected by edges."""
    label = np.where(kept, np.arange(1, kept.size + 1).reshape(kept.shape), 0)
    while True:
        spread = label.copy()
        for axis in range(2):
            for shift in (1, -1):
                spread = np.maximum(spread, np.roll(label, shift, axis=axis))
        spread *= kept
        if np.array_equal(spread, label):
            break
        label = spread
    values, counts = np.unique(label[kept], return_counts=True)
    return label == values[counts.argmax()] if len(values) else kept


def _joined(node: np.ndarray, quads: np.ndarray, region: Region) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grid plus the layers of quadrilaterals along all outlines; which nodes are on an outline."""
    stairs = _staircases(quads)
    if len(stairs) != len(region.borders):
        raise InputError(
            "fitted mesh: the elements leave a hole inside the outline, or it is too narrow; use smaller elements"
            if len(stairs) > len(region.borders)
            else "fitted mesh: a hole is too small, or too near to an edge, for the elements; use smaller ones"
        )
    first, layers = len(node), [quads]
    for border in region.borders:
        nearest = [float(np.abs(border.nearest(node[stair])[0]).mean()) for stair in stairs]
        stair = stairs.pop(int(np.argmin(nearest)))
        node, layer = _join(node, stair, border)
        layers.append(layer)
    return node, np.concatenate(layers), np.arange(len(node)) >= first


def _join(node: np.ndarray, stair: np.ndarray, border: Outline) -> tuple[np.ndarray, np.ndarray]:
    """Nodes with those on an outline, and the layer of quadrilaterals between it and a staircase of the grid."""
    arc = _ordered(border.nearest(node[stair])[1], border.length)
    held = np.zeros(len(stair), dtype=bool)
    filled = np.zeros(len(stair), dtype=bool)
    before, after = np.roll(stair, 1), np.roll(stair, -1)
    # 1 where one square ends, 0 along an edge, -1 where the staircase steps out again
    step = cross(node[stair] - node[before], node[after] - node[stair])
    position = border.start[:-1]
    for corner in border.corner:
        fill = border.turn[corner] > FILLED_TURN
        gap = np.linalg.norm(node[stair] - border.vertex[corner], axis=1)
        gap = np.where(held, np.inf, gap - (0.5 * step if fill else 0.0))
        i = int(gap.argmin())
        held[i], filled[i] = True, fill and step[i] > 0.0
        arc[i] = position[corner] + border.length * round((arc[i] - position[corner]) / border.length)
    # one entry per node on the outline: a filled corner has one before and one after it
    times = np.where(filled, 3, 1)
    owner = np.repeat(stair, times)
    place = np.cumsum(times) - 1 - filled
    entry_arc, entry_held = np.repeat(arc, times), np.zeros(len(owner), dtype=bool)
    entry_held[place] = held
    for i in place[filled]:
        entry_arc[i - 1] -= 1.0
        entry_arc[(i + 1) % len(owner)] += 1.0
    # starting at a corner, if there is one
    first = int(entry_held.argmax())
    entry_arc[:first] += border.length
    owner, entry_arc, entry_held = (np.roll(values, -first) for values in (owner, entry_arc, entry_held))
    place = np.mod(place - first, len(owner))
    entry_arc = _spread(entry_arc, entry_held, border.length)
    first_border = len(node)
    border_node = first_border + np.arange(len(owner))
    following = np.roll(np.arange(len(owner)), -1)
    edge = owner != owner[following]
    layer = np.column_stack([owner, border_node, border_node[following], owner[following]])[edge]
    fill = np.column_stack([
        owner[place], border_node[place - 1], border_node[place], border_node[(place + 1) % len(owner)]
    ])[filled]  # fmt: skip
    return np.concatenate([node, border.point(entry_arc)]), np.concatenate([layer, fill])


def _staircases(quads: np.ndarray) -> list[np.ndarray]:
    """Nodes of each edge of the grid, in order, with the grid to the left."""
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)])
    known = set(map(tuple, edges.tolist()))
    following = {a: b for a, b in known if (b, a) not in known}
    loops = []
    while following:
        loop = [next(iter(following))]
        while (node := following.pop(loop[-1])) != loop[0]:
            loop.append(node)
        loops.append(np.array(loop))
    return loops


def _ordered(arc: np.ndarray, length: float) -> np.ndarray:
    """Arc lengths of successive points without the jump of a full turn."""
    step = np.diff(arc)
    return arc - length * np.concatenate([[0], np.cumsum(np.rint(step / length))])


def _spread(arc: np.ndarray, held: np.ndarray, length: float) -> np.ndarray:
    """Arc lengths in order, evenly spaced between the ``held`` ones, (n,); periodic with ``length``."""
    count = len(arc)
    anchors = np.flatnonzero(held)
    for begin, end in zip(anchors, [*anchors[1:], anchors[0] + count] if len(anchors) else [], strict=True):
        inside = slice(begin + 1, end)
        low, high = arc[begin], arc[end % count] + (length if end == count else 0.0)
        if high - low < 0.5 * (end - begin):
            raise InputError(
                "fitted mesh: two corners of the outline are too close together for the elements; use smaller ones"
            )
        arc[inside] = np.clip(arc[inside], low, high)
    arc = np.maximum.accumulate(arc)
    for _ in range(SMOOTHING_COUNT):
        before, after = np.roll(arc, 1), np.roll(arc, -1)
        before[0] -= length
        after[-1] += length
        arc = np.where(held, arc, 0.5 * (before + after))
    return arc


def _smoothed(node: np.ndarray, quads: np.ndarray, region: Region, on_border: np.ndarray) -> np.ndarray:
    """Inner nodes near the outline, moved to the centre of their neighbours."""
    distance = region.distance(node)
    moved = ~on_border & (distance < SMOOTHED_DISTANCE)
    edges = np.unique(np.sort(np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1), axis=0)
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[moved[edges[:, 0]]]
    count = np.maximum(np.bincount(edges[:, 0], minlength=len(node)), 1)[:, None]
    for _ in range(SMOOTHING_COUNT):
        total = np.stack(
            [np.bincount(edges[:, 0], weights=node[edges[:, 1], c], minlength=len(node)) for c in range(2)], axis=1
        )
        node = np.where(moved[:, None], total / count, node)
    return node


def _careful(node: np.ndarray, wished: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Move nodes to their ``wished`` positions, or only part of the distance if an element would become poor."""
    before = corner_sines(node, quads)
    for share in (0.5, 0.5, 0.5, 0.0):
        after = corner_sines(wished, quads)
        worse = quads[(after < CAREFUL_QUALITY) & (after < before)].ravel()
        if not len(worse):
            break
        worse = np.unique(worse)
        wished = wished.copy()
        wished[worse] = node[worse] + share * (wished[worse] - node[worse])
    return wished
