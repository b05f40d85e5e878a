"""Bending per yarn family, with constant stiffnesses or measured moment-curvature curves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, SerializeAsAny, Tag, model_validator

from ...checks import NotNegative
from ...ranges import Quantity, argument
from ..device_form import DeviceForm, Tabulated
from .curve import BendingCurve, FamilyBending
from .isotropic import IsotropicBending
from .law import BendingLaw, YarnName


def _constant_or_curve(value: Any) -> str:
    return "curve" if isinstance(value, Mapping | FamilyBending) else "constant"


Family = Annotated[
    Annotated[NotNegative, Quantity("bending stiffness"), Tag("constant")]
    | Annotated[SerializeAsAny[FamilyBending], Tag("curve")],
    Discriminator(_constant_or_curve),
]


class YarnBending(BendingLaw):
    """Bending per yarn family and unit width: a constant stiffness or a moment-curvature curve for each family."""

    warp: Family = Field(description="D_1, or a curve [N m]")
    weft: Family = Field(description="D_2, or a curve [N m]")
    twist: Annotated[NotNegative, Quantity("bending stiffness")] = Field(
        description="D_12, half the twisting moment over the tensor component kappa_12 (half the engineering twist); "
        "of a plate G t^3/12 with G = stress over angle [N m]"
    )
    coupling: Annotated[float, Quantity("bending stiffness")] = Field(
        default=0.0, allow_inf_nan=False, description="D_nu between the two curvatures [N m]"
    )

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if isinstance(self.warp, FamilyBending) or isinstance(self.weft, FamilyBending):
            if self.coupling != 0.0:
                raise ValueError(f"coupling = {self.coupling:.4g} N m: must be 0 if a family has a curve")
        elif self.coupling**2 > self.warp * self.weft:
            raise ValueError(
                f"coupling = {self.coupling:.4g} N m: its square may not exceed warp * weft, or bending releases energy"
            )
        return self

    @property
    def curved(self) -> bool:
        """True if a family has a curve."""
        return isinstance(self.warp, FamilyBending) or isinstance(self.weft, FamilyBending)

    @property
    def families(self) -> tuple[FamilyBending, FamilyBending]:
        """Warp and weft, constants as straight curves."""
        warp, weft = (
            family if isinstance(family, FamilyBending) else BendingCurve.straight(family)
            for family in (self.warp, self.weft)
        )
        return warp, weft

    def stiffness_scale(self, thickness: float) -> float:
        return 0.5 * sum(
            family.typical_stiffness if isinstance(family, FamilyBending) else family
            for family in (self.warp, self.weft)
        )

    def largest_stiffness(self, thickness: float) -> float:
        families = max(
            family.largest_stiffness if isinstance(family, FamilyBending) else family
            for family in (self.warp, self.weft)
        )
        return families + abs(self.coupling) + 2.0 * self.twist

    def strip_stiffness(self, yarn: YarnName, thickness: float) -> float:
        along, across = (self.warp, self.weft) if yarn == "warp" else (self.weft, self.warp)
        if isinstance(along, FamilyBending):
            return along.initial_stiffness
        # no coupling if the family across has a curve
        if isinstance(across, FamilyBending) or not self.coupling:
            return along
        return along - self.coupling**2 / across

    def bends_linearly(self, yarn: YarnName) -> bool:
        along = self.warp if yarn == "warp" else self.weft
        return not isinstance(along, FamilyBending) or along.is_constant

    @property
    def trusted_curvature(self) -> tuple[float | None, float | None]:
        warp, weft = self.families
        return warp.trusted_curvature, weft.trusted_curvature

    @property
    def friction_limit(self) -> tuple[float, float]:
        warp, weft = self.families
        return warp.friction_limit, weft.friction_limit

    @property
    def friction_stiffness(self) -> tuple[float, float]:
        warp, weft = self.families
        return warp.friction_stiffness, weft.friction_stiffness

    def device_form(self, thickness: float) -> DeviceForm:
        warp, weft = self.families
        constants = {"twist_stiffness": self.twist}
        if self.curved:
            curves = {"warp_curve": Tabulated(warp.moment, warp.end), "weft_curve": Tabulated(weft.moment, weft.end)}
            return DeviceForm("weavesim.kernels.laws.bending_curves", constants, curves)
        constants |= {"warp_stiffness": warp.initial_stiffness, "weft_stiffness": weft.initial_stiffness}
        return DeviceForm("weavesim.kernels.laws.yarn_bending", constants | {"coupling_stiffness": self.coupling})

    @classmethod
    def from_moduli(cls, modulus: float, poisson_ratio: float, shear_modulus: float, thickness: float) -> YarnBending:
        """Equation (6) along the yarns, with a separate shear modulus.

        Args:
            modulus: E of the sheet in bending [Pa].
            poisson_ratio: nu of the sheet in bending.
            shear_modulus: G, stress over angle (tau = G gamma, the engineering strain), as for the transverse shear of
                a fabric [Pa]: D_12 = G t^3/12, and a twist w = c x y has the moment M_12 = G t^3/6 c per width.
                G = E / (2 (1 + nu)) makes a flat sheet isotropic; ``IsotropicBending`` stays so when it is sheared.
            thickness: of the sheet [m].
        """
        shear_modulus = argument("shear_modulus", shear_modulus, "shear modulus", zero=True)
        thickness = argument("thickness", thickness, "sheet thickness")
        stiffness = IsotropicBending(modulus=modulus, poisson_ratio=poisson_ratio).stiffness(thickness)
        return cls(
            warp=stiffness,
            weft=stiffness,
            coupling=poisson_ratio * stiffness,
            twist=shear_modulus * thickness**3 / 12.0,
        )
