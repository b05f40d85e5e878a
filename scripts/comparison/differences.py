"""How entries differ, in type, shape or any bit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Difference:
    """An entry that is not the same.

    Attributes:
        name: of the entry.
        text: description of the difference.
        frame: first frame that differs; None if the entry is not per frame.
        size: largest difference over the largest magnitude; None if it is not numerical.
    """

    name: str
    text: str
    frame: int | None = None
    size: float | None = None

    def __str__(self) -> str:
        return f"{self.name}: {self.text}"


def difference(name: str, before: np.ndarray, after: np.ndarray) -> Difference | None:
    """How ``after`` differs from ``before`` in type, shape or any bit; None if it does not."""
    if _kind(before) != _kind(after):
        return Difference(name, f"{_kind(before)} became {_kind(after)}")
    of_frames = name.startswith("frames/") and before.ndim > 0
    if of_frames and before.shape[1:] == after.shape[1:] and len(before) != len(after):
        # a run that ends earlier or later: the first difference is more informative than the length
        count = min(len(before), len(after))
        text = f"{len(before)} frames became {len(after)}"
        if one := difference(name, before[:count], after[:count]):
            return replace(one, text=f"{one.text}; {text}")
        return Difference(name, text, frame=count)
    if before.shape != after.shape:
        return Difference(name, f"shape {before.shape} became {after.shape}")
    differs = _bits(before) != _bits(after) if before.dtype.kind not in "US" else before != after
    if not differs.any():
        return None
    first = tuple(int(index) for index in np.argwhere(differs)[0])
    frame = first[0] if of_frames else None
    size = relative_size(before, after)
    text = f"{before[first]} became {after[first]}"
    if len(text) > 80:
        text = "differs"
    place = f"frame {frame}, " if frame is not None else ""
    text = f"{place}{text}, {int(differs.sum())} of {differs.size} values"
    return Difference(name, text if size is None else f"{text}, relative difference {size:.2g}", frame, size)


def _kind(values: np.ndarray) -> str:
    return {"U": "text", "S": "hash"}.get(values.dtype.kind, values.dtype.name)


def _bits(values: np.ndarray) -> np.ndarray:
    """Bits of the values as integers: 0.0 differs from -0.0, and a NaN equals itself."""
    return np.ascontiguousarray(values).reshape(values.shape).view(f"u{values.dtype.itemsize}")


def relative_size(before: np.ndarray, after: np.ndarray) -> float | None:
    """Largest difference over the largest magnitude; None if these are not numbers."""
    if before.dtype.kind == "S":
        return None
    try:
        a, b = (np.asarray(values).astype(np.float64) for values in (before, after))
    except ValueError:
        return None
    same_nan = np.isnan(a) & np.isnan(b)
    with np.errstate(invalid="ignore"):
        gap = np.where(same_nan | (a == b), 0.0, np.abs(a - b))
    if not np.isfinite(gap).all():
        return math.inf
    scale = max((float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) for values in (a, b)), default=0.0)
    return float(gap.max(initial=0.0)) / scale if scale > 0.0 else 0.0


def differences(before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray]) -> list[Difference]:
    """All entries that differ: the earliest frame first, within it the largest, then the others in their order."""
    found = [Difference(name, "is missing") for name in before if name not in after]
    found += [Difference(name, "is new") for name in after if name not in before]
    for name in before:
        if name in after and (one := difference(name, before[name], after[name])):
            found.append(one)
    return sorted(found, key=lambda one: (math.inf if one.frame is None else one.frame, -(one.size or 0.0)))
