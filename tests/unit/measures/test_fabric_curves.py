"""Curves of a fabric against its laws, their bands, and what unloading leaves."""

import math

import numpy as np
import pytest

from weavesim import Origin, glass_polypropylene, glass_polypropylene_consensus, resolve_fabric
from weavesim.fabric import BendingCurve, LinearMembrane, ShearFriction, YarnBending
from weavesim.fabric.presets import PRESETS
from weavesim.measures.fabric_curves import (
    bending_curves,
    curves_of,
    shear_curves,
    tension_curves,
    thickness_curves,
    unloading_of,
    varied,
)

GLASS, CONSENSUS = glass_polypropylene(), glass_polypropylene_consensus()


def test_shear_has_its_loop_its_data_and_its_trust():
    curves = shear_curves(CONSENSUS)
    loading, elastic, unloading = curves.lines
    assert np.interp(20.0, loading.x, loading.y - elastic.y) == pytest.approx(
        CONSENSUS.shear_friction.limit[0], rel=1e-3
    )
    back = np.interp(20.0, unloading.x[::-1], unloading.y[::-1])
    assert np.interp(20.0, loading.x, loading.y) - back == pytest.approx(
        2.0 * CONSENSUS.shear_friction.limit[0], rel=1e-2
    )
    assert curves.trusted == pytest.approx((0.0, 35.0)) and curves.measured_to == pytest.approx(45.0)
    x, low, high = curves.band
    assert np.all(low <= loading.y + 1e-12) and np.all(high >= loading.y - 1e-12)
    # at 20 degrees the elastic part is uncertain by 40 %, and friction from 0.5 to 17 N/m: one at a time
    expected = [18.76 + 0.5, 18.76 + 17.0, 0.6 * 18.76 + 8.25, 1.4 * 18.76 + 8.25]
    assert np.interp(20.0, x, low) == pytest.approx(min(expected), abs=0.1)
    assert np.interp(20.0, x, high) == pytest.approx(max(expected), abs=0.1)


def test_without_friction_and_provenance_there_is_one_line():
    curves = shear_curves(GLASS.model_copy(update={"provenance": ()}))
    assert len(curves.lines) == 1 and curves.band is None and curves.trusted is None
    assert "no friction" in curves.note
    linear = shear_curves(GLASS.with_linear_shear(0.2e6))
    assert linear.measured_to is None and linear.lines[0].x[-1] == pytest.approx(60.0)


def test_tension_of_a_linear_membrane_is_its_stiffness():
    cell = LinearMembrane(warp_stiffness=2.0e6, weft_stiffness=1.0e6, coupling_stiffness=0.5e6)
    origin = Origin(of="unit_cell.warp_stiffness", source="a guess", range=(1.0e6, 3.0e6))
    curves = tension_curves(GLASS.model_copy(update={"unit_cell": cell, "provenance": (origin,)}))
    warp, weft, both_warp, both_weft = (line.y[-1] for line in curves.lines)
    assert (warp, weft, both_warp, both_weft) == pytest.approx((20.0, 10.0, 25.0, 15.0))  # kN/m at 1 %
    assert (curves.band[1][-1], curves.band[2][-1]) == pytest.approx((10.0, 30.0))


def test_crimped_yarns_are_pulled_until_they_are_straight():
    curves = tension_curves(GLASS)
    assert curves.lines[0].x[-1] > 250.0 * (math.hypot(2.6e-3, 0.3e-3) / 2.6e-3 - 1.0) * 0.99
    assert curves.lines[0].y == pytest.approx(curves.lines[1].y)  # balanced
    assert np.all(curves.lines[2].y[1:] > curves.lines[0].y[1:])


def test_bending_of_curves_with_friction():
    curve = BendingCurve.from_kawabata(rigidity=1e-3, hysteresis=2e-2)
    law = YarnBending(warp=curve, weft=BendingCurve(curvature=(0, 50, 100), moment_values=(0, 0.05, 0.08)), twist=1e-4)
    curves = bending_curves(GLASS.model_copy(update={"bending": law, "provenance": ()}))
    labels = [line.label for line in curves.lines]
    assert labels == ["warp", "warp, unloading", "weft"]
    warp, back, weft = curves.lines
    # 1e-3 N m times 100 1/m, and half the hysteresis on either side [N mm/m]
    assert np.interp(100.0, warp.x, warp.y) == pytest.approx(110.0, rel=1e-3)
    assert np.interp(60.0, back.x[::-1], back.y[::-1]) == pytest.approx(50.0, rel=1e-2)
    assert np.interp(50.0, weft.x, weft.y) == pytest.approx(50.0, rel=1e-2)
    assert curves.measured_to == pytest.approx(100.0)
    assert curves.trusted is None
    origin = Origin(of="bending.warp.curvature", source="KES-FB2", range=(0.0, 80.0))
    fabric = GLASS.model_copy(update={"bending": law, "provenance": ()}).model_copy(update={"provenance": (origin,)})
    assert bending_curves(fabric).trusted == (0.0, 80.0)
    flat = bending_curves(GLASS)
    assert flat.lines[0].y[-1] == pytest.approx(1e3 * 60.0 * 20e6 * 1.2e-3**3 / 12.0)
    assert flat.band[2][-1] == pytest.approx(10.0 * flat.lines[0].y[-1])  # modulus up to 200 MPa


def test_thickness_over_pressure_and_shear():
    pressed, sheared = thickness_curves(GLASS)
    modulus = GLASS.compaction.modulus(GLASS.unit_cell)
    assert pressed.lines[0].y[-1] == pytest.approx(1.2 / (1.0 + 100.0e3 / modulus))
    assert np.interp(45.0, sheared.lines[0].x, sheared.lines[0].y) == pytest.approx(1.2 * math.sqrt(2.0), rel=1e-3)
    assert sheared.note == "fibre content 14.6% flat, 14.6% at 45°"


def test_each_number_is_varied_to_both_ends_alone():
    origins = (
        Origin(of="thickness", source="x", range=(1.0e-3, 1.2e-3)),
        Origin(of="bending.modulus", source="x", range=(1.0e7, 4.0e7)),
        Origin(of="shear.moment_values", source="x", scatter=0.5),
    )
    fabric = GLASS.model_copy(update={"provenance": origins})
    assert [(one.thickness, one.bending.modulus) for one in varied(fabric, ["thickness", "bending"])] == [
        (1.0e-3, 2.0e7), (1.2e-3, 1.0e7), (1.2e-3, 4.0e7),
    ]  # fmt: skip
    scaled = [one.shear.moment_values[-1] / fabric.shear.moment_values[-1] for one in varied(fabric, ["shear"])]
    assert scaled == pytest.approx([0.5, 1.5])
    impossible = Origin(of="bending.modulus", source="x", range=(-1.0, 4.0e7))
    assert len(list(varied(GLASS.model_copy(update={"provenance": (impossible,)}), ["bending"]))) == 1


def test_unloading_of_a_linear_law_by_hand():
    """Slope 50 N/m with friction of 10 N/m to 0.5 rad: zero again at 0.2 rad."""
    from weavesim.fabric import MomentCurve

    friction = ShearFriction(stiffness=4.0e3, limit=(10.0,))
    shear = MomentCurve(angle=(0.0, 1.0), moment_values=(0.0, 50.0), extrapolation="trusted")
    fabric = GLASS.model_copy(update={"shear": shear, "shear_friction": friction, "provenance": ()})
    found = unloading_of(fabric, 0.5)
    assert found.residual_angle == pytest.approx(0.2, abs=2e-3)
    loaded = 0.5 * 50.0 * 0.25 + 10.0 * 0.5
    regained = 0.5 * (50.0 * 0.5 - 10.0) * 0.3
    assert found.lost_share == pytest.approx(1.0 - regained / loaded, abs=5e-3)
    elastic = unloading_of(GLASS, 0.5)
    assert elastic.residual_angle == pytest.approx(0.0, abs=1e-9) and elastic.lost_share == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    "name", [name for name in PRESETS if name in ("assumed-stitched-tape", "assumed-linear-membrane")]
)
def test_every_curve_is_finite(name):
    for curves in curves_of(resolve_fabric(name)):
        for values in [line.y for line in curves.lines] + ([curves.band[1], curves.band[2]] if curves.band else []):
            assert np.all(np.isfinite(values)), curves.name
