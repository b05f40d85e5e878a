"""Named fabrics, and one unit cell of every kind."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Literal

from .bending import IsotropicBending
from .cell import UnitCell
from .compaction import Compaction
from .fabric import LARGEST_LOCKING_SHARE, Fabric
from .membrane import LinearMembrane
from .shear import MomentCurve
from .tape import UnidirectionalTape
from .weaves import PlainWeave, SatinWeave, TwillWeave


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
        unit_cell=PlainWeave(
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


def _glass_yarns(kind: type[UnitCell], **more) -> UnitCell:
    return kind(**glass_polypropylene().unit_cell.model_dump() | more)


def _stitched_tape() -> UnitCell:
    tow = min(glass_polypropylene().unit_cell.yarn_stiffness_per_width)
    return UnidirectionalTape(
        tow_stiffness=tow, tow_compressive_stiffness=2.0e-4 * tow, stitch_stiffness=4.0e4, slip_stiffness=1.0e4,
        stitch_pitch=5.2e-3, tow_spacing=5.2e-3, stitch_slack=0.01, transverse_stiffness=1.0e3,
        transverse_compressive_stiffness=2.0e4,
    )  # fmt: skip


# One unit cell of every kind, to try, to test and to measure. All but the first are assumed.
UNIT_CELLS: dict[str, Callable[[], UnitCell]] = {
    "plain-weave": lambda: _glass_yarns(PlainWeave),
    "plain-weave-unilateral": lambda: _glass_yarns(PlainWeave, contact="unilateral"),
    "twill": lambda: _glass_yarns(TwillWeave),
    "satin-5": lambda: _glass_yarns(SatinWeave),
    "satin-8": lambda: _glass_yarns(SatinWeave, repeat=8),
    "stitched-tape": _stitched_tape,
    "linear-membrane": lambda: LinearMembrane(warp_stiffness=2.0e6, weft_stiffness=1.5e6, coupling_stiffness=0.3e6),
}


def assumed_fabric(unit_cell: str) -> Fabric:
    """The glass/polypropylene fabric with another of ``UNIT_CELLS``: no such fabric was measured."""
    fabric, cell = glass_polypropylene(), UNIT_CELLS[unit_cell]()
    shear = fabric.shear
    assert isinstance(shear, MomentCurve)
    # locking may be a tenth as stiff as the softer yarns
    largest = LARGEST_LOCKING_SHARE * min(cell.yarn_stiffness_per_width)
    locking = min(shear.locking_stiffness, 0.1 * largest)
    return fabric.model_copy(
        update={
            "name": f"assumed {unit_cell.replace('-', ' ')} of glass/polypropylene", "unit_cell": cell,
            "shear": shear.model_copy(update={"locking_stiffness": locking}),
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
