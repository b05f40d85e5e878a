"""Friction and loads that stages change: what is refused, what a stage has, and what it does."""

import numpy as np
import pytest

from weavesim import (
    Coulomb,
    Dynamics,
    Fixed,
    InputError,
    Interface,
    NodalLoads,
    Plane,
    PressureFriction,
    Setup,
    Sheet,
    SheetLoads,
    Simulation,
    Solver,
    Stage,
    Tool,
)
from weavesim.engine.staging.derive import acting_of, planned_begins, stage_setup
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank

BLANK = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.01)
FABRIC = glass_polypropylene()
PUSH = np.tile([0.01, 0.0, 0.0], (BLANK.node_count, 1))


def staged(*stages, friction=0.3, law=None, **given):
    floor = Tool("floor", Plane(origin=(0.0, 0.0, -0.5 * FABRIC.thickness)), Fixed(), friction=friction)
    upper = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.01, height=FABRIC.thickness)
    sheets = [Sheet(BLANK, FABRIC, name="a"), Sheet(upper, FABRIC, name="b")]
    return Setup(
        "changed", sheets=sheets, tools=[floor], interfaces=[Interface("a", "b", law or Coulomb(0.2))],
        stages=[Stage("first", 1e-3), *stages], **given,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: staged(Stage("s", 1e-3, friction={"flor": 0.1})), "no tool or interface 'flor'.*did you mean 'floor'"),
        (lambda: staged(Stage("s", 1e-3, friction={"a / b": 0.1}), law=PressureFriction((0.0, 1.0), (0.1, 0.2))),
         "friction of a / b is a PressureFriction: only a coefficient"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH))])), "sheet is required, one of a, b"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH), "c")])), "no sheet 'c'"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH[1:]), "a")])), "force has shape"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH), "a")] * 2)), "loads on a are given twice"),
        (lambda: staged(Stage("s", 1e-3, friction={"floor": -0.1})), "coefficient"),
    ],
)  # fmt: skip
def test_changes_that_cannot_be_are_refused(make, text):
    with pytest.raises(InputError, match=text):
        make()


def test_a_stage_has_what_was_said_last():
    loads = SheetLoads(NodalLoads(PUSH, times=(0.0, 1e-4), shares=(0.0, 1.0)), "a")
    setup = staged(
        Stage("dry", 1e-3, friction={"floor": 0.5, "a / b": 0.4}, loads=[loads]),
        Stage("wet", 1e-3, friction={"floor": 0.05}),
        Stage("free", 1e-3, loads=[]),
    )
    course = acting_of(setup)
    begins = planned_begins(setup, course)
    found = [stage_setup(setup, now, begins[: now.index + 1]) for now in course]
    assert [each.tools[0].friction for each in found] == [0.3, 0.5, 0.05, 0.05]
    assert [each.interfaces[0].friction.coefficient for each in found] == [0.2, 0.4, 0.4, 0.4]
    # every stage of a sheet has some loads, so that their work has its place
    assert [each.sheets[0].loads.force is not None for each in found] == [False, True, True, False]
    assert found[2].sheets[0].loads.times == pytest.approx((1e-3, 1.1e-3)) and found[0].sheets[1].loads is None


def test_a_lubricant_lets_a_pushed_sheet_slide():
    """A sheet on a floor under its weight and a push of 0.4 of it: held by mu = 0.5, accelerated at mu = 0.1."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.01, height=0.5 * FABRIC.thickness)
    floor = Tool("floor", Plane(), Fixed(), friction=0.5)
    weight = 9.81 * FABRIC.areal_density * 0.04 * 0.02
    mass = np.zeros(blank.node_count)
    np.add.at(mass, blank.quads.ravel(), 0.25 * FABRIC.areal_density * 1e-4)
    push = np.column_stack([0.4 * 9.81 * mass, np.zeros((len(mass), 2))])
    stages = (
        Stage("weigh", 0.02),
        Stage("push", 0.02, loads=[SheetLoads(NodalLoads(push, times=(0.0, 5e-3), shares=(0.0, 1.0)))]),
        Stage("oil", 0.02, friction={"floor": 0.1}),
    )
    setup = Setup(
        "oiled", sheets=[Sheet(blank, FABRIC)], tools=[floor], stages=stages, frame_count=6,
        dynamics=Dynamics(gravity=(0.0, 0.0, -9.81), damping=0.0), solver=Solver(precision="float64", lane_count=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    start, held = simulation.stages.frames["weigh"], simulation.stages.frames["push"]
    moved = [frame.sheet.position[:, 0].mean() - blank.node_position[:, 0].mean() for frame in (start, held)]
    slid = simulation.frame.sheet.position[:, 0].mean() - held.sheet.position[:, 0].mean()
    assert max(map(abs, moved)) < 1e-6
    # (0.4 - 0.1) g from rest
    assert slid == pytest.approx(0.5 * 0.3 * 9.81 * 0.02**2, rel=0.05)
    energies = simulation.frame.energies
    assert energies["load_work"] == pytest.approx(0.4 * weight * slid, rel=0.05)
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
