"""The README says what is true: its Python example runs, and its commands have the options that they name."""

import re
import shlex

import pytest
import typer
from typer.testing import CliRunner

from tests.support.paths import ROOT
from weavesim.app.command_line import SCENES, scene_command

README = ROOT / "README.md"
COMMANDS = re.findall(
    r"(?:python scripts/(\w+)\.py|weavesim ([a-z]+-[a-z-]+))([^#`\n]*)", README.read_text(encoding="utf-8")
)


def test_the_python_example_runs(capsys, caplog):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(example.splitlines()) <= 15
    names: dict = {}
    exec(compile(example, str(README), "exec"), names)
    numbers, verdict = capsys.readouterr().out.splitlines()
    stroke, angle, energy = map(
        float, re.fullmatch(r"stroke (\S+) mm, shear up to (\S+) degrees, (\S+) mJ", numbers).groups()
    )
    assert stroke == 17.5
    # a ball of 120 mm pushed by 17.5 mm into a sheet of 200 mm at 45 degrees
    assert 10.0 < angle < 16.0
    assert energy > 0.0
    # it is trusted, and says nothing that an example should not say
    assert verdict == "verdict: trusted"
    assert names["simulation"].warnings == []
    assert not caplog.records


def test_every_file_it_names_is_there():
    text = README.read_text(encoding="utf-8")
    for name in re.findall(r"\]\(((?:docs/)?[\w./]+)\)", text):
        assert (README.parent / name).exists(), name


def parsed(scene_name: str, arguments: str) -> tuple[int, dict]:
    """Exit code of the scene's own command line, and the parameters that a run would get; nothing runs."""
    scene = SCENES[scene_name]
    application = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    given: dict = {}
    scene_command(
        application, scene_name, scene.load().parameters,
        lambda parameters: given.update(parameters) or {}, scene.help,
    )  # fmt: skip
    return CliRunner().invoke(application, shlex.split(arguments)).exit_code, given


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: f"{command[0] or command[1]} {command[2].strip()}")
def test_every_command_has_its_options(command):
    script, scene_name, arguments = command
    if script:
        assert (README.parent / "scripts" / f"{script}.py").exists()
        scene_name = next((name for name, scene in SCENES.items() if scene.module == script), "")
    if not scene_name:
        # no scene: a script of the project's own, named without options
        assert arguments.strip(" ,;.:") == "" or not arguments.lstrip().startswith("-")
    else:
        exit_code, given = parsed(scene_name, arguments)
        assert exit_code == 0
        assert given or "--help" in arguments


@pytest.mark.parametrize("arguments", ["--cycle true", "--cycles", "--mesh-size fine"])
def test_wrong_options_would_be_noticed(arguments):
    assert len(COMMANDS) > 8
    assert parsed("picture-frame", arguments) == (2, {})
    assert parsed("picture-frame", "--cycle")[1]["cycle"] is True
