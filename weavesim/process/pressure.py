"""Pressure on the faces of a sheet, which follows them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import field_validator, model_validator

from ..arrays import IntArray
from ..checks import Parameters
from ..quantities import Numbers
from ..ranges import Quantity
from .loads import check_curve


class Pressure(Parameters):
    """Pressure on one face of a sheet, or on a part of it; its work is booked as ``pressure_work``.

    It pushes against the face, normal to the current surface, on the current area. The top is the face out of which the
    directors of the blank point: of a flat blank, the upper one. With symmetry planes only the modelled part is loaded.

    Attributes:
        face: "top" or "bottom".
        pressures: at ``times`` [Pa], linear between them, constant before and after; a negative one pulls.
        times: increasing [s].
        elements: indices of those that it acts on, each once; None for all.
    """

    positional = ("face", "pressures", "times", "elements")

    face: Literal["top", "bottom"]
    pressures: Annotated[Numbers, Quantity("pressure")]
    times: Annotated[Numbers, Quantity("time")] = (0.0,)
    elements: IntArray | None = None

    @classmethod
    def ramped(cls, face: str, pressure: float, ramp_time: float, **values: Any) -> Self:
        """A pressure [Pa] that grows evenly from zero until ``ramp_time`` [s], and then stays."""
        return cls(face, (0.0, pressure), (0.0, ramp_time), **values)

    @field_validator("elements")
    @classmethod
    def _are_some(cls, value: np.ndarray | None) -> np.ndarray | None:
        if value is not None and (value.ndim != 1 or not len(value)):
            raise ValueError("indices of one or more elements are needed; leave it out for all elements")
        if value is not None and len(np.unique(value)) < len(value):
            raise ValueError("an element is listed twice; list each element once")
        return value

    @model_validator(mode="after")
    def _are_a_curve(self) -> Self:
        check_curve(self.times, self.pressures, "pressures")
        return self

    def check_elements(self, element_count: int) -> None:
        """Check the indices against a blank.

        Raises:
            ValueError: an element that the blank does not have.
        """
        own = self.elements
        if own is not None and (own.min() < 0 or own.max() >= element_count):
            raise ValueError(
                f"pressure on the {self.face}: elements go from {own.min()} to {own.max()}; the blank has "
                f"{element_count} elements, counted from 0"
            )

    def at(self, times: np.ndarray) -> np.ndarray:
        """Pressures [Pa] at ``times`` (n,) [s], (n,)."""
        return np.interp(times, self.times, self.pressures)

    def acts_on(self, element_count: int) -> np.ndarray:
        """Whether it acts on each element, (element_count,) bool."""
        result = np.full(element_count, self.elements is None)
        if self.elements is not None:
            result[self.elements] = True
        return result
