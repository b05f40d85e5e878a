"""``make verify`` runs every test that the others leave out, wherever it is."""

from types import SimpleNamespace

import pytest

from scripts import verification
from tests.support.paths import ROOT


@pytest.fixture
def started(monkeypatch):
    """Arguments of every pytest that was started, and what each returns."""
    calls, codes = [], [0, 0]

    def run(command, **_):
        calls.append(command[command.index("pytest") + 1 :])
        return SimpleNamespace(returncode=codes[len(calls) - 1])

    monkeypatch.setattr(verification.subprocess, "run", run)
    return calls, codes


def test_every_marked_test_is_run(started, tmp_path):
    assert verification.run_studies(tmp_path, 2) == 0
    marked = [path for path in (ROOT / "tests").rglob("test_*.py") if "mark.verification" in path.read_text("utf-8")]
    outside = [path for path in marked if ROOT / "tests" / "verification" not in path.parents]
    assert len(marked) > 10 and outside
    folders = [ROOT / word for call in started[0] for word in call if word.startswith("tests/")]
    assert all(any(folder in path.parents for folder in folders) for path in marked)
    assert all("verification" in call[call.index("-m") + 1] for call in started[0])
    # only what is in the manual writes it
    assert [str(tmp_path) in call for call in started[0]] == [call[1] == "tests/verification" for call in started[0]]


@pytest.mark.parametrize("codes", [(1, 0), (0, 1), (-9, 0)])
def test_a_failure_of_either_is_told(started, tmp_path, codes):
    started[1][:] = codes
    assert verification.run_studies(tmp_path, 1) == next(code for code in codes if code)
