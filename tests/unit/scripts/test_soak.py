"""The soak, in short: its parts run, pass, and see what is wrong."""

import numpy as np
import pytest

from scripts.soaking import cells, damage, endurance, extremes
from weavesim.errors import InputError


def test_damaged_files_of_every_reader(tmp_path, capsys):
    assert damage.damage(tmp_path, 12, 3)
    said = capsys.readouterr().out.splitlines()
    names = [reader.name for reader in damage.readers(tmp_path)]
    assert [line.split(":")[0] for line in said if "not tried" not in line] == names
    assert len(names) == len(set(names)) >= 31
    # of those that a process of its own reads, only one is damaged here
    assert all("refused" in line for line in said if not line.startswith(("a.step", "a.igs", "STEP")))


@pytest.mark.parametrize(
    ("answer", "seen"),
    [
        (lambda path: np.array([np.nan]), "a number that is not finite"),
        (lambda path: {}[path], "KeyError"),
        (lambda path: [1.0], "read"),
    ],
)
def test_what_is_wrong_is_seen(tmp_path, answer, seen):
    reader = damage.Reader("a.txt", b"0123456789", answer)
    assert seen in damage.one(reader, tmp_path / "a.txt", np.random.default_rng(0))


def test_a_message_has_to_be_one(tmp_path):
    def refused(path):
        raise InputError("x" * 5000)

    reader = damage.Reader("a.txt", b"0123456789", refused)
    assert "unreadable" in damage.one(reader, tmp_path / "a.txt", np.random.default_rng(0))


def test_random_states_of_cells(tmp_path, monkeypatch, capsys):
    assert cells.cells(tmp_path, 300, 2)
    assert "300 states, 0 flagged, 0 not finite in silence, 0 wrong" in capsys.readouterr().out
    monkeypatch.setattr(cells, "LARGEST_DIFFERENCE", 1e-18)
    assert not cells.cells(tmp_path, 50, 2)
    assert "FAILED: " in capsys.readouterr().out


def test_extreme_runs(capsys):
    found = {row.name: row for row in extremes.rows()}
    assert len(found) >= 60 and set(extremes.EXPECTED) | set(extremes.REFUSED) < set(found)
    names = "stretched: single precision", "sheared: single precision", "stretched: yarns a thousand times softer"
    assert [extremes.judged(found[name])[0] for name in names] == [True, True, True]


# As in double precision; the last one stops, with its message.
IN_SINGLE = (
    "stretched: one element", "stretched: one row", "falls on a table with 100 m/s", "sheared: membrane 1000 : 1",
    "sheared: hardly any shear stiffness", "stretched: membrane 1000 : 1",
)  # fmt: skip


@pytest.mark.parametrize("name", IN_SINGLE)
def test_extreme_runs_in_single_precision(name):
    (row,) = [row for row in extremes.rows() if row.name == name]
    good, text = extremes.judged(row, "float32")
    assert good, text
    assert ("non-finite" in text) == (name in extremes.STOPPED_IN_SINGLE)


def test_an_extreme_run_that_says_something_else_is_seen(monkeypatch):
    row = next(row for row in extremes.rows() if row.name == "stretched: single precision")
    monkeypatch.setitem(extremes.EXPECTED, row.name, {"hourglass_energy"})
    good, text = extremes.judged(row)
    assert not good and "quiet instead of hourglass_energy" in text
    monkeypatch.setitem(extremes.REFUSED, row.name, "anything")
    assert "it was not refused" in extremes.judged(row)[1]


def test_a_run_of_many_steps_keeps_no_memory(tmp_path):
    assert endurance.steps(tmp_path, 400, 1)
    assert endurance.descriptors() > 2 and endurance.resident() > 1_000_000
