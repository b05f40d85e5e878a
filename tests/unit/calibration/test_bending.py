"""Bending stiffness of cantilevers and bending lengths."""

import math

import numpy as np
import pytest
from scipy.stats import t

from tests.support.synthetic_laboratory import Laboratory, cantilever, random_fabric
from weavesim.calibration import calibrate
from weavesim.calibration.bending import LARGEST_ANGLE, LEAST_ANGLE, _stiffness
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.closed_forms import elastica_stiffness, heavy_elastica
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.proportions import GRAVITY

WEIGHT = 0.743 * GRAVITY


def table(folder, text):
    path = folder / "cantilever.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_bending_lengths_give_the_stiffness_of_peirce():
    lengths = (0.044, 0.046, 0.045)
    found = calibrate("glass-polypropylene", bending_length=lengths)
    (entry,) = found.estimates["bending"]
    values = WEIGHT * np.array(lengths) ** 3
    half = t.ppf(0.975, 2) * values.std(ddof=1) / math.sqrt(3)
    assert entry.value == pytest.approx(values.mean())
    assert (entry.low, entry.high) == pytest.approx((values.mean() - half, values.mean() + half))
    assert found.fabric.bending.strip_stiffness("warp", found.fabric.thickness) == pytest.approx(entry.value, rel=1e-6)


def test_a_chord_angle_gives_the_stiffness_of_the_elastica(tmp_path):
    load, angle = heavy_elastica(math.radians(35.0))
    length = (load * 6.0e-4 / WEIGHT) ** (1.0 / 3.0)
    rows = "".join(f"{1e3 * length:.6f},{math.degrees(angle):.6f}\n" for _ in range(2))
    found = calibrate("glass-polypropylene", cantilever=table(tmp_path, "overhang [mm],chord angle [deg]\n" + rows))
    assert found.estimate("bending_stiffness").value == pytest.approx(6.0e-4, rel=1e-3)


def test_warp_and_weft_become_a_law_of_yarns(tmp_path):
    text = "warp overhang [mm];weft overhang [mm]\n90;80\n92;82\n91;81\n"
    found = calibrate("glass-polypropylene", cantilever=table(tmp_path, text))
    law = found.fabric.bending
    assert isinstance(law, YarnBending)
    assert law.warp == pytest.approx(np.mean(WEIGHT * np.array([0.045, 0.046, 0.0455]) ** 3), rel=1e-6)
    assert law.weft < law.warp
    base = glass_polypropylene()
    before = base.bending.strip_stiffness("warp", base.thickness)
    assert law.twist == pytest.approx(0.5 * math.sqrt(law.warp * law.weft) / before * before, rel=1e-6)
    assert "bending.twist" in found.assumed and found.fabric.origin_of("bending.twist").assumed


def test_one_specimen_has_no_interval_and_says_so():
    found = calibrate("glass-polypropylene", bending_length=0.045)
    assert not found.estimate("bending_stiffness").has_interval
    assert any("no interval can be stated" in warning for warning in found.warnings)


def test_a_stiffness_that_changes_with_the_overhang_is_said(tmp_path):
    rows = []
    for slope in (8.0, 14.0, 20.0, 26.0, 32.0, 38.0):
        load, angle = heavy_elastica(math.radians(slope))
        stiffness = 6.0e-4 * load ** (-0.5)  # softer where it is bent more
        rows.append(f"{1e3 * (load * stiffness / WEIGHT) ** (1 / 3):.5f},{math.degrees(angle):.5f}")
    path = table(tmp_path, "overhang [mm],angle [deg]\n" + "\n".join(rows) + "\n")
    found = calibrate("glass-polypropylene", cantilever=path)
    assert any("changes with the overhang" in warning for warning in found.warnings)


def test_specimens_of_a_known_fabric(tmp_path):
    true = random_fabric(8)
    found = calibrate("glass-polypropylene", cantilever=cantilever(true, Laboratory(), tmp_path))
    entry = found.estimate("bending_stiffness")
    assert entry.low < true.bending.strip_stiffness("warp", true.thickness) < entry.high


@pytest.mark.parametrize("angle", [LEAST_ANGLE, math.radians(20.0), math.radians(60.0), LARGEST_ANGLE])
def test_the_table_of_the_elastica_is_exact(angle):
    assert _stiffness(0.1, angle, WEIGHT) == pytest.approx(elastica_stiffness(angle, 0.1, WEIGHT), rel=1e-4)


def test_a_curve_of_the_given_fabric_is_replaced_and_that_is_said(tmp_path):
    base = glass_polypropylene()
    curve = BendingCurve(curvature=(0.0, 10.0, 20.0), moment_values=(0.0, 8.0e-3, 1.2e-2))
    curved = base.model_copy(update={"bending": YarnBending(warp=curve, weft=7.0e-4, twist=1.0e-4)})
    path = tmp_path / "curved.json"
    path.write_text(curved.to_json(), encoding="utf-8")
    found = calibrate(path, bending_length=(0.044, 0.046))
    assert isinstance(found.fabric.bending.warp, float)
    assert any("are replaced by constant stiffnesses" in note for note in found.notes)
