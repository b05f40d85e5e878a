"""The presets are the published fabrics, and say what is assumed."""

import math

import numpy as np
import pytest

from weavesim.fabric.presets import PRESETS, glass_polypropylene


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
