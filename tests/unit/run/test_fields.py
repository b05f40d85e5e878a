"""Fields of a frame: named once, with their units, and what the host derives of the kernel's rows."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import CellReportRow, ElementField
from weavesim.run.fields import FIELDS, UNIT_CELL_FAILURE, Field, add_field, complete


@pytest.fixture
def rows():
    rng = np.random.default_rng(0)
    return {row.name: 1.0 + 0.1 * rng.random(5) for row in ElementField}


@pytest.fixture
def report():
    values = np.array([0.0, 0.5, 1.0, 2.0, np.nan]) * UNIT_CELL_FAILURE
    return {name: values if name == "worst_residual" else np.full(5, 3.0) for name in CellReportRow.names()}


def test_rows_of_the_kernel_come_first_with_their_units():
    for field, row in zip(FIELDS, ElementField, strict=False):
        assert (field.name, field.unit, field.description) == (row.name, row.unit, row.description)
        assert field.derive is None
    assert len({field.name for field in FIELDS}) == len(FIELDS)


def test_derived_fields(rows, report):
    fabric = glass_polypropylene()
    fields = complete(fabric, rows, report)
    assert [*fields] == [field.name for field in FIELDS if field.name in fields]
    for name in rows:
        assert fields[name] is rows[name]
    assert fields["unit_cell_failed"].tolist() == [0.0, 0.0, 1.0, 1.0, 1.0]
    assert fields["unit_cell_iterations"].tolist() == [3.0] * 5
    area = fabric.unit_cell.crossover_area
    assert np.array_equal(fields["crossover_force"], rows["crossover_pressure"] * area)
    # fibres per current volume: their areal density over that of the glass, thickness and area
    volume = fields["thickness"] * rows["area_ratio"]
    assert fields["fibre_volume_fraction"] == pytest.approx(0.6 * 0.743 / 2550.0 / volume)


def test_a_fabric_without_known_fibres_has_no_fraction(rows, report):
    fabric = glass_polypropylene()
    compaction = fabric.compaction.model_copy(update={"fibre_areal_density": None, "fibre_density": None})
    fields = complete(fabric.model_copy(update={"compaction": compaction}), rows, report)
    assert "thickness" in fields and "fibre_volume_fraction" not in fields


def test_angles_are_degrees_in_files_and_say_so(rows):
    known = {field.name: field for field in FIELDS}
    angle, force = known["shear_angle"], known["warp_force"]
    assert angle.file_name == "shear_angle_deg"
    assert angle.in_file(rows["shear_angle"]) == pytest.approx(np.rad2deg(rows["shear_angle"]))
    assert force.file_name == "warp_force" and force.in_file(rows["warp_force"]) is rows["warp_force"]


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (Field("thickness", "m", "again", derive=lambda *given: None), "field thickness: one of this name exists"),
        (Field("colour", "1", "how red"), "field colour: derive is missing"),
    ],
)
def test_fields_that_are_refused(field, message):
    count = len(FIELDS)
    with pytest.raises(InputError, match=message):
        add_field(field)
    assert len(FIELDS) == count
