"""Bending of the sheet: isotropic, or per yarn family with constant stiffness or measured moment-curvature curves."""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from ..checks import NotNegative, Parameters, positive_number
from .curve import Column, check_curve, interpolate, measured_columns


class IsotropicBending(Parameters):
    """Equations (5) and (6): an isotropic plate in the current tangent plane, decoupled from the membrane."""

    modulus: NotNegative = Field(description="E of the sheet in bending (not that of the yarns) [Pa]")
    poisson_ratio: float = Field(default=0.0, gt=-1.0, lt=0.5)

    def stiffness(self, thickness: float) -> float:
        """D = E t^3 / 12 (1 - nu^2) [N m]."""
        return self.modulus * thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))


class BendingCurve(Parameters):
    """Moment per width over curvature of one yarn family, odd, with friction between the fibres beside it.

    The moment is M(kappa) + M_f, where M_f = friction_stiffness (kappa - slip) keeps within the friction limit because
    the slip follows: bending starts with the slope of both, softens to that of M alone, and unloads along a loop whose
    height is twice the limit. What slipping loses is booked.

    Attributes:
        curvature: increasing curvatures from 0 [1/m].
        moment_values: M at these [N] (moment per width, N m/m); beyond the last, its end slope goes on.
        friction_limit: largest friction moment [N].
        friction_stiffness: slope that friction adds before it slips [N m].
    """

    curvature: tuple[float, ...]
    moment_values: tuple[float, ...]
    friction_limit: NotNegative = 0.0
    friction_stiffness: NotNegative = 0.0

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.curvature, self.moment_values, ("curvatures", "moments"), from_zero=True)
        if min(self.moment_values) < 0.0:
            raise ValueError("moments must not be negative: bending may not release energy")
        if self.friction_limit > 0.0 and self.friction_stiffness == 0.0:
            raise ValueError(
                f"friction_limit = {self.friction_limit:.4g} N needs a friction_stiffness [N m]: the slope before slip"
            )
        return self

    @classmethod
    def straight(cls, stiffness: float) -> BendingCurve:
        """A constant bending stiffness per width [N m]."""
        return cls(curvature=(0.0, 1.0), moment_values=(0.0, stiffness))

    @classmethod
    def from_loading_and_unloading(
        cls,
        curvature: Column,
        loading: Column,
        unloading: Column,
        *,
        friction_stiffness: float,
    ) -> BendingCurve:
        """A measured loop: its middle is the elastic curve, half its mean height the friction limit.

        Args:
            curvature: from 0 [1/m].
            loading, unloading: moments per width at these curvatures on the way up and down [N].
            friction_stiffness: initial slope of the test minus that of the middle [N m].

        Raises:
            InputError: columns of unequal lengths or no numbers, or an unloading above the loading.
        """
        curvature, up, down = measured_columns(curvature=curvature, loading=loading, unloading=unloading)
        middle = 0.5 * (up + down)
        middle = np.maximum(middle - middle[0], 0.0)
        return cls(
            curvature=tuple(curvature), moment_values=tuple(middle),
            friction_limit=float(np.mean(0.5 * (up - down)[1:])), friction_stiffness=friction_stiffness,
        )  # fmt: skip

    @classmethod
    def from_kawabata(cls, rigidity: float, hysteresis: float, *, slip_curvature: float = 10.0) -> BendingCurve:
        """The two numbers of the Kawabata pure-bending test (KES-FB2): M = B kappa with a loop of height 2HB.

        Args:
            rigidity: B, the slope [N m] (moment per width over curvature).
            hysteresis: 2HB, the height of the loop [N].
            slip_curvature: curvature after which the friction slips [1/m].

        Raises:
            InputError: a slip curvature that is not above 0, or numbers that are negative.
        """
        slip_curvature = positive_number("slip_curvature", slip_curvature)
        return cls(
            curvature=(0.0, 1.0), moment_values=(0.0, rigidity),
            friction_limit=0.5 * hysteresis, friction_stiffness=0.5 * hysteresis / slip_curvature,
        )  # fmt: skip

    def moment(self, curvature: np.ndarray) -> np.ndarray:
        """Elastic moment per width [N]."""
        return np.sign(curvature) * interpolate(self.curvature, self.moment_values, np.abs(curvature))

    @property
    def is_constant(self) -> bool:
        """True for one slope without friction: moment and curvature are proportional."""
        slope = np.array(self.moment_values[1:]) / np.array(self.curvature[1:])
        return self.friction_limit == 0.0 and bool(np.ptp(slope) <= 1.0e-9 * slope.max())

    @property
    def initial_stiffness(self) -> float:
        """Slope at zero, without friction [N m]."""
        step = 1.0e-6 * self.curvature[-1]
        return float(self.moment(np.array(step)) / step)

    @property
    def largest_stiffness(self) -> float:
        """Upper bound of the slope, friction included [N m]."""
        x = np.linspace(0.0, self.curvature[-1], 2001)
        return float(np.max(np.diff(self.moment(x)) / np.diff(x))) * 1.01 + self.friction_stiffness

    @property
    def typical_stiffness(self) -> float:
        """Mean of moment over curvature along the curve, friction included [N m]."""
        x = np.linspace(0.0, self.curvature[-1], 101)[1:]
        friction = np.minimum(self.friction_stiffness * x, self.friction_limit)
        return float(np.mean((self.moment(x) + friction) / x))


class YarnBending(Parameters):
    """Bending per yarn family and unit width: constant stiffness, or a moment-curvature curve for each family."""

    warp: NotNegative | BendingCurve = Field(description="D_1 [N m], or a curve")
    weft: NotNegative | BendingCurve = Field(description="D_2 [N m], or a curve")
    twist: NotNegative = Field(description="D_12 [N m]")
    coupling: float = Field(default=0.0, allow_inf_nan=False, description="D_nu between the two curvatures [N m]")

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if isinstance(self.warp, BendingCurve) or isinstance(self.weft, BendingCurve):
            if self.coupling != 0.0:
                raise ValueError(f"coupling = {self.coupling:.4g} N m: must be 0 where a family has a curve")
        elif self.coupling**2 > self.warp * self.weft:
            raise ValueError(
                f"coupling = {self.coupling:.4g} N m: its square may not exceed warp * weft, or bending releases energy"
            )
        return self

    @property
    def curved(self) -> bool:
        """True where a family has a curve."""
        return isinstance(self.warp, BendingCurve) or isinstance(self.weft, BendingCurve)

    @property
    def families(self) -> tuple[BendingCurve, BendingCurve]:
        """Warp and weft, constants as straight curves."""
        warp, weft = (
            family if isinstance(family, BendingCurve) else BendingCurve.straight(family)
            for family in (self.warp, self.weft)
        )
        return warp, weft

    @property
    def largest(self) -> float:
        """Largest stiffness of any curvature, as a bound [N m]."""
        families = max(
            family.largest_stiffness if isinstance(family, BendingCurve) else family
            for family in (self.warp, self.weft)
        )
        return families + abs(self.coupling) + 2.0 * self.twist

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
