"""The README says what is true: its Python example runs, and its commands have the options that they name."""

import importlib
import re
import shlex
from pathlib import Path

import click
import pytest
import typer

from weavesim.command_line import SCENES, scene_command

README = Path(__file__).resolve().parents[2] / "README.md"
COMMANDS = re.findall(r"(?:python scripts/(\w+)\.py|weavesim ([a-z]+-[a-z-]+))([^#`\n]*)", README.read_text(encoding="utf-8"))


def test_the_python_example_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(example.splitlines()) <= 15
    exec(compile(example, str(README), "exec"), {})
    stroke, angle, energy = map(float, capsys.readouterr().out.split())
    assert abs(stroke - 0.02) < 1e-6
    assert 0.0 < angle < 1.0
    assert energy > 0.0


def test_every_file_it_names_is_there():
    text = README.read_text(encoding="utf-8")
    for name in re.findall(r"\]\(((?:docs/)?[\w./]+)\)", text):
        assert (README.parent / name).exists(), name


def parse(scene_name: str, arguments: str) -> None:
    """The command line's own parser, which refuses what it does not know; nothing runs."""
    scene = SCENES[scene_name]
    module = importlib.import_module(f"weavesim.scenes.{scene.module}")
    application = typer.Typer(add_completion=False)
    scene_command(application, getattr(module, scene.parameters), module.run, scene.help)
    typer.main.get_command(application).make_context(scene_name, shlex.split(arguments))


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: f"{command[0] or command[1]} {command[2].strip()}")
def test_every_command_has_its_options(command):
    script, scene_name, arguments = command
    if script:
        assert (README.parent / "scripts" / f"{script}.py").exists()
        scene_name = next((name for name, scene in SCENES.items() if scene.module == script), "")
    if not scene_name:
        # no scene: a script of the project's own, named without options
        assert arguments.strip(" ,;.:") == "" or not arguments.lstrip().startswith("-")
    elif "--help" in arguments:
        with pytest.raises(click.exceptions.Exit):
            parse(scene_name, arguments)
    else:
        parse(scene_name, arguments)


@pytest.mark.parametrize("arguments", ["--cycle true", "--cycles", "--mesh-size fine"])
def test_wrong_options_would_be_noticed(arguments):
    assert len(COMMANDS) > 8
    with pytest.raises(click.UsageError):
        parse("picture-frame", arguments)
