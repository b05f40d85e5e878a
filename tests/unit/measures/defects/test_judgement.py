"""Judgement: a sine of given amplitude and wavelength; a taut strip over a groove; locking; limits of the user."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.measures.defects.judgement import Judgement, Limits
from weavesim.measures.findings import FormedSheet
from weavesim.sheet.blank import Blank

THICKNESS = 1.0e-3
BLANK = Blank.rectangle((-0.15, -0.1), (0.15, 0.1), 0.0025)


def formed(position, **fields):
    count = BLANK.element_count
    values = {
        "warp_stretch": np.ones(count), "weft_stretch": np.ones(count), "warp_force": np.zeros(count),
        "weft_force": np.zeros(count), "shear_angle": np.zeros(count),
    }  # fmt: skip
    return FormedSheet(BLANK, position, values | fields, THICKNESS)


def rippled(amplitude=2e-3, wavelength=0.03, compression=1e-3):
    """Ripples in the middle, within a smooth envelope."""
    x, y = BLANK.material_coordinates.T
    envelope = 1.0 / (1.0 + np.exp((np.hypot(x, y) - 0.05) / 0.002))
    stretch = np.full(BLANK.element_count, 1.0 - compression)
    height = amplitude * envelope * np.sin(2.0 * np.pi * x / wavelength)
    return formed(np.column_stack([x, y, height]), warp_stretch=stretch)


def test_a_sine_under_compression_is_a_wrinkle_with_its_numbers():
    (region,) = Judgement(rippled(), Limits(longest_wavelength=0.06)).regions
    assert region.kind == "wrinkle"
    assert region.largest == pytest.approx(2e-3, rel=0.15) and region.wavelength == pytest.approx(0.03, rel=0.15)
    assert region.crest_count in (3, 4)
    assert region.severity == pytest.approx(region.largest / 1e-3)
    assert np.hypot(*region.flat_place) < 0.05
    assert region.area == pytest.approx(np.pi * 0.05**2, rel=0.35)
    row = region.as_dict()
    assert row["amplitude_mm"] == pytest.approx(1e3 * region.largest) and row["wavelength_mm"] > 25.0


def test_waves_without_compression_or_below_the_limit_are_none():
    assert not Judgement(rippled(compression=0.0), Limits()).regions
    assert not Judgement(rippled(), Limits(longest_wavelength=0.06, wrinkle_amplitude=3e-3)).regions
    assert not Judgement(rippled(), Limits(longest_wavelength=0.06, wrinkle_amplitude=None)).regions


def groove(points):
    """Distance to a flat tool with a groove of half width 15 mm along y, whose edges are rounded by nothing."""
    x, _, z = points.T
    beside = np.maximum(0.015 - np.abs(x), 0.0)
    return np.where(beside > 0.0, np.hypot(beside, z), z)


def test_a_taut_strip_over_a_groove_bridges_it():
    x, y = BLANK.material_coordinates.T
    flat = np.column_stack([x, y, np.full_like(x, 0.5 * THICKNESS)])
    taut = formed(flat, warp_force=np.full(BLANK.element_count, 200.0))
    judgement = Judgement(taut, Limits(), groove)
    (region,) = judgement.regions
    assert region.kind == "bridging"
    # in its middle the sheet is half the groove's width from the edges, but for half an element and the thickness
    assert region.largest == pytest.approx(np.hypot(0.015 - 0.00125, 0.5e-3) - 0.5e-3, rel=1e-9)
    assert abs(region.flat_place[0]) < 0.002
    assert judgement.fields["tool_curvature"][region.elements].min() < 0.0
    # all of the groove but where the gap is below the limit
    assert region.area == pytest.approx(0.2 * 2.0 * 0.015, rel=0.1)
    # slack, or over a ridge, it is no bridging; the gap alone can be limited too
    assert not Judgement(formed(flat), Limits(), groove).regions
    assert not Judgement(taut, Limits(), lambda p: np.hypot(p[:, 0], p[:, 2] + 0.05) - 0.05).regions
    (gap,) = Judgement(formed(flat), Limits(gap=5e-3), groove).regions
    assert gap.kind == "gap" and gap.largest == region.largest


def test_locking_is_the_fabrics_own_angle_or_the_users():
    x, y = BLANK.material_coordinates.T
    angle = np.where(BLANK.element_centres()[:, 0] > 0.1, -np.deg2rad(50.0), 0.0)
    sheet = formed(np.column_stack([x, y, np.zeros_like(x)]), shear_angle=angle)
    assert not Judgement(sheet, Limits()).regions
    (own,) = Judgement(sheet, Limits(), own_locking_angle=45.0).regions
    assert (own.kind, own.largest, own.severity) == ("locking", pytest.approx(50.0), pytest.approx(50.0 / 45.0))
    assert own.area == pytest.approx(0.05 * 0.2)
    assert not Judgement(sheet, Limits(locking_angle=55.0), own_locking_angle=45.0).regions


def test_small_regions_can_be_left_out():
    angle = np.zeros(BLANK.element_count)
    angle[1000] = 1.0
    sheet = formed(BLANK.node_position, shear_angle=angle)
    assert len(Judgement(sheet, Limits(locking_angle=40.0)).regions) == 1
    assert not Judgement(sheet, Limits(locking_angle=40.0, least_area=0.01)).regions


@pytest.mark.parametrize("wrong", [{"wrinkle_amplitude": 0.0}, {"bridging_gap": -1.0}, {"wrinkle": 1.0}])
def test_bad_limits_are_told(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Limits(**wrong)
