"""Which steps keep their corner records in a ring, and that no bit depends on it."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from tests.support.stacked_plies import THICKNESS, ply, square, stack_setup
from weavesim import Simulation
from weavesim.engine.tiling import division
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import ToolWatchRow
from weavesim.process import Coulomb
from weavesim.process.dynamics import Dynamics
from weavesim.process.grippers import Gripper
from weavesim.process.pressure import Pressure
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

LANES = 16


@pytest.fixture
def small(monkeypatch):
    """Sheets of any size count as large, and tiles are small."""
    monkeypatch.setattr(division, "LARGE_SHEET", 0)
    monkeypatch.setattr(division, "TILE_SIZE", 64)


def thrown_sheet(lane_count: int = LANES, quads=None, **given):
    """A free sheet in motion that touches a ball."""
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.2), 0.005)
    x, y = (blank.node_position / 0.005).T[:2]
    velocity = np.column_stack([0.0 * x, 0.0 * x, np.sin(x * y)])
    tools = [Tool("ball", Sphere(0.02, origin=(0.05, 0.1, 0.0205)))]
    settings = {"lane_count": lane_count, "duration": 1.0, "threads": 2, "initial_velocity": velocity, "tools": tools}
    return one_sheet_run(name="thrown", blank=blank, fabric=glass_polypropylene(), **(settings | given))


def rings(simulation, thread_count: int) -> list[bool]:
    return [sheet.ring is not None for sheet in simulation.stepper._launches.divided(thread_count)]


@pytest.mark.parametrize("threads", [1, 2])
def test_a_ring_changes_no_bit(small, monkeypatch, precision, threads):
    found = []
    for share in (0.0, division.LARGEST_SHARE):
        monkeypatch.setattr(division, "LARGEST_SHARE", share)
        simulation = thrown_sheet(precision=precision, threads=threads)
        simulation.stepper._choice.count = threads
        assert rings(simulation, threads) == [share > 0.0]
        simulation.stepper.advance(12)
        found.append(everything(simulation))
    assert found[0] == found[1]
    assert simulation.state.tool_watch.numpy()[ToolWatchRow.peak].max() > 0.0


def test_a_small_sheet_has_none():
    assert rings(thrown_sheet(), 1) == [False]


def test_neither_has_a_sheet_on_a_gpu(small):
    assert rings(thrown_sheet(lane_count=1), 1) == [False]


def test_more_threads_than_pay_have_none(small):
    """Each of them keeps a row of tiles for the next one."""
    simulation = thrown_sheet()
    assert [rings(simulation, count)[0] for count in (1, 2, 12)] == [True, True, False]


@pytest.mark.parametrize(
    "given",
    [
        {"grippers": [Gripper("left", np.arange(20), (1.0, 0.0, 0.0), 1.0e3)]},
        {"dynamics": Dynamics(contact_samples="surface")},
    ],
    ids=["gripper", "contact between nodes"],
)
def test_what_looks_for_forces_of_elements_by_their_entries_finds_them_in_the_state(small, given):
    assert rings(thrown_sheet(**given), 1) == [False]


def everything(run) -> dict[str, bytes]:
    """Every array of the state but the records of the last step."""
    arrays = run.state.arrays()
    return {name: array.numpy().tobytes() for name, array in arrays if not name.endswith("corner_force")}


@pytest.mark.parametrize("threads", [1, 2])
def test_pressures_and_plies_change_no_bit_in_a_ring(small, monkeypatch, threads):
    """A ply slides on another, both under pressure: reactions and pressures go into the ring."""
    sheets = [
        ply("lower", square(0.06, 0.004), pressures=(Pressure("bottom", (2e4,)),)),
        ply("upper", square(0.05, 0.0035, THICKNESS), (2.0, 1.0, 0.0), pressures=(Pressure("top", (2e4,)),)),
    ]
    found = []
    for share in (0.0, division.LARGEST_SHARE):
        monkeypatch.setattr(division, "LARGEST_SHARE", share)
        solver = {"precision": "float32", "lane_count": LANES, "threads": threads}
        run = Simulation(stack_setup(sheets, Coulomb(0.2), duration=4e-3, solver=solver))
        run.stepper._choice.count = threads
        assert rings(run, threads) == 2 * [share > 0.0]
        run.stepper.advance(10)
        found.append(everything(run))
    assert found[0] == found[1]
    assert all(each.works_sum.numpy().any() for each in run.state.passes)
    assert all(own.pressure_work.numpy().any() for own in run.state.sheets)
