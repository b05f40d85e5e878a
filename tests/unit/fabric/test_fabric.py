"""Fabrics: derived quantities, the published curve, and which values are refused."""

import math

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve, IsotropicBending, YarnBending
from weavesim.fabric.fabric import LARGEST_LOCKING_SHARE, Fabric, Stabilisation
from weavesim.fabric.presets import PRESETS, glass_polypropylene
from weavesim.fabric.shear import LinearShear, MomentCurve, ShearFriction
from weavesim.fabric.weaves import PlainWeave


def test_unit_cell_has_the_papers_parameters():
    cell = PlainWeave(
        warp_modulus=70e9, weft_modulus=50e9, contact_modulus=1e8, warp_cross_section=1e-7, weft_cross_section=2e-7,
        contact_cross_section=1e-5, warp_second_moment=1e-16, weft_second_moment=2e-16, warp_half_spacing=3e-3,
        weft_half_spacing=2e-3, crossover_height=4e-4, warp_crimp_share=0.25,
    )  # fmt: skip
    assert cell.axial_stiffness == pytest.approx((7000.0, 10000.0))
    assert cell.bending_stiffness == pytest.approx((7e-6, 1e-5))
    assert cell.crimp_height == pytest.approx((1e-4, 3e-4))
    assert cell.chord_length == pytest.approx((math.hypot(3e-3, 1e-4), math.hypot(2e-3, 3e-4)))
    assert cell.contact_stiffness == pytest.approx(1e8 * 1e-5 / 4e-4)
    # yarns along the warp are spaced by the weft's crossover distance
    assert cell.yarn_stiffness_per_width == pytest.approx((7000.0 / 4e-3, 10000.0 / 6e-3))
    assert cell.compressive_stiffness == pytest.approx(
        (3 * 7e-6 / cell.chord_length[0] ** 2, 3 * 1e-5 / cell.chord_length[1] ** 2)
    )


def cell_with(**changes) -> PlainWeave:
    return PlainWeave(**(glass_polypropylene().unit_cell.model_dump() | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"warp_modulus": -1.0}, "warp_modulus = -1.0"),
        ({"weft_modulus": 0.0}, "weft_modulus = 0.0"),
        ({"contact_modulus": math.nan}, "contact_modulus = nan"),
        ({"warp_cross_section": math.inf}, "warp_cross_section = inf"),
        ({"warp_second_moment": -1e-20}, "warp_second_moment"),
        ({"warp_crimp_share": 1.2}, "warp_crimp_share = 1.2"),
        ({"contact": "sticky"}, "contact = 'sticky'"),
        ({"crossover_height": 0.0}, "contact_stiffness_value"),
        ({"weft_compressive_stiffness": -3.0}, "weft_compressive_stiffness = -3.0"),
        ({"wrap_modulus": 1.0}, "wrap_modulus"),
        ({"warp_modulus": "stiff"}, "warp_modulus = 'stiff'"),
    ],
)
def test_bad_cells_are_refused_by_name(changes, message):
    with pytest.raises(InputError, match=message):
        cell_with(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"areal_density": 0.0}, "areal_density = 0.0"),
        ({"thickness": -1e-3}, "thickness = -0.001"),
        ({"transverse_shear_modulus": -1.0}, "transverse_shear_modulus"),
        ({"compressive_stiffness": math.nan}, "compressive_stiffness"),
        ({"in_plane_bending_stiffness": -1.0}, "in_plane_bending_stiffness"),
    ],
)
def test_bad_fabrics_are_refused_by_name(changes, message):
    fabric = glass_polypropylene()
    values = {name: getattr(fabric, name) for name in type(fabric).model_fields}
    with pytest.raises(InputError, match=message):
        Fabric(**(values | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearShear(modulus=-1.0), "modulus = -1.0"),
        (lambda: IsotropicBending(modulus=-1.0), "modulus = -1.0"),
        (lambda: IsotropicBending(modulus=1.0, poisson_ratio=0.5), "poisson_ratio = 0.5"),
        (lambda: IsotropicBending(modulus=1.0, poisson_ratio=math.nan), "poisson_ratio"),
        (lambda: YarnBending(warp=-1.0, weft=1.0, twist=1.0), "warp = -1.0"),
        (lambda: YarnBending(warp=1.0, weft=1.0, twist=1.0, coupling=1.1), "coupling"),
        (lambda: Stabilisation(in_plane=-0.1), "in_plane = -0.1"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0,)), "2 angles and 1 moments"),
        (lambda: MomentCurve(angle=(0.1, 0.5), moment_values=(0.0, 1.0)), "start at 0"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(1.0, 2.0)), "moments must start at 0"),
        (lambda: MomentCurve(angle=(0.0, 0.5, 0.4), moment_values=(0.0, 1.0, 2.0)), "increase"),
        (lambda: MomentCurve(angle=(0.0, 1.7), moment_values=(0.0, 1.0)), "below pi/2"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0, -1.0)), "moments must not be negative"),
        (lambda: MomentCurve(angle=(0.0, True), moment_values=(0.0, 1.0)), "not true or false"),
        (lambda: LinearShear(modulus=True), "modulus = True: a number is needed"),
        (lambda: ShearFriction(stiffness=1.0, limit=(1.0, 2.0), angle=(0.0, 30.0)), "the last angle is 30 rad"),
        (lambda: BendingCurve.from_kawabata(1e-3, 1e-2, slip_curvature=0.0), "slip_curvature = 0"),
        (lambda: BendingCurve.from_kawabata(1e-3, 1e-2, slip_curvature="x"), "slip_curvature = 'x'"),
        (
            lambda: BendingCurve.from_loading_and_unloading(
                (0.0, 1.0), (0.0, 1.0, 2.0), (0.0, 1.0), friction_stiffness=1.0
            ),
            "2 of curvature, 3 of loading, 2 of unloading",
        ),
        (lambda: MomentCurve.from_loading_and_unloading((0.0, 0.5), (0.0, 1.0), ("a", "b")), "unloading: a list"),
        (
            lambda: ShearFriction.from_loading_and_unloading((0.0, 0.5), (0.0, 1.0), (0.0, 1.0), stiffness=1.0),
            "does nothing",
        ),
        (lambda: MomentCurve(angle=(0.0, math.nan), moment_values=(0.0, 1.0)), "finite"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0, 1.0), locking_stiffness=-1.0), "locking_stiffness"),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_locking_is_bounded_by_the_yarns():
    fabric = glass_polypropylene()
    largest = LARGEST_LOCKING_SHARE * min(fabric.unit_cell.yarn_stiffness_per_width)
    values = {name: getattr(fabric, name) for name in type(fabric).model_fields}
    hard = fabric.shear.model_copy(update={"locking_stiffness": 1.01 * largest})
    with pytest.raises(InputError, match="locking_stiffness"):
        Fabric(**(values | {"shear": hard}))
    allowed = fabric.shear.model_copy(update={"locking_stiffness": largest})
    assert Fabric(**(values | {"shear": allowed})).shear.locking_stiffness == largest


def test_parameters_cannot_be_changed():
    with pytest.raises(Exception, match="frozen"):
        glass_polypropylene().thickness = 1.0


def test_published_curve_with_its_convention():
    """d tau/d gamma = 8.48 g^4 - 12.0972 g^3 + 6.1275 g^2 - 0.83 g + 0.051 MPa, t = 1.2 mm, m = t tau cos gamma."""
    angle = np.deg2rad([0.5, 5.0, 20.0, 45.0, 54.0])
    stress = 1e6 * (
        8.48 * angle**5 / 5 - 12.0972 * angle**4 / 4 + 6.1275 * angle**3 / 3 - 0.83 * angle**2 / 2 + 0.051 * angle
    )
    for convention, factor in (("yarn frame", np.cos(angle)), ("moment", 1.0)):
        curve = glass_polypropylene(convention=convention).shear
        assert np.allclose(curve.moment(angle), 1.2e-3 * stress * factor, rtol=1e-4)
        assert np.allclose(curve.moment(-angle), -curve.moment(angle))
    other = glass_polypropylene(convention="moment").shear.moment(np.array(math.pi / 4))
    assert other / glass_polypropylene().shear.moment(np.array(math.pi / 4)) == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_polynomial_of_the_moment_begins_with_its_linear_term():
    curve = MomentCurve.from_polynomial([30.0, -40.0, 100.0])
    angle = np.linspace(0.0, math.radians(55.0), 77)
    expected = 30.0 * angle - 40.0 * angle**2 + 100.0 * angle**3
    assert curve.moment(angle, 1e-3) == pytest.approx(expected, abs=1e-4 * expected.max())
    slope = np.diff(curve.moment(np.radians([55.0, 60.0, 70.0]), 1e-3)) / np.radians([5.0, 10.0])
    assert slope[0] == pytest.approx(slope[1])


def test_curve_goes_on_beyond_its_end_and_locks():
    curve = MomentCurve(
        angle=(0.0, 0.5, 1.0),
        moment_values=(0.0, 1.0, 3.0),
        locking_angle=1.2,
        locking_width=0.1,
        locking_stiffness=50.0,
    )
    angle = np.linspace(1.0, 1.2, 21)
    slope = np.diff(curve.moment(angle)) / np.diff(angle)
    assert np.allclose(slope, slope[0], rtol=1e-9)
    assert slope[0] > 0.0
    beyond = np.linspace(1.35, 1.5, 16)
    assert np.allclose(np.diff(curve.moment(beyond)) / np.diff(beyond), slope[0] + 50.0, rtol=1e-9)
    # smooth where it begins
    start = 1.2 + np.array([-1e-6, 1e-6])
    assert np.diff(curve.moment(start))[0] / 2e-6 == pytest.approx(slope[0], rel=1e-3)


def test_preset_is_the_published_fabric_and_labels_what_is_assumed():
    fabric = glass_polypropylene()
    assert fabric.areal_density == 0.743
    assert fabric.thickness == 1.2e-3
    assert fabric.unit_cell.half_spacing == (2.6e-3, 2.6e-3)
    assert fabric.unit_cell.axial_stiffness == pytest.approx((31.8e3, 31.8e3))
    assert {"crimp", "contact stiffness", "yarn bending", "sheet bending"} <= set(fabric.assumed)
    assert PRESETS["glass-polypropylene"]() == fabric
    assert fabric.unit_cell.warnings() == []


def test_plate_stiffness():
    assert IsotropicBending(modulus=3e9, poisson_ratio=0.3).stiffness(2e-3) == pytest.approx(3e9 * 8e-9 / 12 / 0.91)
    fabric = glass_polypropylene()
    assert fabric.transverse_shear_stiffness == pytest.approx(5.0 / 6.0 * fabric.transverse_shear_modulus * 1.2e-3)


def test_linear_law_is_a_switch():
    fabric = glass_polypropylene()
    linear = fabric.with_linear_shear(2.0e6)
    assert linear.shear == LinearShear(modulus=2.0e6)
    assert linear.unit_cell == fabric.unit_cell
    assert linear.shear_stiffness_scale == pytest.approx(0.5 * 2.0e6 * 1.2e-3, rel=0.3)
