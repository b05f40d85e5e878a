"""Compaction as a user runs it: thickness under pressure against the law, and beside a measured curve."""

import pytest

from weavesim.errors import InputError
from weavesim.fabric.compaction import Compaction
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.scenes.laboratory import compaction
from weavesim.scenes.laboratory.compaction import CompactionParameters

COARSE = {"mesh_size": 0.025, "frame_count": 20, "threads": 1}


def test_compaction_follows_its_law_beside_a_measured_curve(tmp_path):
    """The table has the law's own t0 / (1 + p / E_c), in other units, with E_c = 11.78 MPa of the preset."""
    modulus = glass_polypropylene().unit_cell.crossover_modulus
    rows = "".join(f"{1e-5 * p:.6f};{1.2 / (1.0 + p / modulus):.8f}\n" for p in (1e3, 1e4, 5e4, 9e4))
    (tmp_path / "plates.csv").write_text("pressure [bar];thickness [mm]\n" + rows)
    summary = compaction.SCENE.run(
        CompactionParameters(out=tmp_path / "out", measured=tmp_path / "plates.csv", write="summary,pictures", **COARSE)
    )
    # of the work of the run: the first watched state has a hundredth of it, at strains of 1e-5 in single precision
    energies = summary["energies_j"]
    assert abs(energies["balance_error"]) < 0.01 * energies["used"]
    assert summary["pressure_pa"] == pytest.approx(1.0e5, rel=1e-3)
    assert summary["plates_thickness_mm"] == pytest.approx(1.2 / (1.0 + 1.0e5 / modulus), rel=1e-5)
    assert summary["largest_thickness_error_ratio"] < 1e-5
    assert summary["thickness_mm"] < summary["plates_thickness_mm"]  # the pulled sheet is wider too
    (share,) = summary["measured_largest_difference_ratio"].values()
    assert share < 1e-4
    assert (tmp_path / "out" / "pictures" / "thickness.png").exists()


def test_a_given_modulus_and_fibres_count():
    law = Compaction(crossover_modulus=1.0e6, thickening=0.0, fibre_areal_density=0.4, fibre_density=2550.0)
    fabric = glass_polypropylene().model_copy(update={"compaction": law})
    parameters = CompactionParameters(**COARSE)
    curves = compaction.record(fabric, parameters)
    Simulation(compaction.compaction(parameters, fabric)).run([curves])
    last = {name: values[-1] for name, values in curves.columns.items()}
    assert last["plates_thickness_mm"] == pytest.approx(1.2 / 1.1, rel=1e-4)
    assert last["plates_fibre_volume_percent"] == pytest.approx(100.0 * 0.4 / 2550.0 / (1.2e-3 / 1.1), rel=1e-4)


def test_what_cannot_be_compacted_is_refused():
    with pytest.raises(InputError, match="gives only .* Pa; reduce it"):
        compaction.compaction(CompactionParameters(largest_pressure=5.0e7))
    with pytest.raises(InputError, match="no crossovers that flatten"):
        compaction.compaction(CompactionParameters(), assumed_fabric("linear-membrane"))
