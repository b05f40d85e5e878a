"""Cuts through a sheet at the begin of a stage: what is waste no longer acts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from pydantic import field_validator

from ..arrays import FloatArray
from ..checks import Parameters
from ..names import Label


class Trim(Parameters):
    """A cut along closed curves, at the begin of a stage.

    Whole elements stay or go, by their centres: the cut is off its curves by up to half the diagonal of an element,
    which the run measures and tells.

    Attributes:
        curves: points of each, in order, (k, 2) [m]; the last one is joined to the first. A point is inside if an odd
            number of curves goes around it, so that a curve within another one is a hole. A single curve will do.
        sheet: name of the sheet; None for the only one of a run.
        view: what the curves are drawn on: "formed", the sheet as it is then, seen along z; or "blank", the flat blank.
        keeps: what stays, "inside" or "outside".
    """

    positional = ("curves", "sheet", "view", "keeps")

    curves: tuple[FloatArray, ...]
    sheet: Label | None = None
    view: Literal["formed", "blank"] = "formed"
    keeps: Literal["inside", "outside"] = "inside"

    @field_validator("curves", mode="before")
    @classmethod
    def _one_will_do(cls, value: Any) -> Any:
        if isinstance(value, np.ndarray) and value.ndim == 2:
            return (value,)
        if isinstance(value, Sequence) and len(value) and np.ndim(value[0]) == 1:
            return (value,)
        return tuple(value) if isinstance(value, Sequence | np.ndarray) else value

    @field_validator("curves")
    @classmethod
    def _are_closed_curves(cls, value: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
        if not value:
            raise ValueError("a closed curve is needed: its points (x, y) in order, at least three [m]")
        for curve in value:
            if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 3 or not np.isfinite(curve).all():
                raise ValueError(
                    f"a curve of shape {curve.shape}; the points of a closed curve are needed, at least three, finite, "
                    "of shape (k, 2)"
                )
        return value
