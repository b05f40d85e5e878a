"""What a calibration leaves in its folder reads back, and says where everything comes from."""

import csv
import json

import pytest

from tests.support.synthetic_laboratory import (
    BIAS_LENGTH,
    BIAS_WIDTH,
    FABRIC_SIDE,
    FRAME_SIDE,
    Laboratory,
    bias_extension,
    biaxial,
    cantilever,
    picture_frame,
    random_fabric,
)
from weavesim import load_fabric
from weavesim.calibration import calibrate, write_calibration
from weavesim.calibration.pictures import draws, fits
from weavesim.calibration.record import given_options
from weavesim.errors import InputError


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A calibration with every kind of test, and its folder."""
    folder = tmp_path_factory.mktemp("laboratory")
    true, laboratory = random_fabric(9), Laboratory(repeat_count=3, point_count=40)
    found = calibrate(
        "glass-polypropylene-polynomial", biaxial=biaxial(true, laboratory, folder, ratios=((1.0, 1.0), (1.0, 0.0))),
        picture_frame=picture_frame(true, laboratory, folder), frame_side=FRAME_SIDE, fabric_side=FABRIC_SIDE,
        bias_extension=bias_extension(true, laboratory, folder), bias_length=BIAS_LENGTH, bias_width=BIAS_WIDTH,
        cantilever=cantilever(true, laboratory, folder), starts=2, name="ours",
    )  # fmt: skip
    out = folder / "out"
    path = write_calibration(found, out)
    return found, out, path


def test_the_fabric_file_reads_back_equal(written):
    found, _, path = written
    assert load_fabric(path) == found.fabric and found.fabric.name == "ours"


def test_the_fabric_file_says_where_its_numbers_come_from(written):
    found, _, path = written
    text = path.read_text(encoding="utf-8")
    for file in found.files:
        assert file.sha256 in text
    assert "Values with 95 % intervals:" in text and "crossover_height = " in text
    fabric = load_fabric(path)
    for name in ("shear.moment_values", "unit_cell.warp_modulus", "bending.modulus", "shear_friction.limit"):
        origin = fabric.origin_of(name)
        assert origin and "calibrated by weavesim" in origin.source, name
    modulus = fabric.origin_of("unit_cell.warp_modulus")
    assert modulus.range[0] <= fabric.unit_cell.warp_modulus <= modulus.range[1]
    # what no test gave keeps what the given fabric says of it
    assert fabric.origin_of("thickness") == found.base.origin_of("thickness")


def test_the_record_has_all_numbers(written):
    found, out, _ = written
    record = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    assert record["options"] == json.loads(json.dumps(given_options(found)))
    assert record["estimates"]["bending"]["bending_stiffness"]["value"] == found.estimate("bending_stiffness").value
    assert set(record["residuals"]) == {"biaxial", "picture frame", "bias extension"}
    fit = record["fits"]["unit cell"]
    size = len(fit["fitted"])
    assert len(fit["correlations"]) == size and fit["correlations"][0][0] == pytest.approx(1.0)
    assert fit["condition_number_of_all"] >= fit["condition_number"] * 0.5
    assert [file["sha256"] for file in record["files"]] == [file.sha256 for file in found.files]


def test_every_point_is_in_the_table_of_curves(written):
    found, out, _ = written
    with open(out / "curves.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(fit.residual) for _, fit in fits(found))
    row = next(r for r in rows if r["test"] == "bias extension")
    assert row["line"] == "2" and row["specimen"] == "1" and row["unit"] == "N"
    assert {r["test"] for r in rows} == {"biaxial", "picture frame", "bias extension"}


def test_the_report_needs_nothing_else(written):
    _, out, _ = written
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == len(list((out / "pictures").glob("*.png"))) >= 8
    assert 'src="http' not in page and "SHA-256" in page and "Correlations" in page
    assert "moment at 45 degrees" in page and "degrees°" not in page
    for heading in ("Values of the unit cell", "Values of the shear", "Residuals", "Fit of the unit cell", "Files"):
        assert heading in page


def test_bands_are_drawn_from_the_intervals(written):
    found, _, _ = written
    (_, fit), *_ = fits(found)
    spread = draws(fit).std(axis=0)
    k = int(fit.chosen[0])
    assert spread[k] / fit.values[k] == pytest.approx(fit.half_width[k] / 1.96, rel=0.4)


def test_there_is_a_picture_for_every_test(written):
    _, out, _ = written
    names = [path.stem for path in (out / "pictures").glob("*.png")]
    for name in ("picture_frame", "bias_extension", "biaxial", "bending", "shear_law", "told_apart", "intervals"):
        assert name in names


def test_an_earlier_calibration_is_not_overwritten_unasked(written):
    found, out, _ = written
    with pytest.raises(InputError, match="it has calibration.json already; give another folder, or overwrite"):
        write_calibration(found, out)
