"""``weavesim study`` from its options to its files."""

import csv
import json
import re
import shutil
from pathlib import Path

import h5py
import pytest
from typer.testing import CliRunner

from tests.support.paths import ROOT
from tests.support.studies import Silence, write_small_job
from weavesim.app.command_line import application
from weavesim.app.study_command import _clear_other
from weavesim.errors import InputError
from weavesim.study.conduct import Conductor
from weavesim.study.execution.executor import HereExecutor
from weavesim.study.job_subject import JobSubject
from weavesim.study.measures import STUDY_FINDINGS
from weavesim.study.read import read_study
from weavesim.study.table import RunTable

runner = CliRunner()


def invoked(*arguments):
    return runner.invoke(application, ["study", *map(str, arguments)])


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> tuple[Path, str]:
    """Folder of a study of three runs and two repeats, and what the command said."""
    folder = tmp_path_factory.mktemp("study")
    job = write_small_job(folder)
    result = invoked(
        job, "--vary", "spring.corner.stiffness=0.5 N/mm:2 N/mm:3", "--measure", "max_shear_p99",
        "--least", "step_count", "--noise", 2, "--fields", "--jobs", 1, "--set", "output.frame_count=2",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    return folder / "study", result.output


def test_a_study_leaves_table_page_and_the_best_run(done):
    folder, said = done
    rows = list(csv.DictReader((folder / "runs.csv").open()))
    assert [row["role"] for row in rows] == ["design"] * 3 + ["noise"] * 6
    assert float(rows[0]["spring.corner.stiffness [N/mm]"]) == 0.5
    told = json.loads((folder / "study.json").read_text())
    assert told["run_count"] == 9 and told["measures"]["max_shear_p99"]["noise"]["degrees"] == 6
    page = (folder / "study.html").read_text()
    assert 'href="best/report.html"' in page and (folder / "best" / "report.html").is_file()
    assert not list((folder / "best").glob("*.usdc"))
    assert "9 runs of 3 points, 9 of 9 finished; 0 were known before" in said
    assert "in the study" not in said  # the best run has the same numbers once more


def test_fields_are_at_common_points(done):
    with h5py.File(done[0] / "fields.h5") as file:
        assert file["sheets/0/position"].shape == (9, len(file["sheets/0/points"]), 3)
        assert file["inputs/spring.corner.stiffness"].attrs["unit"] == "N/mm"
        assert set(file["measures"]) == {"max_shear_p99_deg", "step_count"}


def test_the_same_command_computes_nothing_again(done):
    folder, _ = done
    before = (folder / "runs.csv").read_bytes()
    result = invoked(
        folder.parent / "small.toml", "--vary", "spring.corner.stiffness=0.5 N/mm:2 N/mm:3", "--measure",
        "max_shear_p99", "--least", "step_count", "--noise", 2, "--jobs", 1, "--set", "output.frame_count=2",
        "--no-best",
    )  # fmt: skip
    assert "9 were known before" in result.output
    assert (folder / "runs.csv").read_bytes() == before
    with RunTable(folder / "study.sqlite") as table:
        assert len(table.attempts()) == 9


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "it is a job, not a study"),
        (["--vary", "spring.corner.stiffness=1:2:3"], "--measure: at least one"),
        (["--vary", "spring.corner.stiffness=2:1:3", "--measure", "step_count"], "it is empty"),
        (["--vary", "spring.corner.stiffness=1:2:3", "--measure", "x", "--jobs", "2", "--scheduler", "tcp://a:1"],
         "--jobs: has no effect"),
        (["--vary", "spring.corner.stiffness=1:2:3", "--measure", "x", "--method", "sobol"], "samples: is required"),
    ],
)  # fmt: skip
def test_bad_options_are_told(tmp_path, arguments, text):
    result = invoked(write_small_job(tmp_path), *arguments)
    assert isinstance(result.exception, InputError) and text in str(result.exception)
    assert not (tmp_path / "study").exists()


def test_options_beside_a_study_file_are_refused(tmp_path):
    write_small_job(tmp_path)
    path = tmp_path / "s.toml"
    path.write_text('job = "small.toml"\n[[vary]]\nkey = "a"\nrange = [1, 2]\n[[measure]]\nname = "x"\n')
    result = invoked(path, "--samples", 3)
    assert "--samples: have no effect with a study file" in str(result.exception)


def test_the_ten_lines_of_the_documents_load_the_fields(done, tmp_path, monkeypatch, capsys):
    (script,) = [block for block in documented("python") if "fields.h5" in block]
    (tmp_path / "tray").symlink_to(done[0].parent)
    monkeypatch.chdir(tmp_path)
    exec(compile(script, "docs/studies.md", "exec"), {})
    with h5py.File(done[0] / "fields.h5") as file:
        count = len(file["sheets/0/points"])
    assert capsys.readouterr().out == f"(9, 1) (9, 5) (9, {count}, 3)\n"


def test_the_tutorial_can_be_followed(tmp_path, monkeypatch):
    springs, study, *_ = documented("toml")
    text = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"    weavesim new (.*--die.*)\n", text)
    name, _, die, *rest = command.split()
    monkeypatch.chdir(tmp_path)
    made = runner.invoke(application, ["new", name, "--die", str(ROOT / "docs" / "notebooks" / die), *rest])
    assert made.exit_code == 0, made.output
    with (tmp_path / name / "job.toml").open("a", encoding="utf-8") as job:
        job.write(springs)
    (tmp_path / name / "study.toml").write_text(study, encoding="utf-8")
    read = read_study(tmp_path / name / "study.toml")
    subject = JobSubject(read.job, read.table.set)
    with RunTable(tmp_path / "t.sqlite") as table:
        case = Conductor(read, subject, table, HereExecutor(), Silence()).check()
    (setup,) = [setup for _, setup in case.task.setups]
    assert len(setup.sheet.grippers) == 4 and read.table.budget == 20
    assert {finding.name for finding in STUDY_FINDINGS} >= {measure.name for measure in read.table.measure}


def documented(language):
    """Blocks of docs/studies.md."""
    text = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_a_refused_study_leaves_no_table(tmp_path):
    job = write_small_job(tmp_path)
    result = invoked(job, "--vary", "tools.bal.friction=0.1:0.2:2", "--measure", "step_count", "--jobs", 1)
    assert "no [[tool]] is named 'bal'" in str(result.exception)
    assert not list((tmp_path / "study").glob("study.*"))


def test_another_study_in_a_folder_replaces_the_results_of_the_first(done, tmp_path):
    folder = Path(shutil.copytree(done[0].parent, tmp_path / "copy"))
    result = invoked(
        folder / "small.toml", "--vary", "spring.corner.stiffness=500:2000:2", "--measure", "max_shear_p99", "--jobs",
        1, "--set", "output.frame_count=2",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert "study.html, study.json, runs.csv, fields.h5, best/" in result.output and "replaced" in result.output
    assert not (folder / "study" / "fields.h5").exists() and not list((folder / "study" / "best").glob("*.html"))
    rows = list(csv.DictReader((folder / "study" / "runs.csv").open()))
    assert len(rows) == 2 and "spring.corner.stiffness [N/m]" in rows[0]
    with RunTable(folder / "study" / "study.sqlite") as table:
        assert table.run_count() == 9  # 0.5 and 2 N/mm were known


def test_a_refused_study_keeps_the_fields_of_another(done, tmp_path):
    folder = Path(shutil.copytree(done[0].parent, tmp_path / "copy"))
    job = folder / "small.toml"
    job.write_text(job.read_text().replace('rectangle = ["60 mm", "60 mm"]', 'rectangle = ["50 mm", "60 mm"]'))
    result = invoked(
        job, "--vary", "spring.corner.stiffness=500:2000:2", "--measure", "max_sheer_p99", "--jobs", 1, "--fields"
    )
    assert "'max_sheer_p99'" in str(result.exception)
    with RunTable(folder / "study" / "study.sqlite") as table:
        keys = {key for key, _, outcome in table.attempts() if outcome == "finished"}
        assert keys and all(table.has(key, fields=True) for key in keys)


def test_the_results_of_a_version_that_did_not_name_its_study_stay(done, tmp_path):
    folder = Path(shutil.copytree(done[0], tmp_path / "study"))
    with RunTable(folder / "study.sqlite") as table:
        table._connection.execute("DELETE FROM about WHERE name = 'study'")
        _clear_other(folder, table, "key")
        assert table.about("study") == "key" and (folder / "study.html").is_file()
        _clear_other(folder, table, "another")
    assert not (folder / "study.html").exists()
