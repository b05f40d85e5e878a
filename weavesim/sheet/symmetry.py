"""Symmetry planes at which a blank is cut."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import field_validator

from ..checks import Parameters
from ..errors import InputError

if TYPE_CHECKING:
    from .blank import Blank


AXES = {"x": 0, "y": 1}


class Symmetry(Parameters):
    """Planes through the origin at which the computed part of a sheet is cut.

    Attributes:
        planes: of "x" (the plane x = 0) and "y" (the plane y = 0), each at most once.
    """

    positional = ("planes",)

    planes: tuple[str, ...] = ()

    @field_validator("planes", mode="before")
    @classmethod
    def _are_known(cls, value: Any) -> Any:
        planes = tuple(value)
        for plane in planes:
            if plane not in AXES:
                raise ValueError(f"symmetry plane {plane!r}: 'x' (the plane x = 0) and 'y' (the plane y = 0) are known")
        if len(set(planes)) < len(planes):
            raise ValueError(f"symmetry planes {planes}: each may be named once")
        return planes


def nodes_on_plane(blank: Blank, plane: str) -> np.ndarray:
    """Mask of the nodes of a blank that lie on a symmetry plane, "x" or "y"."""
    coordinate = blank.node_position[:, AXES[plane]]
    return np.abs(coordinate) < 1.0e-9 * max(1.0, np.ptp(coordinate))


def hold_symmetry(blank: Blank, planes: Sequence[str], free: np.ndarray) -> np.ndarray:
    """``free`` with the nodes on the planes x = 0 and y = 0 held: they stay in the plane, directors turn in it.

    Raises:
        InputError: an unknown plane, or one that no node lies on.
    """
    free = free.copy()
    for plane in Symmetry(tuple(planes)).planes:
        axis, on_plane = AXES[plane], nodes_on_plane(blank, plane)
        if not on_plane.any():
            raise InputError(f"symmetry plane {plane} = 0: no node of the blank lies on it")
        free[on_plane, axis] = False
        turning = [3, 4, 5]
        turning.remove(3 + axis)
        free[np.ix_(on_plane, turning)] = False
    return free


def mirror_signs(symmetry: Sequence[str]) -> list[tuple[int, int]]:
    """Factors of (x, y) that turn the computed part into each copy of the whole; the first is (1, 1)."""
    return list(product((1, -1) if "x" in symmetry else (1,), (1, -1) if "y" in symmetry else (1,)))
