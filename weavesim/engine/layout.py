"""Memory layout of rows of numbers over elements or nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import warp as wp

# Arrays are padded to whole blocks of the widest lanes, whatever lane count the kernels use.
BLOCK = 16
# Bytes of a line of the cache.
LINE = 64


def padded(count: int, spare: int) -> int:
    """``count`` plus at least ``spare``, rounded up to whole blocks."""
    return -(-(count + spare) // BLOCK) * BLOCK


def put(array: wp.array, values: np.ndarray) -> None:
    """Set an array that stays where it is, to ``values`` of its shape or one that is broadcast to it.

    On a CPU they are converted in place: ``assign`` makes an array of its own first, which takes several times as long.
    """
    if array.device is not None and array.device.is_cpu:
        array.numpy()[...] = values
    else:
        array.assign(np.broadcast_to(values, array.numpy().shape))


def lanes_view(array: wp.array, lane_count: int) -> wp.array:
    """View an array of numbers with padded last axis as an array of lane vectors, on the same memory."""
    lanes = wp.types.vector(lane_count, array.dtype)
    shape = (*array.shape[:-1], array.shape[-1] // lane_count)
    view: Any = wp.array(ptr=array.ptr, dtype=lanes, shape=shape, device=array.device, capacity=array.capacity)
    view._owner = array
    return view


def rows_together(arrays: Mapping[str, wp.array], lane_count: int) -> dict[str, wp.array]:
    """Copies of arrays, shaped as ``lanes_view`` of each, with the rows of a block side by side in one allocation.

    A block then reads one piece of memory instead of one in each row, which are on different pages: more of them than
    a processor fetches ahead. ``RowLayout`` does so for numbers of one type; these may be of several.

    Args:
        arrays: by name, [row, item] or [item], all with the same number of items, a multiple of ``lane_count``.
        lane_count: items of a block.
    """
    device = next(iter(arrays.values())).device
    values = {name: array.numpy().reshape(-1, array.shape[-1]) for name, array in arrays.items()}
    blocks = {
        name: np.ascontiguousarray(rows.reshape(len(rows), -1, lane_count).swapaxes(0, 1)).view(np.uint8)
        for name, rows in values.items()
    }
    together = np.concatenate([rows.reshape(len(rows), -1) for rows in blocks.values()], axis=1)
    memory = wp.empty(together.size + LINE, dtype=wp.uint8, device=device)
    place, result = -memory.ptr % LINE, {}
    memory[place : place + together.size].assign(together.ravel())
    for name, array in arrays.items():
        row = lane_count * np.dtype(values[name].dtype).itemsize
        strides = (row, together.shape[1])[2 - array.ndim :]
        view: Any = wp.array(
            ptr=memory.ptr + place,
            dtype=wp.types.vector(lane_count, array.dtype),
            shape=(*array.shape[:-1], len(together)),
            strides=strides,
            device=device,
            capacity=array.capacity,
        )
        view._owner = memory
        result[name] = view
        place += row * len(values[name])
    return result


@dataclass(frozen=True)
class RowLayout:
    """Rows of numbers in one flat array: with lanes, the rows of one block are consecutive.

    With whole rows, every value that a block reads or writes would be on a different memory page. Single lanes (a GPU)
    keep whole rows, which neighbouring threads read and write together.
    """

    row_count: int
    length: int  # elements or nodes, padded to whole blocks
    lane_count: int
    record_length: int = 0  # with lanes: rows that lie side by side for each item, before the others; see records.py

    @overload
    def entry(self, row: int, item: int) -> int: ...

    @overload
    def entry(self, row: np.ndarray | int, item: np.ndarray) -> np.ndarray: ...

    def entry(self, row: np.ndarray | int, item: np.ndarray | int) -> np.ndarray | int:
        """Index in the flat array of one row of one element or node."""
        if self.lane_count == 1:
            return row * self.length + item
        block, lane = item // self.lane_count, item % self.lane_count
        in_row, in_record = row * self.lane_count + lane, lane * self.record_length + row
        return block * self.row_count * self.lane_count + np.where(row < self.record_length, in_record, in_row)

    @property
    def stride(self) -> int:
        """Entries between the first two rows."""
        return int(self.entry(1, 0))

    @property
    def _strides(self) -> tuple[int, int]:
        """Entries between two rows of lanes, and between two blocks."""
        if self.lane_count == 1:
            return self.length, 1
        return self.lane_count, self.row_count * self.lane_count

    def view(self, entries: wp.array, shift: int = 0) -> wp.array:
        """The flat array as [row, block] of lanes, on the same memory; with lanes, records are no rows of it.

        Args:
            entries: flat.
            shift: blocks by which all lie further on; those that are not in the memory then must not be used.
        """
        size = np.dtype(wp.dtype_to_numpy(entries.dtype)).itemsize
        view: Any = wp.array(
            ptr=entries.ptr + size * shift * self._strides[1],
            dtype=wp.types.vector(self.lane_count, entries.dtype),
            shape=(self.row_count, self.length // self.lane_count),
            strides=tuple(size * stride for stride in self._strides),
            device=entries.device,
            capacity=entries.capacity,
        )
        view._owner = entries
        return view

    def _all(self) -> np.ndarray:
        return self.entry(np.arange(self.row_count)[:, None], np.arange(self.length))

    def read(self, entries: wp.array) -> np.ndarray:
        """The rows, (row_count, length); waits for the device."""
        # the same as with ``_all``, in a sixth of the time
        values = entries.numpy()
        if self.lane_count == 1:
            return values.reshape(self.row_count, self.length).copy()
        blocks = values.reshape(-1, self.row_count, self.lane_count)
        result = np.empty((self.row_count, *blocks[:, 0].shape), dtype=values.dtype)
        records, count = blocks[:, : self.record_length], self.record_length
        if count:
            result[:count] = records.reshape(-1, self.lane_count, count).transpose(2, 0, 1)
        result[count:] = blocks[:, count:].transpose(1, 0, 2)
        return result.reshape(self.row_count, self.length)

    def flat(self, rows: np.ndarray) -> np.ndarray:
        """The flat array of ``rows``, (row_count, length)."""
        result = np.empty(self.row_count * self.length, dtype=rows.dtype)
        result[self._all()] = rows
        return result


@dataclass(frozen=True)
class Span:
    """Consecutive entries of an array over all tools, or all drives, of a run."""

    start: int
    stop: int

    @property
    def count(self) -> int:
        """How many entries."""
        return self.stop - self.start

    def of(self, array: wp.array) -> wp.array:
        """These entries, on the same memory."""
        return array[self.start : self.stop] if self.count else wp.empty(0, dtype=array.dtype, device=array.device)


def slots_of_nodes(node: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places in a table [slot, node] of what lies around each node.

    Args:
        node: of every entry, (n,) int.

    Returns:
        Entries in ascending order of their nodes, (n,); the slot of each of these, (n,), from 0 for every node.
    """
    order = np.argsort(node, kind="stable")
    return order, np.arange(len(node)) - np.searchsorted(node[order], node[order])
