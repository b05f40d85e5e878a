"""Componentwise ``a * b`` and ``a / b`` of two lane vectors.

Warp looks up the operators of a formula by the names ``mul`` and ``div`` in the globals of its module. So a module with
such formulas imports both, and since no line uses the names, the linter warning is silenced:

    from ..operators import div, mul  # noqa: F401
"""

import warp as wp

from .lanes import ALL_LANE_TYPES

for _types in ALL_LANE_TYPES:

    @wp.func
    def mul(a: _types.lanes, b: _types.lanes):
        return wp.cw_mul(a, b)

    @wp.func
    def div(a: _types.lanes, b: _types.lanes):
        return wp.cw_div(a, b)
