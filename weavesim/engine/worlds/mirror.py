"""Memory of many runs that are alike, copied to another device, where structs of their arrays find it."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np
import warp as wp

# Copies of one array of all worlds begin at multiples of this [bytes].
ALIGNMENT = 64


class Unalike(Exception):
    """Runs whose memory is laid out differently."""


class Memory:
    """Where the arrays of one run are, without gaps and overlaps: (address, size) in the order in which they came."""

    def __init__(self, arrays: Iterable[wp.array]) -> None:
        self.spans: list[tuple[int, int]] = []
        for array in arrays:
            self._add(array)
        starts = np.array([start for start, _ in self.spans], dtype=np.uint64)
        self._order = np.argsort(starts)
        self._starts = starts[self._order]
        self._sizes = np.array([size for _, size in self.spans], dtype=np.uint64)[self._order]

    def _add(self, array: wp.array) -> None:
        if not array.size:
            return
        start, size = array.ptr, extent(array)
        for begin, length in self.spans:
            if begin <= start and start + size <= begin + length:
                return
        self.spans.append((start, size))

    def find(self, addresses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Number of the span of each address, and its offset there; the number of an unknown address is -1."""
        place = np.searchsorted(self._starts, addresses, side="right").astype(int) - 1
        known = place >= 0
        offset = addresses - self._starts[np.maximum(place, 0)]
        known &= offset < self._sizes[np.maximum(place, 0)]
        return np.where(known, self._order[np.maximum(place, 0)], -1), offset


def extent(array: wp.array) -> int:
    """Bytes from the first to the last entry of an array that is not empty."""
    steps = ((count - 1) * stride for count, stride in zip(array.shape, array.strides, strict=True))
    return sum(steps) + wp.types.type_size_in_bytes(array.dtype)


class Mirror:
    """Copies of the memory of several runs.

    An array that is the same in all of them, and that no step writes, is copied once.

    Args:
        device: where the copies are.
        written: arrays that steps write, of each run.
        constant: others that they read, of each run.

    Raises:
        Unalike: the runs have different arrays.
    """

    def __init__(
        self, device: wp.Device, written: Sequence[Sequence[wp.array]], constant: Sequence[Sequence[wp.array]]
    ) -> None:
        self.device = device
        self._memories = [Memory([*own, *other]) for own, other in zip(written, constant, strict=True)]
        sizes = [[size for _, size in memory.spans] for memory in self._memories]
        if any(own != sizes[0] for own in sizes):
            raise Unalike("their arrays differ in number or size")
        self._sizes = sizes[0]
        self._written = len(Memory(written[0]).spans)
        self._rows = [-(-size // ALIGNMENT) * ALIGNMENT for size in self._sizes]
        self._pools = [self._uploaded(k) for k in range(len(self._sizes))]
        self._shared = np.array([pool.shape[0] == 1 for pool in self._pools])
        self._bases = np.array([pool.ptr for pool in self._pools], dtype=np.uint64)

    @property
    def world_count(self) -> int:
        """How many worlds it steps."""
        return len(self._memories)

    def _uploaded(self, k: int) -> wp.array:
        """Copies of span ``k``, (worlds, bytes); one row if all are the same and none is written."""
        values = np.zeros((self.world_count, self._rows[k]), dtype=np.uint8)
        for row, memory in zip(values, self._memories, strict=True):
            ctypes.memmove(row.ctypes.data, memory.spans[k][0], self._sizes[k])
        if k >= self._written and np.array_equal(values, np.broadcast_to(values[0], values.shape)):
            values = values[:1]
        return wp.array(values, dtype=wp.uint8, device=self.device)

    def download(self, worlds: Iterable[int], arrays: Sequence[wp.array]) -> None:
        """Copy back to the runs ``worlds`` what steps write: their arrays that are as ``arrays`` of the first run."""
        chosen = list(worlds)
        places, _ = self._memories[0].find(np.array([each.ptr for each in arrays if each.size], dtype=np.uint64))
        for k in dict.fromkeys(places.tolist()):
            values = self._pools[k].numpy()
            for world in chosen:
                ctypes.memmove(self._memories[world].spans[k][0], values[world].ctypes.data, self._sizes[k])

    def rows(self, arrays: Sequence[wp.array], dtype: Any, shape: tuple[int, ...]) -> wp.array:
        """Copies of one array of each run, which steps write, as one array (worlds, *shape)."""
        places, offsets = self._memories[0].find(np.array([arrays[0].ptr], dtype=np.uint64))
        pool, size = self._pools[int(places[0])], wp.types.type_size_in_bytes(dtype)
        strides = [size]
        for count in reversed(shape[1:]):
            strides.insert(0, strides[0] * count)
        rows: Any = wp.array(
            ptr=pool.ptr + int(offsets[0]),
            dtype=dtype,
            shape=(self.world_count, *shape),
            strides=(pool.shape[1], *strides),
            device=self.device,
            capacity=pool.capacity,
        )
        rows._owner = pool
        return rows

    def structs(self, given: Sequence[Any]) -> wp.array:
        """One struct of each run, with its arrays those of the copies, as an array (worlds,).

        Raises:
            Unalike: a struct has an array that is not among those of its run.
        """
        kind = given[0]._cls
        size = ctypes.sizeof(kind.ctype)
        images = np.empty((len(given), size), dtype=np.uint8)
        for image, struct in zip(images, given, strict=True):
            ctypes.memmove(image.ctypes.data, ctypes.addressof(struct.__ctype__()), size)
        offsets = np.array(list(array_offsets(kind.ctype)), dtype=int)
        for world, memory in enumerate(self._memories):
            self._translate(images[world], offsets, world, memory)
        result = wp.empty(len(given), dtype=kind, device=self.device)
        target: Any = wp.array(ptr=result.ptr, dtype=wp.uint8, shape=images.size, device=self.device)
        wp.copy(target, wp.array(images.ravel(), dtype=wp.uint8, device="cpu"))
        return result

    def _translate(self, image: np.ndarray, offsets: np.ndarray, world: int, memory: Memory) -> None:
        """Replace the addresses of all arrays in the bytes of one struct."""
        heads = [array_form().from_buffer(image, int(offset)) for offset in offsets]
        empty = np.array([not head.data or 0 in head.shape[: head.ndim] for head in heads])
        addresses = np.array([head.data or 0 for head in heads], dtype=np.uint64)
        place, within = memory.find(addresses)
        if np.any((place < 0) & ~empty):
            raise Unalike("an array of theirs is not known")
        found = (
            self._bases[place]
            + within
            + np.where(self._shared[place], 0, world).astype(np.uint64) * np.array(self._rows, dtype=np.uint64)[place]
        )
        for head, address, nothing in zip(heads, found.tolist(), empty.tolist(), strict=True):
            head.data = 0 if nothing else address


@cache
def array_form() -> Any:
    """What an array is within a struct: address, shape and strides."""
    return type(wp.zeros(1, dtype=wp.uint8, device="cpu").__ctype__())


def array_offsets(kind: type[ctypes.Structure], first: int = 0) -> Iterator[int]:
    """Offsets of all arrays in a struct and in those within it [bytes]."""
    for name, of_field, *_ in kind._fields_:
        offset = first + getattr(kind, name).offset
        if of_field is array_form():
            yield offset
        elif isinstance(of_field, type) and issubclass(of_field, ctypes.Structure):
            yield from array_offsets(of_field, offset)
