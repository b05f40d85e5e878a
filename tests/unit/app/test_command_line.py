"""The command line: options made from a parameter class, messages and exit codes."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, Literal

import pytest
import trimesh
import typer
from pydantic import Field

from tests.support.paths import ROOT
from weavesim import __version__
from weavesim.app import command_line
from weavesim.app.calibrate_command import CalibrateParameters
from weavesim.app.options import RunOptions
from weavesim.device import Precision, resolve_device
from weavesim.engine import compilation
from weavesim.engine.setup import Solver
from weavesim.errors import InputError, RunError
from weavesim.fabric.file import resolve_fabric
from weavesim.ranges import ACCEPTING
from weavesim.scenes import scene

# In which a script finds this checkout, installed or not.
CHECKOUT = {**os.environ, "PYTHONPATH": str(ROOT)}
COMMON_OPTIONS = ("--mesh-size", "--device", "--precision", "--threads", "--out")


class ToyParameters(RunOptions):
    part: Literal["quarter", "full"] = Field(default="quarter", description="how much of it")
    holder_gap: Annotated[float, Field(gt=0.0)] | None = Field(default=None, description="gap [m]")
    mirror: bool = Field(default=True, description="show the whole")
    out: Path = Path("toy")


@pytest.fixture
def weavesim_command(monkeypatch, capsys):
    """Runs the command line with a toy scene in the place of the double dome: (exit code, stdout, stderr)."""

    def call(*arguments: str, run=lambda parameters: {}) -> tuple[int, str, str]:
        toy = SimpleNamespace(SCENE=SimpleNamespace(parameters=ToyParameters, run=run))
        monkeypatch.setattr(scene, "import_module", lambda *names: toy)
        monkeypatch.setattr(sys, "argv", ["weavesim", *arguments])
        with pytest.raises(SystemExit) as ending:
            command_line.main()
        captured = capsys.readouterr()
        return ending.value.code or 0, captured.out, captured.err

    return call


def test_help_lists_the_scenes(weavesim_command):
    code, out, _ = weavesim_command("--help")
    assert code == 0
    assert all(name in out for name in command_line.SCENES)


def test_version(weavesim_command):
    assert weavesim_command("--version")[:2] == (0, f"weavesim {__version__}\n")


def test_devices_are_listed(weavesim_command):
    code, out, _ = weavesim_command("devices")
    assert code == 0 and out.startswith("cpu:") and "Compiled kernels:" in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--unit-cell", "felt"), "unit cell 'felt' is unknown: choose one of .*plain-weave"),
        (("--scene", "triple-dome"), "scene 'triple-dome' is unknown: choose one of bias-extension, biaxial"),
    ],
)
def test_compiling_for_what_is_not_known_is_refused(weavesim_command, arguments, message):
    code, _, err = weavesim_command("compile", *arguments)
    assert code == 2 and re.search(message, err)


def test_scene_help_has_every_field(weavesim_command):
    code, out, _ = weavesim_command("double-dome", "--help")
    assert code == 0
    assert all(option in out for option in (*COMMON_OPTIONS, "--part", "--holder-gap", "--no-mirror"))
    assert "quarter" in out and "how much of it" in out and "gap [m]" in out


def texts_of_help() -> Iterator[tuple[str, list[str]]]:
    """Arguments of every command, and the texts that its help shows."""

    def below(command: Any, names: tuple[str, ...]) -> Iterator[tuple[str, list[str]]]:
        texts = [command.help or "", *(getattr(each, "help", None) or "" for each in command.params)]
        if names and names[0] in command_line.SCENES:
            fields = scene.known_scenes()[names[0]].load().parameters.model_fields.values()
            texts += [field.description or "" for field in fields]
        if names == ("calibrate",):
            texts += [field.description or "" for field in CalibrateParameters.model_fields.values()]
        yield " ".join(names), texts
        for name, one in getattr(command, "commands", {}).items():
            yield from below(one, (*names, name))

    yield from below(typer.main.get_command(command_line.application), ())


HELP = list(texts_of_help())


@pytest.mark.parametrize(("arguments", "texts"), HELP, ids=[names or "all" for names, _ in HELP])
def test_help_shows_what_stands_in_brackets(arguments, texts, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["weavesim", *arguments.split(), "--help"])
    with pytest.raises(SystemExit):
        command_line.main()
    shown = "".join(capsys.readouterr().out.split())
    assert any(texts)
    for text in texts:
        for part in re.findall(r'(?:"\w+)?\[[^\[\]]+\]', text):
            assert "".join(part.split()) in shown, (part, text)


def test_no_option_of_a_real_scene_is_cut_in_a_narrow_terminal():
    script = ROOT / "scripts" / "double_dome.py"
    out = subprocess.run(
        [sys.executable, script, "--help"],
        env={**os.environ, "COLUMNS": "80"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    for option in (
        "--blank-holder-force",
        "--measured-outline",
        "--punch-speed",
        "--tools-are-cut",
        "glass-polypropylene",
    ):
        assert option in out.replace("glass-\n", "glass-").replace(" " * 34, "")
    assert "\\[" not in out and "…" not in out


def test_options_reach_the_scene(weavesim_command):
    seen = []
    arguments = ["--mesh-size=0.01", "--precision=float64", "--threads=2", "--part=full", "--holder-gap=1e-3"]
    code, out, _ = weavesim_command(
        "double-dome", *arguments, "--no-mirror", run=lambda parameters: seen.append(parameters) or {}
    )
    assert code == 0 and "Results are in toy" in out
    expected = ToyParameters(
        mesh_size=0.01, precision=Precision.DOUBLE, threads=2, part="full", holder_gap=1e-3, mirror=False
    )
    assert seen == [expected]
    assert seen[0].model_fields_set == expected.model_fields_set


def test_compilation_is_announced_before_it_starts(weavesim_command, monkeypatch):
    missing, compiled = [[0, 2, 5]], []
    monkeypatch.setattr(compilation, "missing", lambda kernel_set: missing[0])
    monkeypatch.setattr(compilation, "_compile", lambda kernel_set, indices, process_count: compiled.append(indices))

    def run(parameters):
        compilation.compile_missing(compilation.MeshKernelSet("cpu"))
        return {}

    code, _, err = weavesim_command("double-dome", run=run)
    assert code == 0 and err.startswith("double-dome: compiling 3 kernels") and compiled == [[0, 2, 5]]
    missing[0] = []
    assert weavesim_command("double-dome", run=run)[2] == "" and len(compiled) == 1


def test_report_is_pointed_at(weavesim_command, tmp_path):
    def run(parameters):
        (parameters.out / "report.html").write_text("")
        return {"outcome": "finished"}

    code, out, _ = weavesim_command("double-dome", "--out", str(tmp_path), run=run)
    assert code == 0 and str(tmp_path / "report.html") in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--mesh-size", "-1"], "weavesim: --mesh-size = -1.0: a number above 0"),
        (["--mesh-size", "nan"], "--mesh-size = nan"),
        (["--mesh-size", "5"], "write 0.005 for 5 mm"),
        (["--mesh-size", "fine"], "--mesh-size"),
        (["--threads", "0"], "--threads = 0"),
        (["--precision", "float16"], "float32"),
        (["--part", "third"], "third"),
        (["--holder-gap", "0"], "--holder-gap = 0"),
        (["--colour", "red"], "--colour"),
        (["--out", ""], "--out: it is empty"),
        (["--out", "  "], "--out: it is empty"),
        (["--out="], "--out: it is empty"),
    ],
)
def test_bad_option_is_reported_before_the_run(weavesim_command, arguments, message):
    started = []
    code, _, err = weavesim_command("double-dome", *arguments, run=started.append)
    assert code == 2 and message in err and started == []


@pytest.mark.parametrize("command", [["form", "job.toml"], ["verdict", "out"], ["study", "study.toml"]])
@pytest.mark.parametrize("empty", [["--out", ""], ["--out="], [" "]])
def test_an_empty_path_is_not_the_current_folder(weavesim_command, command, empty):
    code, _, err = weavesim_command(*command, *empty)
    assert code == 2 and "it is empty" in err


@pytest.mark.parametrize(
    ("error", "shown"),
    [
        (lambda p: Solver(time_step=-1.0), "weavesim: --time-step = -1.0: "),
        (lambda p: Solver(step_safety=5.0), "weavesim: Solver: step_safety"),
        (lambda p: bad("mesh_size = 1 m: give mesh_size=0.1"), "--mesh-size = 1 m: give --mesh-size=0.1"),
        (
            lambda p: bad("use mass scaling (target_step) or mesh_size."),
            "use mass scaling (--target-step) or --mesh-size.",
        ),
        (
            lambda p: bad(f"ToyParameters: unusual. {ACCEPTING}"),
            "weavesim: unusual. If this is meant, give --accept-unusual.\n",
        ),
        (lambda p: bad("mesh /home/mesh_size/mesh_size.stl: empty"), "mesh /home/mesh_size/mesh_size.stl: empty"),
        (lambda p: bad("fabric file x.toml: time_step: unknown name"), "fabric file x.toml: time_step: unknown name"),
    ],
)
def test_a_message_of_the_run_names_options_as_typed(weavesim_command, error, shown):
    code, _, err = weavesim_command("double-dome", run=error)
    assert code == 2 and shown in err


def bad(message):
    raise InputError(message)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("angle,force\n0,0,0,00\n5,0,1,07\n", "line 2: 4 values under 2 names"),
        ("angle,force,angle,force\n0,0,0,0\n", "column force occurs twice"),
        ("angle;force\n0;0\n5;x\n", "line 3: column 'force': 'x' is not a number"),
        ("root:x:0:0\n", "no table with the column angle"),
    ],
)
def test_a_fabric_file_that_cannot_be_read_is_reported_without_a_traceback(weavesim_command, tmp_path, table, message):
    (tmp_path / "frame.csv").write_text(table)
    (tmp_path / "ours.toml").write_text(
        'based_on = "glass-polypropylene"\n[shear]\nkind = "MomentCurve.from_picture_frame"\nframe_side = 0.25\n'
        'angle = {csv = "frame.csv", column = "angle"}\nmachine_force = {csv = "frame.csv", column = "force"}\n'
    )
    code, _, err = weavesim_command("double-dome", run=lambda p: resolve_fabric(str(tmp_path / "ours.toml")))
    assert code == 2 and message in err and "Traceback" not in err and "root:" not in err and err.count("\n") == 1


def test_unknown_device_is_reported(weavesim_command):
    code, _, err = weavesim_command("double-dome", "--device", "cuda:99", run=lambda p: resolve_device(p.device))
    assert code == 2 and "choose one of cpu" in err and "Traceback" not in err


def test_run_that_had_to_stop_exits_with_1(weavesim_command):
    def run(parameters):
        raise RunError("element 7 is not finite")

    code, _, err = weavesim_command("double-dome", run=run)
    assert (code, err) == (1, "weavesim: element 7 is not finite\n")
    assert weavesim_command("double-dome", run=lambda parameters: {"outcome": "not finite"})[0] == 1


def test_interrupt_exits_with_130(weavesim_command):
    def run(parameters):
        raise KeyboardInterrupt

    code, out, _ = weavesim_command("double-dome", run=run)
    assert code == 130 and "Interrupted" in out
    assert weavesim_command("double-dome", run=lambda parameters: {"outcome": "interrupted"})[0] == 130


def test_unknown_command_exits_with_2(weavesim_command):
    code, _, err = weavesim_command("triple-dome")
    assert code == 2 and "triple-dome" in err


@pytest.mark.parametrize("name", command_line.SCENES)
def test_scene_script_offers_the_common_options(name):
    folders = (ROOT / "scripts", ROOT / "scripts" / "laboratory")
    (script,) = (path for folder in folders for path in folder.glob(f"{name.replace('-', '_')}.py"))
    done = subprocess.run([sys.executable, script, "--help"], capture_output=True, text=True, env=CHECKOUT)
    assert done.returncode == 0, done.stderr
    assert all(option in done.stdout for option in COMMON_OPTIONS)


def test_large_tool_meshes_are_announced(monkeypatch, capsys):
    from weavesim.app.session import announced
    from weavesim.tools.mesh_tool import MeshSurface

    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    monkeypatch.setattr("weavesim.tools.mesh_tool.MANY_TRIANGLES", 300)
    with announced():
        MeshSurface(ball.vertices, ball.faces, name="punch.stl")
    assert capsys.readouterr().err == "punch.stl: checking 320 triangles\n"
    MeshSurface(ball.vertices, ball.faces, name="punch.stl")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_during_the_imports_ends_the_command_with_its_code(name):
    """Code in which a signal raises an exception may turn it into another one."""
    program = f"""
import os, signal
from weavesim.app import command_line
def load():
    try:
        os.kill(os.getpid(), signal.{name})
        signal.pause()
    except KeyboardInterrupt:
        raise ValueError("not what came")
command_line.application.command("late")(load)
command_line.main("late")
"""
    done = subprocess.run([sys.executable, "-c", program], env=CHECKOUT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 128 + getattr(signal, name) and "Traceback" not in done.stderr


def test_an_interrupted_command_does_not_show_what_the_signal_broke(weavesim_command):
    def broken(parameters):
        try:
            signal.raise_signal(signal.SIGTERM)
        except KeyboardInterrupt:
            raise ValueError("not what came") from None

    code, out, err = weavesim_command("double-dome", run=broken)
    assert code == 143 and "Interrupted by SIGTERM." in out and "not what came" not in out + err


def test_help_loads_no_heavy_package():
    code = "import sys, weavesim.app.command_line; print({'warp', 'pydantic', 'numpy', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
