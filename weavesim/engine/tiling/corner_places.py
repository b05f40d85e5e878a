"""Where tiles of elements put their corner records, so that places of few tiles are enough for a whole sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .tiles import Part, Tile

# Reader of what waits for another thread, after all tiles: it is never overwritten.
AFTER_ALL = np.iinfo(np.int64).max


@dataclass(frozen=True)
class CornerPlaces:
    """Places of the corner records of a step, in blocks of elements.

    Attributes:
        of_block: place of every block of elements, (block_count,) int.
        count: of all places.
    """

    of_block: np.ndarray
    count: int

    @classmethod
    def of(cls, element_nodes: np.ndarray, lane_count: int, parts: Sequence[Part]) -> CornerPlaces:
        """Every tile takes the places of one before it whose nodes have all moved, or new ones.

        Threads share no place. What nodes of ``Part.shared`` read keeps its place until the end of the step.

        Args:
            element_nodes: (4, padded element count) corner nodes.
            lane_count: elements or nodes per block.
            parts: of the step, from ``divide_step``.
        """
        last_reader = _last_readers(element_nodes, lane_count, parts)
        of_block = np.empty(element_nodes.shape[1] // lane_count, dtype=np.int64)
        count = tile_index = 0
        for part in parts:
            size = max((len(_blocks(tile)) for tile in part.tiles), default=0)
            free: list[int] = []
            taken: dict[int, int] = {}  # first place: last tile that reads there
            for tile in part.tiles:
                for place in [place for place, last in taken.items() if last < tile_index]:
                    del taken[place]
                    free.append(place)
                if not free:
                    free.append(count)
                    count += size
                place = free.pop()
                taken[place] = last_reader[tile_index]
                blocks = _blocks(tile)
                of_block[blocks] = place + np.arange(len(blocks))
                tile_index += 1
        return cls(of_block, count)


def _blocks(tile: Tile) -> np.ndarray:
    """Blocks of elements of a tile; those of a run are consecutive."""
    return np.concatenate([np.arange(first, first + count) for first, count in tile.elements])


def _last_readers(element_nodes: np.ndarray, lane_count: int, parts: Sequence[Part]) -> np.ndarray:
    """For every tile, over all parts in sequence, the last one whose nodes read what it writes, or AFTER_ALL."""
    tiles = [tile for part in parts for tile in part.tiles]
    tile_of_block = np.empty(element_nodes.shape[1] // lane_count, dtype=np.int64)
    moved_by = np.full(element_nodes.max() // lane_count + 1, AFTER_ALL)
    for index, tile in enumerate(tiles):
        tile_of_block[_blocks(tile)] = index
        for first, count in tile.nodes:
            moved_by[first : first + count] = index
    tile_of_element, result = np.repeat(tile_of_block, lane_count), np.zeros(len(tiles), dtype=np.int64)
    for nodes in element_nodes:
        np.maximum.at(result, tile_of_element, moved_by[nodes // lane_count])
    return result
