"""Stresses and resultants of a formed sheet: the parts of equation (1), each by push-forward (docs/theory.md, 8).

Components are those of an orthonormal frame in each element: axis 1 along the warp, axis 2 across it in the tangent
plane, 3 along the normal. Symmetric tensors are (element_count, 3): 11, 22, 12.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..sheet.geometry import ElementGeometry

if TYPE_CHECKING:
    from ..fabric.fabric import Fabric
    from ..sheet.blank import Blank

Values = Mapping[str, np.ndarray]

# Name, unit and meaning of what ``stress_fields`` returns, in its order. Lengths and widths are current ones.
STRESS_FIELDS: dict[str, tuple[str, str]] = {
    "unit_cell_force": ("N/m", "membrane force of the unit cell and of the sheet's compressive stiffness: 11, 22, 12"),
    "shear_force": ("N/m", "membrane force of in-plane shear, elastic and friction: 11, 22, 12"),
    "in_plane_bending_force": ("N/m", "membrane force of the bending of the yarns in the plane: 11, 22, 12"),
    "bending_force": ("N/m", "membrane force of bending and transverse shear, by the metric: 11, 22, 12"),
    "bending_moment": ("N", "moment per width, positive where it stretches the upper face: 11, 22, 12"),
    "transverse_force": ("N/m", "transverse shear force per width: 1, 2"),
    "unit_cell_stress": ("N/m^2", "Cauchy stress of the unit cell: 11, 22, 12"),
    "shear_stress": ("N/m^2", "Cauchy stress of in-plane shear: 11, 22, 12"),
    "in_plane_bending_stress": ("N/m^2", "Cauchy stress of the bending of the yarns in the plane: 11, 22, 12"),
    "bending_stress_upper": ("N/m^2", "Cauchy stress of bending at the upper face: 11, 22, 12"),
    "bending_stress_lower": ("N/m^2", "Cauchy stress of bending at the lower face: 11, 22, 12"),
    "stress_middle": ("N/m^2", "Cauchy stress at the middle, all parts: 11, 22, 12"),
    "stress_upper": ("N/m^2", "Cauchy stress at the upper face, all parts: 11, 22, 12"),
    "stress_lower": ("N/m^2", "Cauchy stress at the lower face, all parts: 11, 22, 12"),
    "line_force_warp": ("N/m", "force across a line that the warp crosses, per reference width: x, y, z"),
    "line_force_weft": ("N/m", "force across a line that the weft crosses, per reference width: x, y, z"),
}


@dataclass(frozen=True, eq=False)
class Convected:
    """Convected vectors of a formed sheet at the centres of its elements.

    Attributes:
        by_yarn: a_1, a_2, derivatives of the position along warp and weft, (element_count, 2, 3).
        director_by_yarn: the same of the director [1/m].
        director: mean director, (element_count, 3).
    """

    by_yarn: np.ndarray
    director_by_yarn: np.ndarray
    director: np.ndarray

    @classmethod
    def of(cls, blank: Blank, position: np.ndarray, director: np.ndarray) -> Convected:
        """Of a blank with its nodes at ``position`` (node_count, 3) [m] and unit directors (node_count, 3)."""
        b = ElementGeometry.of(blank).gradient
        weight_p, weight_q = b[:2].T[:, :, None], b[2:].T[:, :, None]
        derivatives = []
        for nodal in (position, director):
            corner = nodal[blank.quads]
            p, q = corner[:, 0] - corner[:, 2], corner[:, 1] - corner[:, 3]
            derivatives.append(weight_p * p[:, None] + weight_q * q[:, None])
        return cls(derivatives[0], derivatives[1], director[blank.quads].mean(axis=1))

    @cached_property
    def metric(self) -> np.ndarray:
        """m_ab, (element_count, 2, 2)."""
        return np.einsum("eai,ebi->eab", self.by_yarn, self.by_yarn)

    @cached_property
    def frame(self) -> np.ndarray:
        """Rows: along the warp, across it in the tangent plane, normal, (element_count, 3, 3)."""
        warp = self.by_yarn[:, 0] / np.linalg.norm(self.by_yarn[:, 0], axis=1, keepdims=True)
        normal = np.cross(self.by_yarn[:, 0], self.by_yarn[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        return np.stack([warp, np.cross(normal, warp), normal], axis=1)

    @cached_property
    def area_ratio(self) -> np.ndarray:
        """J, (element_count,)."""
        return np.linalg.norm(np.cross(self.by_yarn[:, 0], self.by_yarn[:, 1]), axis=1)

    @cached_property
    def components(self) -> np.ndarray:
        """Components of a_1, a_2 along the axes 1, 2 of the frame, (element_count, 2, 2)."""
        return np.einsum("eai,eki->eak", self.by_yarn, self.frame[:, :2])

    def push_forward(self, contravariant: np.ndarray) -> np.ndarray:
        """T^ab per reference area (element_count, 2, 2) as a tensor per current area: 11, 22, 12."""
        c = self.components
        pushed = np.einsum("eab,eai,ebj->eij", contravariant, c, c) / self.area_ratio[:, None, None]
        return np.stack([pushed[:, 0, 0], pushed[:, 1, 1], pushed[:, 0, 1]], axis=1)


def stress_fields(
    blank: Blank, fabric: Fabric, position: np.ndarray, director: np.ndarray, fields: Values, resultants: Values
) -> dict[str, np.ndarray]:
    """``STRESS_FIELDS`` of a formed sheet, from one of its frames.

    Equation (1) has three parts: unit cell, shear and bending; the bending of the yarns in the plane, which the paper
    does not have, is a fourth. Forces per width are 1/J T^ab a_a (x) a_b, moments 1/J M^ab a_a (x) a_b, and stresses
    N/t + 12 z M/t^3 with the current thickness t. The stabilisation belongs to none of them.

    Args:
        blank: the flat sheet.
        fabric: of the sheet.
        position, director: of the nodes, (node_count, 3), of a ``SheetFrame`` like the rest.
        fields: one value per element.
        resultants: by the names of ``ResultantRow``.
    """
    x = Convected.of(blank, position, director)
    cell = np.zeros_like(x.metric)
    for k, yarn in enumerate(("warp", "weft")):
        cell[:, k, k] = fields[f"{yarn}_force"] / np.sqrt(x.metric[:, k, k])
    transverse = np.stack([resultants["transverse1"], resultants["transverse2"]], axis=1)
    shear, bending, moment = (_symmetric(resultants, name) for name in ("shear", "bending", "moment"))
    in_plane = _of_moment(x, resultants["in_plane_moment"])
    bending = bending + _of_transverse_shear(x, transverse, fabric.transverse_shear_stiffness)
    out = {
        "unit_cell_force": x.push_forward(cell),
        "shear_force": x.push_forward(shear),
        "in_plane_bending_force": x.push_forward(in_plane),
        "bending_force": x.push_forward(bending),
        "bending_moment": x.push_forward(moment),
        "transverse_force": np.einsum("ea,eak->ek", transverse, x.components) / x.area_ratio[:, None],
    }
    out |= _stresses(out, fields["thickness"][:, None])
    total = cell + shear + in_plane + bending
    across = (
        np.einsum("eab,ebi->eai", total, x.by_yarn)
        + np.einsum("eab,ebi->eai", moment, x.director_by_yarn)
        + transverse[:, :, None] * x.director[:, None]
    )
    return out | {"line_force_warp": across[:, 0], "line_force_weft": across[:, 1]}


def _stresses(force: Values, thickness: np.ndarray) -> dict[str, np.ndarray]:
    """Cauchy stresses of forces and moments per width."""
    middle = {part: force[f"{part}_force"] / thickness for part in ("unit_cell", "shear", "in_plane_bending")}
    bending, at_face = force["bending_force"] / thickness, 6.0 * force["bending_moment"] / thickness**2
    membrane = sum(middle.values())
    return {
        **{f"{part}_stress": value for part, value in middle.items()},
        "bending_stress_upper": bending + at_face,
        "bending_stress_lower": bending - at_face,
        "stress_middle": membrane + bending,
        "stress_upper": membrane + bending + at_face,
        "stress_lower": membrane + bending - at_face,
    }


def _symmetric(resultants: Values, name: str) -> np.ndarray:
    """A tensor of its rows, (element_count, 2, 2)."""
    t11, t12, t22 = (resultants[f"{name}{ending}"] for ending in ("11", "12", "22"))
    return np.stack([np.stack([t11, t12], axis=1), np.stack([t12, t22], axis=1)], axis=1)


def _of_moment(x: Convected, moment: np.ndarray) -> np.ndarray:
    """T of a moment dpsi/dgamma (docs/theory.md, section 3)."""
    m11, m12, m22 = x.metric[:, 0, 0], x.metric[:, 0, 1], x.metric[:, 1, 1]
    t12 = moment / x.area_ratio
    return _symmetric({"t11": -t12 * m12 / m11, "t12": t12, "t22": -t12 * m12 / m22}, "t")


def _of_transverse_shear(x: Convected, force: np.ndarray, stiffness: float) -> np.ndarray:
    """T_s of transverse shear forces Q = J G_s g raised (docs/theory.md, section 4)."""
    if stiffness == 0.0:
        return np.zeros_like(x.metric)
    raised = force / (stiffness * x.area_ratio)[:, None]
    energy = 0.5 * np.einsum("ea,eab,eb->e", force, x.metric, raised)
    inverse = np.linalg.inv(x.metric)
    return energy[:, None, None] * inverse - force[:, :, None] * raised[:, None, :]
