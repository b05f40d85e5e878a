"""Fabrics: physical parameters with their sources, checked when they are made."""

from __future__ import annotations

import math
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from .bending import BendingCurve, IsotropicBending, YarnBending
from .parameters import NotNegative, Parameters, Positive, Share
from .shear import LinearShear, MomentCurve, ShearFriction

# No law may resist locking or slip harder than this share of a yarn's stiffness per width: it enters the stable step.
LARGEST_LOCKING_SHARE = 0.1


class UnitCell(Parameters):
    """Plain-weave unit cell of crossed beams: the paper's parameters, and four of our own with defaults.

    A yarn's compressive stiffness E A_c defaults to the Euler-like 3 E I / l0^2: a yarn pushed together is a buckled
    bundle, and a stiffer one gives the cell several equilibria (``warnings`` tells).
    """

    warp_modulus: Positive = Field(description="Young's modulus of the warp yarn [Pa]")
    weft_modulus: Positive = Field(description="Young's modulus of the weft yarn [Pa]")
    contact_modulus: Positive = Field(description="Young's modulus E_3 of the contact element [Pa]")
    warp_cross_section: Positive = Field(description="cross-section of the warp yarn [m^2]")
    weft_cross_section: Positive = Field(description="cross-section of the weft yarn [m^2]")
    contact_cross_section: Positive = Field(
        description="cross-section A_3 of the contact element of the half cell [m^2]"
    )
    warp_second_moment: NotNegative = Field(description="second moment of area of the warp yarn [m^4]")
    weft_second_moment: NotNegative = Field(description="second moment of area of the weft yarn [m^4]")
    warp_half_spacing: Positive = Field(description="L_1, half distance between crossovers along the warp [m]")
    weft_half_spacing: Positive = Field(description="L_2, half distance between crossovers along the weft [m]")
    crossover_height: NotNegative = Field(description="L_3 = h_1 + h_2, distance of the yarn axes at the crossover [m]")
    warp_crimp_share: Share = Field(default=0.5, description="h_1 / L_3")
    warp_compressive_stiffness: NotNegative | None = Field(default=None, description="E A_c of the warp [N]")
    weft_compressive_stiffness: NotNegative | None = Field(default=None, description="E A_c of the weft [N]")
    contact: Literal["bilateral", "unilateral"] = Field(default="bilateral", description="may the yarns separate?")
    contact_stiffness_value: Positive | None = Field(
        default=None, description="E_3 A_3 / L_3 [N/m] given directly; needed where L_3 = 0"
    )

    @model_validator(mode="after")
    def _contact_is_defined(self) -> Self:
        if self.crossover_height == 0.0 and self.contact_stiffness_value is None:
            raise ValueError("crossover_height = 0 leaves E_3 A_3 / L_3 undefined: give contact_stiffness_value [N/m]")
        return self

    @property
    def half_spacing(self) -> tuple[float, float]:
        return self.warp_half_spacing, self.weft_half_spacing

    @property
    def crimp_height(self) -> tuple[float, float]:
        return self.warp_crimp_share * self.crossover_height, (1.0 - self.warp_crimp_share) * self.crossover_height

    @property
    def chord_length(self) -> tuple[float, float]:
        """l0 of warp and weft [m]."""
        return tuple(math.hypot(L, h) for L, h in zip(self.half_spacing, self.crimp_height, strict=True))

    @property
    def axial_stiffness(self) -> tuple[float, float]:
        """E A of warp and weft in tension [N]."""
        return self.warp_modulus * self.warp_cross_section, self.weft_modulus * self.weft_cross_section

    @property
    def bending_stiffness(self) -> tuple[float, float]:
        """E I of warp and weft [N m^2]."""
        return self.warp_modulus * self.warp_second_moment, self.weft_modulus * self.weft_second_moment

    @property
    def euler_stiffness(self) -> tuple[float, float]:
        """3 E I / l0^2 of warp and weft [N], the largest compressive stiffness known to leave one equilibrium."""
        return tuple(3.0 * EI / l0**2 for EI, l0 in zip(self.bending_stiffness, self.chord_length, strict=True))

    @property
    def compressive_stiffness(self) -> tuple[float, float]:
        """E A_c of warp and weft [N]."""
        given = (self.warp_compressive_stiffness, self.weft_compressive_stiffness)
        return tuple(e if g is None else g for g, e in zip(given, self.euler_stiffness, strict=True))

    @property
    def contact_stiffness(self) -> float:
        """E_3 A_3 / L_3 of the half cell [N/m]."""
        if self.contact_stiffness_value is not None:
            return self.contact_stiffness_value
        return self.contact_modulus * self.contact_cross_section / self.crossover_height

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        """E A over the spacing of the yarns: membrane stiffness of straight yarns [N/m]."""
        return (
            self.axial_stiffness[0] / (2.0 * self.weft_half_spacing),
            self.axial_stiffness[1] / (2.0 * self.warp_half_spacing),
        )

    def warnings(self) -> list[str]:
        """What a user should know before trusting this cell."""
        return [
            f"compressive stiffness of the {name} is {given:.4g} N, above the Euler-like {euler:.4g} N: the cell may "
            "have several equilibria; the branch from stretch 1 is followed and what a snap frees is booked"
            for name, given, euler in zip(
                ("warp", "weft"), self.compressive_stiffness, self.euler_stiffness, strict=True
            )
            if given > euler * (1.0 + 1.0e-9)
        ]

    @classmethod
    def straight(cls, *, stiffness_per_width: float, spacing: float = 0.005, bending: float = 0.0) -> UnitCell:
        """Two straight, uncoupled yarn families of equal tensile and compressive stiffness: a linear membrane.

        Args:
            stiffness_per_width: E A over the yarn spacing [N/m].
            spacing: distance of the yarns [m].
            bending: E I of a yarn [N m^2].
        """
        axial = stiffness_per_width * spacing
        return cls(
            warp_modulus=axial, weft_modulus=axial, contact_modulus=1.0,
            warp_cross_section=1.0, weft_cross_section=1.0, contact_cross_section=1.0,
            warp_second_moment=bending / axial, weft_second_moment=bending / axial,
            warp_half_spacing=0.5 * spacing, weft_half_spacing=0.5 * spacing, crossover_height=0.0,
            warp_compressive_stiffness=axial, weft_compressive_stiffness=axial,
            contact_stiffness_value=axial / spacing,
        )  # fmt: skip


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
    unit_cell: UnitCell
    shear: LinearShear | MomentCurve
    shear_friction: ShearFriction | None = None
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
        if self.shear_friction is not None and self.shear_friction.stiffness > largest * (1 + 1e-9):
            raise ValueError(
                f"shear_friction.stiffness = {self.shear_friction.stiffness:.4g} N/m: at most {largest:.4g} N/m, a "
                "tenth of the yarn stiffness per width, is allowed (it enters the stable time step)"
            )
        return self

    @property
    def has_inner_friction(self) -> bool:
        """True where yarns or fibres slip on each other inside the sheet, which then has a history."""
        bending = self.bending
        return self.shear_friction is not None or (
            isinstance(bending, YarnBending) and any(family.friction_limit > 0.0 for family in bending.families)
        )

    @property
    def shear_stiffness_scale(self) -> float:
        """Typical shear stiffness [N/m], for the in-plane stabilisation: the mean of m/gamma up to 45 degrees."""
        angle = np.linspace(0.0, math.pi / 4, 46)[1:]
        moment = self.shear.moment(angle, self.thickness)
        if self.shear_friction is not None:
            moment = moment + self.shear_friction.moment_along(angle)
        return float(np.mean(moment / angle))

    @property
    def bending_stiffness_scale(self) -> float:
        """Typical bending stiffness [N m] that the director stabilisation scales with."""
        if isinstance(self.bending, IsotropicBending):
            return self.bending.stiffness(self.thickness)
        return 0.5 * sum(
            family.typical_stiffness if isinstance(family, BendingCurve) else family
            for family in (self.bending.warp, self.bending.weft)
        )

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
