"""Shape functions and initial strains of the elements of a blank."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .blank import Blank


@dataclass(frozen=True)
class ElementGeometry:
    """Shape functions of every element from its initial geometry; arrays over elements, SI units."""

    gradient: np.ndarray  # (4, m): b_p1, b_p2, b_q1, b_q2
    hourglass_offset: np.ndarray  # (2, m)
    area: np.ndarray  # (m,)
    curvature: np.ndarray  # (3, m) initial
    transverse_shear: np.ndarray  # (2, m) initial
    hourglass: np.ndarray  # (3, m) initial

    @classmethod
    def of(cls, blank: Blank) -> ElementGeometry:
        """Of the elements of a blank as it is at the start."""
        x = blank.node_position[blank.quads]
        d = blank.initial_director[blank.quads]
        frame = np.stack([blank.warp_direction, blank.weft_direction], axis=1)
        diagonals = np.stack([x[:, 0] - x[:, 2], x[:, 1] - x[:, 3]], axis=1)
        flat = np.einsum("eik,ejk->eij", diagonals, frame)  # rows p, q; columns warp, weft
        area = 0.5 * (flat[:, 0, 0] * flat[:, 1, 1] - flat[:, 0, 1] * flat[:, 1, 0])
        inverse = np.linalg.inv(flat)  # [[b_p1, b_q1], [b_p2, b_q2]]
        b_p, b_q = inverse[:, :, 0], inverse[:, :, 1]
        sign = np.array([1.0, -1.0, 1.0, -1.0])
        odd = np.einsum("i,eik,ejk->ej", sign, x, frame)
        c_p, c_q = np.einsum("ej,ej->e", b_p, odd), np.einsum("ej,ej->e", b_q, odd)

        def vectors(v):
            p, q = v[:, 0] - v[:, 2], v[:, 1] - v[:, 3]
            along = b_p[:, :, None] * p[:, None] + b_q[:, :, None] * q[:, None]
            hourglass = np.einsum("i,eik->ek", sign, v) - c_p[:, None] * p - c_q[:, None] * q
            return along, v.mean(axis=1), hourglass

        a, _, x_hourglass = vectors(x)
        d_along, mean_director, d_hourglass = vectors(d)
        k = np.einsum("eik,ejk->eij", a, d_along)
        return cls(
            gradient=np.stack([b_p[:, 0], b_p[:, 1], b_q[:, 0], b_q[:, 1]]),
            hourglass_offset=np.stack([c_p, c_q]),
            area=area,
            curvature=np.stack([k[:, 0, 0], 0.5 * (k[:, 0, 1] + k[:, 1, 0]), k[:, 1, 1]]),
            transverse_shear=np.einsum("eik,ek->ie", a, mean_director),
            hourglass=np.stack([
                0.25 * np.einsum("ek,ek->e", x_hourglass, mean_director),
                *np.einsum("eik,ek->ie", a, d_hourglass),
            ]),
        )  # fmt: skip

    @property
    def largest_size(self) -> float:
        """Of an element, as the square root of its area [m]."""
        return math.sqrt(self.area.max())

    @property
    def flat(self) -> bool:
        """True where every initial strain is zero to round-off."""
        length = self.largest_size
        return bool(
            np.abs(self.curvature).max() * length < 1e-12
            and np.abs(self.transverse_shear).max() < 1e-12
            and np.abs(self.hourglass).max() < 1e-12 * max(length, 1.0)
        )

    @property
    def squared_gradients(self) -> tuple[np.ndarray, np.ndarray]:
        """Sum over the corners of N_,1^2 and N_,2^2, (m,) each [1/m^2]."""
        b = self.gradient
        return 2.0 * (b[0] ** 2 + b[2] ** 2), 2.0 * (b[1] ** 2 + b[3] ** 2)

    @property
    def largest_gradient(self) -> np.ndarray:
        """Largest eigenvalue of the sums over the corners of N_,alpha N_,beta, (m,) [1/m^2]."""
        b11, b22 = self.squared_gradients
        b12 = 2.0 * (self.gradient[0] * self.gradient[1] + self.gradient[2] * self.gradient[3])
        return 0.5 * (b11 + b22) + np.hypot(0.5 * (b11 - b22), b12)

    @property
    def squared_hourglass(self) -> np.ndarray:
        """Sum over the corners of the squared hourglass vector, (m,)."""
        return 4.0 + 2.0 * np.square(self.hourglass_offset).sum(axis=0)

    @property
    def squared_twist_weights(self) -> np.ndarray:
        """Sum of the squares of (p p - q q)/16, which gives the natural twist from the curvatures, (m,) [m^4]."""
        b_p1, b_p2, b_q1, b_q2 = self.gradient
        square = np.square(b_p1 * b_q2 - b_p2 * b_q1)
        p, q, mixed = b_q1**2 + b_q2**2, b_p1**2 + b_p2**2, b_p1 * b_q1 + b_p2 * b_q2
        return (p**2 + q**2 - 2.0 * mixed**2) / (256.0 * square**2)
