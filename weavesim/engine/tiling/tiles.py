"""What each thread does in a step: tiles of elements, and the nodes that can move after them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Number of elements whose forces stay in a core's L2 cache until their nodes have moved.
TILE_SIZE = 1024


def chunks(count: int, part_count: int) -> list[tuple[int, int]]:
    """(first, length) of ``part_count`` nearly equal parts of range(count)."""
    edges = np.linspace(0, count, part_count + 1).astype(int)
    return [(int(a), int(b - a)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


@dataclass(frozen=True)
class Part:
    """What one thread does in a step; ranges of blocks of lanes as (first, count).

    Attributes:
        tiles: elements, then the nodes that can move after them.
        shared: nodes that can move once the elements of all threads are done.
    """

    tiles: tuple[tuple[tuple[int, int], tuple[int, int]], ...]
    shared: tuple[tuple[int, int], ...]


def divide_step(
    element_nodes: np.ndarray, lane_count: int, thread_count: int, tile_size: int, window: int = 1
) -> list[Part]:
    """Distribute the elements to threads and divide them into tiles.

    A node can move as soon as all of its elements are done, and it is fastest while their forces are in the cache. With
    elements numbered row by row nearly all nodes can do so; with random numbering all of them have to wait.

    Args:
        element_nodes: (4, padded element count) corner nodes.
        lane_count: elements or nodes per block.
        thread_count: number of parts.
        tile_size: elements of a tile.
        window: blocks of elements that stay together, from the first block on.
    """
    block_of_element = np.arange(element_nodes.shape[1]) // lane_count
    block_count, node_block_count = block_of_element[-1] + 1, element_nodes.max() // lane_count + 1
    first = np.full(node_block_count, block_count)
    last = np.zeros(node_block_count, dtype=first.dtype)
    for nodes in element_nodes:
        np.minimum.at(first, nodes // lane_count, block_of_element)
        np.maximum.at(last, nodes // lane_count, block_of_element)
    # node blocks stay in order: each waits for those before it too
    last = np.maximum.accumulate(last)
    first = np.minimum.accumulate(first[::-1])[::-1]
    tile_block_count = max(tile_size // (lane_count * window), 1) * window
    tiles: list[list[tuple[tuple[int, int], tuple[int, int]]]] = []
    shared: list[np.ndarray] = []
    moved = 0
    windows = chunks(-(-block_count // window), thread_count)
    for start, count in ((window * a, min(window * n, block_count - window * a)) for a, n in windows):
        own = max(moved, int(np.searchsorted(first, start)))
        end = max(own, int(np.searchsorted(last, start + count)))
        own = min(own, end)
        shared.append(np.arange(moved, own))
        moved, done, part = own, start, []
        while done < start + count:
            tile = min(tile_block_count, start + count - done)
            ready = max(moved, int(np.searchsorted(last, done + tile)))
            part.append(((done, tile), (moved, ready - moved)))
            moved, done = ready, done + tile
        tiles.append(part)
    waiting = np.concatenate(shared)
    return [
        Part(tuple(part), tuple(_runs(waiting[a : a + n])))
        for part, (a, n) in zip(tiles, chunks(len(waiting), thread_count), strict=True)
    ]


def _runs(numbers: np.ndarray) -> list[tuple[int, int]]:
    """Ascending numbers as (first, count) of consecutive runs."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return [(int(run[0]), len(run)) for run in runs if len(run)]
