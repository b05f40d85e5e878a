"""Symmetry planes at which a blank is cut."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import field_validator

from ..checks import Parameters
from ..errors import InputError
from .topology import length_tolerance

if TYPE_CHECKING:
    from .blank import Blank


AXES = {"x": 0, "y": 1}


class Symmetry(Parameters):
    """Planes through the origin at which the computed part of a sheet is cut.

    Attributes:
        planes: any of "x" (the plane x = 0) and "y" (the plane y = 0), each at most once.
    """

    positional = ("planes",)

    planes: tuple[str, ...] = ()

    @field_validator("planes", mode="before")
    @classmethod
    def _are_known(cls, value: Any) -> Any:
        try:
            planes = tuple(value)
        except TypeError:
            raise ValueError(f"symmetry planes {value!r}: a list of 'x' and 'y' is needed") from None
        for plane in planes:
            if plane not in tuple(AXES):
                raise ValueError(f"symmetry plane {plane!r}: 'x' (plane x = 0) and 'y' (plane y = 0) are allowed")
        if len(set(planes)) < len(planes):
            raise ValueError(f"symmetry planes {planes}: list each plane once")
        return planes

    @property
    def share(self) -> float:
        """The computed share of the whole: 1, 0.5 or 0.25."""
        return 0.5 ** len(self.planes)

    @property
    def mirror_factors(self) -> tuple[tuple[int, int], ...]:
        """Factors of (x, y) that map the computed part to each copy of the whole; the first is (1, 1)."""
        along_x, along_y = ((1, -1) if plane in self.planes else (1,) for plane in AXES)
        return tuple(product(along_x, along_y))

    def mirrored(self, points: np.ndarray) -> np.ndarray:
        """``points`` (k, ..., 3) of the computed part and of all copies, (copy_count k, ..., 3), as precise."""
        copies = np.stack([points] * len(self.mirror_factors))
        for copy, signs in zip(copies, self.mirror_factors, strict=True):
            for axis, sign in enumerate(signs):
                if sign < 0:
                    copy[..., axis] *= sign
        return copies.reshape(-1, *points.shape[1:])

    def hold(self, blank: Blank, free: np.ndarray) -> np.ndarray:
        """``free`` (node_count, 6) with symmetry constraints: nodes stay on their plane, directors rotate within it.

        Raises:
            InputError: a plane that no node lies on.
        """
        free = free.copy()
        for plane in self.planes:
            axis, held = AXES[plane], self.held_nodes(blank, plane)
            free[held, axis] = False
            turning = [3, 4, 5]
            turning.remove(3 + axis)
            free[np.ix_(held, np.array(turning))] = False
        return free

    def held_nodes(self, blank: Blank, plane: str) -> np.ndarray:
        """Which nodes of a blank a plane holds, (node_count,) bool.

        Raises:
            InputError: there are none.
        """
        held = on_plane(blank, plane)
        if not held.any():
            off = 1e3 * float(np.abs(blank.node_position[:, AXES[plane]]).min())
            raise InputError(
                f"symmetry plane {plane} = 0: no node of the blank lies on it, the nearest is {off:.4g} mm off; what "
                "is given ends at the plane"
            )
        return held

    def upright(self, blank: Blank) -> Blank:
        """``blank`` with the directors of held nodes in their planes, as on the whole sheet; itself where they are.

        A curved blank that is cut at a plane has there the normals of the elements on one side, which lean.
        """
        director = blank.initial_director.copy()
        for plane in self.planes:
            director[self.held_nodes(blank, plane), AXES[plane]] = 0.0
        leaning = (director != blank.initial_director).any(axis=1)
        if not leaning.any():
            return blank
        length = np.linalg.norm(director[leaning], axis=1, keepdims=True)
        # a sheet that lies in the plane has no other normal
        director[leaning] = np.where(
            length > 1.0e-3, director[leaning] / np.maximum(length, 1.0e-3), blank.initial_director[leaning]
        )
        return blank.model_copy(update={"initial_director": director})


# For a blank without symmetry.
WHOLE = Symmetry()


def on_plane(blank: Blank, plane: str) -> np.ndarray:
    """Whether each node lies on a symmetry plane, to rounding of the mesh's coordinates, (node_count,) bool."""
    return np.abs(blank.node_position[:, AXES[plane]]) <= length_tolerance(blank)


def shear_angle_parity(blank: Blank, plane: str) -> np.ndarray:
    """Factor of the shear angle of each element in its mirror image, (element_count,).

    It is -1 if the mirror maps each yarn family onto itself, and 1 if it swaps the two (yarns at 45 degrees to the
    plane). This is the only place that decides it, from the yarn directions alone.
    """
    mirror = np.ones(3)
    mirror[AXES[plane]] = -1.0
    warp, weft = blank.warp_direction, blank.weft_direction
    kept, swapped = (np.einsum("ei,ei->e", warp * mirror, other) for other in (warp, weft))
    kept_weft, swapped_weft = (np.einsum("ei,ei->e", weft * mirror, other) for other in (weft, warp))
    return np.where(np.abs(swapped) > np.abs(kept), np.sign(swapped * swapped_weft), np.sign(kept * kept_weft))


def nodes_of_odd_angle(blank: Blank, free: np.ndarray) -> np.ndarray:
    """Nodes where the mean shear angle of the surrounding elements is zero by symmetry, (node_count,) bool.

    They lie on a symmetry plane, and the elements around them have the opposite angle in the mirror image. They are
    recognised from ``free`` (node_count, 6), whether set by a ``Symmetry`` or by the user: held along x (or y), with a
    director that rotates only about that axis. The node where two planes meet cannot rotate and is not included.
    """
    odd = np.zeros(blank.node_count, dtype=bool)
    for plane, axis in AXES.items():
        held = ~free[:, axis] & free[:, 3 + axis] & ~free[:, [3 + a for a in range(3) if a != axis]].any(axis=1)
        around = np.repeat(shear_angle_parity(blank, plane), 4)
        odd |= held & (np.bincount(blank.quads.ravel(), around, blank.node_count) < 0.0)
    return odd
