"""Forces of tools at every point of a sheet: those that the next step applies, as pressures whose sums are known."""

import numpy as np
import pytest

from tests.support.every_kind import ONE_LANE, carried
from tests.support.runs import one_sheet_run
from weavesim import Simulation, StribeckFriction
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven
from weavesim.run.relaxation import relax
from weavesim.scenes.laboratory.sled import SledParameters, sled
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

FABRIC = glass_polypropylene()
HALF = 0.5 * FABRIC.thickness
UPSIDE_DOWN = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
LAW = StribeckFriction((0.0, 1e-5, 1e-4, 1e-3), (0.35, 0.15, 0.1, 0.3), 0.02)


def rubbed(precision="float64", samples="nodes", **solver):
    """A sheet that slides between two balls, after 200 steps; its bits depend on nothing else."""
    tools = [
        Tool("lower", Sphere(0.05, origin=(0.01, 0.01, -0.05 - HALF)), friction=0.3),
        Tool("upper", Sphere(0.05, origin=(0.015, 0.01, 0.05 + HALF)), ForceDriven.constant(-20.0, 0.01), friction=0.2),
    ]
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=20.0)
    simulation = one_sheet_run(
        name="rubbed", blank=blank, fabric=FABRIC, tools=tools, duration=1.0, precision=precision,
        initial_velocity=np.tile([0.4, 0.1, -0.1], (blank.node_count, 1)), accept_unusual=True,
        dynamics=Dynamics(contact_samples=samples), **({"threads": 1} | solver),
    )  # fmt: skip
    simulation.stepper.advance(10)
    return simulation


def by_a_law():
    """A sled on a table whose friction is a law, met between the nodes too, half of its way."""
    setup = sled(SledParameters(mesh_size=0.03, frame_count=2, threads=1), friction=LAW)
    dynamics = setup.worlds[0].dynamics.model_copy(update={"contact_samples": "surface"})
    world = setup.worlds[0].model_copy(update={"dynamics": dynamics})
    simulation = Simulation(setup.model_copy(update={"worlds": (world,)}))
    simulation.stepper.advance_to(0.5 * setup.duration)
    return simulation


def on_a_drum():
    """The same between two tools that turn, one of which is carried along a path and rubs by a law."""
    simulation = Simulation(carried(ONE_LANE))
    simulation.stepper.advance(10)
    return simulation


@pytest.mark.parametrize(
    ("run", "tolerance"),
    [
        (lambda: rubbed("float64"), 1e-11),
        (lambda: rubbed("float32"), 1e-4),
        (lambda: rubbed("float64", "surface"), 1e-11),
        (by_a_law, 1e-4),
        (on_a_drum, 1e-11),
    ],
    ids=["double", "single", "between nodes", "law", "carried"],
)
def test_their_sum_is_the_force_that_the_next_step_applies(run, tolerance):
    simulation = run()
    frame = simulation.take_frame()
    forces = simulation.ledger.sheets[0].tool_forces()
    total = -(forces.push[..., None] * forces.normal + forces.drag).sum(axis=1)
    applied = simulation.stepper.look_ahead().tool_force.numpy()
    size = np.abs(applied).max()
    assert size > 0.01 and np.abs(forces.drag).sum() > 0.02 * forces.push.sum()
    assert (forces.push > 0.0).any(axis=1).all()
    assert total == pytest.approx(applied, abs=tolerance * size)
    # pressures times areas are the same forces
    area = frame.fields["area_ratio"] * simulation.model.sheet.geometry.area
    for face, pushed in zip(("below", "above"), forces.push.sum(axis=1), strict=False):
        assert frame.fields[f"tool_pressure_{face}"] @ area == pytest.approx(pushed, rel=1e-6)
    rubbing = sum(frame.fields[f"tool_friction_{face}"] @ area for face in ("below", "above"))
    assert rubbing == pytest.approx(np.linalg.norm(forces.drag, axis=2).sum(), rel=1e-6)


def test_taking_frames_changes_no_bit_and_threads_change_none_of_theirs():
    first, second = rubbed("float32"), rubbed("float32", threads=2)
    for _ in range(3):
        first.take_frame()
    for simulation in (first, second):
        simulation.stepper.advance(2)
    fields = [simulation.take_frame().fields for simulation in (first, second)]
    for name in ("tool_pressure_below", "tool_pressure_above", "tool_friction_below", "tool_friction_above"):
        assert fields[0][name].any() and np.array_equal(fields[0][name], fields[1][name])
    assert first.state.sheet.motion.numpy().tobytes() == second.state.sheet.motion.numpy().tobytes()


def test_a_flat_tool_presses_with_its_force_over_the_area():
    """A plate of a known force on a sheet on a table: the same pressure everywhere, on both faces."""
    side, force = 0.02, 8.0
    tools = [
        Tool("table", Plane(origin=(0.0, 0.0, -HALF))),
        Tool("plate", Plane(origin=(0.0, 0.0, HALF), rotation=UPSIDE_DOWN), ForceDriven.constant(-force, 0.05)),
    ]
    simulation = one_sheet_run(
        name="pressed", blank=Blank.rectangle((0.0, 0.0), (side, side), 0.005), fabric=FABRIC, tools=tools,
        duration=1.0, precision="float64", threads=1,
    )  # fmt: skip
    relax(simulation, tolerance=1e-6)
    fields = simulation.frame.fields
    for face in ("below", "above"):
        assert fields[f"tool_pressure_{face}"] == pytest.approx(force / side**2, rel=1e-3)
        assert fields[f"tool_friction_{face}"] == pytest.approx(0.0, abs=0.05)


def test_a_sheet_that_touches_nothing_has_no_pressure_and_one_without_tools_no_such_field():
    far = Tool("far", Plane(origin=(0.0, 0.0, -0.1)))
    settings = {"blank": Blank.rectangle((0.0, 0.0), (0.01, 0.01), 0.005), "fabric": FABRIC, "duration": 1.0}
    fields = one_sheet_run(name="far", tools=[far], **settings).frame.fields
    assert not fields["tool_pressure_below"].any() and not fields["tool_friction_above"].any()
    assert not [name for name in one_sheet_run(name="alone", **settings).frame.fields if name.startswith("tool_")]
