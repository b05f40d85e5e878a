"""``weavesim docs``: every document by its name, from the checkout or from inside the package."""

import io
import sys

import pytest
from typer.testing import CliRunner

from tests.support.paths import ROOT
from weavesim.app import docs_command
from weavesim.app.command_line import application
from weavesim.errors import InputError


def call(*words):
    return CliRunner().invoke(application, ["docs", *words])


def test_without_a_name_all_pages_are_listed():
    said = call().output
    assert said.startswith("# Documentation")
    assert "(job.md)" in said and "(decisions/0001-total-lagrangian-one-director.md)" in said


@pytest.mark.parametrize("name", ["job", "job.md", "docs/job.md"])
def test_a_page_is_found_by_its_name(name):
    assert call(name).output == (ROOT / "docs" / "job.md").read_text(encoding="utf-8")


def test_a_decision_is_found_by_its_number():
    assert call("41").output.startswith("# 41. ")
    assert call("decisions/0041-jobs").output == call("41").output


def test_where_a_page_is():
    assert call("own_part", "--path").output.strip() == str(ROOT / "docs" / "own_part.md")


def test_an_unknown_page_is_refused_with_the_nearest():
    error = call("jobs").exception
    assert isinstance(error, InputError)
    assert str(error) == "page 'jobs' is unknown; did you mean 'job'?; weavesim docs lists all pages"


def test_the_documents_inside_the_package_come_first(tmp_path, monkeypatch):
    (tmp_path / "weavesim" / "docs").mkdir(parents=True)
    monkeypatch.setattr(docs_command, "__file__", str(tmp_path / "weavesim" / "app" / "docs_command.py"))
    assert docs_command.documents() == tmp_path / "weavesim" / "docs"
    assert "there are no documents" in str(call("job").exception)


def test_a_terminal_gets_pages_that_are_set(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    shown = []
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.setattr("pydoc.pager", shown.append)
    docs_command.show("# A title\n\nSome *text*.")
    assert "A title" in shown[0] and "# A" not in shown[0]
