"""Exit codes, and what the user is told."""

import signal

import pytest

from weavesim.app.ending import closing_lines, exit_code, summaries

FINE = {"outcome": "finished", "missing": []}
LESS = {"outcome": "finished", "missing": ["film", "history.csv"]}
BAD = {"outcome": "finished", "verdict": "do not use", "missing": []}
CUT = {"outcome": "interrupted", "missing": []}
BROKEN = {"outcome": "not finite", "missing": []}


@pytest.mark.parametrize(
    ("result", "number", "code"),
    [
        (FINE, None, 0),
        ({}, None, 0),
        (BROKEN, None, 1),
        (BAD, None, 3),
        (BAD | {"missing": ["film"]}, None, 3),
        (LESS, None, 4),
        (CUT, signal.SIGINT, 130),
        (CUT, signal.SIGTERM, 143),
        (CUT, signal.SIGHUP, 129),
        (CUT, None, 130),
        (FINE, signal.SIGTERM, 143),
        ({"one": FINE, "two": FINE, "outcome": "finished"}, None, 0),
        ({"one": LESS, "two": FINE, "outcome": "finished"}, None, 4),
        ({"one": FINE, "two": BAD, "outcome": "finished"}, None, 3),
        ({"one": FINE, "two": CUT, "outcome": "interrupted"}, signal.SIGTERM, 143),
    ],
)
def test_exit_codes(result, number, code):
    assert exit_code(result, number) == code


def test_summaries_of_cases():
    assert list(summaries({"one": FINE, "two": LESS, "outcome": "finished"})) == [FINE, LESS]
    assert list(summaries(FINE)) == [FINE]


def text(result, number, out):
    return "\n".join(closing_lines(result, out, number))


def test_results_are_announced_only_if_they_are_all_there(tmp_path):
    assert text(FINE, None, tmp_path) == f"Results are in {tmp_path}."
    less = text(LESS, None, tmp_path)
    assert "Results are in" not in less and "film, history.csv missing" in less


def test_a_springback_is_told(tmp_path):
    found = {"springback_mm": 12.34, "formed_max_shear_angle_deg": 40.0, "springback_max_shear_angle_deg": -3.5}
    assert "Springback: 12.3 mm, largest shear angle -3.5 degrees from 40." in text(FINE | found, None, tmp_path)
    assert "Springback" not in text(FINE, None, tmp_path)


def test_the_signal_and_the_verdict_are_named(tmp_path):
    assert text(CUT, signal.SIGINT, tmp_path).startswith("Interrupted; results so far are kept. ")
    assert text(CUT, signal.SIGTERM, tmp_path).startswith("Interrupted by SIGTERM; results so far are kept. ")
    assert "Finished, although interrupted by SIGHUP at the end" in text(FINE, signal.SIGHUP, tmp_path)
    assert "Do not use the result" in text(BAD, None, tmp_path)
    assert text(BROKEN, None, tmp_path).startswith("Stopped early. ")


def test_a_report_that_could_not_be_written_is_not_to_be_opened(tmp_path):
    (tmp_path / "report.html").write_text("page of the middle of the run")
    told = text({**FINE, "missing": ["film", "report.html"]}, None, tmp_path)
    assert "film, report.html missing" in told and "Open " not in told
    assert "Open " in text({**FINE, "missing": ["film"]}, None, tmp_path)


def test_only_reports_of_this_run_are_named(tmp_path):
    for name in ("", "one", "two", "another run"):
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / name / "report.html").write_text("page")
    assert text(FINE, None, tmp_path).count("Open ") == 1
    assert f"Open {tmp_path / 'report.html'} in" in text(FINE, None, tmp_path)
    cases = text({"one": FINE, "three": LESS, "outcome": "finished"}, None, tmp_path)
    assert cases.count("Open ") == 1 and f"Open {tmp_path / 'one' / 'report.html'} in" in cases
