"""Records: the numbers of one node, or of one element, side by side in memory, read and written as lanes.

A vector of a record and the scalar behind it are a piece of four. A processor reads the pieces of sixteen records in
sixteen loads, wherever they are, and transposes them in registers: sooner than one load for each number, and the same
bits. Single lanes (a GPU) have whole rows instead, which neighbouring threads read together; the functions below have
both forms. ``RowLayout`` in weavesim/engine/layout.py lays out either.
"""

from typing import Any

import warp as wp

from .lane_types import ALL_LANE_TYPES, LaneTypes
from .lanes import from_rows, pick, store_rows3

# Row of a piece behind its vector.
SCALAR = wp.constant(3)

_FAST = "#if defined(__x86_64__) && !defined(__CUDACC__)"


def _shuffled(a: str, b: str, order: list[int]) -> str:
    return f"__builtin_shufflevector({a}, {b}, {', '.join(map(str, order))})"


def _transposition() -> str:
    """C++ from sixteen pieces a, b, c, d to their rows x, y, z, w, or back: four squares of 4 x 4.

    Part k of ``a`` is the piece of lane 4 k, of ``b`` that of lane 4 k + 1, and so on. The fences do nothing but keep
    the compiler from taking the shuffles apart into single numbers; they need "reassociate", but there is no sum here.
    """
    low = [i + j for i in range(0, 16, 4) for j in (0, 16, 1, 17)]
    high = [i + 2 for i in low]
    first = [i + j for i in range(0, 16, 4) for j in (0, 1, 16, 17)]
    second = [i + 2 for i in first]
    return f"""
        Lanes ab_low = {_shuffled("a", "b", low)}, ab_high = {_shuffled("a", "b", high)};
        Lanes cd_low = {_shuffled("c", "d", low)}, cd_high = {_shuffled("c", "d", high)};
        Lanes x = {_shuffled("ab_low", "cd_low", first)}, y = {_shuffled("ab_low", "cd_low", second)};
        Lanes z = {_shuffled("ab_high", "cd_high", first)}, w = {_shuffled("ab_high", "cd_high", second)};
    """


def _vectors(types: LaneTypes) -> str:
    scalar = "float" if types.real is wp.float32 else "double"
    return f"""{{
        _Pragma("clang fp reassociate(on)")
        using Piece = {scalar} __attribute__((ext_vector_type(4)));
        using Lanes = {scalar} __attribute__((ext_vector_type(16)));
    """


def _read(types: LaneTypes, place: str) -> str:
    """C++ of a function that reads pieces from ``place``, an expression of the lane i, as four rows of lanes."""
    eight, sixteen = list(range(8)), list(range(16))
    beside = _shuffled(
        _shuffled("piece(i)", "piece(i + 4)", eight), _shuffled("piece(i + 8)", "piece(i + 12)", eight), sixteen
    )
    return f"""
        wp::mat_t<4, {types.lane_count}, wp::{types.real.__name__}> result;
{_FAST}
        {_vectors(types)}
        auto piece = [&](int i) {{ Piece p; __builtin_memcpy(&p, {place}, sizeof(p)); return p; }};
        auto beside = [&](int i) -> Lanes {{ return {beside}; }};
        Lanes a = beside(0), b = beside(1), c = beside(2), d = beside(3);
        {_transposition()}
        x = __arithmetic_fence(x), y = __arithmetic_fence(y), z = __arithmetic_fence(z), w = __arithmetic_fence(w);
        __builtin_memcpy(result.data[0], &x, sizeof(x));
        __builtin_memcpy(result.data[1], &y, sizeof(y));
        __builtin_memcpy(result.data[2], &z, sizeof(z));
        __builtin_memcpy(result.data[3], &w, sizeof(w));
        }}
#else
        for (int i = 0; i < {types.lane_count}; ++i)
            for (int row = 0; row < 4; ++row)
                result.data[row][i] = ({place})[row];
#endif
        return result;
    """


def _write(types: LaneTypes, place: str) -> str:
    """C++ of a function that writes ``vector`` and ``scalar`` as pieces to ``place``, an expression of the lane i."""
    stores = "".join(
        f"store({4 * k + j}, {_shuffled(name, name, list(range(4 * k, 4 * k + 4)))});\n        "
        for j, name in enumerate("xyzw")
        for k in range(4)
    )
    return f"""
{_FAST}
        {_vectors(types)}
        auto store = [&](int i, Piece p) {{ __builtin_memcpy({place}, &p, sizeof(p)); }};
        Lanes a, b, c, d;
        __builtin_memcpy(&a, vector.data[0], sizeof(a));
        __builtin_memcpy(&b, vector.data[1], sizeof(b));
        __builtin_memcpy(&c, vector.data[2], sizeof(c));
        __builtin_memcpy(&d, &scalar, sizeof(d));
        a = __arithmetic_fence(a), b = __arithmetic_fence(b), c = __arithmetic_fence(c), d = __arithmetic_fence(d);
        {_transposition()}
        x = __arithmetic_fence(x), y = __arithmetic_fence(y), z = __arithmetic_fence(z), w = __arithmetic_fence(w);
        {stores}
        }}
#else
        for (int i = 0; i < {types.lane_count}; ++i) {{
            for (int row = 0; row < 3; ++row)
                ({place})[row] = vector.data[row][i];
            ({place})[3] = scalar[i];
        }}
#endif
    """


def _own(types: LaneTypes, array: str) -> str:
    """Place of the piece from ``row`` on of record i of the block."""
    scalar = types.real.__name__
    return (
        f"reinterpret_cast<wp::{scalar} *>(reinterpret_cast<char *>({array}.data) + {array}.strides[1] * block)"
        " + length * i + row"
    )


for _types in ALL_LANE_TYPES:
    _entries, _rows = wp.array(dtype=_types.real), wp.array2d(dtype=_types.lanes)
    if _types.lane_count == 1:

        @wp.func
        def gather4(source: _entries, index: _types.indices, first: wp.int32, stride: wp.int32):
            """The scalars ``source[index + first + (0, 1, 2, 3) stride]``, one per lane, in four rows."""
            return from_rows(
                pick(source, index, first),
                pick(source, index, first + stride),
                pick(source, index, first + 2 * stride),
                pick(source, index, first + 3 * stride),
            )

        @wp.func
        def scatter4(
            target: _entries, index: _types.indices, first: wp.int32, stride: wp.int32,
            vector: _types.lanes3, scalar: _types.lanes,
        ):  # fmt: skip
            """Write where ``gather4`` reads."""
            entry = index[0] + first
            target[entry] = vector[0][0]
            target[entry + stride] = vector[1][0]
            target[entry + 2 * stride] = vector[2][0]
            target[entry + 3 * stride] = scalar[0]

        @wp.func
        def record4(source: _rows, length: wp.int32, row: wp.int32, block: wp.int32):
            """The four rows from ``row`` on of a block of records of ``length`` numbers."""
            return from_rows(source[row, block], source[row + 1, block], source[row + 2, block], source[row + 3, block])

        @wp.func
        def store_record4(
            target: _rows, length: wp.int32, row: wp.int32, block: wp.int32, vector: _types.lanes3, scalar: _types.lanes
        ):
            """Write a vector and the scalar behind it to the rows from ``row`` on of a block of records."""
            store_rows3(target, row, block, vector)
            target[row + 3, block] = scalar

        @wp.func
        def store_record3(target: _rows, length: wp.int32, row: wp.int32, block: wp.int32, vector: _types.lanes3):
            """Write a vector; the scalar behind it may be lost."""
            store_rows3(target, row, block, vector)
    else:

        @wp.func_native(_read(_types, "source.data + first + index[i]"))
        def gather4(source: _entries, index: _types.indices, first: wp.int32, stride: wp.int32) -> _types.lanes4:
            """The same of records: ``stride`` is one."""

        @wp.func_native(_write(_types, "target.data + first + index[i]"))
        def scatter4(
            target: _entries, index: _types.indices, first: wp.int32, stride: wp.int32,
            vector: _types.lanes3, scalar: _types.lanes,
        ): ...  # fmt: skip

        @wp.func_native(_read(_types, _own(_types, "source")))
        def record4(source: _rows, length: wp.int32, row: wp.int32, block: wp.int32) -> _types.lanes4: ...

        @wp.func_native(_write(_types, _own(_types, "target")))
        def store_record4(
            target: _rows, length: wp.int32, row: wp.int32, block: wp.int32, vector: _types.lanes3, scalar: _types.lanes
        ): ...

        @wp.func
        def store_record3(target: _rows, length: wp.int32, row: wp.int32, block: wp.int32, vector: _types.lanes3):
            store_record4(target, length, row, block, vector, type(vector[0])())


@wp.func
def vector_of(piece: Any):
    """The vector of a piece."""
    return from_rows(piece[0], piece[1], piece[2])


@wp.func
def record3(source: Any, length: int, row: int, block: int):
    """A vector, from ``row`` on, of a block of records of ``length`` numbers."""
    return vector_of(record4(source, length, row, block))
