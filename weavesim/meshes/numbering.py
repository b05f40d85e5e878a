"""Numbers of the nodes and elements of a mesh: how far neighbours are apart in them, and an order that mends it.

A step reads the nodes of sixteen elements at once, and keeps what a thousand elements hand over in a core's cache. Both
need neighbours with neighbouring numbers, which few mesh generators give (docs/decisions/0072).
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np

from ..errors import InputError
from .source import listed

Numbering = Literal["kept", "neighbouring"]

# Elements and nodes that are read together on a CPU.
BLOCK = 16
# Blocks of nodes that a block of elements touches in the mean: 4 to 9 in any good order, 64 at most. From here on the
# steps of 10,000 elements take 1.1 to 1.5 times as long, those of 100,000 twice as long.
SCATTERED = 20.0
# Smaller sheets lie in a core's cache as a whole.
FEWEST_ELEMENTS = 4096


def checked_numbering(value: Any) -> Numbering:
    """Raises an InputError unless it is one of ``Numbering``."""
    for known in get_args(Numbering):
        if isinstance(value, str) and value == known:
            return known
    raise InputError(f"numbering = {value!r}: one of {', '.join(map(repr, get_args(Numbering)))} is needed")


def neighbouring_order(quads: np.ndarray, node_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the nodes, (node_count,), and of the elements, (m,), in an order in which neighbours follow each other.

    Nodes by reverse Cuthill and McKee, front after front across the sheet; elements by their lowest node in that order.

    Args:
        quads: corner nodes of each element, (m, 4).
        node_count: of all nodes.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    first, second = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    ones = np.ones(2 * len(first), dtype=np.int8)
    either_way = np.concatenate([first, second]), np.concatenate([second, first])
    sides = coo_array((ones, either_way), shape=(node_count, node_count)).tocsr()
    nodes = np.asarray(reverse_cuthill_mckee(sides, symmetric_mode=True))
    place = np.empty(node_count, dtype=np.int64)
    place[nodes] = np.arange(node_count)
    corners = place[quads]
    return nodes, np.lexsort((corners.sum(axis=1), corners.min(axis=1)))


def blocks_touched(quads: np.ndarray) -> float:
    """Blocks of nodes that a block of elements touches, in the mean over all whole blocks; (m, 4) corner nodes."""
    count = len(quads) // BLOCK * BLOCK
    if not count:
        return 1.0
    blocks = np.sort((quads[:count] // BLOCK).reshape(-1, 4 * BLOCK), axis=1)
    return float(1.0 + np.count_nonzero(np.diff(blocks, axis=1)) / len(blocks))


def scatter_told(quads: np.ndarray) -> str:
    """What numbers that are far apart between neighbours cost, and what to do; empty where they cost little."""
    if len(quads) < FEWEST_ELEMENTS or (touched := blocks_touched(quads)) <= SCATTERED:
        return ""
    return (
        f"neighbours have numbers far apart: {BLOCK} elements in sequence use nodes in {touched:.0f} different places, "
        "which are 4 to 9 in a good order, and steps take 1.1 to 1.5 times as long with 10,000 elements, twice with "
        '100,000; numbering = "neighbouring" mends that, and results keep the numbers of the mesh as labels'
    )


def each_once(numbers: np.ndarray) -> bool:
    """Whether these are numbers from 1 on, each there once: instances of a part have the same ones."""
    return len(numbers) == 0 or (int(numbers.min()) >= 1 and len(np.unique(numbers)) == len(numbers))


def rows_numbered(word: str, wanted: Any, numbers: np.ndarray | None, count: int) -> np.ndarray:
    """Rows, from 0, of what has some numbers in the mesh of a user.

    Args:
        word: "node" or "element".
        wanted: numbers, (k,) int.
        numbers: of all rows, (count,); None for rows counted from 1.
        count: of all rows.

    Raises:
        InputError: a number that is not there.
    """
    asked = np.atleast_1d(np.asarray(wanted))
    if asked.ndim != 1 or (asked.size and not np.issubdtype(asked.dtype, np.integer)):
        raise InputError(f"numbers of {word}s: whole numbers are needed, in one row")
    known = np.arange(1, count + 1) if numbers is None else numbers
    order = np.argsort(known)
    place = np.minimum(np.searchsorted(known, asked, sorter=order), count - 1)
    rows: np.ndarray = order[place]
    if (missing := known[rows] != asked).any():
        raise InputError(f"the mesh has no {word} {listed(asked[missing].tolist())}: give numbers of its own")
    return rows
