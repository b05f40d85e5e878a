"""The lane vocabulary: every formula operates on W elements (or nodes) at once.

A kernel thread holds W scalars in a Warp vector ("lanes") and W 3-vectors in a 3 x W matrix ("lanes3").
Clang turns the componentwise operations into SIMD instructions; on a GPU, and in most tests, W = 1 and the same
source is plain scalar code. The functions below are generic in W and precision; most have a second form for sixteen
lanes, in C++.

Numbers: a bare literal is a single-precision constant and does not combine with lanes. A formula uses ``x.dtype(2.0)``
for a factor and ``fill(x, 1.0)`` for lanes, where x is any lanes in it; ``fill(x, laws.thickness)`` broadcasts a scalar
of the same precision. ``fill`` rounds a literal to single precision, ``x.dtype`` does not: for a number that is not
exact in single precision write ``fill(x, x.dtype(4.4))``. Only a kernel, which knows its precision, may use
``real(2.0)`` and, for lanes of zeros, ``lanes()``. Componentwise products of lanes: see operators.py.
"""

import re
from typing import Any

import warp as wp

from .lane_types import ALL_LANE_TYPES, LaneTypes

# --- lanes as vectors of C++ ------------------------------------------------------------------------------------------


def _in_rows(types: LaneTypes, *rows: str) -> str:
    """C++ of a value with a row for each expression; ``a0`` is the first row of an argument a, ``b2`` the third of b.

    A row is one vector of C++. Warp's own loops over lanes are taken apart into thousands of single numbers, and the
    compiler looks for each of them through all code behind a branch: that took most of the time to compile.
    """
    count, scalar = types.lane_count, f"wp::{types.real.__name__}"
    kind = f"wp::vec_t<{count}, {scalar}>" if len(rows) == 1 else f"wp::mat_t<{len(rows)}, {count}, {scalar}>"
    place = f"<{{}} *>(&{{}}) + {{}} * sizeof({scalar}) * {count} + at"
    read = "".join(
        f"Row {name}; memcpy(&{name}, reinterpret_cast{place.format('const char', *name)}, sizeof(Row));\n            "
        for name in sorted({name for row in rows for name in re.findall(r"\b[a-f]\d\b", row)})
    )
    write = "".join(
        f"row = {row}; memcpy(reinterpret_cast{place.format('char', 'result', k)}, &row, sizeof(Row));\n            "
        for k, row in enumerate(rows)
    )
    return f"""
#if defined(__CUDACC__)
        using Row = {scalar};
        auto root = [](Row a) {{ return wp::sqrt(a); }};
        auto fused = [](Row a, Row b, Row c) {{ return wp::muladd(a, b, c); }};
#else
        using Row = {scalar} __attribute__((ext_vector_type({count})));
        auto root = [](Row a) {{ return __builtin_elementwise_sqrt(a); }};
        auto fused = [](Row a, Row b, Row c) {{ return __builtin_elementwise_fma(a, b, c); }};
#endif
        {kind} result;
        Row row, none = 0;
        for (unsigned at = 0; at < sizeof({scalar}) * {count}; at += sizeof(Row)) {{
            {read}{write}
        }}
        return result;
    """


def _halved(types: LaneTypes, expression: str) -> str:
    """C++ that makes one number of sixteen lanes by halves, ``low`` and ``high``: in sequence each would wait."""
    count, scalar = types.lane_count, f"wp::{types.real.__name__}"
    return f"""
        auto halved = [](auto low, auto high) {{ return {expression}; }};
#if defined(__CUDACC__)
        for (int half = {count} / 2; half > 0; half /= 2)
            for (int i = 0; i < half; ++i)
                a[i] = halved(a[i], a[i + half]);
        return a[0];
#else
        {scalar} __attribute__((ext_vector_type({count}))) all;
        memcpy(&all, &a, sizeof(all));
        auto eight = halved(all.lo, all.hi);
        auto four = halved(eight.lo, eight.hi);
        auto two = halved(four.lo, four.hi);
        return halved(two.lo, two.hi);
#endif
    """


def _alike(types: LaneTypes, row_count: int, expression: str) -> str:
    """The same ``expression`` for each row, ``#`` for its number."""
    return _in_rows(types, *(expression.replace("#", str(k)) for k in range(row_count)))


# A module finds the operators by their names: see operators.py. What is missing here is Warp's own.
for _types in ALL_LANE_TYPES:

    @wp.func_native(_in_rows(_types, "value"))
    def in_every_lane(like: _types.lanes, value: _types.real) -> _types.lanes: ...

    @wp.func_native(_in_rows(_types, "value[0]", "value[1]", "value[2]"))
    def in_every_lane(like: _types.lanes3, value: _types.vec3) -> _types.lanes3: ...

    for _kind, _row_count in ((_types.lanes, 1), (_types.lanes3, 3), (_types.lanes4, 4)):
        if _types.lane_count == 1:

            @wp.func
            def mul(a: _kind, b: _kind):
                return wp.cw_mul(a, b)

            @wp.func
            def div(a: _kind, b: _kind):
                return wp.cw_div(a, b)

            continue

        @wp.func_native(_alike(_types, _row_count, "a# + b#"))
        def add(a: _kind, b: _kind) -> _kind: ...

        @wp.func_native(_alike(_types, _row_count, "a# - b#"))
        def sub(a: _kind, b: _kind) -> _kind: ...

        @wp.func_native(_alike(_types, _row_count, "a# * b#"))
        def mul(a: _kind, b: _kind) -> _kind: ...

        @wp.func_native(_alike(_types, _row_count, "a * b#"))
        def mul(a: _types.real, b: _kind) -> _kind: ...

        @wp.func_native(_alike(_types, _row_count, "a# / b#"))
        def div(a: _kind, b: _kind) -> _kind: ...

        @wp.func_native(_alike(_types, _row_count, "a# / b"))
        def div(a: _kind, b: _types.real) -> _kind: ...

    if _types.lane_count == 1:

        @wp.func
        def lane_sum(a: _types.lanes):
            return a[0]

        @wp.func
        def lane_maximum(a: _types.lanes):
            return a[0]

        continue

    @wp.func_native(_in_rows(_types, "root(a0)"))
    def square_root(a: _types.lanes) -> _types.lanes: ...

    for _kind, _row_count in ((_types.lanes, 1), (_types.lanes3, 3)):

        @wp.func_native(_alike(_types, _row_count, "-a#"))
        def negative(a: _kind) -> _kind: ...

    @wp.func_native(_in_rows(_types, "a0 > 0 ? b0 : c0"))
    def where_positive(a: _types.lanes, b: _types.lanes, c: _types.lanes) -> _types.lanes: ...

    @wp.func_native(_in_rows(_types, "a0 < 0 ? -a0 : a0"))
    def magnitude(a: _types.lanes) -> _types.lanes: ...

    @wp.func_native(_in_rows(_types, "a0 > b0 ? a0 : b0"))
    def larger(a: _types.lanes, b: _types.lanes) -> _types.lanes: ...

    @wp.func_native(_in_rows(_types, "a0 < b0 ? a0 : b0"))
    def smaller(a: _types.lanes, b: _types.lanes) -> _types.lanes: ...

    @wp.func_native(_halved(_types, "low + high"))
    def lane_sum(a: _types.lanes) -> _types.real: ...

    @wp.func_native(_halved(_types, "high > low ? high : low"))
    def lane_maximum(a: _types.lanes) -> _types.real: ...

    @wp.func_native(_in_rows(_types, "a0 * b0", "a0 * b1", "a0 * b2"))
    def scale(a: _types.lanes, b: _types.lanes3) -> _types.lanes3: ...

    # fused, as Warp's own products of matrices
    @wp.func_native(
        _alike(_types, 3, "fused(m.data[#][2], a2, fused(m.data[#][1], a1, fused(m.data[#][0], a0, none)))")
    )
    def mul(m: wp.types.matrix((3, 3), _types.real), a: _types.lanes3) -> _types.lanes3: ...

    @wp.func_native(_in_rows(_types, "a0 * b0 + a1 * b1 + a2 * b2"))
    def dot(a: _types.lanes3, b: _types.lanes3) -> _types.lanes: ...

    @wp.func_native(_in_rows(_types, "a1 * b2 - a2 * b1", "a2 * b0 - a0 * b2", "a0 * b1 - a1 * b0"))
    def cross(a: _types.lanes3, b: _types.lanes3) -> _types.lanes3: ...

    _lanes = _types.lanes
    _lanes2, _lanes6 = (wp.types.matrix((count, _types.lane_count), _types.real) for count in (2, 6))

    @wp.func_native(_in_rows(_types, "a0", "b0"))
    def from_rows(a: _lanes, b: _lanes) -> _lanes2: ...

    @wp.func_native(_in_rows(_types, "a0", "b0", "c0"))
    def from_rows(a: _lanes, b: _lanes, c: _lanes) -> _types.lanes3: ...

    @wp.func_native(_in_rows(_types, "a0", "b0", "c0", "d0"))
    def from_rows(a: _lanes, b: _lanes, c: _lanes, d: _lanes) -> _types.lanes4: ...

    @wp.func_native(_in_rows(_types, "a0", "b0", "c0", "d0", "e0", "f0"))
    def from_rows(a: _lanes, b: _lanes, c: _lanes, d: _lanes, e: _lanes, f: _lanes) -> _lanes6: ...


# --- scalars in lanes -------------------------------------------------------------------------------------------------

# Lane by lane: ``square_root``, ``power`` by one exponent, ``magnitude`` |a|, and of two the ``larger`` and the
# ``smaller``, which are ``b`` where a lane of ``a`` or ``b`` is not a number. What they do is said here and not in
# them: their text is a part of the hash of every kernel.


@wp.func
def fill(like: Any, value: Any):
    """``value`` in every lane: a number, or a scalar of the lanes' own precision."""
    return in_every_lane(like, like.dtype(value))


@wp.func
def square_root(a: Any):
    result = type(a)()
    for i in range(len(a)):
        result[i] = wp.sqrt(a[i])
    return result


@wp.func
def power(a: Any, exponent: Any):
    result = type(a)()
    for i in range(len(a)):
        result[i] = wp.pow(a[i], exponent)
    return result


@wp.func
def negative(a: Any):
    """-a; the sign before a variable is Warp's own, lane by lane."""
    return -a


@wp.func
def magnitude(a: Any):
    result = type(a)()
    for i in range(len(a)):
        result[i] = wp.where(a[i] < a.dtype(0.0), -a[i], a[i])
    return result


@wp.func
def larger(a: Any, b: Any):
    result = type(a)()
    for i in range(len(a)):
        result[i] = wp.where(a[i] > b[i], a[i], b[i])
    return result


@wp.func
def smaller(a: Any, b: Any):
    result = type(a)()
    for i in range(len(a)):
        result[i] = wp.where(a[i] < b[i], a[i], b[i])
    return result


@wp.func
def where_positive(condition: Any, if_positive: Any, otherwise: Any):
    """``if_positive`` in the lanes where ``condition`` > 0, else ``otherwise`` (also for NaN)."""
    result = type(otherwise)()
    for i in range(len(condition)):
        result[i] = wp.where(condition[i] > condition.dtype(0.0), if_positive[i], otherwise[i])
    return result


@wp.func
def inverses(a: Any, b: Any):
    """1/a and 1/b with one division; a b must be finite and not zero."""
    inverse = div(fill(a, 1.0), mul(a, b))
    return mul(b, inverse), mul(a, inverse)


# --- 3-vectors in lanes -----------------------------------------------------------------------------------------------

# A row of lanes for each component. ``from_rows`` puts such rows together; ``dot`` is a.b and ``cross`` is a x b, lane
# by lane.


@wp.func
def from_rows(a: Any, b: Any):
    return wp.matrix_from_rows(a, b)


@wp.func
def from_rows(a: Any, b: Any, c: Any):
    return wp.matrix_from_rows(a, b, c)


@wp.func
def from_rows(a: Any, b: Any, c: Any, d: Any):
    return wp.matrix_from_rows(a, b, c, d)


@wp.func
def from_rows(a: Any, b: Any, c: Any, d: Any, e: Any, f: Any):
    return wp.matrix_from_rows(a, b, c, d, e, f)


@wp.func
def scale(s: Any, v: Any):
    """Each lane's scalar times its 3-vector."""
    return wp.matrix_from_rows(mul(s, v[0]), mul(s, v[1]), mul(s, v[2]))


@wp.func
def dot(a: Any, b: Any):
    return mul(a[0], b[0]) + mul(a[1], b[1]) + mul(a[2], b[2])


@wp.func
def cross(a: Any, b: Any):
    return wp.matrix_from_rows(
        mul(a[1], b[2]) - mul(a[2], b[1]),
        mul(a[2], b[0]) - mul(a[0], b[2]),
        mul(a[0], b[1]) - mul(a[1], b[0]),
    )


# Warp addresses entries by strides in bytes, with indices of twice the length, of which half as many fit into a
# register: in C++ a gather needs half the instructions. One overload per precision and lane count.
for _types in ALL_LANE_TYPES:

    @wp.func_native(f"""
        const auto *from = source.data + first;
        wp::vec_t<{_types.lane_count}, wp::{_types.real.__name__}> result;
        for (int i = 0; i < {_types.lane_count}; ++i)
            result[i] = from[index[i]];
        return result;
    """)
    def pick(source: wp.array(dtype=_types.real), index: _types.indices, first: wp.int32) -> _types.lanes:
        """The scalars ``source[index + first]``, one per lane; ``source`` is contiguous."""


@wp.func
def rows3(source: Any, row: int, block: int):
    """Three consecutive rows of lanes as 3-vectors."""
    return from_rows(source[row, block], source[row + 1, block], source[row + 2, block])


@wp.func
def store_rows3(target: Any, row: int, block: int, value: Any):
    """Write 3-vectors to three consecutive rows of lanes."""
    for c in range(3):
        target[row + c, block] = value[c]


@wp.func
def load(source: Any, first: int, like: Any):
    """3-vectors ``source[first], source[first + 1], ...``, one per lane; ``like`` is any lanes3."""
    result = type(like)()
    for i in range(len(like[0])):
        value = source[first + i]
        result[0, i] = value[0]
        result[1, i] = value[1]
        result[2, i] = value[2]
    return result


@wp.func
def store(target: Any, first: int, value: Any):
    """Write one 3-vector per lane to ``target[first], target[first + 1], ...``."""
    for i in range(len(value[0])):
        column = target[first + i]
        column[0] = value[0, i]
        column[1] = value[1, i]
        column[2] = value[2, i]
        target[first + i] = column
