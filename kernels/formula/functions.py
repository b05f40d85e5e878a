"""Functions of formulas in C++: on a CPU those without a vector instruction as polynomials, which are vectorised."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..angles import arctangent_coefficients

RIGHT_ANGLE = 1.5707963267948966
# Tangent of 22.5 degrees.
REDUCED_TANGENT = 0.41421356237309503


def _horner(coefficients: list[float], variable: str, real: str) -> str:
    """Even and odd powers in two independent chains."""
    chains = []
    for part in (coefficients[0::2], coefficients[1::2]):
        text = f"{real}({part[-1]!r})"
        for coefficient in reversed(part[:-1]):
            text = f"({text} * square + {real}({coefficient!r}))"
        chains.append(text)
    even, odd = chains
    return f"const {real} square = {variable} * {variable}; const {real} value = {even} + {variable} * {odd};"


def _arctangent2(real: str) -> str:
    coefficients = arctangent_coefficients(10 if real == "double" else 6, REDUCED_TANGENT**2)
    return f"""const auto atan2_of = [](const {real} y, const {real} x) {{
#if defined(__CUDA_ARCH__)
    return ::atan2(y, x);
#else
    const {real} right = wp::abs(x);
    const {real} up = wp::abs(y);
    const {real} most = up > right ? up : right;
    const {real} least = up > right ? right : up;
    // beyond 22.5 degrees, the angle from 45 degrees
    const bool steep = least > {real}({REDUCED_TANGENT!r}) * most;
    const {real} above = steep ? least - most : least;
    const {real} beside = steep ? least + most : most;
    const {real} ratio = beside > {real}(0.0) ? above / beside : {real}(0.0) * beside;
    const {real} squared = ratio * ratio;
    {_horner(coefficients, "squared", real)}
    const {real} small = (steep ? {real}({0.5 * RIGHT_ANGLE!r}) : {real}(0.0)) + ratio * value;
    const {real} angle = up > right ? {real}({RIGHT_ANGLE!r}) - small : small;
    const {real} turned = x < {real}(0.0) ? {real}({2 * RIGHT_ANGLE!r}) - angle : angle;
    return y < {real}(0.0) ? -turned : turned;
#endif
}};"""


def arctangent2(y: Any, x: Any) -> Any:
    """The angle as the polynomial gives it, to the bit: what vanishes at rest on the device does so for constants."""
    coefficients = arctangent_coefficients(10, REDUCED_TANGENT**2)
    right, up = np.abs(x), np.abs(y)
    most, least = np.where(up > right, up, right), np.where(up > right, right, up)
    steep = least > REDUCED_TANGENT * most
    above, beside = np.where(steep, least - most, least), np.where(steep, least + most, most)
    ratio = np.where(beside > 0.0, above / np.where(beside > 0.0, beside, 1.0), 0.0 * beside)
    squared = ratio * ratio
    square = squared * squared
    chains = []
    for part in (coefficients[0::2], coefficients[1::2]):
        value = part[-1]
        for coefficient in reversed(part[:-1]):
            value = value * square + coefficient
        chains.append(value)
    small = np.where(steep, 0.5 * RIGHT_ANGLE, 0.0) + ratio * (chains[0] + squared * chains[1])
    angle = np.where(up > right, RIGHT_ANGLE - small, small)
    turned = np.where(np.less(x, 0.0), 2 * RIGHT_ANGLE - angle, angle)
    return np.where(np.less(y, 0.0), -turned, turned)[()]


def definitions(names: Iterable[str], real: str) -> list[str]:
    """C++ definitions ``NAME_of`` of functions."""
    written = {"atan2": _arctangent2}
    return [
        written[name](real)
        if name in written
        else f"const auto {name}_of = [](const {real} a) {{ return ::{name}(a); }};"
        if name != "pow"
        else f"const auto pow_of = [](const {real} a, const {real} b) {{ return ::pow(a, b); }};"
        for name in sorted(names)
    ]
