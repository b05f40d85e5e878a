"""The uniaxial test as a user runs it: force and contraction against the unit cell that is free to pull in."""

import pytest

from weavesim.errors import InputError
from weavesim.scenes.laboratory import uniaxial
from weavesim.scenes.laboratory.uniaxial import UniaxialParameters


@pytest.mark.parametrize("yarn", ["warp", "weft"])
def test_a_slender_strip_pulls_as_its_unit_cell(tmp_path, yarn):
    """The clamps hold the yarns across over about a width: 2 % of the length here, 25 % in the standard's strip."""
    parameters = UniaxialParameters(
        out=tmp_path, yarn=yarn, length=0.4, width=0.02, mesh_size=0.005, speed=0.4, frame_count=20, threads=1,
        write="summary,pictures",
    )  # fmt: skip
    summary = uniaxial.SCENE.run(parameters)
    assert summary["energy_balance_error"] < 0.01
    assert summary["force_ratio"] == pytest.approx(1.0, abs=0.02)
    assert summary["across_strain_percent"] < -1.0
    assert summary["middle_strain_percent"] == pytest.approx(1.0, abs=0.01)
    assert summary["force_n"] == pytest.approx(0.02 * summary["force_n_per_m"])
    names = {path.name for path in (tmp_path / "pictures").iterdir()}
    assert {"force.png", "force_displacement.png", "across.png"} <= names


def test_a_wide_strip_is_stiffer_than_one_that_is_free_to_pull_in(tmp_path):
    parameters = UniaxialParameters(
        out=tmp_path, length=0.1, width=0.1, mesh_size=0.0125, speed=0.1, frame_count=20, threads=1, write="summary"
    )
    assert 1.05 < uniaxial.SCENE.run(parameters)["force_ratio"] < 1.6


@pytest.mark.parametrize(
    ("given", "message"), [({"yarn": "bias"}, "yarn"), ({"largest_strain": 0.0}, "largest_strain")]
)
def test_nonsense_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        UniaxialParameters(**given)
