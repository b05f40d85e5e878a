"""Unit cells of crossed yarns: plain weave, twill, satin (docs/theory.md, section 2)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ...checks import NotNegative, Positive, Share
from ...ranges import Quantity, argument
from .contract import UNIT_CELL_TOLERANCE, EnergyCell, UnitCell

if TYPE_CHECKING:
    from ...device import Precision
    from ...kernels.cell.law import CellLaw


# Glass/polypropylene weave of the double-dome benchmark (the preset of that name cites the source).
GLASS_PITCH = 5.2e-3  # yarn spacing [m]
GLASS_YARN_STIFFNESS = 31.8e3  # E A [N]
# Smallest force over E A that a residual is compared with. Tolerance times this is at most 2e-16 E A across the yarn; a
# slightly crimped yarn multiplies it.
FORCE_FLOOR = {"float32": 1.0e-11, "float64": 1.0e-9}


class CrossedYarns(UnitCell):
    """Warp and weft beams that cross at a contact element: the paper's parameters, and four more with defaults.

    A yarn's compressive stiffness E A_c defaults to the Euler-like 3 E I / l0^2: a compressed yarn is a buckled
    bundle, and with a higher stiffness the cell may have several equilibria (``warnings`` says so).
    """

    is_kind: ClassVar[bool] = False

    warp_modulus: Annotated[Positive, Quantity("yarn modulus")] = Field(
        description="Young's modulus of the warp yarn [Pa]"
    )
    weft_modulus: Annotated[Positive, Quantity("yarn modulus")] = Field(
        description="Young's modulus of the weft yarn [Pa]"
    )
    contact_modulus: Annotated[Positive, Quantity("contact modulus")] = Field(
        description="Young's modulus E_3 of the contact element [Pa]"
    )
    warp_cross_section: Annotated[Positive, Quantity("cross-section")] = Field(
        description="cross-section of the warp yarn [m^2]"
    )
    weft_cross_section: Annotated[Positive, Quantity("cross-section")] = Field(
        description="cross-section of the weft yarn [m^2]"
    )
    contact_cross_section: Annotated[Positive, Quantity("cross-section")] = Field(
        description="cross-section A_3 of the contact element of the half cell [m^2]"
    )
    warp_second_moment: Annotated[NotNegative, Quantity("second moment")] = Field(
        description="second moment of area of the warp yarn [m^4]"
    )
    weft_second_moment: Annotated[NotNegative, Quantity("second moment")] = Field(
        description="second moment of area of the weft yarn [m^4]"
    )
    warp_half_spacing: Annotated[Positive, Quantity("yarn spacing")] = Field(
        description="L_1, half distance between crossovers along the warp [m]"
    )
    weft_half_spacing: Annotated[Positive, Quantity("yarn spacing")] = Field(
        description="L_2, half distance between crossovers along the weft [m]"
    )
    crossover_height: Annotated[NotNegative, Quantity("crossover height")] = Field(
        description="L_3 = h_1 + h_2, distance of the yarn axes at the crossover [m]"
    )
    warp_crimp_share: Share = Field(default=0.5, description="h_1 / L_3")
    warp_compressive_stiffness: Annotated[NotNegative, Quantity("yarn stiffness")] | None = Field(
        default=None, description="E A_c of the warp [N]"
    )
    weft_compressive_stiffness: Annotated[NotNegative, Quantity("yarn stiffness")] | None = Field(
        default=None, description="E A_c of the weft [N]"
    )
    contact: Literal["bilateral", "unilateral"] = Field(
        default="bilateral", description='"unilateral" lets the yarns separate'
    )
    contact_stiffness_value: Annotated[Positive, Quantity("contact stiffness")] | None = Field(
        default=None, description="E_3 A_3 / L_3 [N/m] given directly; needed where L_3 = 0"
    )

    @model_validator(mode="after")
    def _contact_is_defined(self) -> Self:
        if self.crossover_height == 0.0 and self.contact_stiffness_value is None:
            raise ValueError("crossover_height = 0 leaves E_3 A_3 / L_3 undefined: give contact_stiffness_value [N/m]")
        return self

    @classmethod
    def glass_polypropylene(cls, **changes: Any) -> Self:
        """Commingled glass/polypropylene yarns of the double-dome benchmark; ``changes`` replace values by name.

        Pitch and E A are published; crimp, contact stiffness and yarn bending are assumed.
        """
        cross_section = 1.0e-6  # only the products E A and E I matter
        modulus = GLASS_YARN_STIFFNESS / cross_section
        yarn_bending = 1.5e-5  # E I [N m^2], equal to the bending stiffness of the sheet over one pitch
        values: dict[str, Any] = {
            "warp_modulus": modulus, "weft_modulus": modulus, "contact_modulus": 10.0e6,
            "warp_cross_section": cross_section, "weft_cross_section": cross_section, "contact_cross_section": 1.6e-5,
            "warp_second_moment": yarn_bending / modulus, "weft_second_moment": yarn_bending / modulus,
            "warp_half_spacing": 0.5 * GLASS_PITCH, "weft_half_spacing": 0.5 * GLASS_PITCH, "crossover_height": 0.6e-3,
        }  # fmt: skip
        return cls(**values | changes)

    @property
    def half_spacing(self) -> tuple[float, float]:
        """L of warp and weft: half the distance of the crossovers along each [m]."""
        return self.warp_half_spacing, self.weft_half_spacing

    @property
    def crimp_height(self) -> tuple[float, float]:
        """h of warp and weft: heights of their axes at a crossover over its middle [m]."""
        return self.warp_crimp_share * self.crossover_height, (1.0 - self.warp_crimp_share) * self.crossover_height

    @property
    def chord_length(self) -> tuple[float, float]:
        """l0 of warp and weft [m]."""
        warp_height, weft_height = self.crimp_height
        return math.hypot(self.warp_half_spacing, warp_height), math.hypot(self.weft_half_spacing, weft_height)

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
        """3 E I / l0^2 of warp and weft [N], the largest compressive stiffness known to give a single equilibrium."""
        (warp, weft), (warp_length, weft_length) = self.bending_stiffness, self.chord_length
        return 3.0 * warp / warp_length**2, 3.0 * weft / weft_length**2

    @property
    def compressive_stiffness(self) -> tuple[float, float]:
        """E A_c of warp and weft [N]."""
        warp, weft = self.warp_compressive_stiffness, self.weft_compressive_stiffness
        warp_euler, weft_euler = self.euler_stiffness
        return warp_euler if warp is None else warp, weft_euler if weft is None else weft

    @property
    def contact_stiffness(self) -> float:
        """E_3 A_3 / L_3 of the half cell [N/m]."""
        if self.contact_stiffness_value is not None:
            return self.contact_stiffness_value
        return self.contact_modulus * self.contact_cross_section / self.crossover_height

    @property
    def crossover_modulus(self) -> float:
        """Two half cells of stiffness E_3 A_3 / L_3 share the area of a crossover; they flatten relative to L_3."""
        if self.crossover_height == 0.0:
            return math.inf
        return 2.0 * self.contact_stiffness * self.crossover_height / self.crossover_area

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        """E A over the spacing of the yarns: membrane stiffness of straight yarns [N/m]."""
        return (
            self.axial_stiffness[0] / (2.0 * self.weft_half_spacing),
            self.axial_stiffness[1] / (2.0 * self.warp_half_spacing),
        )

    def warnings(self) -> list[str]:
        """Warnings about this cell for the user."""
        return [
            f"compressive stiffness of the {name} is {given:.4g} N, above the Euler-like {euler:.4g} N: the cell may "
            "have several equilibria; the branch from stretch 1 is followed and what a snap frees is booked"
            for name, given, euler in zip(
                ("warp", "weft"), self.compressive_stiffness, self.euler_stiffness, strict=True
            )
            if given > euler * (1.0 + 1.0e-9)
        ]


class PlainWeave(CrossedYarns):
    """Plain-weave unit cell of crossed beams, written by hand for lanes: the paper's cell."""

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        return {
            "plain-weave": cls.glass_polypropylene,
            "plain-weave-unilateral": partial(cls.glass_polypropylene, contact="unilateral"),
        }

    def law(self) -> CellLaw:
        from ...kernels.cell.plain_weave import PLAIN_WEAVE

        return PLAIN_WEAVE

    def device_parameters(self, precision: Precision) -> Any:
        import warp as wp

        cell = self.law().parameters(precision.real)()
        vec2 = wp.types.vector(2, precision.real)
        length = np.array(self.chord_length)
        tensile, compressive = self.axial_stiffness / length, self.compressive_stiffness / length
        # the longest chord about 1, the largest stiffness about 1e9: products of three stay within single precision
        length_unit = 2.0 ** round(math.log2(length.max()))
        stiffness_unit = 2.0 ** (round(math.log2(max(*tensile, *compressive, self.contact_stiffness))) - 30)
        cell.length_unit, cell.per_length_unit, cell.stiffness_unit = length_unit, 1.0 / length_unit, stiffness_unit
        spacing = np.array(self.half_spacing) / length_unit
        cell.per_width = vec2(*(0.5 * stiffness_unit / spacing[::-1]))
        cell.per_area = 0.5 * stiffness_unit / length_unit / spacing.prod()
        cell.half_spacing = vec2(*spacing)
        cell.crimp_height = vec2(*(np.array(self.crimp_height) / length_unit))
        cell.chord_length = vec2(*(length / length_unit))
        cell.tensile_stiffness = vec2(*(tensile / stiffness_unit))
        cell.compressive_stiffness = vec2(*(compressive / stiffness_unit))
        rotation_unit = stiffness_unit * length_unit**2
        rotation = 3.0 * np.array(self.bending_stiffness) / length / rotation_unit
        cell.rotation_stiffness = vec2(*rotation)
        cell.inverse_rotation_stiffness = vec2(*(1.0 / k if k > 0.0 else 0.0 for k in rotation.tolist()))
        cell.contact_stiffness = self.contact_stiffness / stiffness_unit
        cell.unilateral = int(self.contact == "unilateral")
        cell.tolerance = UNIT_CELL_TOLERANCE[precision.value]
        cell.resolution = 2.0 * np.finfo(precision.numpy).eps
        cell.stiffness_floor = 1.0e-9 * max(self.axial_stiffness) / length.max() / stiffness_unit
        cell.force_floor = FORCE_FLOOR[precision.value] * max(self.axial_stiffness) / (stiffness_unit * length_unit)
        return cell

    @property
    def crossover_area(self) -> float:
        return 4.0 * self.warp_half_spacing * self.weft_half_spacing

    @classmethod
    def straight(cls, *, stiffness_per_width: float, spacing: float = 0.005, bending: float = 0.0) -> PlainWeave:
        """Two straight, uncoupled yarn families of equal tensile and compressive stiffness: a linear membrane.

        Args:
            stiffness_per_width: E A over the yarn spacing [N/m].
            spacing: yarn spacing [m].
            bending: E I of a yarn [N m^2].
        """
        stiffness_per_width = argument("stiffness_per_width", stiffness_per_width, "membrane stiffness")
        axial = stiffness_per_width * argument("spacing", spacing, "yarn spacing")
        # about 1 mm^2; a power of two, so that the products E A and E I are exact
        area = 2.0**-20
        return cls(
            warp_modulus=axial / area, weft_modulus=axial / area, contact_modulus=1.0e6,
            warp_cross_section=area, weft_cross_section=area, contact_cross_section=area,
            warp_second_moment=area * (bending / axial), weft_second_moment=area * (bending / axial),
            warp_half_spacing=0.5 * spacing, weft_half_spacing=0.5 * spacing, crossover_height=0.0,
            warp_compressive_stiffness=axial, weft_compressive_stiffness=axial,
            contact_stiffness_value=axial / spacing,
        )  # fmt: skip


class FloatWeave(CrossedYarns, EnergyCell):
    """A weave whose yarns float over several others: crimped beams of the plain weave, in series with straight floats.

    In a repeat of N crossovers every yarn changes sides twice; the beams are as long as in a plain weave, the other
    N - 2 crossover distances are floats. N = 2 is the plain weave. Unknowns: the scaled height changes at the crossover
    and the strains of the floats. The floats stay straight and level, which is an idealisation.
    """

    law_name: ClassVar[str] = "FloatWeave"
    unknown_count: ClassVar[int] = 4
    depends_on_shear: ClassVar[bool] = False
    part_names: ClassVar[tuple[str, ...]] = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact")

    repeat: int = Field(kw_only=True, ge=2, le=16, description="N, crossovers in a repeat along a yarn")

    def functions(self) -> dict[str, Any]:
        from ...kernels.cell.energies import floats_crossover_pressure, floats_energies

        return {"parts": floats_energies, "crossover_pressure": floats_crossover_pressure}

    def parameters(self) -> dict[str, float | tuple[float, ...]]:
        return {
            "half_spacing": self.half_spacing,
            "crimp_height": self.crimp_height,
            "chord_length": self.chord_length,
            "float_length": tuple((0.5 * self.repeat - 1.0) * spacing for spacing in self.half_spacing),
            "axial_stiffness": self.axial_stiffness,
            "compressive_stiffness": self.compressive_stiffness,
            "bending_stiffness": self.bending_stiffness,
            "contact_stiffness": self.contact_stiffness,
            "unilateral": float(self.contact == "unilateral"),
            "height_scale": max(self.crossover_height, 0.05 * min(self.half_spacing)),
            # per pair of half beams; 2 L_1 L_2 in a plain weave
            "area": self.repeat * self.warp_half_spacing * self.weft_half_spacing,
        }

    @property
    def crossover_area(self) -> float:
        """Area per crossover at which the yarns are bent: crossovers within floats carry no force."""
        return 2.0 * self.repeat * self.warp_half_spacing * self.weft_half_spacing


class TwillWeave(FloatWeave):
    """2/2 twill: over two, under two."""

    repeat: Literal[4] = Field(default=4, description="N, crossovers in a repeat along a yarn")

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        return {"twill": cls.glass_polypropylene}


class SatinWeave(FloatWeave):
    """Satin with five or eight harnesses: over all but one."""

    repeat: Literal[5, 8] = Field(default=5, description="N, number of harnesses")

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        return {"satin-5": cls.glass_polypropylene, "satin-8": partial(cls.glass_polypropylene, repeat=8)}
