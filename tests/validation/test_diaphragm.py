"""Plies between two diaphragms are drawn over a dome in three stages."""

import json

import numpy as np
import pytest

from weavesim.run.guards import Level
from weavesim.run.simulation import Simulation
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.scenes.diaphragm import SCENE, DiaphragmParameters, diaphragm, rubber

# A forming run of half a minute.
pytestmark = pytest.mark.slow

COARSE = {"mesh_size": 0.016, "frame_count": 16, "threads": 1, "drawing": 0.06, "evacuation": 0.02, "rise_speed": 0.4}


@pytest.fixture(scope="module")
def formed(tmp_path_factory):
    """A coarse run with all results, and what passed through what."""
    parameters = DiaphragmParameters(**COARSE, out=tmp_path_factory.mktemp("diaphragm"))
    setup = diaphragm(parameters)
    simulation, record = Simulation(setup), CrossingRecord()
    simulation.run([record])
    return parameters, simulation, record


def test_the_stages_follow_each_other_and_the_ledger_closes(formed):
    _, simulation, record = formed
    assert [told["name"] for told in simulation.stages.ended] == ["evacuate", "rise", "draw"]
    assert all(told["reached"] for told in simulation.stages.ended)
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
    assert energies["pressure_work"] > 0.0 and energies["tool_work"] > 0.0
    assert record.total == 0
    assert max((doubt.level for doubt in simulation.doubts()), default=Level.NOTE) < Level.DO_NOT_USE


def test_the_vacuum_clamps_and_the_pressure_draws(formed):
    parameters, simulation, _ = formed
    frames = simulation.stages.frames
    # between the plies, away from their edges, the vacuum presses
    lower, blank = frames["evacuate"].sheets[1], simulation.info.sheets[1].blank
    inner = np.abs(blank.material_coordinates[blank.quads].mean(axis=1)).max(axis=1) < 0.3 * parameters.ply_side
    assert lower.fields["ply_pressure_above"][inner].mean() == pytest.approx(parameters.vacuum, rel=0.03)
    found = SCENE.findings(parameters, simulation, None)
    assert found["touching_share"] > 0.4
    assert max(found["largest_diaphragm_strain"].values()) < 0.4
    # the pole of the plies lies on the dome, through the lower diaphragm
    stack = 1.5 * parameters.rubber_thickness + simulation.info.sheets[1].fabric.thickness
    pole = simulation.frame.sheets[1].position[:, 2].max()
    assert pole == pytest.approx(parameters.rise + stack - 0.5 * parameters.rubber_thickness, abs=1.5e-3)
    angles = [np.degrees(np.abs(sheet.fields["shear_angle"])).max() for sheet in simulation.frame.sheets]
    assert min(angles) > 5.0


def test_the_same_bits_for_any_number_of_threads():
    """Four sheets that touch, in all stages, each a millisecond long: three threads on two cores are slow."""
    short = {"evacuation": 4e-4, "rise": 1e-3, "rise_speed": 1.0, "drawing": 4e-4, "frame_count": 3}
    ends = []
    for threads in (1, 3):
        simulation = Simulation(diaphragm(DiaphragmParameters(**(COARSE | short | {"threads": threads}))))
        simulation.run()
        assert len(simulation.stages.ended) == 3 and simulation.stepper.thread_count == threads
        assert simulation.frame.energies["ply_contact"] > 0.0
        ends.append({name: array.numpy().tobytes() for name, array in simulation.state.arrays()})
    assert ends[0] == ends[1]


def test_rubber_is_isotropic_at_small_strains():
    """Stretched along its yarns or across them, Young's modulus; sheared, its shear modulus."""
    parameters = DiaphragmParameters()
    fabric, modulus, ratio = rubber(parameters), parameters.rubber_modulus, 0.49
    cell, thickness = fabric.unit_cell, parameters.rubber_thickness
    own = cell.warp_stiffness - cell.coupling_stiffness**2 / cell.weft_stiffness
    assert own / thickness == pytest.approx(modulus)
    assert fabric.shear.moment(np.array([1e-4]), thickness)[0] / (1e-4 * thickness) == pytest.approx(
        modulus / (2.0 * (1.0 + ratio)), rel=1e-6
    )


def test_a_job_has_the_same_stages(tmp_path):
    from weavesim.job.read import read_job
    from weavesim.job.scenes import scene_of

    path = tmp_path / "bag.toml"
    path.write_text('[scene]\nname = "diaphragm"\nforming_pressure = "0 Pa"\nmesh_size = "16 mm"\n')
    scene, parameters = scene_of(read_job(path), out=tmp_path / "out")
    (setup,) = scene.setups(parameters).values()
    assert [stage.name for stage in setup.stages] == ["evacuate", "rise"]
    assert json.loads(setup.to_json())["stages"][1]["name"] == "rise"
