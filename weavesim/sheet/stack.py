"""Lay-ups: plies on each other, from a code such as "[0/90]s" to the sheets of a world."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import field_validator, model_validator

from ..arrays import FloatArray
from ..checks import Finite, Parameters, Positive
from ..errors import InputError
from ..fabric.fabric import Fabric
from ..names import Label
from ..process.self_contact import SelfContact
from ..quantities import finite
from ..ranges import Quantity, argument, check_usual
from .blank import Blank
from .lay_up_code import LARGEST_PLY_COUNT, angles_of, code_of
from .sheet import Sheet

# Beyond it the user is asked.
LARGEST_USUAL_PLY_COUNT = 64
# Smaller angles than this, but zero, are asked about [degrees].
SMALLEST_USUAL_ANGLE = 1.0
# Angles are the same up to this [degrees].
_SAME_ANGLE = 1.0e-9

MeshAlong = Literal["yarns", "outline"]


class Ply(Parameters):
    """One ply of a lay-up.

    Attributes:
        angle: from the x axis to the warp, counter-clockwise seen from above [degrees]; a woven ply has its weft at
            plus 90 degrees.
        fabric: None for that of the lay-up.
        thickness: in place of the fabric's [m]; None leaves it.
        outline: corners in order, (k, 2) [m]; None for that of the lay-up.
        name: None for ply_1, ply_2, ... from the bottom.
    """

    positional = ("angle", "fabric")

    angle: Annotated[Finite, Quantity("angle")]
    fabric: Fabric | None = None
    thickness: Annotated[Positive, Quantity("sheet thickness")] | None = None
    outline: Annotated[FloatArray, Quantity("position")] | None = None
    name: Label | None = None

    def disproportions(self) -> Iterator[str]:
        if 0.0 < abs(self.angle) < SMALLEST_USUAL_ANGLE:
            yield f"an angle of {self.angle:g} degrees is unusually small; write 45 for 45 degrees"


class LayUp(Parameters):
    """Plies that lie on each other, the first one at the bottom.

    Attributes:
        plies: from the bottom to the top.
        fabric: of the plies that have none of their own.
        outline: corners in order, (k, 2) [m], of the plies that have none of their own.
    """

    positional = ("plies", "fabric", "outline")

    plies: tuple[Ply, ...]
    fabric: Fabric | None = None
    outline: Annotated[FloatArray, Quantity("position")] | None = None

    @field_validator("plies")
    @classmethod
    def _are_some(cls, value: tuple[Ply, ...]) -> tuple[Ply, ...]:
        if not 1 <= len(value) <= LARGEST_PLY_COUNT:
            raise ValueError(f"1 to {LARGEST_PLY_COUNT} plies are allowed, here are {len(value)}")
        return value

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = self.names
        for index, name in enumerate(names):
            if name in names[:index]:
                raise ValueError(f"plies {names.index(name)} and {index} are both named {name!r}; give each its own")
        return self

    @classmethod
    def parse(cls, code: str, fabric: Fabric | None = None, outline: np.ndarray | None = None) -> LayUp:
        """The lay-up of a code such as "0/45/-45/90", "[0/90]s" or "[45/-45]2s", bottom to top.

        Args:
            code: see ``lay_up_code``.
            fabric, outline: of all plies.

        Raises:
            InputError: a code that cannot be read.
        """
        if not isinstance(code, str):
            raise InputError(f"lay-up {code!r}: a text such as '[0/90]s' is needed")
        return cls(plies=tuple(Ply(angle) for angle in angles_of(code)), fabric=fabric, outline=outline)

    @classmethod
    def rectangle(cls, code: str, fabric: Fabric, lower: tuple[float, float], upper: tuple[float, float]) -> LayUp:
        """The lay-up of a code, of rectangular plies between two corners (x, y) [m]."""
        (left, near), (right, far) = lower, upper
        return cls.parse(code, fabric, np.array([(left, near), (right, near), (right, far), (left, far)], dtype=float))

    @property
    def code(self) -> str:
        """The angles in the usual notation."""
        return code_of(tuple(ply.angle for ply in self.plies))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the plies, from the bottom."""
        return tuple(ply.name or f"ply_{index}" for index, ply in enumerate(self.plies, start=1))

    @property
    def fabrics(self) -> tuple[Fabric, ...]:
        """Of the plies, from the bottom, with their own thickness.

        Raises:
            InputError: a ply without one.
        """
        return tuple(self._fabric(name, ply) for name, ply in zip(self.names, self.plies, strict=True))

    def _fabric(self, name: str, ply: Ply) -> Fabric:
        fabric = ply.fabric or self.fabric
        if fabric is None:
            raise InputError(f"lay-up {self.code}: {name} has no fabric; give one to the ply or to the lay-up")
        return fabric if ply.thickness is None else fabric.model_copy(update={"thickness": ply.thickness})

    @property
    def thickness(self) -> float:
        """Of all plies together [m]."""
        return sum(fabric.thickness for fabric in self.fabrics)

    def heights(self, bottom: float = 0.0) -> tuple[float, ...]:
        """Mid-surfaces of the plies, which rest on each other [m]: half thicknesses apart.

        Args:
            bottom: z of the lowest face [m].
        """
        thickness = np.array([fabric.thickness for fabric in self.fabrics])
        return tuple((finite("bottom", bottom) + np.cumsum(thickness) - 0.5 * thickness).tolist())

    def sheets(
        self,
        mesh_size: float,
        *,
        bottom: float = 0.0,
        mesh_along: MeshAlong = "yarns",
        self_contact: SelfContact | None = None,
        accept_unusual: bool = False,
    ) -> tuple[Sheet, ...]:
        """The sheets of a world, flat and horizontal, from the bottom to the top.

        Elements follow the yarns of their ply wherever the outline allows, which is the more accurate choice where
        yarns are hard to compress (docs/decisions/0015-mesh-angle.md): a rectangle along the axes has a regular mesh
        for plies at multiples of 90 degrees, all others one layer of other elements along their outline. With
        ``mesh_along`` "outline" all plies of a rectangle have the same regular mesh, which the yarns cross.

        Args:
            mesh_size: edge length of an element [m].
            bottom: z of the lowest face [m].
            mesh_along: what the elements follow.
            self_contact: of every ply with itself; without it, each passes through itself.
            accept_unusual: take unusual angles, sizes and counts as meant.

        Raises:
            InputError: a ply without fabric or outline, an outline that cannot be filled, or an unusual value.
        """
        if mesh_along not in ("yarns", "outline"):
            raise InputError(f"mesh_along = {mesh_along!r}: yarns or outline is allowed")
        mesh_size = argument("mesh_size", mesh_size, "mesh size")
        if not accept_unusual:
            try:
                check_usual(self, f"lay-up {self.code}")
            except ValueError as error:
                raise InputError(str(error)) from None
        parts = zip(self.names, self.plies, self.fabrics, self.heights(bottom), strict=True)
        return tuple(
            Sheet(self._blank(name, ply, mesh_size, height, mesh_along), fabric, name, self_contact=self_contact)
            for name, ply, fabric, height in parts
        )

    def _blank(self, name: str, ply: Ply, mesh_size: float, height: float, mesh_along: MeshAlong) -> Blank:
        outline = self.outline if ply.outline is None else ply.outline
        if outline is None:
            raise InputError(f"lay-up {self.code}: {name} has no outline; give one to the ply or to the lay-up")
        mesh_angle = ply.angle if mesh_along == "yarns" else 0.0
        aligned = abs(mesh_angle - 90.0 * round(mesh_angle / 90.0)) <= _SAME_ANGLE
        try:
            if aligned and (corners := _rectangle(outline)) is not None:
                return Blank.rectangle(*corners, mesh_size, yarn_angle=ply.angle, height=height)
            return Blank.fitted(outline, mesh_size, mesh_angle=mesh_angle, yarn_angle=ply.angle, height=height)
        except InputError as error:
            raise InputError(f"lay-up {self.code}, {name}: {error}") from None

    def disproportions(self) -> Iterator[str]:
        if len(self.plies) > LARGEST_USUAL_PLY_COUNT:
            yield f"{len(self.plies)} plies; usual are up to {LARGEST_USUAL_PLY_COUNT}"


def _rectangle(outline: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Opposite corners of an outline that is a rectangle along the axes; None for others."""
    lower, upper = outline.min(axis=0), outline.max(axis=0)
    slack = 1.0e-9 * float((upper - lower).max())
    at_lower, at_upper = np.abs(outline - lower) <= slack, np.abs(outline - upper) <= slack
    corner = at_upper.astype(int) @ np.array([1, 2])
    if len(outline) != 4 or not (at_lower | at_upper).all() or len(set(corner.tolist())) != 4:
        return None
    return (float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1]))
