"""The soak, in short: its parts run, pass, and see what is wrong."""

import numpy as np
import pytest

from scripts.soaking import damage, endurance
from weavesim.errors import InputError


def test_damaged_files_of_every_reader(tmp_path, capsys):
    assert damage.damage(tmp_path, 12, 3)
    said = capsys.readouterr().out.splitlines()
    assert len(said) == len(list(damage.readers(tmp_path))) >= 21
    assert all("refused" in line for line in said)


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


def test_a_run_of_many_steps_keeps_no_memory(tmp_path):
    assert endurance.steps(tmp_path, 1500, 1)
    assert endurance.descriptors() > 2 and endurance.resident() > 1_000_000
