"""What is read off a formed sheet: each number once, from one place, with its unit in its key."""

import dataclasses

import numpy as np
import pytest

from tests.support.flat_blanks import FULL, HALF_LENGTH, HALF_WIDTH, QUARTER, blank_of
from weavesim.measures import findings
from weavesim.measures.findings import SHEET_FINDINGS, Finding, FormedSheet, found
from weavesim.measures.units import DEGREES, MILLIMETRES, PURE, UNITS, split_unit
from weavesim.sheet.blank import Blank


def pressed(symmetry=QUARTER, **given) -> FormedSheet:
    """Plan scaled by 0.9 in x and 0.8 in y, an odd shear angle, warp 1 % and weft 2 % longer."""
    blank = blank_of(symmetry)
    centre = blank.element_centres()
    fields = {
        "shear_angle": -30.0 * centre[:, 0] * centre[:, 1],
        "warp_stretch": np.full(blank.element_count, 1.01),
        "weft_stretch": np.full(blank.element_count, 1.02),
        "thickness": np.linspace(1.0e-3, 1.5e-3, blank.element_count),
    }
    settings = {"position": blank.node_position * (0.9, 0.8, 1.0), "fields": fields, "thickness": 1.2e-3}
    return FormedSheet(blank, **(settings | {"symmetry": symmetry} | given))


@pytest.mark.parametrize("symmetry", [QUARTER, FULL])
def test_numbers_of_a_pressed_sheet(symmetry):
    points = np.array([[0.11, 0.067], [HALF_LENGTH, 0.0]])
    numbers = found(SHEET_FINDINGS, pressed(symmetry, points=points))
    largest = np.rad2deg(30.0 * (HALF_LENGTH - 0.01) * (HALF_WIDTH - 0.01))
    assert numbers["max_shear_angle_deg"] == pytest.approx(largest)
    assert (numbers["min_stretch"], numbers["max_stretch"]) == (1.01, 1.02)
    assert numbers["shear_angle_points_deg"] == pytest.approx([np.rad2deg(30.0 * 0.11 * 0.067), 0.0], abs=1e-9)
    assert (numbers["min_thickness_mm"], numbers["max_thickness_mm"]) == (1.0, 1.5)
    assert numbers["draw_in_long_axis_mm"] == pytest.approx(0.1 * 240.0)
    assert numbers["draw_in_short_axis_mm"] == pytest.approx(0.2 * 140.0)
    assert numbers["integrated_yarn_stretch_long_axis_mm"] == pytest.approx(0.01 * 240.0)
    assert numbers["integrated_yarn_stretch_short_axis_mm"] == pytest.approx(0.02 * 140.0)
    assert numbers["close_pair_count"] == 0


def test_what_means_nothing_is_left_out():
    numbers = found(SHEET_FINDINGS, pressed(has_draw_in=False))
    assert not [key for key in numbers if "draw_in" in key or "yarn_stretch" in key]
    assert "shear_angle_points_deg" not in numbers and "max_fibre_volume_fraction" not in numbers


def test_a_blank_away_from_the_axes_has_no_draw_in():
    blank = Blank.rectangle((0.1, 0.1), (0.2, 0.2), 0.02)
    fields = {name: np.ones(blank.element_count) for name in ("shear_angle", "warp_stretch", "weft_stretch")}
    sheet = FormedSheet(blank, blank.node_position, fields, 1.0e-3)
    assert sheet.draw_in_mm == {} and not sheet.meets_both_lines


def test_yarns_across_the_axes_have_no_lengthening_along_them():
    sheet = pressed(FULL)
    turned = blank_of(FULL, yarn_angle=45.0)
    assert dataclasses.replace(sheet, blank=turned).yarn_stretch_mm == {}


def test_angles_at_points_are_computed_once(monkeypatch):
    calls = []
    measure = findings.shear_angle_at
    monkeypatch.setattr(findings, "shear_angle_at", lambda *given: calls.append(given) or measure(*given))
    sheet = pressed(points=np.array([[0.1, 0.05]]))
    for _ in range(3):
        assert found(SHEET_FINDINGS, sheet)["shear_angle_points_deg"] == sheet.point_angles_deg.tolist()
    assert len(calls) == 1


def test_keys_end_in_their_units():
    for finding in SHEET_FINDINGS:
        assert split_unit(finding.key) == (finding.name, finding.unit)
        assert finding.description
    assert len({finding.key for finding in SHEET_FINDINGS}) == len(SHEET_FINDINGS)


def test_a_number_of_ones_own():
    area = Finding("corner_distance", MILLIMETRES, "how far the corner went", lambda sheet: 1.0e3 * sheet.thickness)
    assert found((area,), pressed()) == {"corner_distance_mm": 1.2}


@pytest.mark.parametrize(
    ("key", "name", "symbol"),
    [
        ("draw_in_mm", "draw_in", "mm"), ("kinetic_j", "kinetic", "J"), ("time_step_s", "time_step", "s"),
        ("element_steps_per_second", "element_steps", "1/s"), ("shear_force_n_per_m", "shear_force", "N/m"),
        ("frame_angle_deg", "frame_angle", "°"), ("element_count", "element_count", ""), ("m", "m", ""),
    ],
)  # fmt: skip
def test_units_of_keys(key, name, symbol):
    found_name, unit = split_unit(key)
    assert (found_name, unit.symbol) == (name, symbol)
    assert unit.named(name) == key


def test_units_are_written_behind_numbers():
    assert (DEGREES.after("3"), MILLIMETRES.after("3"), PURE.after("3")) == ("3°", "3 mm", "3")
    endings = [unit.ending for unit in UNITS]
    assert len(set(endings)) == len(endings)
