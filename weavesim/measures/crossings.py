"""Where sheets pass through themselves or each other: an exact count of the triangles that meet others.

Every pair of triangles whose boxes overlap is tested, with predicates that bound their rounding. Nothing here is shared
with the search for contact, so that a pair which that search misses is found.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .geometry.near import near_pairs
from .geometry.triangles import meet, pierces
from .proximity import join

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
        meeting = meet(position[self._triangles[first]], position[self._triangles[second]])
        fan = self._near_nodes(position)
        return np.concatenate([np.column_stack([first, second])[meeting], fan[self._meet_elsewhere(position, fan)]])

    def distant(self, pairs: np.ndarray, flat: np.ndarray, distance: float) -> np.ndarray:
        """Those of ``pairs`` that have no common node and lie further apart on the flat blank than ``distance``.

        Contact of a sheet with itself leaves out what is closer on the flat blank than about twice its thickness: there
        two triangles are neighbours.

        Args:
            pairs: of triangles, (k, 2).
            flat: flat coordinates of the nodes, (node_count, 2) [m].
            distance: [m].
        """
        own, other = self._triangles[pairs[:, 0]], self._triangles[pairs[:, 1]]
        apart = ~(own[:, :, None] == other[:, None, :]).any(axis=(1, 2))
        gap = np.minimum(_corner_gap(flat[own], flat[other]), _corner_gap(flat[other], flat[own]))
        return pairs[apart & (gap > distance)]

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
        return not any(_crosses(start, end, self._border, row) for row in rows)

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
        return _overlapping(*_boxes(points), first, second)

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
            found |= pierces(p, q, position[those], touching=False)
        return found


class CrossingsBetween:
    """Finds the triangles of sheets that meet triangles of other sheets.

    Every element is two triangles, as in ``Crossings``; pairs that meet or touch count.

    Args:
        quads: of every sheet, (element_count, 4) each.
    """

    def __init__(self, quads: Sequence[np.ndarray]) -> None:
        self._quads = [np.asarray(own, dtype=np.int64) for own in quads]
        self._sheet = np.repeat(np.arange(len(quads)), [len(own) for own in quads])
        self._first = np.concatenate([[0], np.cumsum([len(own) for own in quads])])

    def pairs(self, positions: Sequence[np.ndarray]) -> np.ndarray:
        """Every pair that meets, (k, 4): number of the sheet and its triangle, twice; the lower sheet first.

        Triangle t of a sheet is one of its element t // 2.

        Args:
            positions: formed nodes of every sheet, (node_count, 3) each [m].
        """
        middle = np.concatenate(positions).mean(axis=0)
        corners = np.concatenate([
            position[quads] - middle for position, quads in zip(positions, self._quads, strict=True)
        ])  # fmt: skip
        a, b = near_pairs(corners.mean(axis=1), corners, self._sheet)
        a, b = _overlapping(*_boxes(corners), a, b)
        first = (2 * a[:, None] + np.array([0, 0, 1, 1])).ravel()
        second = (2 * b[:, None] + np.array([0, 1, 0, 1])).ravel()
        triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
        first, second = _overlapping(*_boxes(triangles), first, second)
        meeting = meet(triangles[first], triangles[second])
        first, second = first[meeting], second[meeting]
        sheets = self._sheet[first // 2], self._sheet[second // 2]
        return np.column_stack([
            sheets[0], first - 2 * self._first[sheets[0]], sheets[1], second - 2 * self._first[sheets[1]],
        ])  # fmt: skip


def _boxes(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners of the boxes around bodies of few points, (k, n, 3), (k, 3) each [m]."""
    points = corners.transpose(1, 0, 2)  # a reduction over a short axis is slow
    return np.minimum.reduce(list(points)), np.maximum.reduce(list(points))


def _overlapping(
    lower: np.ndarray, upper: np.ndarray, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Those of the pairs whose boxes overlap; ``lower`` and ``upper`` are the corners of all boxes, (k, 3)."""
    overlap = np.ones(len(first), dtype=bool)
    for low, high in zip(lower.T, upper.T, strict=True):
        overlap &= (low[first] <= high[second]) & (low[second] <= high[first])
    return first[overlap], second[overlap]


def _corner_gap(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Smallest distance from the corners of flat triangles (k, 3, 2) to the edges of others (k, 3, 2), (k,)."""
    gap = np.full(len(points), np.inf)
    for corner in range(3):
        start = triangle[:, corner, None]
        edge = triangle[:, (corner + 1) % 3, None] - start
        to = points - start
        share = np.clip((to * edge).sum(axis=2) / np.maximum((edge * edge).sum(axis=2), 1.0e-300), 0.0, 1.0)
        gap = np.minimum(gap, np.linalg.norm(to - share[:, :, None] * edge, axis=2).min(axis=1))
    return gap


def _crosses(start: np.ndarray, end: np.ndarray, nodes: np.ndarray, rows: slice) -> bool:
    """Whether an edge in ``rows`` crosses or touches any edge of a plane, (k, 2) each, without a common node."""
    # edges on one line are parted by rounding; their boxes overlap only where they do
    lower, upper = np.minimum(start, end), np.maximum(start, end)
    near = np.ones((len(start[rows]), len(start)), dtype=bool)
    for low, high in zip(lower.T, upper.T, strict=True):
        near &= (low[rows, None] <= high) & (low <= high[rows, None])
    own, other = np.nonzero(near)
    own += rows.start
    apart = ~(nodes[own][:, :, None] == nodes[other][:, None, :]).any(axis=(1, 2))
    own, other = own[apart], other[apart]

    def parts(line: np.ndarray, edge: np.ndarray) -> np.ndarray:
        """Whether the lines along edges part the ends of other edges, or go through one."""
        along = end[line] - start[line]
        sides = []
        for point in (start[edge], end[edge]):
            to = point - start[line]
            sides.append(along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0])
        return np.asarray(sides[0] * sides[1] <= 0.0)

    return bool((parts(own, other) & parts(other, own)).any())
