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


def groups_that_share(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Of every group of nodes of ``first``, the groups of ``second`` with a node of it; as ``compact_groups``."""
    holders: dict[int, list[int]] = {}
    for index, column in enumerate(second.T):
        for node in column[column >= 0]:
            holders.setdefault(int(node), []).append(index)
    return padded_columns(
        [np.unique([index for node in column[column >= 0] for index in holders[int(node)]]) for column in first.T]
    )
