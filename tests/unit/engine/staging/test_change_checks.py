"""Friction and loads that stages change: what is refused, what a stage has, and what it does."""

import numpy as np
import pytest

from weavesim import (
    Coulomb,
    Dynamics,
    Fixed,
    FrictionOf,
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
    ViscousFilm,
    YarnAngleFriction,
)
from weavesim.engine.staging.derive import acting_of, planned_begins, stage_setup
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.friction_device import viscous_share
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
        (lambda: staged(Stage("s", 1e-3, friction={"floor": YarnAngleFriction((0.0, 90.0), (0.1, 0.2))})),
         "friction of floor: YarnAngleFriction depends on the angle"),
        (lambda: staged(Stage("s", 1e-3, friction=[FrictionOf("floor", 0.1), FrictionOf("floor", Coulomb(0.2))])),
         "friction of floor is given twice"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH))])), "sheet is required, one of a, b"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH), "c")])), "no sheet 'c'"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH[1:]), "a")])), "force has shape"),
        (lambda: staged(Stage("s", 1e-3, loads=[SheetLoads(NodalLoads(PUSH), "a")] * 2)), "loads on a are given twice"),
        (lambda: staged(Stage("s", 1e-3, friction={"floor": -0.1})), "friction"),
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


def pushed() -> tuple[Blank, SheetLoads]:
    """A sheet of 8 cm2 on a floor at z = 0, and a push of 0.4 of its weight."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.01, height=0.5 * FABRIC.thickness)
    mass = np.zeros(blank.node_count)
    np.add.at(mass, blank.quads.ravel(), 0.25 * FABRIC.areal_density * 1e-4)
    push = np.column_stack([0.4 * 9.81 * mass, np.zeros((len(mass), 2))])
    return blank, SheetLoads(NodalLoads(push, times=(0.0, 5e-3), shares=(0.0, 1.0)))


def formed(*stages, friction=0.5) -> Simulation:
    blank, _ = pushed()
    setup = Setup(
        "oiled", sheets=[Sheet(blank, FABRIC)], tools=[Tool("floor", Plane(), Fixed(), friction=friction)],
        stages=stages, frame_count=6, dynamics=Dynamics(gravity=(0.0, 0.0, -9.81), damping=0.0),
        solver=Solver(precision="float64", lane_count=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    return simulation


def slide(simulation: Simulation, since: str) -> float:
    """Way of the sheet along x from the end of a stage on [m]."""
    return float((simulation.frame.position - simulation.stages.frames[since].sheet.position)[:, 0].mean())


def test_a_lubricant_lets_a_pushed_sheet_slide():
    """Held by mu = 0.5, accelerated at mu = 0.1."""
    blank, load = pushed()
    simulation = formed(
        Stage("weigh", 0.02), Stage("push", 0.02, loads=[load]), Stage("oil", 0.02, friction={"floor": 0.1})
    )
    start, held = simulation.stages.frames["weigh"], simulation.stages.frames["push"]
    moved = [frame.sheet.position[:, 0].mean() - blank.node_position[:, 0].mean() for frame in (start, held)]
    assert max(map(abs, moved)) < 1e-6
    # (0.4 - 0.1) g from rest
    slid = slide(simulation, "push")
    assert slid == pytest.approx(0.5 * 0.3 * 9.81 * 0.02**2, rel=0.05)
    energies = simulation.frame.energies
    weight = 9.81 * FABRIC.areal_density * 0.04 * 0.02
    assert energies["load_work"] == pytest.approx(0.4 * weight * slid, rel=0.05)
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]


def test_a_stage_may_give_a_tool_a_law_and_take_it_away():
    """From a coefficient to a table of pressure, beyond whose end the sheet presses; then to a film, and back."""
    _, load = pushed()
    pressure = 9.81 * FABRIC.areal_density
    table = PressureFriction((0.0, 0.2 * pressure, 0.5 * pressure), (0.9, 0.3, 0.1))
    film = ViscousFilm(viscosity=20.0, thickness=1e-3)
    simulation = formed(
        Stage("weigh", 0.02), Stage("push", 0.02, loads=[load]),
        Stage("oil", 0.02, friction={"floor": table}), Stage("film", 0.01, friction={"floor": film}),
        Stage("dry", 0.02, friction={"floor": 0.9}),
    )  # fmt: skip
    frames = simulation.stages.frames
    way = {name: float(frames[name].sheet.position[:, 0].mean()) for name in ("weigh", "push", "oil", "film", "dry")}
    assert abs(way["push"] - way["weigh"]) < 1e-6
    # at the end of the table, 0.1
    assert way["oil"] - way["push"] == pytest.approx(0.5 * 0.3 * 9.81 * 0.02**2, rel=0.05)
    # m dv/dt = 0.4 m g - (eta / h) A v
    rate, speed, time = 20.0 / 1e-3 / FABRIC.areal_density, 0.3 * 9.81 * 0.02, 0.01
    rate *= simulation_share(simulation, film)
    final = 0.4 * 9.81 / rate
    expected = final * time + (speed - final) * (1.0 - np.exp(-rate * time)) / rate
    assert way["film"] - way["oil"] == pytest.approx(expected, rel=0.05)
    # mu = 0.9 stops it
    last = final + (speed - final) * np.exp(-rate * time)
    assert way["dry"] - way["film"] == pytest.approx(0.5 * last**2 / (0.5 * 9.81), rel=0.1, abs=2e-6)
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
    (doubt,) = [each for each in simulation.doubts() if each.guard == "tool_friction" and each.time is not None]
    assert "Pa of pressure" in doubt.text and 0.04 < doubt.time < 0.061 and doubt.place is not None


def simulation_share(simulation: Simulation, film: ViscousFilm) -> float:
    """Share of the drag of a film that the step carries, as the guard tells it."""
    (rate,) = simulation.model.carried_rates()
    return viscous_share(film, rate)
