"""The table knows every run once, and keeps it."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.study.plans.trials import Trial
from weavesim.study.table import Found, RunTable


def test_a_run_is_kept_with_all_its_digits(tmp_path):
    found = Found(
        numbers={"a": 0.1 + 0.2, "b": 3}, fields={"sheet/position": np.eye(3)}, verdict="trusted", seconds=2.0
    )
    with RunTable(tmp_path / "t.sqlite") as table:
        assert not table.has("k")
        table.store("k", "s", found)
    with RunTable(tmp_path / "t.sqlite") as table:
        answer = table.answer(Trial((1,)), "k")
        assert answer.numbers == {"a": 0.1 + 0.2, "b": 3} and answer.verdict == "trusted"
        assert np.array_equal(table.fields("k")["sheet/position"], np.eye(3))
        assert table.has("k", fields=True) and table.seconds() == [2.0]


def test_a_run_that_comes_twice_counts_once_and_other_numbers_are_told(tmp_path):
    with RunTable(tmp_path / "t.sqlite") as table:
        assert table.store("k", "s", Found(numbers={"a": 1.0})) == ""
        assert table.store("k", "s", Found(numbers={"a": 1.0})) == ""
        assert table.run_count() == 1 and len(table.attempts()) == 2
        assert "with other numbers" in table.store("k", "s", Found(numbers={"a": 1.5}))


def test_a_run_without_the_fields_that_are_wanted_is_not_known(tmp_path):
    with RunTable(tmp_path / "t.sqlite") as table:
        table.store("k", "s", Found(numbers={"a": 1.0}))
        table.store("bad", "s", Found("failed", error="no"))
        assert table.has("k") and not table.has("k", fields=True)
        assert table.has("bad", fields=True)


def test_a_run_of_another_version_is_not_known(tmp_path, monkeypatch):
    with RunTable(tmp_path / "t.sqlite") as table:
        table.store("k", "s", Found(numbers={"a": 1.0}))
        monkeypatch.setattr("weavesim.study.table.__version__", "another")
        assert not table.has("k") and table.answer(Trial(()), "k").status == "lost"


def test_a_file_that_is_no_table_is_refused(tmp_path):
    path = tmp_path / "t.sqlite"
    path.write_text("no table " * 1000)
    with pytest.raises(InputError, match="no table of a study"):
        RunTable(path)


def test_a_table_of_another_format_is_refused(tmp_path):
    with RunTable(tmp_path / "t.sqlite") as table:
        table.remark("format_version", "7")
    with pytest.raises(InputError, match="version 7"):
        RunTable(tmp_path / "t.sqlite")


def test_fields_at_other_points_are_forgotten_and_those_at_the_same_stay(tmp_path):
    with RunTable(tmp_path / "t.sqlite") as table:
        table.want_fields_at("coarse")
        table.store("k", "s", Found(numbers={"a": 1.0}, fields={"sheet/position": np.eye(3)}))
        table.want_fields_at("coarse")
        assert table.has("k", fields=True)
        table.want_fields_at("fine")
        assert table.has("k") and not table.has("k", fields=True)
    with RunTable(tmp_path / "t.sqlite") as table:
        table.want_fields_at("fine")
        assert not table.has("k", fields=True)
