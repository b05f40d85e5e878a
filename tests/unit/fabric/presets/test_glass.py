"""The presets are the published fabrics, and say what is assumed."""

import math

import numpy as np
import pytest

from weavesim import InputError
from weavesim.fabric.presets import (
    PRESETS,
    glass_polypropylene,
    glass_polypropylene_consensus,
    glass_polypropylene_hkust,
)
from weavesim.fabric.presets.cao2008 import FOLDER, FRAME_LABORATORIES, consensus_moment, frame_curve
from weavesim.tables import Wanted, read_table


def scatter_at(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest moment per reference area [N/m] over all frames and bias series, at angles (n,) [rad]."""
    table = read_table(FOLDER / "consensus.csv", "table")
    columns = table.columns(
        Wanted("angle", "rad"), Wanted("frame least", "N/m"), Wanted("bias least", "N/m"),
        Wanted("frame largest", "N/m"), Wanted("bias largest", "N/m"),
    ).values  # fmt: skip
    least, largest = np.minimum(columns[1], columns[2]), np.maximum(columns[3], columns[4])
    factor = np.cos(angle)
    return np.interp(angle, columns[0], least) * factor, np.interp(angle, columns[0], largest) * factor


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


def test_preset_is_the_published_fabric_and_labels_what_is_assumed():
    fabric = glass_polypropylene()
    assert fabric.areal_density == 0.743
    assert fabric.thickness == 1.2e-3
    assert fabric.unit_cell.half_spacing == (2.6e-3, 2.6e-3)
    assert fabric.unit_cell.axial_stiffness == pytest.approx((31.8e3, 31.8e3))
    assert {"crimp", "contact stiffness", "yarn bending", "sheet bending"} <= set(fabric.assumed)
    assert PRESETS["glass-polypropylene"]() == fabric
    assert fabric.unit_cell.warnings() == []


@pytest.mark.parametrize("name", [name for name in PRESETS if name.startswith("assumed")])
def test_assumed_fabrics_say_so(name):
    fabric = PRESETS[name]()
    assert fabric.assumed == ("everything",)
    assert "assumed" in fabric.name
    assert fabric.source.startswith("none")


def test_the_old_name_means_the_polynomial():
    assert PRESETS["glass-polypropylene"]() == PRESETS["glass-polypropylene-polynomial"]() == glass_polypropylene()


def test_hkust_is_the_curve_of_its_frame():
    """Within its own scatter of 1.5 N/m; the curve never falls, though the points do."""
    fabric = glass_polypropylene_hkust()
    angle, force = frame_curve("hkust")
    distance = fabric.shear.moment(angle) - force * np.cos(angle)
    assert np.sqrt(np.mean(distance**2)) == pytest.approx(1.5, rel=0.05)
    assert np.diff(fabric.shear.moment(np.linspace(0.0, angle[-1], 500))).min() > -1e-9
    assert fabric.shear_friction is None
    assert PRESETS["glass-polypropylene-hkust"]() == fabric
    # as published, read by hand: 2 N/m at 10 degrees, 41 at 30, 224 at 50
    published = np.array([1.266, 40.863, 224.48])
    assert np.interp(np.deg2rad([10.0, 30.0, 50.0]), angle, force) == pytest.approx(published, rel=1e-12)


def test_consensus_loads_along_the_mean_of_all_laboratories():
    """Elastic moment and friction together; their split at the start is the line of the curve from 2 to 10 degrees."""
    fabric = glass_polypropylene_consensus()
    angle, mean = consensus_moment()
    angle, mean = angle[angle < 0.786], mean[angle < 0.786]
    assert math.degrees(angle[-1]) == pytest.approx(45.0) == math.degrees(fabric.shear.trusted_angle)
    friction = fabric.shear_friction.moment_along(np.concatenate([[0.0], angle]))[1:]
    total = fabric.shear.moment(angle) + friction
    assert total[1:] == pytest.approx(mean[1:], rel=1e-12)
    assert total[0] == pytest.approx(mean[0], abs=0.7)
    # frames and bias extensions of Figs. 28 and 39 at 20 degrees: 29.42 and 28.07 N/m
    assert total[angle > 0.349][0] == pytest.approx(0.5 * (29.42 + 28.07) * math.cos(math.radians(20.0)), rel=1e-9)
    assert friction == pytest.approx(np.full(len(angle), 8.25), abs=0.01)
    assert np.diff(fabric.shear.moment(np.linspace(0.0, 1.5, 500))).min() >= 0.0
    least, largest = scatter_at(angle)
    assert np.all((least < total) & (total < largest))
    assert PRESETS["glass-polypropylene-consensus"]() == fabric


def test_polynomial_is_too_soft_at_small_angles():
    """Why there are measured presets."""
    small = np.deg2rad([1.0, 5.0, 10.0])
    angle, mean = consensus_moment()
    assert np.all(glass_polypropylene().shear.moment(small) < 0.4 * np.interp(small, angle, mean))


@pytest.mark.parametrize("laboratory", FRAME_LABORATORIES)
def test_frames_of_laboratories_are_kept(laboratory):
    angle, force = frame_curve(laboratory)
    assert angle[0] == force[0] == 0.0 and np.all(np.diff(angle) > 0.0) and angle[-1] < 0.95
    assert 35.0 < np.interp(math.radians(30.0), angle, force) < 70.0


def test_unknown_laboratory_is_refused():
    with pytest.raises(InputError, match="did you mean 'hkust'"):
        frame_curve("hkus")
