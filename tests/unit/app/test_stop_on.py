"""A run that a guard ends, as its user wants it: from the command line and from a job, and how it goes on."""

import json

import pytest
from typer.testing import CliRunner

from tests.support.processes import summary
from weavesim.app.command_line import application
from weavesim.app.ending import ExitCode, closing_lines, exit_code
from weavesim.errors import InputError
from weavesim.run.checkpoint.checkpoints import FOLDER_NAME, has_job
from weavesim.scenes.laboratory import uniaxial

GUARD = "yarn_stretch"
# Pulled to 12 %, where 10 % are doubted.
PULLED = {
    "mesh_size": 0.0125,
    "length": 0.1,
    "largest_strain": 0.12,
    "frame_count": 4,
    "accept_unusual": True,
    "threads": 1,
}


def call(*arguments):
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


def options(folder, **given):
    return uniaxial.SCENE.parameters(**PULLED, write="summary,tables", out=folder, **given)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Of a run that nothing ends."""
    return uniaxial.SCENE.run(options(tmp_path_factory.mktemp("whole")))


def test_a_command_ends_with_its_own_code_and_goes_on_all_the_same(tmp_path, whole):
    typed = [
        text for name, value in PULLED.items() if value is not True for text in (f"--{name.replace('_', '-')}", value)
    ]
    command = ("uniaxial", *typed, "--accept-unusual", "--write", "summary,tables", "--out", tmp_path)
    ended = call(*command, "--stop-on", f"self_intersection, {GUARD}")
    assert ended.exit_code == ExitCode.STOPPED == 6, ended.output
    assert f"Stopped by the guard {GUARD}, as wanted (stop_on); results so far are kept." in ended.output
    assert f"Go on with it all the same: weavesim resume {tmp_path}" in ended.output
    found = summary(tmp_path)
    assert (found["outcome"], found["stopped_by"], found["missing"]) == ("stopped", GUARD, [])
    assert 0.0 < found["time_s"] < whole["time_s"] and has_job(tmp_path)
    (doubt,) = [doubt for doubt in found["doubts"] if doubt["guard"] == GUARD]
    assert doubt["time_s"] == found["time_s"] and doubt["place_m"] and doubt["limit"] <= doubt["value"] < 0.105
    record = json.loads((tmp_path / "run.json").read_text())
    assert (record["outcome"], record["stopped_by"]) == ("stopped", GUARD)

    done = call("resume", tmp_path)
    assert done.exit_code == exit_code(whole, None) and f"Results are in {tmp_path}" in done.output, done.output
    again = summary(tmp_path)
    names = ("outcome", "step_count", "time_s", "frame_count", "energies_j", "max_stretch", "verdict", "doubts")
    assert [again[name] for name in names] == [whole[name] for name in names]
    assert "stopped_by" not in again and not (tmp_path / FOLDER_NAME).exists()


def test_a_job_says_it_in_its_output(tmp_path):
    job = tmp_path / "job.toml"
    scene = {name: value for name, value in PULLED.items() if name not in ("frame_count", "accept_unusual", "threads")}
    lines = [f"{name} = {value}" for name, value in scene.items()]
    job.write_text("\n".join([
        "accept_unusual = true", "[scene]", 'name = "uniaxial"', *lines, "[solver]", "threads = 1",
        "[output]", "frame_count = 4", 'write = ["summary"]', f'stop_on = ["{GUARD}"]',
    ]))  # fmt: skip
    ended = call("form", job)
    assert ended.exit_code == ExitCode.STOPPED, ended.output
    assert summary(tmp_path / "out")["stopped_by"] == GUARD


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("uniaxial", "--stop-on", "yarn_strech"), "guard 'yarn_strech': choose from .*; did you mean 'yarn_stretch'"),
        (("uniaxial", "--stop-on", "kinetic_energy"), "guard 'kinetic_energy': it judges a run by its end"),
    ],
)
def test_what_cannot_end_a_run_is_refused_before_it(tmp_path, arguments, message):
    with pytest.raises(InputError, match=message):
        CliRunner().invoke(application, [*arguments, "--out", str(tmp_path / "out")], catch_exceptions=False)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [True, False])
def test_a_job_with_an_unknown_guard_is_refused_with_its_place(tmp_path, option):
    job = tmp_path / "job.toml"
    job.write_text('[scene]\nname = "uniaxial"\n' + ("" if option else '[output]\nstop_on = ["yarn_strech"]\n'))
    arguments = ["form", str(job), *(("--stop-on", "yarn_strech") if option else ())]
    place = "--set output.stop_on" if option else r"line 4, \[output\]"
    with pytest.raises(InputError, match=rf"{place}.*guard 'yarn_strech': choose from"):
        CliRunner().invoke(application, arguments, catch_exceptions=False)


def test_codes_and_words_of_several_cases(tmp_path):
    finished, stopped = {"outcome": "finished"}, {"outcome": "stopped", "stopped_by": GUARD, "verdict": "do not use"}
    result = {"one": finished, "two": stopped, "outcome": "stopped"}
    assert exit_code(result, None) == 6 and exit_code(result, 15) == 143
    text = list(closing_lines(result, tmp_path, None))
    assert text[0].startswith(f"Stopped by the guard {GUARD}, as wanted") and "Do not use the result" in text[1]
