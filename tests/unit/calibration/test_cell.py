"""Unit cells of biaxial tests: recovered, reduced, or refused."""

import numpy as np
import pytest

from tests.support.synthetic_laboratory import Laboratory, biaxial, given_fabric, random_fabric
from weavesim.calibration import CalibrationOptions, calibrate
from weavesim.calibration.cell import cell_problem, ratios
from weavesim.calibration.readings import biaxial_tests
from weavesim.errors import InputError
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.presets import PRESETS, glass_polypropylene

EXACT = Laboratory(noise=0.0, specimen=0.0, repeat_count=1, point_count=30)


def given(folder, fabric, name="given.json"):
    path = folder / name
    path.write_text(fabric.to_json(), encoding="utf-8")
    return path


def test_exact_tests_give_all_parameters_back(tmp_path):
    true = random_fabric(5)
    base = given(tmp_path, given_fabric(true, 5))
    found = calibrate(base, biaxial=biaxial(true, EXACT, tmp_path), starts=3, full=True)
    cell = true.unit_cell
    for name, value in (
        ("yarn_stiffness", cell.axial_stiffness[0]), ("yarn_bending", cell.bending_stiffness[0]),
        ("crossover_height", cell.crossover_height), ("contact_stiffness", cell.contact_stiffness),
    ):  # fmt: skip
        assert found.estimate(name).value == pytest.approx(value, rel=1e-3), name
    assert found.fabric.unit_cell.axial_stiffness[0] == pytest.approx(cell.axial_stiffness[0], rel=1e-3)
    assert found.cell.reduced.fit.same_minimum == 3


def test_equal_strains_alone_do_not_tell_four_parameters(tmp_path):
    """The trial fit that found a condition number of 7e5 and L_3 = 0.03 mm: said, and reduced."""
    true = random_fabric(6)
    paths = biaxial(true, Laboratory(repeat_count=3, point_count=30), tmp_path, ratios=((1.0, 1.0),))
    base = given(tmp_path, given_fabric(true, 6))
    found = calibrate(base, biaxial=paths, starts=1)
    assert "yarn_bending" in found.cell.reduced.held and len(found.cell.reduced.held) >= 2
    assert found.cell.reduced.whole.condition > 1e4
    warning = next(w for w in found.warnings if "cannot tell" in w)
    assert "condition number" in warning and "held at the values of the given fabric" in warning
    assert found.cell.reduced.fit.condition < 1e3
    held = found.estimate("yarn_bending")
    assert held.state == "held" and held.value == pytest.approx(held.given) and not held.has_interval
    assert any("10 % more would change" in note for note in found.notes)
    assert "unit_cell: yarn_bending" in found.assumed
    whole = calibrate(base, biaxial=paths, starts=1, full=True)
    assert whole.estimate("yarn_bending").state != "held"
    assert any("do not trust them one by one" in warning for warning in whole.warnings)


def test_only_what_is_asked_for_is_fitted(tmp_path):
    true = random_fabric(5)
    found = calibrate(
        given(tmp_path, true), biaxial=biaxial(true, EXACT, tmp_path, ratios=((1.0, 0.0),)), starts=1,
        fit=("yarn_stiffness",),
    )  # fmt: skip
    assert [e.state for e in found.estimates["unit cell"]] == ["fitted", "held", "held", "held"]
    with pytest.raises(InputError, match="fit = 'yarn_stifness'.*did you mean 'yarn_stiffness'"):
        calibrate(given(tmp_path, true), biaxial=tmp_path / "biaxial_0.csv", fit=("yarn_stifness",))


def test_families_that_differ_get_their_own_values(tmp_path):
    true = random_fabric(7)
    cell = true.unit_cell.model_copy(update={"weft_modulus": 0.7 * true.unit_cell.weft_modulus})
    true = true.model_copy(update={"unit_cell": cell})
    paths = biaxial(true, EXACT, tmp_path)
    found = calibrate(given(tmp_path, glass_polypropylene()), biaxial=paths, starts=1, families="separate", full=True)
    assert found.estimate("weft_yarn_stiffness").value == pytest.approx(cell.axial_stiffness[1], rel=0.01)
    assert found.estimate("warp_yarn_stiffness").value == pytest.approx(cell.axial_stiffness[0], rel=0.01)


def test_a_linear_membrane(tmp_path):
    true = glass_polypropylene().model_copy(update={"shear_friction": None, "unit_cell": LinearMembrane(
        warp_stiffness=2.0e6, weft_stiffness=1.5e6, coupling_stiffness=1.0e5)})  # fmt: skip
    start = PRESETS["assumed-linear-membrane"]()
    found = calibrate(given(tmp_path, start), biaxial=biaxial(true, EXACT, tmp_path), starts=1, families="separate")
    cell = found.fabric.unit_cell
    assert (cell.warp_stiffness, cell.weft_stiffness) == pytest.approx((2.0e6, 1.5e6), rel=1e-4)
    assert cell.coupling_stiffness == pytest.approx(1.0e5, rel=1e-3)


def test_another_kind_of_cell_needs_names(tmp_path):
    paths = biaxial(random_fabric(5), EXACT, tmp_path, ratios=((1.0, 0.0),))
    with pytest.raises(InputError, match="UnidirectionalTape: fit is not given.*tow_stiffness"):
        calibrate("assumed-stitched-tape", biaxial=paths)
    found = calibrate("assumed-stitched-tape", biaxial=paths, fit=("tow_stiffness",), starts=1)
    assert found.estimate("tow_stiffness").state == "fitted"
    assert found.fabric.assumed[0] == "everything that no test gave"


def test_repeats_are_tests_along_one_path(tmp_path):
    paths = biaxial(random_fabric(5), Laboratory(repeat_count=2), tmp_path, ratios=((1.0, 0.0), (1.0, 1.0)))
    options = CalibrationOptions(fabric="glass-polypropylene", biaxial=tuple(paths))
    tests, _ = biaxial_tests(options)
    assert ratios(tests) == [0, 0, 1, 1]
    problem, model, scatters = cell_problem(tests, glass_polypropylene().unit_cell, options)
    assert len(problem.group_names) == 2 and "2 repeats" in scatters["biaxial"].source
    # the batch gives what single cells give
    sets = np.array([problem.start, 1.2 * problem.start])
    batch = model.predict(sets)
    np.testing.assert_allclose(batch[1], model.predict(sets[1:])[0])
