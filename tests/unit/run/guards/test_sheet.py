"""Guards of sheets that pass through themselves, fold, turn over, or enter their mirror image."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.judged import said
from tests.support.runs import small_run
from weavesim.engine.setup import Setup, Solver, World
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.interfaces import Interface
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Drive, Support
from weavesim.run.guards import Level
from weavesim.run.simulation import Simulation
from weavesim.run.watch.condition import Tally
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

GUARDS = {
    "self_intersection": "crossings", "folded_elements": "folded", "inverted_elements": "inverted",
}  # fmt: skip


@pytest.mark.parametrize(("guard", "what"), GUARDS.items())
@pytest.mark.parametrize(("share", "level"), [(0.002, Level.WARNING), (0.02, Level.DO_NOT_USE)])
def test_what_is_counted_is_doubted_by_its_share(guard, what, share, level):
    (doubt,) = said(guard, tallies={what: Tally(3.0, 5.0, 0.2, (0.01, 0.02), share)})
    assert doubt.level == level and doubt.text.startswith("5 ") and "3 at the end" in doubt.text
    assert (doubt.time, doubt.place, doubt.sheet) == (0.2, (0.01, 0.02), "sheet")
    assert said(guard) == []


@pytest.mark.parametrize(("beyond", "level"), [(4.0e-4, Level.WARNING), (4.3e-3, Level.DO_NOT_USE)])
def test_a_node_in_the_mirror_image_is_doubted(beyond, level):
    (doubt,) = said("beyond_symmetry", tallies={"beyond": Tally(0.0, beyond, 0.2, (0.0, 0.1))})
    assert doubt.level == level and f"{1e3 * beyond:.3g} mm beyond a symmetry plane" in doubt.text
    assert said("beyond_symmetry", tallies={"beyond": Tally(0.0, 1e-5)}) == []


def driven(where, travel: tuple[float, float, float], symmetry=(), length: float = 0.04):
    """A strip 20 mm wide, held at x = 0 or on a plane, whose nodes at ``where`` are moved by ``travel`` in 4 ms."""
    blank = Blank.rectangle((0.0, 0.0), (length, 0.02), 0.005)
    x = blank.node_position[:, 0]
    stroke = Stroke((0.0, 4e-3), (0.0, 1.0))
    supports = [Support("moved", np.flatnonzero(where(x)), (Drive(stroke, travel),))]
    if not symmetry:
        supports.append(Support("held", np.flatnonzero(x < 1e-9)))
    run = small_run(blank=blank, supports=tuple(supports), duration=4e-3, frame_count=1, symmetry=symmetry)
    run.run()
    return run


def spoken(run) -> dict:
    return {doubt.guard: doubt for doubt in run.doubts()}


def test_an_edge_that_is_pulled_through_the_sheet_is_seen():
    """One end goes up, the middle is pushed over it: the strip passes through itself."""
    run = driven(lambda x: x > 0.035, (-0.05, 0.004, -0.002))
    found = spoken(run)
    assert run.verdict == "do not use"
    assert {"folded_elements", "inverted_elements"} & set(found)


def test_an_edge_that_crosses_its_symmetry_plane_is_seen():
    found = spoken(driven(lambda x: x > 0.035, (-0.05, 0.0, 0.004), symmetry=("x",)))
    doubt = found["beyond_symmetry"]
    assert doubt.level == Level.DO_NOT_USE and doubt.value > 0.0145  # the driven nodes; free ones may be further
    assert doubt.place[0] > 0.0


def test_a_small_move_is_not_doubted():
    found = spoken(driven(lambda x: x > 0.035, (0.0, 0.0, 0.002)))
    assert not set(found) & {*GUARDS, "beyond_symmetry"}


@pytest.mark.parametrize(("share", "level"), [(0.002, Level.WARNING), (0.02, Level.DO_NOT_USE)])
def test_sheets_that_pass_through_each_other_are_doubted_by_their_share(share, level):
    tally = Tally(3.0, 5.0, 0.2, (0.01, 0.02), share)
    stack = SimpleNamespace(crossings={("ply_1", "ply_2"): tally, ("ply_2", "ply_3"): Tally()})
    (doubt,) = said("sheet_intersection", stacks=(stack,))
    assert doubt.level == level and doubt.text.startswith("5 pairs of triangles of ply_1 and ply_2 ")
    assert (doubt.time, doubt.place, doubt.sheet) == (0.2, (0.01, 0.02), "ply_1") and said("sheet_intersection") == []


def test_sheets_of_one_world_that_pass_through_each_other_are_seen_and_those_of_two_are_not():
    """The upper one moves down through the lower one."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    above = Blank.rectangle((0.003, 0.0), (0.023, 0.02), 0.005, height=1e-4)
    fabric = glass_polypropylene()
    falling = np.tile([0.0, 0.0, -1.0], (above.node_count, 1))
    tilted = falling * (1.0 + 100.0 * above.node_position[:, :1])
    sheets = (Sheet(blank, fabric, "lower"), Sheet(above, fabric, "upper", initial_velocity=tilted))
    settings = {"duration": 1e-4, "frame_count": 3, "solver": Solver(threads=1, lane_count=1)}
    together, record = Simulation(Setup("together", (World(sheets),), **settings)), CrossingRecord()
    together.run([record])
    (doubt,) = [doubt for doubt in together.doubts() if doubt.guard == "sheet_intersection"]
    assert doubt.sheet == "lower" and together.verdict == "do not use" and doubt.value > 0.0
    found = together.summary()["sheet_intersections"]["lower and upper"]
    assert found["at_end"] == 0 < found["most"] <= found["total"] and found["state_count"] > 3
    assert len(record.between["lower", "upper"]) == 4 and record.within == {"lower": [0] * 4, "upper": [0] * 4}
    assert 0 < max(record.between["lower", "upper"]) <= record.total

    worlds = tuple(World((sheet,), name=sheet.name) for sheet in sheets)
    apart, record = Simulation(Setup("apart", worlds, **settings)), CrossingRecord()
    apart.run([record])
    assert record.between == {} and "sheet_intersections" not in apart.summary()
    assert "sheet_intersection" not in {doubt.guard for doubt in apart.doubts()}


def started(height: float, *, interface: bool = True, shift: float = 0.0, upside_down: bool = False) -> Simulation:
    """A run, not yet prepared, of a sheet at ``height`` over another, of meshes that do not match."""
    fabric = glass_polypropylene()
    lower = Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.005)
    upper = Blank.rectangle((shift, 0.003), (0.03 + shift, 0.036), 0.004, height=height)
    names = ("upper", "lower") if upside_down else ("lower", "upper")
    world = World(
        (Sheet(lower, fabric, "lower"), Sheet(upper, fabric, "upper")),
        interfaces=(Interface(*names),) if interface else (),
    )
    solver = Solver(threads=1, lane_count=1, precision="float64")
    return Simulation(Setup("start", (world,), duration=1e-5, frame_count=1, solver=solver))


def of_start(simulation: Simulation) -> list:
    return [doubt for doubt in simulation.doubts() if doubt.guard == "start_of_stack"]


def test_plies_that_rest_on_each_other_start_without_a_doubt():
    thickness = glass_polypropylene().thickness
    assert of_start(started(thickness)) == of_start(started(2.0 * thickness)) == []
    assert of_start(started(0.0, shift=0.05)) == []  # beside each other


def test_a_small_overlap_is_doubted_and_a_large_one_refused():
    thickness = glass_polypropylene().thickness
    (doubt,) = of_start(started(0.9 * thickness))
    assert doubt.level == Level.WARNING and doubt.value == pytest.approx(0.1 * thickness) and doubt.sheet == "upper"
    for height in (0.7 * thickness, 0.0):
        with pytest.raises(InputError, match="lower and upper start inside each other by .* as LayUp does"):
            started(height).prepare()


def test_plies_in_the_other_order_are_refused():
    thickness = glass_polypropylene().thickness
    for given in ({"height": -thickness}, {"height": thickness, "upside_down": True}, {"height": -0.3 * thickness}):
        with pytest.raises(InputError, match="starts below .* exchange the two names"):
            started(**given).prepare()


@pytest.mark.parametrize("upside_down", [False, True])
def test_a_plate_within_a_ring_lies_below_it_though_the_far_side_is_below_the_plate(upside_down):
    fabric = glass_polypropylene()
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    nodes = np.array([[0.03 * np.sin(a), y, 0.03 * np.cos(a)] for a in angle for y in (-0.004, 0.004)])
    first = np.arange(24)
    ahead = np.roll(first, -1)
    ring = Blank.from_mesh(nodes, np.column_stack([2 * first, 2 * ahead, 2 * ahead + 1, 2 * first + 1]))
    plate = Blank.rectangle((-0.002, -0.002), (0.002, 0.002), 0.004, height=0.03 - fabric.thickness - 3e-4)
    names = ("ring", "plate") if upside_down else ("plate", "ring")
    world = World((Sheet(plate, fabric, "plate"), Sheet(ring, fabric, "ring")), interfaces=(Interface(*names),))
    solver = Solver(threads=1, lane_count=1, precision="float64")
    run = Simulation(Setup("start", (world,), duration=1e-5, frame_count=1, solver=solver, accept_unusual=True))
    if upside_down:
        with pytest.raises(InputError, match="starts below .* exchange the two names"):
            run.prepare()
    else:
        assert of_start(run) == []


def test_sheets_that_touch_without_an_interface_are_doubted():
    thickness = glass_polypropylene().thickness
    for height in (thickness, 0.5 * thickness, 0.0, -thickness):
        (doubt,) = of_start(started(height, interface=False))
        assert doubt.level == Level.WARNING and "give the world an interface" in doubt.advice
    assert of_start(started(1.5 * thickness, interface=False)) == []


def test_what_to_do_about_a_crossing_depends_on_the_interface():
    stack = SimpleNamespace(crossings={("lower", "upper"): Tally(3.0, 5.0, 0.2, (0.01, 0.02), 0.02)})
    (without,) = said("sheet_intersection", stacks=(stack,))
    assert "need an interface" in without.advice
    setup = started(glass_polypropylene().thickness).setup
    (within,) = said("sheet_intersection", stacks=(stack,), setup=setup)
    assert "did not hold them apart" in within.advice
