"""The commands for jobs, as a user types them."""

import json

import pytest
from typer.testing import CliRunner

from tests.support.jobs import write_tray
from weavesim import InputError
from weavesim.app.command_line import application
from weavesim.scenes.scene import known_scenes

DOME = {"mesh_size": 0.02, "stroke": 0.004, "punch_speed": 2.0}


def call(*words):
    return CliRunner().invoke(application, [str(word) for word in words], catch_exceptions=True)


def problem(*words):
    """The message of a call that is refused before anything runs."""
    result = call(*words)
    assert isinstance(result.exception, InputError), result.output
    return str(result.exception)


@pytest.fixture(scope="module")
def scene_folder(tmp_path_factory):
    """The double dome, coarse and short, as a scene."""
    scene = known_scenes()["double-dome"].load()
    out = tmp_path_factory.mktemp("scene") / "out"
    scene.run(scene.parameters(**DOME, frame_count=2, out=out, write="tables"))
    return out


@pytest.fixture(scope="module")
def job_folder(tmp_path_factory):
    """The same as a job, run by the command."""
    folder = tmp_path_factory.mktemp("job")
    text = '[scene]\nname = "double-dome"\nmesh_size = "20 mm"\nstroke = "9 mm"\npunch_speed = "2000 mm/s"\n'
    (folder / "dome.toml").write_text(text + '[output]\nframe_count = 2\nwrite = ["tables"]\n')
    result = call("form", folder / "dome.toml", "--set", "scene.stroke=4 mm")
    assert f"Results are in {folder / 'out'}." in result.output
    return folder / "out"


def test_a_scene_and_its_job_have_the_same_bits(scene_folder, job_folder):
    setups = [json.loads((folder / "setup.json").read_text()) for folder in (scene_folder, job_folder)]
    assert setups[0] == setups[1]
    histories = [(folder / "history.csv").read_text() for folder in (scene_folder, job_folder)]
    assert histories[0] == histories[1]


def test_a_mistake_is_told_before_anything_runs(tmp_path):
    path = write_tray(tmp_path)
    assert "did you mean 'force'" in problem("form", path, "--set", "tools.ring.forse=600")
    assert not (tmp_path / "out").exists()
    assert "cannot be read" in problem("form", tmp_path / "none.toml")
