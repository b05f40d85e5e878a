"""Writers are known as soon as they are defined, chosen by name, and cost no more than their own files."""

import logging

import pytest

from weavesim.errors import InputError
from weavesim.output import ResultFolder, Writer, chosen_writers, known_writers
from weavesim.output import writer as writer_module
from weavesim.run.frame import Outcome


@pytest.fixture(autouse=True)
def _writers_forgotten():
    """What a test defines is unknown afterwards."""
    before = dict(known_writers())
    yield
    writer_module._known.clear()
    writer_module._known.update(before)


def names(kinds):
    return [kind.name for kind in kinds]


def play(folder, run):
    info, frames = run
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    return folder.write({})


def test_writers_come_in_the_order_in_which_they_write():
    assert names(chosen_writers()) == ["film", "paraview", "results", "tables", "pictures", "report", "summary"]
    assert names(chosen_writers(["summary", "film"])) == ["film", "summary"]
    assert names(chosen_writers(without=["film", "pictures"])) == ["paraview", "results", "tables", "report", "summary"]
    assert names(chosen_writers(["film"], without=["film"])) == []


@pytest.mark.parametrize("given", [{"names": ["movie"]}, {"without": ["movie"]}])
def test_an_unknown_writer_is_refused_and_the_known_ones_are_listed(given):
    with pytest.raises(
        InputError, match="'movie': choose from film, paraview, results, tables, pictures, report, summary"
    ):
        chosen_writers(**given)


def test_two_writers_of_one_name_are_refused():
    with pytest.raises(TypeError, match="writer film: weavesim.output.writers.film already has one of this name"):

        class Other(Writer):
            name = "film"


def test_a_base_class_without_a_name_is_no_writer():
    class Base(Writer):
        pass

    assert Base not in known_writers().values()


def test_only_what_is_chosen_is_written(tmp_path, coarse_run):
    play(ResultFolder(tmp_path, writers=["tables", "summary"]), coarse_run)
    assert {file.name for file in tmp_path.iterdir()} == {
        "history.csv", "draw_in.csv", "summary.json", "run.json", ".weavesim.lock",
    }  # fmt: skip


class Events(Writer):
    """Records its calls, and fails where it is configured to."""

    seen: list[str] = []
    failing = ""

    def _at(self, event):
        self.seen.append(event)
        if event == self.failing:
            raise OSError(28, "No space left on device")

    def start(self, info):
        self._at("start")

    def frame(self, frame):
        self._at("frame")

    def finish(self, outcome):
        self._at("finish")

    def discard(self):
        self._at("discard")
        raise OSError("gone already")

    def write(self, results):
        self._at("write")


@pytest.mark.parametrize(
    ("failing", "expected"),
    [
        ("", ["start", "frame", "frame", "finish", "write"]),
        ("start", ["start", "discard"]),
        ("frame", ["start", "frame", "discard"]),
        ("finish", ["start", "frame", "frame", "finish", "discard"]),
        ("write", ["start", "frame", "frame", "finish", "write"]),
    ],
)
def test_a_writer_that_fails_is_given_up_and_the_others_go_on(tmp_path, coarse_run, caplog, failing, expected):
    kind = type("Mine", (Events,), {"name": "mine", "title": "my file", "seen": [], "failing": failing})
    info, frames = coarse_run
    with caplog.at_level(logging.WARNING, "weavesim"):
        summary = play(ResultFolder(tmp_path, writers=["mine", "tables", "report", "summary"]), (info, frames[:2]))
    assert kind.seen == expected
    warnings = ["my file could not be written and is given up: No space left on device"] if failing else []
    assert summary["warnings"] == warnings == [record.message for record in caplog.records]
    assert all((tmp_path / name).exists() for name in ("history.csv", "report.html", "summary.json"))
    assert ("my file could not be written" in (tmp_path / "report.html").read_text()) == bool(failing)


def test_a_text_in_place_of_a_list_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"writers = 'summary': give a list, \['summary'\]"):
        ResultFolder(tmp_path, writers="summary")
    with pytest.raises(InputError, match=r"without = 'film': give a list"):
        chosen_writers(without="film")
