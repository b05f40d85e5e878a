"""Numbers of a run by their names, and measures of its waves."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.errors import InputError
from weavesim.measures.defects.judgement import Limits
from weavesim.study.measures import flattened, formed_run, resolved, study_numbers, unit_of


def test_a_summary_becomes_numbers_by_dotted_names():
    summary = {
        "a_mm": 1.5, "force_n": {"punch": 2}, "sheets": [{"name": "p", "a_mm": 3}], "points_deg": [1.0, 2.0],
        "ok": True, "text": "no", "wall_time_s": 9.0, "none": None,
    }  # fmt: skip
    assert flattened(summary) == {
        "a_mm": 1.5, "force_n.punch": 2, "sheets.p.a_mm": 3, "points_deg.1": 1.0, "points_deg.2": 2.0, "ok": 1,
    }  # fmt: skip


def test_a_measure_is_found_with_or_without_its_unit():
    known = {"max_shear_p99_deg", "wrinkle_area_mm2", "force_n.punch", "sheets.a.x_mm", "sheets.b.x_mm"}
    assert resolved("max_shear_p99", known) == resolved("max_shear_p99_deg", known) == "max_shear_p99_deg"
    assert resolved("wrinkle_area", known) == "wrinkle_area_mm2"
    assert resolved("force.punch", known) == "force_n.punch"
    with pytest.raises(InputError, match="several numbers have this name; write one of sheets.a.x_mm, sheets.b.x_mm"):
        resolved("x_mm", known)
    with pytest.raises(InputError, match="did you mean 'wrinkle_area'"):
        resolved("wrinkel_area", known)


@pytest.mark.parametrize(
    ("key", "unit"), [("a_mm2", "mm²"), ("a_deg", "°"), ("peak_n.punch", "N"), ("sheets.p.a_mm", "mm"), ("count", "")]
)
def test_a_measure_has_the_unit_of_its_name(key, unit):
    assert unit_of(key) == unit


def test_percentiles_and_means_are_by_area():
    run = formed_run(small_run(), Limits())
    (judged,) = run.sheets
    values = np.arange(16.0)
    judged.fields["shear_angle_deg"] = values
    assert run.percentile("shear_angle_deg", 50.0) == pytest.approx(7.5)
    assert run.mean_square_root("shear_angle_deg") == pytest.approx(np.sqrt(np.mean(values**2)))
    assert not run.has_tools


def test_a_flat_sheet_has_no_wrinkles():
    numbers = study_numbers(small_run(), Limits())
    assert numbers["wrinkle_count"] == 0 and numbers["max_shear_p99_deg"] < 1e-6
    assert numbers["wave_amplitude_rms_mm"] < 1e-6
    assert "largest_bridging_gap_mm" not in numbers
