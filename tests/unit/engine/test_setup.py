"""A set-up is a value: equal, hashed and the same through JSON and pickle, also in a fresh process, for every kind."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import weavesim
from tests.support.paths import ROOT
from tests.support.registered_cells import KnottedNet
from tests.support.registered_laws import TERMS
from tests.support.registered_shapes import SHAPES as FORMULAS
from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.app.command_line import SCENES
from weavesim.checks import json_schema
from weavesim.device import Precision
from weavesim.engine.setup import LANE_COUNTS, Rest, Setup, Solver, World
from weavesim.errors import InputError
from weavesim.fabric.presets import PRESETS, glass_polypropylene
from weavesim.kernels.lane_types import CPU_LANE_COUNT, GPU_LANE_COUNT
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.motions.paths import PathMotion
from weavesim.process.strokes import Fixed, ForceDriven, Motion, SmoothStroke, Stroke
from weavesim.process.supports import Drive, Support
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.segments.opening import DomeOpeningSector
from weavesim.tools.shapes import Plane, Shape, Sphere, Torus, Union, rotation_matrix
from weavesim.tools.tool import Tool

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.03), 0.01, yarn_angle=30.0, distortion=0.1)
TURN = rotation_matrix((1.0, 0.3, 0.0), 0.7)
TRIANGLES = {"vertices": np.eye(4, 3) / 3.0, "faces": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]}
SHAPES = (
    *(shape.placed((0.0, 0.1, 1.0 / 3.0), TURN) for shape in FORMULAS),
    DomeOpeningSector(0.1, 0.02, 0.01, 10.0, 80.0),
    Union((Sphere(0.1), Union((Plane(), Torus(0.1, 0.3)), rotation=TURN))),
    MeshShape.from_triangles(**TRIANGLES, mirror=(), origin=(0.0, 0.0, 0.1)),
)
STROKE = SmoothStroke.ramped(1e-3, speed=1.0, ramp_time=1e-4)
MOTIONS = (Fixed(), Stroke.smooth(0.1, 1.0, 0.02), ForceDriven.constant(3.0, 2.0, 0.1))


def kinds_of_weavesim(family: type) -> set[type]:
    """Without those that tests have defined."""
    return {kind for kind in family.kinds().values() if kind.__module__.startswith("weavesim.")}


def every_tool() -> Setup:
    tools = [Tool(f"tool {k}", shape, MOTIONS[k % 3], axis=(1.0, 1.0, k)) for k, shape in enumerate(SHAPES)]
    assert {type(tool.shape) for tool in tools} == kinds_of_weavesim(Shape)
    assert {type(tool.motion) for tool in tools} | {SmoothStroke, PathMotion} == kinds_of_weavesim(Motion)
    return Setup(
        "tools", sheets=[Sheet(BLANK, glass_polypropylene())], tools=tools, duration=1.0, leading_tool=3,
        accept_unusual=True,
        solver=Solver(precision="float64", threads=2, lane_count=1, time_step=1e-7, target_step=1e-6, step_safety=0.3),
    )  # fmt: skip


def everything_at_nodes() -> Setup:
    count = BLANK.node_count
    free = np.ones((count, 6), dtype=bool)
    free[2, 1] = False
    wave = np.sin(np.arange(3.0 * count)).reshape(count, 3)
    drives = (Drive(STROKE, (0.0, 1.0, 0.0)), Drive(Stroke((0.0, 1.0), (0.0, 1e-3)), np.ones((2, 3)) / 3.0))
    supports = (Support("grip", [4, 5], drives, rotations=""), Support("held", [7], displacements="xz"))
    loads = NodalLoads(force=wave, couple=0.1 * wave, times=(0.0, 0.1), shares=(0.0, 1.0 / 3.0))
    sheet = Sheet(
        BLANK, glass_polypropylene(), "ply", orientation=15.0, free=free, initial_velocity=wave, supports=supports,
        loads=loads,
    )  # fmt: skip
    other = World([Sheet(BLANK, glass_polypropylene(), "variant")], name="variant", dynamics=Dynamics((0, 0, -9.81)))
    return Setup("nodes", worlds=[World([sheet]), other], duration=0.1, rest=Rest(0.01, 1e-6))


def scene_setups(name: str) -> dict[str, Setup]:
    scene = SCENES[name].load()
    return scene.setups(scene.parameters())


SETUPS = {
    "every tool": every_tool,
    "everything at nodes": everything_at_nodes,
    **{
        f"preset {name}": lambda make=make: one_sheet_setup(name="preset", blank=BLANK, fabric=make(), duration=1.0)
        for name, make in PRESETS.items()
    },
    **{
        f"law {name}": lambda law=law: one_sheet_setup(
            name="law", blank=BLANK, fabric=plain_fabric(**law), duration=1.0, accept_unusual=True
        )
        for name, (law, _) in TERMS.items()
    },
    **{f"scene {name}": lambda name=name: list(scene_setups(name).values())[-1] for name in SCENES},
}
VALIDATOR = Draft202012Validator(json_schema(Setup))


@pytest.mark.parametrize("name", SETUPS)
def test_json_and_pickle_give_an_equal_value(name):
    setup = SETUPS[name]()
    text = setup.to_json()
    for there in (Setup.from_json(text), pickle.loads(pickle.dumps(setup))):
        assert there == setup and hash(there) == hash(setup) and there.to_json() == text
    VALIDATOR.validate(json.loads(text))


def test_every_value_is_the_same_in_a_fresh_process(tmp_path):
    hashes = {}
    for name, make in SETUPS.items():
        setup = make()
        hashes[name] = setup.content_hash
        (tmp_path / f"{name}.json").write_text(setup.to_json(), encoding="utf-8")
        (tmp_path / f"{name}.pickle").write_bytes(pickle.dumps(setup))
    code = """
import json, pathlib, pickle, sys
from weavesim import Setup
folder = pathlib.Path(sys.argv[1])
found = {}
for file in folder.glob("*.json"):
    there = Setup.from_json(file.read_text(encoding="utf-8"))
    assert there == pickle.loads(file.with_suffix(".pickle").read_bytes())
    found[file.stem] = there.content_hash
assert "warp" not in sys.modules
print(json.dumps(found))
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout) == hashes


def test_a_double_dome_is_set_up_without_warp():
    code = """
import sys
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome
setup = double_dome(DoubleDomeParameters(mesh_size=0.02))
assert len(setup.tools) == 3 and setup.content_hash
print("warp" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_the_hash_sees_every_setting():
    setup = everything_at_nodes()
    sheet = setup.sheets[0]
    for change in (
        {"name": "other"}, {"duration": np.nextafter(setup.duration, 1.0)}, {"frame_count": 61}, {"rest": None},
        {"solver": Solver(threads=2)}, {"worlds": setup.worlds[::-1]},
        {"worlds": [World([sheet.model_copy(update={"orientation": 16.0})]), setup.worlds[1]]},
    ):  # fmt: skip
        changed = setup.model_copy(update=change)
        assert changed != setup and changed.content_hash != setup.content_hash


def test_a_cell_of_a_user_is_known_once_its_module_is_imported():
    fabric = plain_fabric(unit_cell=KnottedNet(thread=3.0e4))
    text = one_sheet_setup(name="net", blank=BLANK, fabric=fabric, duration=1.0).to_json()
    assert Setup.from_json(text).sheet.fabric.unit_cell == fabric.unit_cell
    with pytest.raises(InputError, match="kind = 'UnknownNet': .* import the module that defines"):
        Setup.from_json(text.replace('"KnottedNet"', '"UnknownNet"'))


def test_lanes_are_those_of_the_kernels():
    assert LANE_COUNTS == (GPU_LANE_COUNT, CPU_LANE_COUNT)
    assert Solver().lanes(is_cpu=True) == CPU_LANE_COUNT and Solver().lanes(is_cpu=False) == GPU_LANE_COUNT
    assert Solver(lane_count=GPU_LANE_COUNT).lanes(is_cpu=True) == GPU_LANE_COUNT


def test_a_setup_of_one_world_is_short():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.03), 0.01)
    sheets, tools = (Sheet(blank, glass_polypropylene()),), (Tool("table", Plane()),)
    short = Setup("run", sheets=sheets, tools=tools, symmetry=("y",), dynamics=Dynamics(damping=1.0), duration=1.0)
    world = World(sheets=sheets, tools=tools, symmetry=weavesim.Symmetry(("y",)), dynamics=Dynamics(damping=1.0))
    assert short == Setup("run", worlds=(world,), duration=1.0)
    assert short.sheets == sheets and short.tools == tools and short.sheet is short.worlds[0].sheets[0]
    assert Solver().precision is Precision.SINGLE


SHEET = Sheet(BLANK, glass_polypropylene())
HELD = SHEET.model_copy(update={"supports": (Support("grip", [1]),)})


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Setup("run", duration=1.0), "worlds: is required"),
        (lambda: Setup("run", worlds=[], duration=1.0), "worlds: at least one is needed"),
        (lambda: Setup("run", sheets=[], duration=1.0), "at least one sheet is needed"),
        (lambda: Setup("run", tools=[], duration=1.0), "sheets: is required"),
        (lambda: Setup("run", worlds=[World([SHEET])], sheets=[SHEET], duration=1.0), "sheets: belong in worlds"),
        (
            lambda: Setup("run", sheets=[SHEET, SHEET], duration=1.0),
            "sheets: the name 'sheet' of entry 1 is .* already",
        ),
        (lambda: Setup("run", worlds=[World([SHEET])] * 2, duration=1.0), "worlds: the name 'world' of entry 1"),
        (
            lambda: Setup("run", sheets=[HELD, HELD.model_copy(update={"name": "upper"})], duration=1.0),
            "supports: the name 'grip' of entry 1",
        ),
        (lambda: World([SHEET], [Tool("table", Plane())] * 2), "tools: the name 'table' of entry 1"),
        (lambda: World([SHEET], [Tool("", Plane())]), "Tool: name = '': a name is needed"),
        (lambda: World([SHEET], symmetry=("x", "x")), "list each plane once"),
        (
            lambda: World([Sheet(Blank.rectangle((0.1, 0.0), (0.2, 0.1), 0.05), glass_polypropylene())], symmetry="x"),
            "symmetry",
        ),
        (lambda: Setup("run", sheets=SHEET, duration=1.0), r"sheets = Sheet\(...\): give a list$"),
        (lambda: World([SHEET], Tool("table", Plane())), r"^World: tools = Tool\(...\): give a list$"),
        (lambda: Setup("run", World([SHEET]), duration=1.0), r"^Setup: worlds = World\(...\): give a list$"),
        (lambda: Setup("run", sheets=[SHEET], duration=1.0, leading_tool=7), "leading_tool = 7: there are 0 tools"),
        (lambda: Rest(-1.0, 0.1), "after = -1.0"),
        (lambda: Rest(1.0, 0.0), "kinetic_share = 0.0"),
        (lambda: Solver(threads=0), "threads = 0: 1 to 256 threads"),
        (lambda: everything_at_nodes().sheet, "it has 2 sheets"),
    ],
)
def test_what_does_not_fit_together_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("name", ["", " ", "..", "../x", "a/b", "a\\b", "a\nb", "a\0"])
def test_a_name_that_is_no_name_of_a_file_is_refused(name):
    with pytest.raises(InputError, match="Setup: name = .*: it becomes the name of files"):
        Setup(name, sheets=[SHEET], duration=1.0)


def test_a_run_ends_at_rest():
    rest = Rest(0.5, 0.1)
    assert not rest.reached(0.5, {"kinetic": 0.0, "internal": 1.0})
    assert not rest.reached(0.6, {"kinetic": 0.1, "internal": 1.0})
    assert rest.reached(0.6, {"kinetic": 0.09, "internal": 1.0})
    hanging = one_sheet_setup(
        name="hanging", blank=BLANK, fabric=glass_polypropylene(), duration=1e-4, rest=Rest(3e-5, 1e9), lane_count=1,
        dynamics=Dynamics(gravity=(0.0, 0.0, -9.81)), supports=(Support("grip", [0]),), frame_count=10, threads=1,
        accept_unusual=True,
    )  # fmt: skip
    simulation = Simulation(hanging)
    simulation.run()
    assert 3e-5 < simulation.frame.time < 6e-5
