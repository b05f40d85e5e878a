"""A sector of a plate with an opening, such as a segment of a blank holder."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from pydantic import model_validator

from ...checks import Finite
from ...ranges import Quantity
from ..drawing import Triangles
from ..shapes import DomeOpening
from .cutting import sector_normals, sector_of


class DomeOpeningSector(DomeOpening):
    """The part of a ``DomeOpening`` between two half planes that begin at its axis.

    Its sides are upright and end in sharp edges: beside a neighbour that stands as high nothing is felt of them.

    Attributes:
        begin, end: angles of the sides from x, counter-clockwise, in the shape's own frame, at most half a turn apart
            [degrees].
    """

    distance_function = "weavesim.kernels.contact.opening_sector"
    dimension_names = ("radius", "half_length", "edge_radius", "begin_x", "begin_y", "end_x", "end_y")
    positional = ("radius", "half_length", "edge_radius", "begin", "end")

    begin: Annotated[Finite, Quantity("turn of a tool")]
    end: Annotated[Finite, Quantity("turn of a tool")]

    @model_validator(mode="after")
    def _is_a_sector(self) -> Self:
        if not 0.0 < self.end - self.begin <= 180.0:
            raise ValueError(
                f"begin = {self.begin:g}, end = {self.end:g}: a sector goes on from its begin by up to 180 degrees"
            )
        return self

    def dimensions(self) -> dict[str, float]:
        """Dimensions of the opening [m], and the outward normals of both sides in plan."""
        normals = sector_normals(math.radians(self.begin), math.radians(self.end))
        names = self.dimension_names[3:]
        own = {name: getattr(self, name) for name in self.dimension_names[:3]}
        return own | dict(zip(names, normals.ravel().tolist(), strict=True))

    def local_triangles(self) -> Triangles:
        """The drawn opening, cut along the sides."""
        vertices, faces = super().local_triangles()
        begin, end = math.radians(self.begin), math.radians(self.end)
        return sector_of((np.asarray(vertices), np.asarray(faces)), (0.0, 0.0), begin, end)
