"""Where each number of the presets comes from. Ranges of assumed numbers are those that a study should try."""

from __future__ import annotations

import math

from ..fabric import Fabric
from ..provenance import Origin, given_numbers
from .cao2008 import CITATION

TABLE_1 = f"{CITATION}, Table 1"
ARIDHI = "Aridhi et al. 2019, credited there to Cao et al. 2008"
NOT_MEASURED = "assumed: not measured on this fabric"
SETTING = "weavesim: a setting of the element, no property of the fabric (docs/theory.md, section 3)"
# The authors trust the angle that follows from the crosshead of a picture frame up to here [rad].
TRUSTED_FRAME_ANGLE = math.radians(35.0)
LABORATORY_SCATTER = 0.4


def _assumed(name: str, low: float, high: float, note: str = "") -> Origin:
    return Origin(of=name, source=NOT_MEASURED, assumed=True, range=(low, high), note=note)


CLOTH = (
    Origin(of="areal_density", source=TABLE_1, range=(0.72, 0.765), note="two yarn systems of 1870 tex give 0.72"),
    Origin(
        of="thickness", source=f"{TABLE_1} (NU, at 4.14 kPa, ASTM D1777)", range=(1.0e-3, 1.4e-3),
        note="depends on the pressure; the range is assumed",
    ),
    Origin(
        of=("unit_cell.warp_modulus", "unit_cell.weft_modulus"), source=f"{ARIDHI}: E A = 31.8 kN per yarn",
        range=(28.0e9, 34.0e9),
        note="only E A counts; 1870 tex with 60 % of E-glass by mass (2550 kg/m^3, 72 GPa) give 31.7 kN",
    ),
    Origin(
        of=("unit_cell.warp_cross_section", "unit_cell.weft_cross_section"),
        source="a convention: only E A and E I count", range=(1.0e-6, 1.0e-6),
    ),
    Origin(
        of=("unit_cell.warp_second_moment", "unit_cell.weft_second_moment"), source=NOT_MEASURED, assumed=True,
        range=(4.7e-17, 4.8e-15), note="E I is the bending stiffness of the sheet over one pitch",
    ),
    _assumed("unit_cell.contact_modulus", 1.0e6, 1.0e8, "softness of the crossovers: biaxial tests give it"),
    _assumed("unit_cell.contact_cross_section", 8.0e-6, 1.8e-5, "yarns are 4.2 mm wide (Cao et al. 2008, Table 1)"),
    _assumed("unit_cell.crossover_height", 0.3e-3, 1.2e-3, "half the thickness of the sheet"),
    _assumed("unit_cell.warp_crimp_share", 0.3, 0.7, "warp and weft have the same count and yarn"),
    _assumed("shear.locking_angle", math.radians(45.0), math.radians(65.0), "beyond the measured curves"),
    _assumed("shear.locking_stiffness", 1.0e4, 6.2e5, "a hundredth of the yarn stiffness per width"),
    _assumed("shear.locking_width", math.radians(1.0), math.radians(10.0)),
    _assumed("bending.modulus", 2.0e6, 2.0e8, "cold yarns; a cantilever test gives it"),
    _assumed("bending.poisson_ratio", 0.0, 0.3, "yarn families bend independently"),
    _assumed("transverse_shear_modulus", 1.0e6, 1.0e8, "stiff against bending, so that it hardly counts"),
    _assumed("in_plane_bending_stiffness", 0.0, 5.0e-2, "keeps neighbouring elements from alternating in shear"),
    _assumed("compressive_stiffness", 0.0, 2.4e5, "the bending modulus times the thickness"),
    Origin(
        of=("stabilisation.in_plane", "stabilisation.warping", "stabilisation.director"), source=SETTING,
        range=(0.05, 0.2),
    ),
    _assumed("compaction.thickening", 0.0, 1.0, "1: the fibre content stays what it is when the area shrinks"),
    _assumed("compaction.fibre_areal_density", 0.42, 0.47, "60 % of glass by mass, which E A supports"),
    Origin(of="compaction.fibre_density", source="E-glass, handbook value", range=(2540.0, 2600.0)),
)  # fmt: skip
_COUNT = ("unit_cell.warp_half_spacing", "unit_cell.weft_half_spacing")
PUBLISHED_PITCH = Origin(of=_COUNT, source=f"{ARIDHI}: pitch 5.2 mm", range=(2.56e-3, 2.64e-3))
COUNTED_PITCH = Origin(
    of=_COUNT, source=f"{TABLE_1}: 1.93 yarns per cm (HKUST); 1.90 to 1.95 elsewhere", range=(2.56e-3, 2.64e-3)
)

POLYNOMIAL = (
    *CLOTH,
    PUBLISHED_PITCH,
    Origin(
        of="shear.angle", source=f"{ARIDHI}: a polynomial, evaluated to 55 degrees",
        range=(math.radians(25.0), TRUSTED_FRAME_ANGLE),
        note="far too soft below 25 degrees: 3 N/m at 5 degrees, where the laboratories' mean is 12 N/m",
    ),
    Origin(
        of="shear.moment_values", source=f"{ARIDHI}: stress over the current frame, so m = t tau cos(angle)",
        scatter=LABORATORY_SCATTER, note="the scatter of the laboratories of Cao et al. 2008",
    ),
    Origin(of="shear.smoothing", source="no smoothing: a polynomial has no noise", range=(0.0, 0.0)),
    Origin(
        of="shear_friction", source="assumed: no unloading was published", assumed=True,
        note="all of the moment is taken as elastic",
    ),
)  # fmt: skip
HKUST = (
    *CLOTH,
    COUNTED_PITCH,
    Origin(
        of="shear.angle", source=f"{CITATION}, Fig. 28: picture frame of HKUST, to 52 degrees",
        range=(0.0, TRUSTED_FRAME_ANGLE),
        note="conditioned: sheared several times before the test; the authors trust the angle up to 35 degrees",
    ),
    Origin(
        of="shear.moment_values", source=f"{CITATION}, Fig. 28: normalised by its equation 10, m = N cos(angle)",
        scatter=LABORATORY_SCATTER, note="the scatter of the laboratories; HKUST's own is 1.2 N/m",
    ),
    Origin(
        of="shear.smoothing", source="chosen: about the noise of the points, 1.2 N/m", assumed=True, range=(1.2, 2.5),
        note="the least with which the curve never falls",
    ),
    Origin(
        of="shear_friction", source="assumed: no unloading was published", assumed=True,
        note="all of the moment is taken as elastic; conditioning took away the friction that others saw",
    ),
)  # fmt: skip
CONSENSUS = (
    *CLOTH,
    COUNTED_PITCH,
    Origin(
        of="shear.angle", source=f"{CITATION}, Figs. 28 and 39: six picture frames and nine series of bias extension",
        range=(0.0, TRUSTED_FRAME_ANGLE),
        note="the authors trust the angle up to 35 degrees in frames and 30 degrees in bias extension",
    ),
    Origin(
        of="shear.moment_values", source=f"{CITATION}, Figs. 28 and 39: mean of both methods' means, less the friction",
        scatter=LABORATORY_SCATTER, note="fewer laboratories beyond 34 degrees",
    ),
    Origin(of="shear.smoothing", source="no smoothing: a mean of laboratories", range=(0.0, 0.0)),
    Origin(
        of="shear_friction.limit", source="assumed: the moment that jumps up within the first degree is friction",
        assumed=True, range=(0.5, 17.0),
        note="the line through 2 to 10 degrees, at 0; laboratories from none (HKUST) to 17 N/m (LMSP), none of which "
        "published unloading",
    ),
    Origin(
        of="shear_friction.angle", source="assumed: the same friction at every angle", assumed=True, range=(0.0, 0.0)
    ),
    Origin(
        of="shear_friction.stiffness", source="assumed: the jump is over within one degree", assumed=True,
        range=(200.0, 2000.0),
    ),
    _assumed("shear_friction.crossover_friction_length", 0.0, 1.0e-3, "growth with yarn tension was not measured"),
)  # fmt: skip


def all_assumed(fabric: Fabric, why: str) -> tuple[Origin, ...]:
    """Provenance of a fabric that nobody has measured: a third to three times of everything should be tried."""
    result = []
    for name, number in given_numbers(fabric).items():
        low, high = min(number.values), max(number.values)
        if not isinstance(number.value, tuple):
            low, high = sorted((low / 3.0, high * 3.0))
        elif number.unit not in ("rad", "1/m"):  # what a curve is over keeps its place
            result.append(Origin(of=name, source=why, assumed=True, scatter=0.67))
            continue
        result.append(Origin(of=name, source=why, assumed=True, range=(low, high)))
    if fabric.shear_friction is None:
        result.append(Origin(of="shear_friction", source=why, assumed=True))
    return tuple(result)
