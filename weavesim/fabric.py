"""Fabrics: physical parameters with their sources, checked when they are made."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from .bending import BendingCurve, IsotropicBending, YarnBending
from .cells import Cell, LinearMembrane, SatinWeave, TwillWeave, UnidirectionalTape, UnitCell
from .compaction import Compaction, check_compaction
from .parameters import NotNegative, Parameters, Positive, at_most
from .shear import LinearShear, MomentCurve, ShearFriction

# No law may resist locking or slip harder than this share of a yarn's stiffness per width: it enters the stable step.
LARGEST_LOCKING_SHARE = 0.1


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
    areal_density: Annotated[Positive, at_most(50.0, "it is in kg/m^2, write 0.6 for 600 g/m^2")] = Field(
        description="[kg/m^2]"
    )
    thickness: Annotated[Positive, at_most(0.05, "it is in metres, write 0.0012 for 1.2 mm")] = Field(description="[m]")
    unit_cell: SerializeAsAny[Cell]
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
    compaction: Compaction = Compaction()
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
        check_compaction(self.compaction, self.thickness, self.areal_density)
        if self.shear_friction is not None and self.shear_friction.stiffness > largest * (1 + 1e-9):
            raise ValueError(
                f"shear_friction.stiffness = {self.shear_friction.stiffness:.4g} N/m: at most {largest:.4g} N/m, a "
                "tenth of the yarn stiffness per width, is allowed (it enters the stable time step)"
            )
        return self

    @model_validator(mode="after")
    def _crossovers_can_rub(self) -> Self:
        friction = self.shear_friction
        if friction is not None and friction.crossover_friction_length > 0.0 and not self.unit_cell.has_crossovers:
            raise ValueError(
                f"shear_friction.crossover_friction_length = {friction.crossover_friction_length:.4g} m: the unit cell "
                f"{type(self.unit_cell).__name__} tells no pressure between warp and weft, so it would do nothing; "
                "leave it out, or take a cell with crossovers (a cell of your own: crossover_pressure)"
            )
        return self

    @property
    def has_bending_friction(self) -> bool:
        """True where a bent yarn of one family at least has friction inside."""
        bending = self.bending
        return isinstance(bending, YarnBending) and any(family.friction_limit > 0.0 for family in bending.families)

    @property
    def has_inner_friction(self) -> bool:
        """True where yarns or fibres slip on each other inside the sheet, which then has a history."""
        return self.shear_friction is not None or self.has_bending_friction

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
    def largest_bending_stiffness(self) -> float:
        """Bound of the bending stiffness of any curvature [N m], for the stable step."""
        if isinstance(self.bending, IsotropicBending):
            return self.bending.stiffness(self.thickness) * (1.0 + abs(self.bending.poisson_ratio))
        return self.bending.largest

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
        compaction=Compaction(fibre_areal_density=0.6 * 0.743, fibre_density=2550.0),
        source="Aridhi et al. 2019, credited there to Cao et al. 2008 (shear curve, density, thickness, pitch, E A)",
        assumed=("crimp", "contact stiffness", "yarn bending", "sheet bending", "transverse shear", "compression",
            "in-plane bending", "locking", "fibre content", "thickening",
        ),
    )  # fmt: skip


def _glass_yarns(kind: type[Cell], **more) -> Cell:
    return kind(**glass_polypropylene().unit_cell.model_dump() | more)


def _stitched_tape() -> Cell:
    tow = min(glass_polypropylene().unit_cell.yarn_stiffness_per_width)
    return UnidirectionalTape(
        tow_stiffness=tow, tow_compressive_stiffness=2.0e-4 * tow, stitch_stiffness=4.0e4, slip_stiffness=1.0e4,
        stitch_pitch=5.2e-3, tow_spacing=5.2e-3, stitch_slack=0.01, transverse_stiffness=1.0e3,
        transverse_compressive_stiffness=2.0e4,
    )  # fmt: skip


# One unit cell of every kind, to try, to test and to measure. All but the first are assumed.
UNIT_CELLS: dict[str, Callable[[], Cell]] = {
    "plain-weave": lambda: _glass_yarns(UnitCell),
    "plain-weave-unilateral": lambda: _glass_yarns(UnitCell, contact="unilateral"),
    "twill": lambda: _glass_yarns(TwillWeave),
    "satin-5": lambda: _glass_yarns(SatinWeave),
    "satin-8": lambda: _glass_yarns(SatinWeave, repeat=8),
    "stitched-tape": _stitched_tape,
    "linear-membrane": lambda: LinearMembrane(warp_stiffness=2.0e6, weft_stiffness=1.5e6, coupling_stiffness=0.3e6),
}


def assumed_fabric(unit_cell: str) -> Fabric:
    """The glass/polypropylene fabric with another of ``UNIT_CELLS``: no such fabric was measured."""
    fabric, cell = glass_polypropylene(), UNIT_CELLS[unit_cell]()
    # locking may be a tenth as stiff as the softer yarns
    largest = LARGEST_LOCKING_SHARE * min(cell.yarn_stiffness_per_width)
    locking = min(fabric.shear.locking_stiffness, 0.1 * largest)
    return fabric.model_copy(
        update={
            "name": f"assumed {unit_cell.replace('-', ' ')} of glass/polypropylene", "unit_cell": cell,
            "shear": fabric.shear.model_copy(update={"locking_stiffness": locking}),
            "source": f"none; all but the unit cell as in {fabric.name!r}", "assumed": ("everything",),
        }
    )  # fmt: skip


PRESETS: dict[str, Callable[[], Fabric]] = {
    "glass-polypropylene": glass_polypropylene,
    **{
        f"assumed-{name}": partial(assumed_fabric, name)
        for name in ("twill", "satin-5", "satin-8", "stitched-tape", "linear-membrane")
    },
}
