"""A sheet: a blank of one fabric, with what holds and loads its nodes."""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import model_validator

from ..arrays import BoolArray, FloatArray
from ..checks import Finite, Parameters
from ..fabric.fabric import Fabric
from .blank import Blank


class Sheet(Parameters):
    """One sheet of a run.

    Attributes:
        blank: its mesh and yarn directions.
        fabric: its laws.
        name: of its outputs, unique in a run.
        orientation: turns the yarn directions of the blank about its normal, counter-clockwise [degrees].
        free: (node_count, 6) bool, False where a displacement (x, y, z) or a director's rotation about x, y, z is held;
            None holds nothing.
        initial_velocity: (node_count, 3) [m/s]; None for rest.
    """

    positional = ("blank", "fabric")

    blank: Blank
    fabric: Fabric
    name: str = "sheet"
    orientation: Finite = 0.0
    free: BoolArray | None = None
    initial_velocity: FloatArray | None = None

    @model_validator(mode="after")
    def _fits_the_blank(self) -> Self:
        count = self.blank.node_count
        if self.free is not None and self.free.shape != (count, 6):
            raise ValueError(f"free: shape {self.free.shape}, but ({count}, 6) is needed")
        velocity = self.initial_velocity
        if velocity is not None and (velocity.shape != (count, 3) or not np.isfinite(velocity).all()):
            raise ValueError(
                f"initial_velocity: shape {velocity.shape}; finite values of shape ({count}, 3) are needed"
            )
        return self
