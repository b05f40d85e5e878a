"""Operators between lanes: componentwise ``a * b`` and ``a / b``, and sums, all of which compile quickly.

Warp looks up the operators of a formula by the names ``add``, ``sub``, ``mul`` and ``div`` in the globals of a module.
So a module with such formulas imports all four, and since no line uses the names, the linter warning is silenced:

    from ..operators import add, div, mul, sub  # noqa: F401

Without ``add`` and ``sub`` sums are Warp's own: the same numbers, but the kernel takes several times as long to
compile (decision 70).
"""

from .lanes import add, div, mul, sub

__all__ = ["add", "div", "mul", "sub"]
