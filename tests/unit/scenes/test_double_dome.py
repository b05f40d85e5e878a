"""The default tools of the double dome fit the fabric (field case 16), and own tools are checked against it."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.frames import Frames
from weavesim.errors import InputError
from weavesim.fabric.file import resolve_fabric
from weavesim.run.simulation import Simulation
from weavesim.run.verdict import Judged
from weavesim.scenes.dome_holder import SMALLEST_CLEARANCE
from weavesim.scenes.double_dome import (
    DoubleDomeParameters,
    double_dome,
    expected_draw_in,
    springback,
)
from weavesim.tools.shapes import DomeOpening


@pytest.fixture(params=[0.4, 1.2, 1.3, 2.0, 3.5])
def thickness(request, tmp_path):
    """[m], of a fabric file."""
    file = tmp_path / "thick.toml"
    file.write_text(f'based_on = "glass-polypropylene"\nname = "thick"\nthickness = {1e-3 * request.param}\n')
    return 1e-3 * request.param, str(file)


def opening(setup) -> DomeOpening:
    return setup.tools[1].shape


def test_a_fabric_of_any_thickness_gets_tools_that_leave_room_for_it(thickness):
    thick, file = thickness
    parameters = DoubleDomeParameters(fabric=file, mesh_size=0.03, stroke=0.012, frame_count=1)
    setup = double_dome(parameters)
    assert setup.sheet.fabric.thickness == pytest.approx(thick)
    assert opening(setup).radius - setup.tools[0].shape.radius == pytest.approx(max(thick, SMALLEST_CLEARANCE))
    simulation = Simulation(setup)
    simulation.run()
    assert not {"closing_gap", "start_overlap"} & {doubt.guard for doubt in simulation.doubts()}
    assert expected_draw_in(parameters, simulation)["taut_path_draw_in_mm"] > 0.0


def test_the_default_tools_are_what_they_were():
    setup = double_dome(DoubleDomeParameters())
    assert opening(setup).radius == 0.060 + 0.0012
    assert setup.sheet.fabric == resolve_fabric("glass-polypropylene")


COARSE = {"mesh_size": 0.03, "stroke": 0.02, "frame_count": 2}


@pytest.fixture(scope="module")
def released():
    """A run with a release, its parameters, and its frames."""
    parameters = DoubleDomeParameters(release=True, release_damping=20.0, **COARSE)
    simulation, frames = Simulation(double_dome(parameters)), Frames()
    assert springback(simulation) == {}
    simulation.run([frames])
    return parameters, simulation, frames.all


def test_a_release_begins_at_the_formed_sheet_of_a_run_without_it(released):
    _, simulation, _ = released
    plain = Simulation(double_dome(DoubleDomeParameters(**COARSE)))
    plain.run()
    assert np.array_equal(simulation.stages.frames["forming"].position, plain.frame.position)
    assert plain.stages.frames == {} and springback(plain) == {} and not plain.setup.supports
    # what the tools did is judged as it is without a release
    at_release = Judged(simulation)
    assert at_release.damping_share < Judged(simulation).share_of_supplied("damping_loss")
    assert max(entry["time"] for entry in at_release.last_quarter) <= plain.frame.time


def test_a_released_sheet_comes_to_rest_and_tells_its_springback(released):
    parameters, simulation, frames = released
    assert [told["ended_by"] for told in simulation.stages.ended] == ["duration", "rest"]
    last = frames[-1]
    assert last.stage == "release" and not last.tool_acts.any() and not last.tool_reaction.any()
    most = max(frame.energies["supplied"] for frame in frames)
    assert max(abs(frame.energies["balance_error"]) for frame in frames) < 0.01 * most
    assert simulation.summary()["energy_balance_error"] < 0.01
    assert frames[-1].energies["internal"] < 0.1 * simulation.stages.frames["forming"].energies["internal"]
    found = springback(simulation)
    formed = next(frame for frame in reversed(frames) if frame.stage == "forming")
    moved = np.linalg.norm(last.position - formed.position, axis=1)
    middle = simulation.setup.supports[0].nodes[0]
    assert found["springback_mm"] == pytest.approx(1e3 * moved.max()) and found["springback_mm"] > 5.0
    assert moved[middle] < 1e-6
    angles = [np.rad2deg(np.abs(frame.fields["shear_angle"]).max()) for frame in (formed, last)]
    assert found["formed_max_shear_angle_deg"] == pytest.approx(angles[0])
    assert found["springback_max_shear_angle_deg"] == pytest.approx(angles[1] - angles[0])
    assert expected_draw_in(parameters, simulation) == {}


@pytest.mark.parametrize(
    ("part", "held"),
    [("quarter", [("z", "")]), ("half", [("xz", "y")]), ("full", [("xyz", "xy"), ("y", "")])],
)
def test_a_free_sheet_is_held_against_the_rigid_motions_that_symmetry_leaves(part, held):
    setup = double_dome(DoubleDomeParameters(release=True, part=part, mesh_size=0.005))
    assert [(support.displacements, support.rotations) for support in setup.supports] == held
    forming, release = setup.stages
    assert forming.supports == () and release.tools == () and len(release.supports) == len(held)


def test_the_length_of_a_release_needs_one():
    with pytest.raises(InputError, match="release"):
        DoubleDomeParameters(release_duration=1.0)


def test_a_free_sheet_without_a_middle_node_is_refused():
    with pytest.raises(InputError, match="no node in its middle"):
        double_dome(DoubleDomeParameters(release=True, part="full", mesh_size=0.03))


@pytest.mark.parametrize(
    ("given", "samples"),
    [
        ({}, "surface"),
        ({"mesh_size": 0.0025}, "nodes"),
        ({"mesh_size": 0.01}, "nodes"),
        ({"mesh_size": 0.0025, "contact_samples": "surface"}, "surface"),
        ({"contact_samples": "nodes"}, "nodes"),
        ({"punch": Path("punch.stl")}, "nodes"),
    ],
)
def test_elements_that_would_sink_meet_the_default_tools_between_nodes_too(given, samples):
    """Samples near meshes are looked at in every step, which is slow."""
    assert DoubleDomeParameters(**given).meets_between_nodes == (samples == "surface")
    if "punch" not in given:
        (world,) = double_dome(DoubleDomeParameters(**given)).worlds
        assert world.dynamics.contact_samples == samples
        assert world.dynamics.contact_allowance == (0.04 if samples == "surface" else 0.0)
