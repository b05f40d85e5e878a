"""Where a sheet passes through itself: an exact count of its triangles that meet others."""

from __future__ import annotations

from itertools import product

import numpy as np

from .proximity import join

# Share of the product of three edges below which a volume is rounding, and counts as zero.
ROUNDING = 1.0e-13
# Elements larger than the median by more than this are compared with all others.
LARGEST_RATIO = 4.0
# Edges of the border that are compared with all others at once.
EDGES_AT_ONCE = 512
# The triangles around a node lie in one half space by at least this cosine wherever none of them can meet.
SMALLEST_COSINE = 0.1


class Crossings:
    """Finds the triangles of a sheet that meet others; what depends on the mesh alone is computed once.

    Every element is two triangles, (0, 1, 2) and (0, 2, 3) of its corners. Pairs without a common node count if they
    meet or touch. Pairs with one common node count if they meet elsewhere. Pairs with a common edge never count: see
    ``folding.py``.

    Args:
        quads: (element_count, 4).
        node_count: of the sheet.
    """

    def __init__(self, quads: np.ndarray, node_count: int) -> None:
        self._quads = np.asarray(quads, dtype=np.int64)
        self._triangles = self._quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
        self._node_count = node_count
        order = np.argsort(self._triangles.ravel(), kind="stable")
        self._corner_node, self._corner_triangle = self._triangles.ravel()[order], order // 3
        edges = np.stack([self._quads, np.roll(self._quads, -1, axis=1)], axis=2).reshape(-1, 2)
        _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
        self._border = edges[place[count == 1]]

    def pairs(self, position: np.ndarray) -> np.ndarray:
        """Every pair of triangles that meet, (k, 2); triangle t is one of element t // 2.

        Args:
            position: formed nodes, (node_count, 3) [m].
        """
        position = position - position.mean(axis=0)
        if self._has_a_plan(position):
            return np.empty((0, 2), dtype=np.int64)
        first, second = self._apart(position)
        meet = _meet(position[self._triangles[first]], position[self._triangles[second]])
        fan = self._near_nodes(position)
        return np.concatenate([np.column_stack([first, second])[meet], fan[self._meet_elsewhere(position, fan)]])

    # --- sheets that need no search ----------------------------------------------------------------------------------

    def _has_a_plan(self, position: np.ndarray) -> bool:
        """Whether the sheet lies above a plane like a landscape, which has no crossings.

        All triangles face one way, and no two edges of the border cross in the plan. Then every point of the plan lies
        under as many triangles as the border winds around it, which is at most one.
        """
        normal = self._normals(position)
        up = normal.sum(axis=0)
        if not (normal @ up > 0.0).all():
            return False
        across = np.linalg.svd(up[None])[2][1:]
        start, end = (position[self._border[:, side]] @ across.T for side in (0, 1))
        rows = (slice(k, k + EDGES_AT_ONCE) for k in range(0, len(start), EDGES_AT_ONCE))
        return not any(_crossing_edges(start, end, self._border, row).any() for row in rows)

    def _normals(self, position: np.ndarray) -> np.ndarray:
        """Of all triangles, as long as twice their area, (triangle_count, 3) [m^2]."""
        a, b, c = (position[self._triangles[:, corner]] for corner in range(3))
        return np.cross(b - a, c - a)

    # --- pairs without a common node ---------------------------------------------------------------------------------

    def _apart(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of triangles of elements without a common node, whose boxes overlap."""
        corners = position[self._quads]
        a, b = near_pairs(corners.mean(axis=1), corners)
        # neighbours too: two of their triangles may have no common node
        first = (2 * a[:, None] + np.array([0, 0, 1, 1])).ravel()
        second = (2 * b[:, None] + np.array([0, 1, 0, 1])).ravel()
        own, other = self._triangles[first], self._triangles[second]
        apart = np.ones(len(first), dtype=bool)
        for corner in range(3):
            for opposite in range(3):
                apart &= own[:, corner] != other[:, opposite]
        first, second = first[apart], second[apart]
        points = position[self._triangles]
        lower = np.minimum(np.minimum(points[:, 0], points[:, 1]), points[:, 2])
        upper = np.maximum(np.maximum(points[:, 0], points[:, 1]), points[:, 2])
        overlap = np.ones(len(first), dtype=bool)
        for axis in range(3):
            low, high = lower[:, axis], upper[:, axis]
            overlap &= (low[first] <= high[second]) & (low[second] <= high[first])
        return first[overlap], second[overlap]

    # --- pairs with one common node ----------------------------------------------------------------------------------

    def _around(self, nodes: np.ndarray) -> np.ndarray:
        """Pairs of triangles of different elements whose one common node is among ``nodes`` (node_count,), (k, 2)."""
        node, triangle = self._corner_node, self._corner_triangle
        wanted = nodes[node]
        node, triangle = node[wanted], triangle[wanted]
        place = np.arange(len(node))
        # each with the triangles before it around the same node
        later, earlier = join(place, np.searchsorted(node, node, side="left"), place)
        a, b = triangle[earlier], triangle[later]
        common = (self._triangles[a][:, :, None] == self._triangles[b][:, None, :]).any(axis=2).sum(axis=1)
        apart = (common == 1) & (a // 2 != b // 2)
        return np.column_stack([a, b])[apart]

    def _near_nodes(self, position: np.ndarray) -> np.ndarray:
        """Those of ``_around`` whose node is in a fold: elsewhere all normals lie in one half space."""
        normal = self._normals(position)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1.0e-300)[:, None]
        mean = np.zeros((self._node_count, 3))
        for axis in range(3):
            mean[:, axis] = np.bincount(self._triangles.ravel(), np.repeat(normal[:, axis], 3), self._node_count)
        mean /= np.maximum(np.linalg.norm(mean, axis=1), 1.0e-300)[:, None]
        turned = np.einsum("tc,tkc->tk", normal, mean[self._triangles]) < SMALLEST_COSINE
        folded = np.zeros(self._node_count, dtype=bool)
        folded[self._triangles[turned]] = True
        return self._around(folded)

    def _meet_elsewhere(self, position: np.ndarray, pairs: np.ndarray) -> np.ndarray:
        """Whether triangles with one common node meet elsewhere: an edge opposite to it goes through the other."""
        own, other = self._triangles[pairs[:, 0]], self._triangles[pairs[:, 1]]
        found = np.zeros(len(pairs), dtype=bool)
        for these, those in ((own, other), (other, own)):
            at = np.argmax((these[:, :, None] == those[:, None, :]).any(axis=2), axis=1)
            row = np.arange(len(pairs))
            p, q = position[these[row, (at + 1) % 3]], position[these[row, (at + 2) % 3]]
            found |= _pierces(p, q, position[those], touching=False)
        return found


def _crossing_edges(start: np.ndarray, end: np.ndarray, nodes: np.ndarray, rows: slice) -> np.ndarray:
    """Which of the edges in ``rows`` cross or touch which edges of a plane, (k, 2) each, without a common node."""

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Side of the lines p-q on which the points r lie, (lines, points)."""
        along, to = q - p, r[None] - p[:, None]
        return np.asarray(along[:, None, 0] * to[..., 1] - along[:, None, 1] * to[..., 0])

    own, other = (start[rows], end[rows]), (start, end)
    parted = side(*own, start) * side(*own, end) <= 0.0
    parted &= (side(*other, own[0]) * side(*other, own[1]) <= 0.0).T
    # edges on one line are parted by rounding; their boxes overlap only where they do
    lower, upper = np.minimum(start, end), np.maximum(start, end)
    near = ((lower[rows, None] <= upper[None]) & (lower[None] <= upper[rows, None])).all(axis=2)
    common = (nodes[rows, None, :, None] == nodes[None, :, None, :]).any(axis=(2, 3))
    return np.asarray(parted & near & ~common)


def near_pairs(centre: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs a < b of bodies whose bounding spheres meet, each once.

    Args:
        centre: (k, 3) [m].
        corners: all points of every body, (k, n, 3) [m].
    """
    radius = np.sqrt(np.square(corners - centre[:, None]).sum(axis=2).max(axis=1)) * (1.0 + 1.0e-12)
    usual = LARGEST_RATIO * float(np.median(radius))
    large, small = np.flatnonzero(radius > usual), np.flatnonzero(radius <= usual)
    found = [_meeting(centre, radius, np.full(len(centre), body), np.arange(len(centre))) for body in large]
    if len(large):
        found = [np.unique(np.sort(np.concatenate(found), axis=1), axis=0)]

    size = max(2.0 * float(radius[small].max(initial=0.0)), 1.0e-300)
    cell = np.floor((centre[small] - centre.min(axis=0)) / size).astype(np.int64) + 1
    stride = cell.max(axis=0, initial=0) + 3
    key = (cell[:, 0] * stride[1] + cell[:, 1]) * stride[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    ranked, own = key[order], small[order]
    for shift in product((-1, 0, 1), repeat=3):
        step = (shift[0] * stride[1] + shift[1]) * stride[2] + shift[2]
        if step < 0:  # the other way round it is found too
            continue
        first, last = (np.searchsorted(ranked, ranked + step, side=side) for side in ("left", "right"))
        if step == 0:
            first = np.arange(1, len(ranked) + 1)
        body, other = join(own, first, last)
        found.append(_meeting(centre, radius, body, own[other]))
    pairs = np.concatenate(found)
    return pairs.min(axis=1), pairs.max(axis=1)


def _meeting(centre: np.ndarray, radius: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Those of the pairs (a, b) of different bodies whose spheres meet, (k, 2)."""
    apart = centre[a] - centre[b]
    meet = (np.einsum("ki,ki->k", apart, apart) <= (radius[a] + radius[b]) ** 2) & (a != b)
    return np.column_stack([a[meet], b[meet]])


def _volume(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Sign of the volume of tetrahedra, (k,): 0 where it is rounding."""
    u, v, w = b - a, c - a, d - a
    value = np.einsum("ki,ki->k", np.cross(u, v), w)
    size = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1) * np.linalg.norm(w, axis=1)
    return np.where(np.abs(value) <= ROUNDING * size, 0.0, np.sign(value))


def _pierces(p: np.ndarray, q: np.ndarray, triangle: np.ndarray, touching: bool) -> np.ndarray:
    """Whether segments p-q (k, 3) go through triangles (k, 3, 3) that are not in one plane with them.

    Args:
        touching: whether it is enough to touch.
    """
    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    below, above = _volume(a, b, c, p), _volume(a, b, c, q)
    result = below * above < 0.0
    if touching:
        result |= (below * above == 0.0) & (below != above)
    (candidate,) = np.nonzero(result)
    p, q, a, b, c = (array[candidate] for array in (p, q, a, b, c))
    sides = np.stack([_volume(p, q, a, b), _volume(p, q, b, c), _volume(p, q, c, a)])
    through = (sides > 0.0).all(axis=0) | (sides < 0.0).all(axis=0)
    if touching:
        through = (sides >= 0.0).all(axis=0) | (sides <= 0.0).all(axis=0)
    result[candidate] = through
    return result


def _meet(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether pairs of triangles (k, 3, 3) meet or touch, (k,)."""
    result = np.zeros(len(first), dtype=bool)
    if not len(first):
        return result
    a, b, c = second[:, 0], second[:, 1], second[:, 2]
    side = np.stack([_volume(a, b, c, first[:, corner]) for corner in range(3)])
    crossing = ~((side > 0.0).all(axis=0) | (side < 0.0).all(axis=0))
    flat = (side == 0.0).all(axis=0)
    (candidate,) = np.nonzero(crossing & ~flat)
    for these, those in ((first, second), (second, first)):
        for corner in range(3):
            p, q = these[candidate, corner], these[candidate, (corner + 1) % 3]
            result[candidate] |= _pierces(p, q, those[candidate], touching=True)
    (candidate,) = np.nonzero(flat)
    if len(candidate):
        result[candidate] = _overlap(first[candidate], second[candidate])
    return result


def _overlap(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether pairs of triangles (k, 3, 3) in one plane overlap or touch: no edge of either separates them."""
    normal = np.cross(second[:, 1] - second[:, 0], second[:, 2] - second[:, 0])
    apart = np.zeros(len(first), dtype=bool)
    for triangle in (first, second):
        for corner in range(3):
            start, edge = triangle[:, corner], triangle[:, (corner + 1) % 3] - triangle[:, corner]
            across = np.cross(normal, edge)
            own, other = (np.einsum("kni,ki->kn", points - start[:, None], across) for points in (first, second))
            apart |= (own.min(axis=1) > other.max(axis=1)) | (other.min(axis=1) > own.max(axis=1))
    return ~apart
