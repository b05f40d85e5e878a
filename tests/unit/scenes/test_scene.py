"""Scenes are found from their files, and the recipe of CONTRIBUTING makes one."""

import subprocess
import sys

import pytest

import weavesim.scenes
from tests.support.paths import ROOT
from tests.support.recipes import written_recipe
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.process.scaling.mass import MassScaling
from weavesim.scenes.scene import Scene, known_scenes


def test_every_scene_is_found_by_its_file():
    scenes = ROOT / "scenes"
    files = {
        ".".join(file.relative_to(scenes).with_suffix("").parts)
        for file in scenes.rglob("*.py")
        if "SCENE = " in file.read_text(encoding="utf-8")
    }
    found = known_scenes()
    assert {scene.module for scene in found.values()} == files - {"scene"} and len(found) >= 11


@pytest.mark.parametrize("name", known_scenes())
def test_what_is_read_off_a_file_is_what_it_defines(name):
    found = known_scenes()[name]
    scene = found.load()
    assert isinstance(scene, Scene)
    assert (scene.name, scene.help) == (name, found.help)
    assert scene.name.replace("-", "_") == found.module.rpartition(".")[2]


def test_names_and_help_need_no_scene():
    code = """
import sys, time
started = time.process_time()
from weavesim.scenes.scene import known_scenes
assert len(known_scenes()) >= 5
seconds = time.process_time() - started
assert not {"warp", "pydantic", "numpy", "weavesim.scenes.double_dome"} & set(sys.modules)
print(seconds)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    # a tenth of a second; this is for a slow machine without bytecode
    assert float(done.stdout) < 2.0


def test_a_scene_imports_without_warp():
    modules = ", ".join(f"weavesim.scenes.{scene.module}" for scene in known_scenes().values())
    code = f"import sys, {modules}; print('warp' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_the_recipe_of_a_scene(tmp_path, monkeypatch):
    """A file in the folder is enough: it is found, its options are checked, its run leaves a folder of results."""
    folder = tmp_path / "scenes"
    folder.mkdir()
    written_recipe("trampoline.py", folder)
    monkeypatch.setattr(weavesim.scenes, "__path__", [*weavesim.scenes.__path__, str(folder)])
    found = known_scenes()["trampoline"]
    assert found.help == "Let a sheet that is held all around sag under its weight."
    scene = found.load()
    parameters = scene.parameters(mesh_size=0.025, out=tmp_path / "out", threads=1, write="summary")
    (setup,) = scene.setups(parameters).values()
    assert Setup.from_json(setup.to_json()) == setup
    summary = scene.run(parameters)
    assert summary["outcome"] == "finished" and summary["sag_mm"] > 0.0
    assert (tmp_path / "out" / "summary.json").exists()
    monkeypatch.delitem(sys.modules, "weavesim.scenes.trampoline")


def test_a_scene_looks_for_a_mass_scaling_in_every_case(tmp_path, monkeypatch):
    """The set-ups that are tried are those of the scene with another mesh and step; what is found is what is run."""
    scene, asked, run = known_scenes()["picture-frame"].load(), [], []

    def chosen(make, mesh_size, **tolerances):
        coarse = make(1.5 * mesh_size, 3e-6)
        asked.append((coarse.name, coarse.sheet.blank.element_count, coarse.solver.target_step, tolerances))
        return MassScaling(factor=2.0, target_step=4e-6, mesh_size=mesh_size, coarse_size=1.5 * mesh_size,
                           angle_tolerance=0.5, draw_in_tolerance=5e-4)  # fmt: skip

    monkeypatch.setattr("weavesim.run.scaling.mass.choose_mass_scaling", chosen)
    monkeypatch.setattr(
        Scene, "_run_case", lambda self, parameters, case, setup, *rest, **more: run.append(setup) or {}
    )
    parameters = scene.parameters(out=tmp_path, mesh_size=0.02, mass_scaling_draw_in=1e-3)
    setups = scene.setups(parameters)
    scene.run(parameters)
    assert len(asked) == 1 and asked[0][2:] == (3e-6, {"angle_tolerance": 0.5, "draw_in_tolerance": 1e-3})
    assert asked[0][1] < next(iter(setups.values())).sheet.blank.element_count
    assert run[0].solver.target_step == 4e-6 and run[0].solver.mass_scaling.factor == 2.0
    assert run[0].sheet == next(iter(setups.values())).sheet


def test_a_scene_that_cannot_be_coarser_says_so(tmp_path):
    scene = known_scenes()["grippers"].load()
    parameters = scene.parameters(out=tmp_path, mesh_size=0.015, mass_scaling_angle=0.5)
    with pytest.raises(InputError, match=r"sought on elements of 22.5 mm, which is refused: .*at least 5 elements"):
        scene.run(parameters)


@pytest.mark.parametrize("name", ["target_step", "time_step"])
def test_a_step_and_a_search_for_one_are_refused(name):
    with pytest.raises(InputError, match=f"{name}: it is what a search by mass_scaling_angle"):
        known_scenes()["grippers"].load().parameters(**{name: 1e-6, "mass_scaling_angle": 0.5})
