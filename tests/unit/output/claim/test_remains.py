"""Old results are never beside new ones, and nothing else is ever removed."""

import json

import pytest

from weavesim.errors import InputError
from weavesim.output import ResultFolder
from weavesim.output.claim.remains import check_free, remove_results
from weavesim.run.frame import Outcome

FOREIGN = ("notes.txt", "punch.stl", "data.csv", "pictures/photo.jpg", "paraview/mine.pvsm", ".hidden", "sub/a.csv")


def write(folder, names, text="x"):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def play(folder, run, count=None, write=True):
    info, frames = run
    folder.start(info)
    for frame in frames[:count]:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    return folder.write({}) if write else {}


def names(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


def test_a_folder_without_results_is_free(tmp_path):
    check_free(tmp_path)
    write(tmp_path, FOREIGN)
    check_free(tmp_path)


@pytest.mark.parametrize(
    "name",
    ["summary.json", "run.json", "history.csv", "report.html", "draw_in_upper.csv", "paraview/frame_0000.vtu",
     "pictures/formed_sheet.png", "run.log"],
)  # fmt: skip
def test_results_are_not_overwritten_without_being_asked(tmp_path, name):
    write(tmp_path, [name])
    with pytest.raises(InputError, match=r"has results already .* give another folder \(--out\), or .*--overwrite"):
        ResultFolder(tmp_path)
    ResultFolder(tmp_path, overwrite=True)
    assert (tmp_path / name).read_text() == "x"  # not before the run starts


@pytest.mark.parametrize("name", ["summary.json", "run.json", "run.log", "history.csv", "report.html", "setup.json"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_folder_with_the_name_of_a_result_is_told_before(tmp_path, name, overwrite):
    write(tmp_path, [f"{name}/mine.txt"])
    with pytest.raises(InputError, match=f"{name} in it is a folder; move it"):
        ResultFolder(tmp_path, overwrite=overwrite)
    assert names(tmp_path) == {f"{name}/mine.txt"}


@pytest.mark.parametrize("name", ["pictures", "paraview"])
def test_a_file_with_the_name_of_a_folder_of_results_is_told_before(tmp_path, name):
    write(tmp_path, [name])
    with pytest.raises(InputError, match=f"{name} in it is a file; move it"):
        ResultFolder(tmp_path, overwrite=True)
    assert names(tmp_path) == {name}


def test_results_that_came_meanwhile_are_not_overwritten(tmp_path, coarse_run):
    folder = ResultFolder(tmp_path)
    play(ResultFolder(tmp_path, writers=["summary"]), coarse_run, 2)
    with pytest.raises(InputError, match="has results already"):
        folder.start(coarse_run[0])


def test_overwriting_removes_every_old_result_and_nothing_else(tmp_path, coarse_run):
    write(tmp_path, FOREIGN)
    play(ResultFolder(tmp_path), coarse_run)
    first = json.loads((tmp_path / "run.json").read_text())
    assert set(FOREIGN) < names(tmp_path)
    play(ResultFolder(tmp_path, writers=["summary"], overwrite=True), coarse_run, 2)
    assert names(tmp_path) == {*FOREIGN, "summary.json", "run.json", ".weavesim.lock"}
    assert json.loads((tmp_path / "run.json").read_text())["run_id"] == first["run_id"]  # the same made-up run


def test_a_killed_rerun_leaves_no_finished_summary(tmp_path, coarse_run, monkeypatch):
    # whatever this machine does meanwhile, only the first frame is saved
    for name in ("FIRST_INTERVAL", "INTERVAL"):
        monkeypatch.setattr(f"weavesim.output.pace.{name}", 1.0e9)
    play(ResultFolder(tmp_path), coarse_run)
    info, frames = coarse_run
    folder = ResultFolder(tmp_path, overwrite=True)
    folder.start(info)
    assert json.loads((tmp_path / "summary.json").read_text())["outcome"] == "running"
    assert not (tmp_path / "history.csv").exists() and not list((tmp_path / "paraview").glob("*.vtu"))
    for frame in frames[:4]:
        folder.frame(frame)
    folder.release()  # as if killed, before the files of the last frame are recorded
    assert (tmp_path / "paraview" / "frame_0003.vtm").exists()
    assert "paraview/frame_0003.vtm" not in json.loads((tmp_path / "run.json").read_text())["files"]
    found = json.loads((tmp_path / "summary.json").read_text())
    assert (found["outcome"], found["frame_count"]) == ("running", 1)
    # everything that it left is known to the next run
    play(ResultFolder(tmp_path, writers=["summary"], overwrite=True), coarse_run, 2)
    assert names(tmp_path) == {"summary.json", "run.json", ".weavesim.lock"}


def test_results_without_a_record_are_known_by_name(tmp_path):
    old = [
        "summary.json", "history.csv", "report.html", "run.log", "draw_in.csv", "paraview/frame_0012.vtu",
        "paraview/series.pvd", "paraview/final_state.vtu", "pictures/formed_sheet.png", "double_dome.usdc",
    ]  # fmt: skip
    write(tmp_path, old)
    write(tmp_path, FOREIGN)
    remove_results(tmp_path)
    assert names(tmp_path) == set(FOREIGN)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"files": 3}', '{"files": [1, null]}'])
def test_a_damaged_record_is_no_licence(tmp_path, text):
    write(tmp_path, FOREIGN)
    write(tmp_path, ["summary.json"])
    (tmp_path / "run.json").write_text(text)
    remove_results(tmp_path)
    assert names(tmp_path) == set(FOREIGN)


def test_a_record_cannot_name_files_elsewhere(tmp_path):
    folder, elsewhere = tmp_path / "results", tmp_path / "elsewhere"
    write(tmp_path, ["elsewhere/precious.txt", "results/mine.txt"])
    (folder / "link").symlink_to(elsewhere)
    listed = ["../elsewhere/precious.txt", str(elsewhere / "precious.txt"), "link/precious.txt", "sub/../mine.txt"]
    (folder / "run.json").write_text(json.dumps({"files": listed}))
    remove_results(folder)
    assert (elsewhere / "precious.txt").exists() and (folder / "mine.txt").exists()
    assert not (folder / "run.json").exists()


def test_a_link_is_removed_and_not_its_target(tmp_path):
    folder = tmp_path / "results"
    write(tmp_path, ["target.csv", "results/x"])
    (folder / "history.csv").symlink_to(tmp_path / "target.csv")
    (folder / "run.json").write_text(json.dumps({"files": ["history.csv"]}))
    remove_results(folder)
    assert (tmp_path / "target.csv").exists() and not (folder / "history.csv").is_symlink()
