"""What each thread does in a step: tiles of elements, and the nodes that can move after them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Number of elements whose forces stay in a core's L2 cache until their nodes have moved.
TILE_SIZE = 1024
# Runs of a tile in the mean, of elements and of nodes; each is a launch.
LARGEST_RUN_COUNT = 8
# The same where elements go in their own order; elements in no order have more, or gain nothing.
LARGEST_OWN_RUN_COUNT = 4


def chunks(count: int, part_count: int) -> list[tuple[int, int]]:
    """(first, length) of ``part_count`` nearly equal parts of range(count)."""
    edges = np.linspace(0, count, part_count + 1).astype(int)
    return [(int(a), int(b - a)) for a, b in zip(edges[:-1], edges[1:], strict=True)]


# (first, count) of consecutive blocks: one launch.
Run = tuple[int, int]


@dataclass(frozen=True)
class Tile:
    """Blocks of elements, and those of the nodes that can move after them."""

    elements: tuple[Run, ...]
    nodes: tuple[Run, ...]


@dataclass(frozen=True)
class Part:
    """What one thread does in a step.

    Attributes:
        tiles: one after the other.
        shared: blocks of nodes that can move once the elements of all threads are done.
    """

    tiles: tuple[Tile, ...]
    shared: tuple[Run, ...]

    @property
    def run_count(self) -> int:
        """Of all tiles and of the shared nodes."""
        return sum(len(tile.elements) + len(tile.nodes) for tile in self.tiles) + len(self.shared)


def divide_step(
    element_nodes: np.ndarray, lane_count: int, thread_count: int, tile_size: int, window: int = 1
) -> list[Part]:
    """Distribute the elements to threads and divide them into tiles.

    A node can move as soon as all of its elements are done, and it is fastest while their forces are in the cache.
    Elements go in the order of the nodes that they touch, so that those along a border, which a mesh may have behind
    all others, are done together with their neighbours; nearly all nodes can then move with a tile. In a mesh in no
    order such tiles would be of many runs: its elements go in their own order, and nodes move with them if these tiles
    have few runs (a mesh in rows whose border nodes come before all others); else all nodes wait.

    Args:
        element_nodes: (4, padded element count) corner nodes.
        lane_count: elements or nodes per block.
        thread_count: number of parts.
        tile_size: elements of a tile.
        window: blocks of elements that stay together, from the first block on.
    """
    by_nodes = _order(element_nodes, lane_count * window, window)
    for order, most in ((by_nodes, LARGEST_RUN_COUNT), (None, LARGEST_OWN_RUN_COUNT)):
        parts = _divided(element_nodes, lane_count, thread_count, tile_size, window, order)
        if sum(part.run_count for part in parts) <= most * sum(len(part.tiles) for part in parts):
            return parts
    return _divided(element_nodes, lane_count, thread_count, tile_size, window, None, in_sequence=True)


def _divided(
    element_nodes: np.ndarray,
    lane_count: int,
    thread_count: int,
    tile_size: int,
    window: int,
    order: np.ndarray | None,
    in_sequence: bool = False,
) -> list[Part]:
    """Parts of blocks of elements in an order, None for their own; ``in_sequence``: of nodes too."""
    block_count, node_block_count = element_nodes.shape[1] // lane_count, element_nodes.max() // lane_count + 1
    order = np.arange(block_count) if order is None else order
    turn = np.empty(block_count, dtype=np.int64)
    turn[order] = np.arange(block_count)
    turn_of_element = np.repeat(turn, lane_count)
    first = np.full(node_block_count, block_count)
    last = np.zeros(node_block_count, dtype=first.dtype)
    for nodes in element_nodes:
        np.minimum.at(first, nodes // lane_count, turn_of_element)
        np.maximum.at(last, nodes // lane_count, turn_of_element)
    if in_sequence:
        # each block of nodes waits for those before it too
        last = np.maximum.accumulate(last)
        first = np.minimum.accumulate(first[::-1])[::-1]
    tile_block_count = max(tile_size // (lane_count * window), 1) * window
    tiles: list[list[Tile]] = []
    waiting = np.ones(node_block_count, dtype=bool)
    for start, count in chunks(-(-block_count // window), thread_count):
        start, end = window * start, min(window * (start + count), block_count)
        own = (first >= start) & (last < end)
        waiting &= ~own
        tiles.append([])
        for done in range(start, end, tile_block_count):
            after = min(done + tile_block_count, end)
            ready = np.flatnonzero(own & (last >= done) & (last < after))
            tiles[-1].append(Tile(_runs(np.sort(order[done:after])), _runs(ready)))
    shared = np.flatnonzero(waiting)
    return [
        Part(tuple(part), _runs(shared[a : a + n]))
        for part, (a, n) in zip(tiles, chunks(len(shared), thread_count), strict=True)
    ]


def _order(element_nodes: np.ndarray, window_size: int, window: int) -> np.ndarray:
    """Blocks of elements, windows of them in ascending order of the first node that they touch."""
    lowest = element_nodes.min(axis=0)
    of_windows = np.minimum.reduceat(lowest, np.arange(0, len(lowest), window_size))
    block_count = len(lowest) * window // window_size
    if block_count % window:  # one that is shorter stays last, so that all others begin at multiples of their size
        of_windows[-1] = np.iinfo(of_windows.dtype).max
    blocks = window * np.argsort(of_windows, kind="stable")[:, None] + np.arange(window)
    return blocks[blocks < block_count]


def _runs(numbers: np.ndarray) -> tuple[Run, ...]:
    """Ascending numbers as (first, count) of consecutive runs."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return tuple((int(run[0]), len(run)) for run in runs if len(run))
