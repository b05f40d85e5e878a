"""The commands for jobs, as a user types them."""

import json
import shutil

import meshio
import pytest
from typer.testing import CliRunner

from tests.support.jobs import TRAY, tray_surface, write_stl, write_tray
from weavesim import InputError, Simulation
from weavesim.app.command_line import application
from weavesim.app.ending import ExitCode
from weavesim.app.jobs.rerun import repeatable
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.output.claim.record import frame_hash
from weavesim.scenes.scene import _scene_literals, known_scenes

pytestmark = pytest.mark.usefixtures("tools_sampled_once")

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
    scene.run(scene.parameters(**DOME, frame_count=2, out=out, write="summary,tables"))
    return out


@pytest.fixture(scope="module")
def job_folder(tmp_path_factory):
    """The same as a job, run by the command."""
    folder = tmp_path_factory.mktemp("job")
    text = '[scene]\nname = "double-dome"\nmesh_size = "20 mm"\nstroke = "9 mm"\npunch_speed = "2000 mm/s"\n'
    (folder / "dome.toml").write_text(text + '[output]\nframe_count = 2\nwrite = ["summary", "tables", "paraview"]\n')
    given = ("--set", "scene.stroke=4 mm", "--set", "output.solver_fields=true")
    result = call("form", folder / "dome.toml", *given)
    assert f"Results are in {folder / 'out'}." in result.output
    return folder / "out"


def test_a_scene_and_its_job_have_the_same_bits(scene_folder, job_folder):
    setups = [json.loads((folder / "setup.json").read_text()) for folder in (scene_folder, job_folder)]
    assert setups[0] == setups[1]
    histories = [(folder / "history.csv").read_text() for folder in (scene_folder, job_folder)]
    assert histories[0] == histories[1]


def test_frames_for_paraview_have_the_fields_of_the_solver_if_wanted(job_folder):
    cells = meshio.read(job_folder / "paraview" / "frame_0001_sheet.vtu").cell_data
    assert {"unit_cell_residual", "thickness_m"} <= set(cells)
    # a run that is resumed remembers it
    assert json.loads((job_folder / "run.json").read_text())["options"]["solver_fields"] is True


def test_a_mistake_is_told_before_anything_runs(tmp_path):
    path = write_tray(tmp_path)
    assert "--limits: has no effect without --strict" in problem("form", path, "--limits", "limits.toml")
    without = ("--strict", "--set", 'output.without=["results"]')
    assert "--strict: needs the results file" in problem("form", path, *without)
    fields = ("--set", "output.solver_fields=true", "--set", 'output.write=["summary"]')
    assert "solver_fields: has no effect without the results paraview" in problem("form", path, *fields)
    assert "did you mean 'force'" in problem("form", path, "--set", "tools.ring.forse=600")
    assert not (tmp_path / "out").exists()
    assert "cannot be read" in problem("form", tmp_path / "none.toml")


def test_a_run_can_be_repeated_to_the_bit(job_folder):
    result = call("rerun", job_folder)
    assert result.exit_code == 0, result.output
    assert "The same to the bit" in result.output


def test_a_run_that_differs_is_told(job_folder, tmp_path):
    import shutil

    shutil.copytree(job_folder, tmp_path / "out")
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    (tmp_path / "out" / "run.json").write_text(json.dumps({**record, "final_state": "0" * 64}))
    result = call("rerun", tmp_path / "out", "--into", tmp_path / "again")
    assert result.exit_code == 1 and "Not the same" in result.output
    assert json.loads((tmp_path / "again" / "run.json").read_text())["final_state"] == record["final_state"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"outcome": "interrupted"}, "its run is interrupted; only one that finished can be repeated"),
        ({"final_state": None}, "did not record the final state"),
        ({"setup_hash": "x"}, "is not the set-up that was run"),
    ],
)
def test_what_cannot_be_repeated_is_refused(job_folder, tmp_path, change, message):
    import shutil

    shutil.copytree(job_folder, tmp_path / "out")
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    (tmp_path / "out" / "run.json").write_text(json.dumps({**record, **change}))
    assert message in problem("rerun", tmp_path / "out")


def test_a_run_is_shown_with_its_verdict_and_numbers(job_folder, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    result = call("view", job_folder)
    assert result.exit_code == 0
    for text in ("double_dome: finished", "verdict:", "max shear angle deg", "peak force of punch n", "history.csv"):
        assert text in result.output
    assert not opened  # this run wrote no report
    (job_folder / "report.html").write_text("x")
    assert "Report:" in call("view", job_folder).output and opened[0].startswith("file://")
    opened.clear()
    call("view", job_folder, "--no-open")
    assert not opened
    (job_folder / "report.html").unlink()


def test_a_folder_without_a_run_is_refused(tmp_path, job_folder):
    assert "no run wrote its results there" in problem("view", tmp_path)
    assert "it has runs in" in problem("view", job_folder.parent)


def test_a_scene_as_a_job_has_all_its_options_as_comments(tmp_path):
    result = call("new", "dome", "--scene", "double-dome", "--into", tmp_path / "dome")
    assert result.exit_code == 0, result.output
    text = (tmp_path / "dome" / "job.toml").read_text()
    assert "# punch_speed = 0.5" in text and "# [m/s] [m/s]" not in text
    from weavesim.job.read import read_job
    from weavesim.job.scenes import scene_of

    scene, parameters = scene_of(read_job(tmp_path / "dome" / "job.toml"), out=tmp_path)
    assert parameters == scene.parameters(out=tmp_path)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("part",), "give --die FILE for a tool of your own, or --scene NAME for a scene"),
        (("part", "--die", "die.stl", "--scene", "double-dome"), "give --die FILE"),
        (("part", "--die", "none.stl"), "none.stl does not exist"),
        (("part", "--die", "die.stl", "--thickness", "1.2 kg"), "--thickness 1.2 kg: 'kg' is no unit of it"),
        (("part", "--die", "die.stl", "--thickness", "0"), "--thickness 0: a length above 0 is needed"),
        (("part", "--die", "die.stl", "--mesh-size", "900"), "--mesh-size 900: at most 0.5 m is allowed"),
        (("part", "--die", "die.stl", "--up", "up"), "--up up: one of +z"),
        (("part", "--die", "die.stl", "--unit", "kg"), "--unit kg: a unit of length is needed"),
        (("part", "--die", "die.stl", "--unit", "m"), "1000 times too big. Give --unit mm for millimetres."),
        (("part", "--die", "die.stl", "--unit", "um"), "Give --unit m for metres, --unit mm for millimetres."),
        (("part", "--die", "die.stl", "--fabric", "wool"), "fabric 'wool' is unknown"),
        (("a/b", "--die", "die.stl"), "name of the job = 'a/b'"),
        (("part", "--scene", "double-dom"), "did you mean 'double-dome'"),
    ],
)
def test_what_new_cannot_do_is_refused(tmp_path, monkeypatch, words, message):
    write_tray(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert message in problem("new", *words)
    assert not (tmp_path / "part").exists()


def test_fields_of_a_later_version_and_another_commit_do_not_make_a_run_another(job_folder, tmp_path):
    shutil.copytree(job_folder, tmp_path / "out")
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    fewer = [name for name in record["final_fields"] if name != "shear_angle"]
    setup, _ = repeatable(tmp_path / "out", record)
    simulation = Simulation(setup)
    simulation.run()
    older = {"final_state": frame_hash(simulation.frame, fewer), "final_fields": fewer, "commit": "0" * 40}
    (tmp_path / "out" / "run.json").write_text(json.dumps({**record, **older}))
    result = call("rerun", tmp_path / "out")
    assert result.exit_code == 0 and "The same to the bit" in result.output
    assert "Note: it was made by commit 000000000000" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scene", "double-dome", "--thickness", "3", "--fabric", "carbon"],
         "--thickness, --fabric: no effect with --scene"),
        (["--die", "die.stl", "--thickness", "0.0012"], "a gap of 0.0012 mm between the closed tools does not suit"),
        (["--die", "die.stl", "--thickness", "60"], "which is 1.2 mm thick; a number without a unit is in mm"),
        (["--die", "die.stl", "--ring", "ring.stl", "--no-ring"], "--ring and --no-ring: give one of them"),
    ],
)  # fmt: skip
def test_options_of_new_without_effect_are_refused(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    write_stl(tmp_path / "die.stl", *tray_surface())
    assert message in problem("new", "mine", *arguments)
    assert not (tmp_path / "mine").exists()


def test_a_new_job_has_its_fabric_with_it_and_any_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    die = write_stl(tmp_path / 'my "die" \\ 2.stl', *tray_surface())
    (tmp_path / "curve.csv").write_text("angle [rad],moment [N/m]\n0,0\n0.5,20\n1,60\n")
    (tmp_path / "mine.toml").write_text(
        'based_on = "glass-polypropylene"\n[shear]\nkind = "MomentCurve"\n'
        'angle = {csv = "curve.csv", column = "angle"}\nmoment_values = {csv = "curve.csv", column = "moment"}\n'
    )
    assert call("new", "mine", "--die", die, "--fabric", tmp_path / "mine.toml").exit_code == 0
    file = read_job(tmp_path / "mine" / "job.toml")
    assert file.job.tool[0].file == die.name and file.job.ply[0].fabric == "mine.toml"
    assert setup_of(file).sheet.fabric.shear.angle == (0.0, 0.5, 1.0)


def test_options_of_export_without_formats_are_refused(job_folder, tmp_path):
    text = problem("export", job_folder, "--flat", tmp_path / "f.dxf", "--unit", "furlong", "--yarns", 7, "--whole")
    assert "--unit, --whole, --yarns: no effect without formats" in text
    assert not (tmp_path / "f.dxf").exists()


def test_what_only_the_run_would_refuse_is_told_by_the_check(tmp_path):
    path = write_tray(tmp_path, TRAY)
    assert "movie" in problem("check", path, "--set", 'output.write=["movie"]')
    assert "--picture" in problem("check", path, "--picture", "picture.xyz")
    (tmp_path / "file").write_text("")
    assert "it is a file" in problem("check", path, "--picture", tmp_path / "file" / "picture.png")


def test_a_question_is_answered_in_the_job(tmp_path):
    path = write_tray(tmp_path, TRAY)
    text = problem("form", path, "--set", "process.gravity=9810")
    assert "write 9.81 for 9810 mm/s^2" in text
    assert "accept_unusual = true at the top of the job, or --set accept_unusual=true" in text
    assert "--accept-unusual" not in text


def test_a_strict_run_beyond_a_limit_ends_with_its_own_code(tmp_path):
    path = write_tray(tmp_path, TRAY)
    (tmp_path / "limits.toml").write_text("locking_angle = 5\n")
    settings = ("--set", "ply.mesh_size=20 mm", "--set", "tools.punch.speed=5 m/s", "--set", "output.frame_count=1",
                "--set", 'output.write=["summary", "results"]')  # fmt: skip
    result = call("form", path, "--strict", "--limits", tmp_path / "limits.toml", *settings)
    assert result.exit_code in (ExitCode.BEYOND_LIMITS, ExitCode.DO_NOT_USE), result.output
    assert "Verdict: beyond limits" in result.output
    assert (tmp_path / "out" / "verdict.json").is_file()


def test_a_scene_whose_text_has_the_line_of_its_definition():
    text = '"""Write\n\nSCENE = Scene(...)\n\nbelow."""\n\nSCENE = Scene(name="mine", help="a cup", run=None)\n'
    assert _scene_literals(text) == {"name": "mine", "help": "a cup"}
    assert _scene_literals("NOTHING = 1\n") == {}
