"""The biaxial test as a user runs it: forces against the unit cell by itself and against known numbers."""

import numpy as np
import pytest

from tests.support.tables import columns
from weavesim.errors import InputError
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.scenes.laboratory import biaxial
from weavesim.scenes.laboratory.biaxial import BiaxialParameters

COARSE = {"mesh_size": 0.025, "frame_count": 20, "threads": 1}


def test_biaxial_pulls_as_its_unit_cell_beside_a_measured_curve(tmp_path):
    """Glass, weft strained half as much; the table has 0.9 times the forces of a run, with a decimal comma."""
    parameters = BiaxialParameters(out=tmp_path / "first", ratio=0.5, write="summary,tables", **COARSE)
    summary = biaxial.SCENE.run(parameters)
    assert summary["energy_balance_error"] < 0.01
    assert summary["largest_force_error_ratio"] < 2e-3
    assert summary["warp_strain_percent"] == pytest.approx(1.0) and summary["weft_strain_percent"] == pytest.approx(0.5)
    table = columns(tmp_path / "first" / "biaxial.csv")
    rows = zip(table["largest_strain_percent"], table["warp_force_n_per_m"], table["weft_force_n_per_m"], strict=True)
    lines = [f"{0.01 * a:.8f};{0.9e-3 * b:.6f};{0.9e-3 * c:.6f}".replace(".", ",") for a, b, c in rows]
    path = tmp_path / "test.csv"
    path.write_text("strain [-];Warp force [N/mm];Weft force [N/mm]\n" + "\n".join(lines[:-1]) + "\n")
    again = BiaxialParameters(out=tmp_path / "second", ratio=0.5, measured=path, write="summary,pictures", **COARSE)
    compared = biaxial.SCENE.run(again)
    assert len(compared["measured_rms_difference_ratio"]) == 2
    for share in compared["measured_largest_difference_ratio"].values():
        assert share == pytest.approx(0.1 / 0.9, rel=0.02)
    assert (tmp_path / "second" / "pictures" / "force.png").exists()


@pytest.mark.parametrize(("ratio", "strains"), [(0.0, (0.02, 0.0)), (4.0, (0.005, 0.02))])
def test_straight_yarns_pull_as_their_stiffness_says(ratio, strains):
    cell = PlainWeave.straight(stiffness_per_width=2.0e4, spacing=0.005, bending=1.001 * 2.0e4 * 0.005**3 / 12.0)
    glass = glass_polypropylene()
    fabric = glass.model_copy(update={"unit_cell": cell, "shear": glass.shear.locking_at_most(100.0)})
    parameters = BiaxialParameters(ratio=ratio, largest_strain=0.02, **COARSE)
    curves = biaxial.record(parameters, fabric)
    Simulation(biaxial.biaxial(parameters, fabric)).run([curves])
    found = [curves.columns[f"{yarn}_force_n_per_m"][-1] for yarn in ("warp", "weft")]
    assert found == pytest.approx(2.0e4 * np.array(strains), rel=2e-3, abs=1.0)


@pytest.mark.parametrize(
    ("given", "message"), [({"ratio": -1.0}, "ratio"), ({"largest_strain": 2.0}, "largest_strain.*at most 0.5")]
)
def test_nonsense_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        BiaxialParameters(**given)
