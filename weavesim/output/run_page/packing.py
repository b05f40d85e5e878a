"""Numbers in a page: rounded to 16 bits, differences between frames, deflated, base64."""

from __future__ import annotations

import base64
import math
import zlib
from typing import Any

import numpy as np

# Largest code of a number; the one above it is "not a number".
LARGEST_CODE = 65534
NOT_A_NUMBER = 65535
# The page opens it once: little time is worth more than few bytes.
_LEVEL = 3


def packed(values: np.ndarray) -> str:
    """The bytes of an array, little-endian, deflated, as base64."""
    values = np.ascontiguousarray(values)
    values = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(zlib.compress(values.tobytes(), _LEVEL)).decode("ascii")


def packed_series(values: np.ndarray, *, logarithmic: bool = False) -> dict[str, Any]:
    """Values of all frames, (frame_count, n), or (frame_count, n, component_count) with a range for each component.

    A number is off by at most half of ``step``: the range of all frames over 65,534. What is not finite becomes
    not a number.

    Args:
        values: to be packed.
        logarithmic: keep the decadic logarithm, so that small numbers keep their digits; what is not positive becomes
            the smallest positive number.

    Returns:
        ``low`` and ``step``, one per component, ``logarithmic``, and ``data``: unsigned 16-bit differences from the
        frame before, all low bytes before all high bytes. If all numbers are one, ``data`` is empty.
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
    step = (high - low) / LARGEST_CODE
    head = {"low": low.tolist(), "step": step.tolist(), "logarithmic": logarithmic}
    if finite.all() and not step.any():
        return {**head, "data": ""}
    scaled = (np.where(finite, values, low) - low) / np.where(step > 0.0, step, 1.0)
    code = np.where(finite, np.rint(scaled), NOT_A_NUMBER).astype(np.uint16).reshape(frame_count, -1)
    # a difference may wrap around: the page adds modulo 2^16
    change = np.concatenate([code[:1], code[1:] - code[:-1]])
    planes = change.astype("<u2").view(np.uint8).reshape(-1, 2).T
    return {**head, "data": packed(planes)}


def rounded(values: np.ndarray) -> list[float | None]:
    """Numbers of a chart with five digits; None for what is not finite."""
    return [float(f"{value:.5g}") if math.isfinite(value) else None for value in np.asarray(values, dtype=float)]
