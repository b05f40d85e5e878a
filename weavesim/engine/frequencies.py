"""Highest frequencies of the elements of a sheet before it moves, and the stabilisation that they depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fabric.fabric import Fabric, Stabilisation
from ..sheet.geometry import ElementGeometry

# The rotary inertia is scaled up until bending and transverse shear reach at most this share of the membrane's omega^2.
ROTARY_SHARE = 0.05


@dataclass(frozen=True)
class Frequencies:
    """State-independent parts of each element's highest squared frequency [1/s^2], for the stable step."""

    straight: np.ndarray  # membrane with straight yarns: a safe bound for any crimped state
    constant: np.ndarray  # bending, transverse shear, stabilisation
    rotary_radius_squared: np.ndarray  # scaled rotary inertia per mass [m^2]

    @classmethod
    def of(
        cls, fabric: Fabric, stabilisation: Stabilisation, geometry: ElementGeometry, areal_density: np.ndarray
    ) -> Frequencies:
        """Of the elements of a sheet of ``fabric``; ``areal_density`` is (m,) [kg/m^2], with added mass."""
        b11, b22 = geometry.squared_gradients
        b = b11 + b22
        c1, c2 = fabric.unit_cell.yarn_stiffness_per_width
        gamma = geometry.squared_hourglass
        in_plane, warping, director = hourglass_coefficients(fabric, stabilisation)
        transverse = fabric.transverse_shear_stiffness
        bending = 4.0 * fabric.largest_bending_stiffness * b
        shear = fabric.shear_stiffness_scale + fabric.unit_cell.shear_stiffness
        straight = 4.0 / areal_density * (np.maximum(c1 * b11, c2 * b22) + 2.0 * shear * b)
        yarns_in_plane = 2.0 * 4.0 * fabric.in_plane_bending_stiffness / geometry.area
        turning = transverse + bending + 4.0 * (director * gamma + warping * geometry.squared_twist_weights * b) * b
        radius = np.maximum(fabric.thickness**2 / 12.0, turning / (areal_density * ROTARY_SHARE * straight))
        constant = 4.0 / areal_density * (
            (transverse + fabric.compressive_stiffness + yarns_in_plane) * b
            + in_plane * b * gamma
            + warping * b * gamma / 16.0
        ) + turning / (areal_density * radius)
        return cls(straight, constant, radius)


def hourglass_coefficients(fabric: Fabric, share: Stabilisation) -> tuple[float, float, float]:
    """Factors of the sum of squared gradients in the hourglass energies (docs/theory.md, section 5).

    In-plane, warping, director. On a square, the exact stiffness of the first two modes is G/24 and 4/3 G_s times that
    sum; for the third, bending along one yarn contributes D/24 times it.
    """
    return (
        share.in_plane * fabric.shear_stiffness_scale / 24.0,
        share.warping * fabric.transverse_shear_stiffness * 4.0 / 3.0,
        share.director * fabric.bending_stiffness_scale / 24.0,
    )
