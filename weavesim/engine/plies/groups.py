"""Groups of nodes and of elements that lie together on the flat blank, for the watch of self-contact."""

from __future__ import annotations

import numpy as np

# Nodes, or elements, of a group at most.
GROUP_SIZE = 16


def compact_groups(flat: np.ndarray, size: int = GROUP_SIZE) -> np.ndarray:
    """Points in groups by halving their number along the longer side again and again.

    Args:
        flat: (n, 2) [m].
        size: largest number of a group.

    Returns:
        Their numbers, ascending in each group, (size, group_count) int32; -1 where a group has fewer.
    """
    groups: list[np.ndarray] = []
    waiting = [np.arange(len(flat))]
    while waiting:
        members = waiting.pop()
        if len(members) <= size:
            groups.append(np.sort(members))
            continue
        axis = int(np.argmax(np.ptp(flat[members], axis=0)))
        members = members[np.argsort(flat[members, axis], kind="stable")]
        # whole groups on one side, so that few are left half empty
        half = size * (-(-len(members) // size) // 2)
        waiting += [members[half:], members[:half]]
    return padded_columns(groups)


def padded_columns(rows: list[np.ndarray]) -> np.ndarray:
    """Lists of different lengths as columns, (longest, count) int32; -1 behind their ends."""
    result = np.full((max(map(len, rows), default=1), len(rows)), -1, dtype=np.int32)
    for column, row in enumerate(rows):
        result[: len(row), column] = row
    return result


def nodes_of(elements: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Nodes of groups of elements, ascending, as ``compact_groups`` returns them."""
    return padded_columns([np.unique(quads[column[column >= 0]]) for column in elements.T])


def groups_that_hang_together(
    first: np.ndarray, second: np.ndarray, flat: np.ndarray, distance: float, cut: np.ndarray
) -> np.ndarray:
    """Of every group of nodes of ``first``, the groups of ``second`` to which the sheet leads on a short way.

    Args:
        first, second: groups of nodes, as ``compact_groups``.
        flat: coordinates of the nodes, (node_count, 2) [m].
        distance: of their boxes on the flat blank, up to which groups count [m].
        cut: nodes at a cut, (node_count,) bool, where the sheet may slide over itself; their groups have none.
    """
    from scipy.sparse import csr_array

    def holding(groups: np.ndarray) -> csr_array:
        place, group = np.nonzero(groups >= 0)
        ones = np.ones(len(group), dtype=np.int32)
        return csr_array((ones, (group, groups[place, group])), shape=(groups.shape[1], len(flat)))

    def boxes(groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        members = [flat[column[column >= 0]] for column in groups.T]
        return np.array([m.min(axis=0) for m in members]), np.array([m.max(axis=0) for m in members])

    of_first, of_second = holding(first), holding(second)
    (low, high), (other_low, other_high) = boxes(first), boxes(second)
    next_to = ((of_second @ of_second.T) > 0).astype(np.int32)
    reached = ((of_first @ of_second.T) > 0).astype(np.int32)
    size = max(float(np.median(other_high - other_low)), 1e-12)
    # groups between them may be half as wide as most
    steps = min(8, int(np.ceil(2.0 * distance / size))) + 1 if distance > 0.0 else 0
    for _ in range(steps):
        reached = ((reached @ next_to) > 0).astype(np.int32)
    whole = ~np.array([cut[column[column >= 0]].any() for column in first.T])
    other_whole = ~np.array([cut[column[column >= 0]].any() for column in second.T])
    group, other = reached.nonzero()
    gap = np.maximum(other_low[other] - high[group], low[group] - other_high[other]).max(axis=1)
    kept = (gap <= distance) & whole[group] & other_whole[other]
    group, other = group[kept], other[kept]
    order = np.lexsort((other, group))
    ends = np.searchsorted(group[order], np.arange(1, first.shape[1]))
    return padded_columns(np.split(other[order], ends))


def nodes_at_cuts(flat: np.ndarray, on_edge: np.ndarray, size: float) -> np.ndarray:
    """Nodes of a free edge that lie at another one's place on the flat blank: at a slit, (node_count,) bool.

    Args:
        flat: coordinates of the nodes, (node_count, 2) [m].
        on_edge: which lie on a free edge, (node_count,) bool.
        size: of an element [m].
    """
    from scipy.spatial import KDTree

    result, nodes = np.zeros(len(flat), dtype=bool), np.flatnonzero(on_edge)
    if len(nodes):
        pairs = KDTree(flat[nodes]).query_pairs(0.3 * size, output_type="ndarray")
        result[nodes[np.unique(pairs)]] = True
    return result
