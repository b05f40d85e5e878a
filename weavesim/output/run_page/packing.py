"""Numbers in a page: rounded to 16 bits or fewer, differences between frames, deflated, base64."""

from __future__ import annotations

import base64
import math
import zlib
from typing import Any

import numpy as np

# Largest code of a number, and where there are very many numbers, which then take a third of the bytes.
LARGEST_CODE = 65534
COARSE_CODE = 1022
NOT_A_NUMBER = 65535
# The page opens it once: little time is worth more than few bytes, unless there are very many.
_LEVEL, _COARSE_LEVEL = 3, 6


def packed(values: np.ndarray, level: int = _LEVEL) -> str:
    """The bytes of an array, little-endian, deflated, as base64."""
    values = np.ascontiguousarray(values)
    values = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(zlib.compress(values.tobytes(), level)).decode("ascii")


def packed_series(values: np.ndarray, *, logarithmic: bool = False, largest_code: int = LARGEST_CODE) -> dict[str, Any]:
    """Values of all frames, (frame_count, n), or (frame_count, n, component_count) with a range for each component.

    A number is off by at most half of ``step``: the range of all frames over ``largest_code``. What is not finite
    becomes not a number.

    Args:
        values: to be packed.
        logarithmic: keep the decadic logarithm, so that small numbers keep their digits; what is not positive becomes
            the smallest positive number.
        largest_code: into how many steps the range is divided.

    Returns:
        ``low`` and ``step``, one per component, ``logarithmic``, and ``data``: 16-bit differences from the frame
        before, 0, -1, 1, -2, ... as 0, 1, 2, 3, ..., all low bytes before all high bytes. If all numbers are one,
        ``data`` is empty.
    """
    values = np.asarray(values, dtype=np.float64)
    if logarithmic:
        positive = np.isfinite(values) & (values > 0.0)
        least = float(values[positive].min()) if positive.any() else 1.0
        values = np.log10(np.where(positive, values, np.where(np.isfinite(values), least, np.nan)))
    frame_count = len(values)
    values = values.reshape(frame_count, values.shape[1], -1)
    finite = np.isfinite(values)
    some = finite.any(axis=(0, 1))
    low = np.where(some, np.min(values, axis=(0, 1), where=finite, initial=np.inf), 0.0)
    high = np.where(some, np.max(values, axis=(0, 1), where=finite, initial=-np.inf), 0.0)
    step = (high - low) / largest_code
    head = {"low": low.tolist(), "step": step.tolist(), "logarithmic": logarithmic}
    if finite.all() and not step.any():
        return {**head, "data": ""}
    scaled = (np.where(finite, values, low) - low) / np.where(step > 0.0, step, 1.0)
    code = np.where(finite, np.rint(scaled), NOT_A_NUMBER).astype(np.uint16).reshape(frame_count, -1)
    # a difference may wrap around: the page adds modulo 2^16
    change = np.concatenate([code[:1], code[1:] - code[:-1]]).view(np.int16)
    # small sizes of either sign have no high byte
    planes = ((change << 1) ^ (change >> 15)).astype("<u2").view(np.uint8).reshape(-1, 2).T
    return {**head, "data": packed(planes, _LEVEL if largest_code == LARGEST_CODE else _COARSE_LEVEL)}


def rounded(values: np.ndarray) -> list[float | None]:
    """Numbers of a chart with five digits; None for what is not finite."""
    return [float(f"{value:.5g}") if math.isfinite(value) else None for value in np.asarray(values, dtype=float)]
