"""Named fabrics, and examples of every kind of unit cell."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Literal

from .bending import IsotropicBending
from .cell import PlainWeave, UnitCell
from .cell.weaves import GLASS_PITCH, GLASS_YARN_STIFFNESS
from .compaction import Compaction
from .fabric import LARGEST_LOCKING_SHARE, Fabric
from .shear import MomentCurve


def glass_polypropylene(
    *, convention: Literal["yarn frame", "moment"] = "yarn frame", locking_angle: float = math.radians(60.0)
) -> Fabric:
    """Commingled glass/polypropylene plain weave, as in the double-dome benchmark.

    Areal density, thickness, pitch, yarn stiffness and the shear curve are published, second-hand (Aridhi et al. 2019,
    credited there to Cao et al. 2008). Crimp, contact stiffness, yarn bending and sheet bending are assumed.
    """
    thickness = 1.2e-3
    bending_modulus = 20.0e6  # of the sheet [Pa]; also sets its compressive stiffness along the yarns
    return Fabric(
        name="glass/polypropylene plain weave",
        areal_density=0.743,
        thickness=thickness,
        unit_cell=PlainWeave.glass_polypropylene(),
        shear=MomentCurve.from_stress_polynomial(
            (0.051e6, -0.83e6, 6.1275e6, -12.0972e6, 8.48e6), thickness, convention=convention,
            locking_angle=locking_angle,
            locking_stiffness=LARGEST_LOCKING_SHARE * GLASS_YARN_STIFFNESS / GLASS_PITCH * 0.1,
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


# Examples of all kinds of unit cells, for trials, tests and benchmarks. All except the plain weave are assumed.
UNIT_CELLS: dict[str, Callable[[], UnitCell]] = {
    name: make for kind in UnitCell.kinds().values() for name, make in sorted(kind.examples().items())
}


def assumed_fabric(unit_cell: str) -> Fabric:
    """The glass/polypropylene fabric with another of ``UNIT_CELLS``; no such fabric was measured."""
    fabric, cell = glass_polypropylene(), UNIT_CELLS[unit_cell]()
    # locking stiffness is limited to a tenth of that of the softer yarns
    largest = LARGEST_LOCKING_SHARE * min(cell.yarn_stiffness_per_width)
    return fabric.model_copy(
        update={
            "name": f"assumed {unit_cell.replace('-', ' ')} of glass/polypropylene", "unit_cell": cell,
            "shear": fabric.shear.locking_at_most(0.1 * largest),
            "source": f"none; all but the unit cell as in {fabric.name!r}", "assumed": ("everything",),
        }
    )  # fmt: skip


PRESETS: dict[str, Callable[[], Fabric]] = {
    "glass-polypropylene": glass_polypropylene,
    **{f"assumed-{name}": partial(assumed_fabric, name) for name in UNIT_CELLS if name not in PlainWeave.examples()},
}
