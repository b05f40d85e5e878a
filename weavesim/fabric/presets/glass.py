"""A commingled glass/polypropylene plain weave, TPEET22XXX: three fabrics, which differ in what is said of its shear.

The same cloth was sheared by many laboratories (Cao et al. 2008), which scatter by 40 %. ``glass_polypropylene`` has
the polynomial of the double-dome benchmark; it is far too soft below 25 degrees. The other two have measured curves.
"""

from __future__ import annotations

import math
from typing import Any, Literal

from ..bending import IsotropicBending
from ..cell import PlainWeave
from ..cell.weaves import GLASS_PITCH, GLASS_YARN_STIFFNESS
from ..compaction import Compaction
from ..fabric import LARGEST_LOCKING_SHARE, Fabric
from ..provenance import without
from ..shear import MomentCurve, split_jump
from .cao2008 import CITATION, consensus_moment, frame_curve
from .origins import CONSENSUS, HKUST, POLYNOMIAL

THICKNESS = 1.2e-3  # [m]
AREAL_DENSITY = 0.743  # [kg/m^2]
LOCKING_ANGLE = math.radians(60.0)
# Slope of the locking branch [N/m].
LOCKING_STIFFNESS = LARGEST_LOCKING_SHARE * GLASS_YARN_STIFFNESS / GLASS_PITCH * 0.1
# Distance of the yarns from their count, 1.93 per cm (HKUST) [m].
COUNTED_PITCH = 1.0e-2 / 1.93
# HKUST's frame scatters by 1.2 N/m from one point to the next [N/m].
HKUST_NOISE = 1.5
# Up to here the laboratories' mean is a curve: beyond it fewer of them are left [rad].
CONSENSUS_END = math.radians(45.0)
# The measured moment jumps within the first degree and then rises along a line up to about 10 degrees [rad].
JUMP_END = math.radians(1.0)
JUMP_LINE = math.radians(2.0), math.radians(10.0)

_ASSUMED = (
    "crimp", "contact stiffness", "yarn bending", "sheet bending", "transverse shear", "compression",
    "in-plane bending", "locking", "fibre content", "thickening",
)  # fmt: skip


def glass_polypropylene(
    *, convention: Literal["yarn frame", "moment"] = "yarn frame", locking_angle: float = LOCKING_ANGLE
) -> Fabric:
    """Commingled glass/polypropylene plain weave, as in the double-dome benchmark.

    Areal density, thickness, pitch, yarn stiffness and the shear curve are published, second-hand (Aridhi et al. 2019,
    credited there to Cao et al. 2008). Crimp, contact stiffness, yarn bending and sheet bending are assumed.
    """
    # what is not as published is not of this provenance
    of_other = {"shear.locking_angle": locking_angle != LOCKING_ANGLE, "shear.moment_values": convention == "moment"}
    shear = MomentCurve.from_stress_polynomial(
        (0.051e6, -0.83e6, 6.1275e6, -12.0972e6, 8.48e6), THICKNESS, convention=convention,
        locking_angle=locking_angle, locking_stiffness=LOCKING_STIFFNESS,
    )  # fmt: skip
    return _cloth(
        name="glass/polypropylene plain weave",
        unit_cell=PlainWeave.glass_polypropylene(),
        shear=shear,
        source="Aridhi et al. 2019, credited there to Cao et al. 2008 (shear curve, density, thickness, pitch, E A)",
        assumed=_ASSUMED,
        provenance=without(POLYNOMIAL, [name for name, is_other in of_other.items() if is_other]),
    )


def glass_polypropylene_hkust() -> Fabric:
    """The same cloth with the shear curve of one laboratory: HKUST's picture frame (Cao et al. 2008, Fig. 28).

    Its specimens were sheared several times before the test, which took away the friction that others measured at small
    angles: the whole curve is taken as elastic, and no friction is known.
    """
    angle, force = frame_curve("hkust")
    shear = MomentCurve.from_normalised_force(
        angle, force, convention="fabric area", smoothing=HKUST_NOISE, locking_angle=LOCKING_ANGLE,
        locking_stiffness=LOCKING_STIFFNESS,
    )  # fmt: skip
    return _cloth(
        name="glass/polypropylene plain weave, sheared by HKUST",
        unit_cell=_counted_cell(),
        shear=shear,
        source=f"{CITATION}: HKUST's picture frame of a conditioned specimen, count, density, thickness; "
        "E A from Aridhi et al. 2019",
        assumed=(*_ASSUMED, "all of the shear moment elastic"),
        provenance=HKUST,
    )


def glass_polypropylene_consensus() -> Fabric:
    """The same cloth with what all laboratories measured together, to 45 degrees, and friction (Cao et al. 2008).

    The moment that jumps up within the first degree is taken as friction between the yarns, at all angles the same; no
    unloading was published, so this split is an assumption.
    """
    angle, moment = consensus_moment()
    angle, moment = angle[angle <= CONSENSUS_END * (1.0 + 1.0e-9)], moment[angle <= CONSENSUS_END * (1.0 + 1.0e-9)]
    elastic, friction = split_jump(angle, moment, line=JUMP_LINE, onset=JUMP_END)
    shear = MomentCurve(
        angle=(0.0, *angle.tolist()), moment_values=(0.0, *elastic.tolist()), locking_angle=LOCKING_ANGLE,
        locking_stiffness=LOCKING_STIFFNESS,
    )  # fmt: skip
    return _cloth(
        name="glass/polypropylene plain weave, consensus of laboratories",
        unit_cell=_counted_cell(),
        shear=shear,
        shear_friction=friction,
        source=f"{CITATION}: mean of picture frames and bias extensions, count, density, thickness; "
        "E A from Aridhi et al. 2019",
        assumed=(*_ASSUMED, "friction between the yarns"),
        provenance=CONSENSUS,
    )


def _counted_cell() -> PlainWeave:
    return PlainWeave.glass_polypropylene(warp_half_spacing=0.5 * COUNTED_PITCH, weft_half_spacing=0.5 * COUNTED_PITCH)


def _cloth(**values: Any) -> Fabric:
    """What all three fabrics share, and the ``values`` of one."""
    bending_modulus = 20.0e6  # of the sheet [Pa]; also sets its compressive stiffness along the yarns
    return Fabric(
        areal_density=AREAL_DENSITY,
        thickness=THICKNESS,
        bending=IsotropicBending(modulus=bending_modulus, poisson_ratio=0.0),
        transverse_shear_modulus=10.0e6, compressive_stiffness=bending_modulus * THICKNESS,
        in_plane_bending_stiffness=5.0e-3,
        compaction=Compaction(fibre_areal_density=0.6 * AREAL_DENSITY, fibre_density=2550.0),
        **values,
    )  # fmt: skip
