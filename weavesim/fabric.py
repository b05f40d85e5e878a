"""Fabrics: physical parameters with their sources, checked when they are made."""

from __future__ import annotations

import math
from typing import Literal, Self

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from .cells import Cell as Cell
from .cells import EnergyCell as EnergyCell
from .cells import LinearMembrane as LinearMembrane
from .cells import SatinWeave as SatinWeave
from .cells import TwillWeave as TwillWeave
from .cells import UnidirectionalTape as UnidirectionalTape
from .cells import UnitCell as UnitCell
from .parameters import NotNegative as NotNegative
from .parameters import Parameters as Parameters
from .parameters import Positive as Positive

# No law may resist locking harder than this share of a yarn's stiffness per width: it enters the stable time step.
LARGEST_LOCKING_SHARE = 0.1
SHEAR_KNOT_COUNT = 512


class LinearShear(Parameters):
    """The paper's law, equation (4): S_12 = G_12 E_12 with the tensor component E_12 of the Green-Lagrange strain.

    At small angles the stress is therefore G_12 gamma / 2: a modulus meant as tau/gamma has to be doubled here.
    """

    modulus: NotNegative = Field(description="G_12 of equation (4) [Pa]")

    def moment(self, angle: np.ndarray, thickness: float) -> np.ndarray:
        """m(gamma) = dpsi/dgamma at unit stretch, t/2 G_12 sin(gamma) cos(gamma) [N/m]."""
        return 0.5 * thickness * self.modulus * np.sin(angle) * np.cos(angle)


class MomentCurve(Parameters):
    """Shear moment per reference area m(gamma) [N/m] as a curve, odd in gamma, with a locking branch.

    Attributes:
        angle: increasing angles from 0 [rad].
        moment: m at these angles, without locking [N/m]; beyond the last angle its end slope (never negative) goes on.
        locking_angle: where the locking branch begins [rad].
        locking_stiffness: slope dm/dgamma that locking adds, at most a tenth of the yarn stiffness per width [N/m].
        locking_width: angle over which that slope builds up [rad].
    """

    angle: tuple[float, ...]
    moment_values: tuple[float, ...]
    locking_angle: Positive = math.radians(60.0)
    locking_stiffness: NotNegative = 0.0
    locking_width: Positive = math.radians(5.0)

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        angle, moment = np.array(self.angle), np.array(self.moment_values)
        if len(angle) < 2 or len(angle) != len(moment):
            raise ValueError(f"{len(angle)} angles and {len(moment)} moments: two or more of each, as many, are needed")
        if not (np.all(np.isfinite(angle)) and np.all(np.isfinite(moment))):
            raise ValueError("angles and moments must be finite")
        if angle[0] != 0.0 or moment[0] != 0.0 or np.any(np.diff(angle) <= 0.0) or angle[-1] > math.pi / 2:
            raise ValueError("angles must start at 0 (with moment 0), increase, and stay below pi/2 rad")
        return self

    @classmethod
    def from_stress_polynomial(
        cls,
        tangent_coefficients: tuple[float, ...],
        thickness: float,
        *,
        convention: Literal["yarn frame", "moment"] = "yarn frame",
        trusted_angle: float = math.radians(55.0),
        **locking: float,
    ) -> MomentCurve:
        """A published d tau / d gamma = c_0 + c_1 gamma + ... [Pa], gamma in rad.

        convention "yarn frame": tau is a nominal shear stress over the yarn's current frame, m = t tau cos(gamma);
        "moment": m = t tau. Beyond ``trusted_angle`` the curve goes on along its end slope.
        """
        angle = np.linspace(0.0, trusted_angle, 221)
        stress = np.polynomial.Polynomial(tangent_coefficients).integ()(angle)
        factor = np.cos(angle) if convention == "yarn frame" else 1.0
        return cls(angle=tuple(angle), moment_values=tuple(thickness * stress * factor), **locking)

    def moment(self, angle: np.ndarray, thickness: float = 0.0) -> np.ndarray:
        """m(gamma) [N/m], locking included."""
        size = np.abs(angle)
        knots, values = np.array(self.angle), np.array(self.moment_values)
        slope = _monotone_slopes(knots, values)
        i = np.clip(np.searchsorted(knots, size, side="right") - 1, 0, len(knots) - 2)
        h = knots[i + 1] - knots[i]
        s = np.minimum(size - knots[i], h) / h
        inside = (
            values[i] * (1 + 2 * s) * (1 - s) ** 2
            + h * slope[i] * s * (1 - s) ** 2
            + values[i + 1] * s**2 * (3 - 2 * s)
            + h * slope[i + 1] * s**2 * (s - 1)
        )
        beyond = np.maximum(size - knots[-1], 0.0) * max(slope[-1], 0.0)
        x = np.maximum(size - self.locking_angle, 0.0)
        width = self.locking_width
        locking = self.locking_stiffness * np.where(x < width, x**2 / (2.0 * width), x - 0.5 * width)
        return np.sign(angle) * (inside + beyond + locking)


def _monotone_slopes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Slopes of a cubic Hermite curve: three-point differences, second order also at the ends."""
    return np.gradient(y, x, edge_order=2 if len(x) > 2 else 1)


class IsotropicBending(Parameters):
    """Equations (5) and (6): an isotropic plate in the current tangent plane, decoupled from the membrane."""

    modulus: NotNegative = Field(description="E of the sheet in bending (not that of the yarns) [Pa]")
    poisson_ratio: float = Field(default=0.0, gt=-1.0, lt=0.5)

    def stiffness(self, thickness: float) -> float:
        """D = E t^3 / 12 (1 - nu^2) [N m]."""
        return self.modulus * thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))


class YarnBending(Parameters):
    """Bending stiffness of each yarn family, per unit width."""

    warp: NotNegative = Field(description="D_1 [N m]")
    weft: NotNegative = Field(description="D_2 [N m]")
    twist: NotNegative = Field(description="D_12 [N m]")
    coupling: float = Field(default=0.0, allow_inf_nan=False, description="D_nu between the two curvatures [N m]")

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if self.coupling**2 > self.warp * self.weft:
            raise ValueError(
                f"coupling = {self.coupling:.4g} N m: its square may not exceed warp * weft, or bending releases energy"
            )
        return self

    @property
    def largest(self) -> float:
        """Largest stiffness of any curvature, as a bound [N m]."""
        return max(self.warp, self.weft) + abs(self.coupling) + 2.0 * self.twist

    @classmethod
    def from_moduli(cls, modulus: float, poisson_ratio: float, shear_modulus: float, thickness: float) -> YarnBending:
        """Equation (6) along the yarns, with a shear modulus G of its own: sigma_12 = G eps_12, eps_12 the tensor's.

        G = E/(1 + nu) would make the sheet isotropic; ``IsotropicBending`` does that in the current tangent plane.
        """
        stiffness = IsotropicBending(modulus=modulus, poisson_ratio=poisson_ratio).stiffness(thickness)
        return cls(
            warp=stiffness,
            weft=stiffness,
            coupling=poisson_ratio * stiffness,
            twist=shear_modulus * thickness**3 / 24.0,
        )


class Stabilisation(Parameters):
    """Shares of the exact stiffness of the hourglass modes; constants of a run.

    The in-plane share is of the shear stiffness, never of the yarns': a sheet that shears almost freely would else be
    locked by its own stabilisation. The warping mode is measured without the twist, so that a pure twist costs nothing.
    """

    in_plane: NotNegative = 0.1
    warping: NotNegative = 0.1
    director: NotNegative = 0.1


class Fabric(Parameters):
    """A woven fabric as the sheet sees it.

    Attributes:
        assumed: names of the values that no source gives; a report labels them so.
    """

    name: str
    areal_density: Positive = Field(description="[kg/m^2]")
    thickness: Positive = Field(description="[m]")
    unit_cell: SerializeAsAny[Cell]
    shear: LinearShear | MomentCurve
    bending: IsotropicBending | YarnBending
    transverse_shear_modulus: NotNegative = Field(description="G of equation (6) across the sheet [Pa]")
    in_plane_bending_stiffness: NotNegative = Field(
        default=0.0,
        description="B of psi = 1/2 B |grad gamma|^2: yarns resist being bent in the plane, so that the shear angle "
        "cannot jump from element to element [N m]",
    )
    compressive_stiffness: NotNegative = Field(
        default=0.0,
        description="of the sheet itself along yarns that are pushed together, beside the unit cell's [N/m]",
    )
    stabilisation: Stabilisation = Stabilisation()
    source: str = ""
    assumed: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _locking_is_bounded(self) -> Self:
        largest = LARGEST_LOCKING_SHARE * min(self.unit_cell.yarn_stiffness_per_width)
        if isinstance(self.shear, MomentCurve) and self.shear.locking_stiffness > largest * (1 + 1e-9):
            raise ValueError(
                f"locking_stiffness = {self.shear.locking_stiffness:.4g} N/m: at most {largest:.4g} N/m, a tenth of "
                "the yarn stiffness per width, is allowed (it enters the stable time step)"
            )
        return self

    @property
    def shear_stiffness_scale(self) -> float:
        """Typical shear stiffness [N/m], for the in-plane stabilisation: the mean of m/gamma up to 45 degrees."""
        angle = np.linspace(0.0, math.pi / 4, 46)[1:]
        return float(np.mean(self.shear.moment(angle, self.thickness) / angle))

    @property
    def bending_stiffness_scale(self) -> float:
        """Typical bending stiffness [N m] that the director stabilisation scales with."""
        if isinstance(self.bending, IsotropicBending):
            return self.bending.stiffness(self.thickness)
        return 0.5 * (self.bending.warp + self.bending.weft)

    @property
    def transverse_shear_stiffness(self) -> float:
        """G_s = 5/6 G t [N/m]."""
        return 5.0 / 6.0 * self.transverse_shear_modulus * self.thickness

    def with_linear_shear(self, modulus: float) -> Fabric:
        """The same fabric with the paper's linear shear law."""
        return self.model_copy(update={"shear": LinearShear(modulus=modulus)})


def glass_polypropylene(
    *, convention: Literal["yarn frame", "moment"] = "yarn frame", locking_angle: float = math.radians(60.0)
) -> Fabric:
    """Commingled glass/polypropylene plain weave, as in the double-dome benchmark.

    Areal density, thickness, pitch, yarn stiffness and the shear curve: published, second-hand (Aridhi et al. 2019,
    credited there to Cao et al. 2008). Crimp, contact stiffness, yarn bending and sheet bending are assumed.
    """
    thickness = 1.2e-3
    pitch = 5.2e-3
    yarn_stiffness = 31.8e3
    cross_section = 1.0e-6  # only the products E A and E I matter
    modulus = yarn_stiffness / cross_section
    bending_modulus = 20.0e6  # of the sheet [Pa]; pushed together along its yarns it is as stiff
    yarn_bending = 1.5e-5  # E I [N m^2], as stiff as the sheet's bending over one pitch
    return Fabric(
        name="glass/polypropylene plain weave",
        areal_density=0.743,
        thickness=thickness,
        unit_cell=UnitCell(
            warp_modulus=modulus, weft_modulus=modulus, contact_modulus=10.0e6,
            warp_cross_section=cross_section, weft_cross_section=cross_section, contact_cross_section=1.6e-5,
            warp_second_moment=yarn_bending / modulus, weft_second_moment=yarn_bending / modulus,
            warp_half_spacing=0.5 * pitch, weft_half_spacing=0.5 * pitch, crossover_height=0.6e-3,
        ),
        shear=MomentCurve.from_stress_polynomial(
            (0.051e6, -0.83e6, 6.1275e6, -12.0972e6, 8.48e6), thickness, convention=convention,
            locking_angle=locking_angle, locking_stiffness=LARGEST_LOCKING_SHARE * yarn_stiffness / pitch * 0.1,
        ),
        bending=IsotropicBending(modulus=bending_modulus, poisson_ratio=0.0),
        transverse_shear_modulus=10.0e6, compressive_stiffness=bending_modulus * thickness,
        in_plane_bending_stiffness=5.0e-3,
        source="Aridhi et al. 2019, credited there to Cao et al. 2008 (shear curve, density, thickness, pitch, E A)",
        assumed=("crimp", "contact stiffness", "yarn bending", "sheet bending", "transverse shear", "compression",
            "in-plane bending", "locking",
        ),
    )  # fmt: skip


PRESETS = {"glass-polypropylene": glass_polypropylene}
