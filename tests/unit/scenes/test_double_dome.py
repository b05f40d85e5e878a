"""The default tools of the double dome fit the fabric (field case 16), and own tools are checked against it."""

import pytest

from weavesim.fabric.file import resolve_fabric
from weavesim.run.simulation import Simulation
from weavesim.scenes.double_dome import (
    SMALLEST_CLEARANCE,
    DoubleDomeParameters,
    double_dome,
    expected_draw_in,
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
