"""Sheets and worlds: every sheet of a run gets the bits that it gets alone, and sheets of one world share its tools."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.engine.model import Model
from weavesim.engine.setup import Setup, Solver, World
from weavesim.engine.sheet_model import CONTACT_SHARE
from weavesim.errors import InputError
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Plane, Sphere, rotation_matrix
from weavesim.tools.tool import Tool

FABRIC = glass_polypropylene()
STEP = 2.0e-6


def world(name: str, yarn_angle: float, radius: float, fabric: Fabric = FABRIC, size: float = 0.01) -> World:
    """A square that a ball lifts into a plane which a force presses down."""
    blank = Blank.rectangle((-0.03, -0.03), (0.03, 0.03), size, yarn_angle=yarn_angle)
    ball = Sphere(radius, origin=(0.0, 0.0, -radius - 0.5 * FABRIC.thickness))
    lid = Plane(origin=(0.0, 0.0, 0.0011), rotation=rotation_matrix((1.0, 0.0, 0.0), np.pi))
    tools = (
        Tool("punch", ball, Stroke((0.0, 0.02), (0.0, 0.02))),
        Tool("weight", lid, ForceDriven.constant(2.0, 0.05), axis=(0.0, 0.0, -1.0)),
    )
    dynamics = Dynamics(gravity=(0.0, 0.0, -9.81), damping=50.0)
    return World((Sheet(blank, fabric, name=name),), tools, dynamics=dynamics, name=name)


def run(*worlds: World, lane_count: int = 1, threads: int = 1) -> Simulation:
    solver = Solver(time_step=STEP, lane_count=lane_count, threads=threads)
    simulation = Simulation(Setup(name="worlds", worlds=worlds, duration=2e-3, frame_count=2, solver=solver))
    simulation.run()
    return simulation


@pytest.mark.parametrize(("lane_count", "threads"), [(1, 1), (16, 2)])
def test_two_sheets_under_two_sets_of_tools_get_the_bits_that_each_gets_alone(lane_count, threads):
    worlds = world("first", 45.0, 0.02), world("second", 0.0, 0.03, assumed_fabric("twill"), 0.012)
    both = run(*worlds, lane_count=lane_count, threads=threads)
    assert np.abs(both.frame.tool_reaction[:, 2]).min() > 0.1  # every tool is touched
    for k, own in enumerate(worlds):
        alone = run(own, lane_count=lane_count)
        assert alone.state.step_count == both.state.step_count >= 1000
        here, there = both.frame.sheets[k], alone.frame.sheets[0]
        assert here.position.tobytes() == there.position.tobytes() and here.energies == there.energies
        assert all(here.fields[name].tobytes() == there.fields[name].tobytes() for name in there.fields)
        tools = slice(2 * k, 2 * k + 2)
        assert np.array_equal(both.frame.tool_reaction[tools], alone.frame.tool_reaction)
        assert np.array_equal(both.frame.tool_displacement[tools], alone.frame.tool_displacement)


def test_energies_of_a_run_are_those_of_its_sheets_and_tools():
    both = run(world("first", 45.0, 0.02), world("second", 0.0, 0.03))
    energies, sheets = both.frame.energies, both.frame.sheets
    for name in ("internal", "kinetic", "contact", "gravity_work", "damping_loss"):
        assert energies[name] == pytest.approx(sum(sheet.energies[name] for sheet in sheets), rel=1e-12)
    assert max(abs(entry["balance_error"]) for entry in both.history) < 2e-3 * energies["supplied"]
    assert both.summary()["element_count"] == 2 * 36


def test_sheets_of_one_world_press_on_the_same_tools():
    """Two sheets side by side on one plane: it bears the weight of both."""
    sheets = tuple(
        Sheet(
            Blank.rectangle((x, 0.0), (x + 0.02, 0.02), 0.005, height=0.5 * FABRIC.thickness), FABRIC, name=f"at {x} m"
        )
        for x in (0.0, 0.1)
    )
    dynamics = Dynamics(gravity=(0.0, 0.0, -9.81), damping=2000.0)
    setup = Setup(
        name="table", sheets=sheets, tools=(Tool("table", Plane()),), dynamics=dynamics, duration=5e-3, frame_count=1,
        solver=Solver(precision="float64", lane_count=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    weight = 2 * 0.02**2 * FABRIC.areal_density * 9.81
    assert simulation.frame.tool_reaction[0, 2] == pytest.approx(-weight, rel=0.01)


def test_an_orientation_turns_the_yarns_and_nothing_else():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    turned = Sheet(blank, FABRIC, orientation=30.0).oriented_blank
    expected = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01, yarn_angle=30.0)
    np.testing.assert_allclose(turned.warp_direction, expected.warp_direction, atol=1e-15)
    np.testing.assert_allclose(turned.weft_direction, expected.weft_direction, atol=1e-15)
    assert turned.node_position.tobytes() == blank.node_position.tobytes()
    assert Sheet(blank, FABRIC).oriented_blank is blank


def test_one_sheet_is_asked_for_only_where_there_is_one():
    two = Setup(name="two", worlds=(world("first", 0.0, 0.02), world("second", 0.0, 0.02)), duration=1.0)
    with pytest.raises(InputError, match=r"2 sheets; use one of setup\.sheets"):
        _ = two.sheet
    model = Model(two)
    with pytest.raises(InputError, match=r"2 sheets: use one of model\.sheets"):
        _ = model.sheet
    assert [sheet.places.tools.start for sheet in model.sheets] == [0, 2]


def test_making_a_simulation_costs_nothing(monkeypatch):
    monkeypatch.setattr("weavesim.run.start.prepare", lambda setup: pytest.fail("prepared in the constructor"))
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    Simulation(one_sheet_setup(name="idle", blank=blank, fabric=FABRIC, duration=1.0))


def test_a_soft_sheet_beside_a_stiff_one_meets_tools_as_the_step_of_the_run_allows():
    """Its own step would let rubber sink into a tool; sheets that are alike keep their own."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.01)
    stiff = glass_polypropylene()
    soft = plain_fabric(
        areal_density=1.7, thickness=1.5e-3, unit_cell=LinearMembrane(warp_stiffness=4e3, weft_stiffness=4e3)
    )
    floor = Tool("floor", Plane(origin=(0.0, 0.0, -0.01)))

    def share(*fabrics):
        sheets = [Sheet(blank, fabric, name=f"sheet {k}") for k, fabric in enumerate(fabrics)]
        model = Model(Setup("made", sheets=sheets, tools=[floor], duration=1e-3))
        return [
            float((sheet.contact_stiffness / sheet.node_mass).max()) * model.reference_step**2 for sheet in model.sheets
        ]

    assert share(stiff, soft) == pytest.approx([CONTACT_SHARE, CONTACT_SHARE])
    assert share(soft) == pytest.approx([CONTACT_SHARE])
    # a few per cent more mass, and a longer step of its own
    like = stiff.model_copy(update={"areal_density": 1.1 * stiff.areal_density})
    assert share(stiff, like)[1] == pytest.approx(CONTACT_SHARE / 1.1)
