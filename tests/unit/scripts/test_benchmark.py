"""The benchmark runs, and says what it measured; how fast anything is, no test asks."""

import json
import logging
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from scripts.benchmarks.cases import element_count
from scripts.benchmarks.compilation import times
from scripts.benchmarks.compilation.start import start_of, whole_run
from tests.support.paths import ROOT
from tests.support.processes import COARSE

SCRIPT = ROOT / "scripts" / "benchmark.py"


def benchmark(*arguments: str) -> str:
    """What it prints; without a start of its own, which takes longer than most of its work here."""
    from scripts.benchmark import app

    try:
        result = CliRunner().invoke(app, arguments, catch_exceptions=False)
    finally:
        logging.disable(logging.NOTSET)
    assert result.exit_code == 0, result.output
    return result.stdout


def started_benchmark(*arguments: str) -> str:
    """What it prints in a process of its own."""
    command = [sys.executable, str(SCRIPT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_rates_are_reported_with_their_problem_and_earlier_ones(tmp_path):
    file = tmp_path / "rates.json"
    what = ("rates", "--case", "double_dome_10mm", "--precision", "float32", "--threads", "1,2")
    length = ("--seconds", "0.01", "--turns", "1")
    started_benchmark(*what, *length, "--json", str(file))
    rows = json.loads(file.read_text())["rows"]
    assert [row["threads"] for row in rows] == [1, 2]
    for row in rows:
        assert row["elements"] == 322
        assert abs(row["rate"] * row["step_us"] * 1e-6 - row["elements"]) < 1e-6
        # docs/performance.md says what they are
        assert 200 < row["state_bytes"] <= 509
        assert row["state_bytes"] < row["moved_bytes"] < 1000
    assert set(rows[0]["phases_us"]) == {
        "elements", "nodes and contact", "tools", "stable step (every 20th)", "output frame",
    }  # fmt: skip
    table = benchmark(*what, *length, "--compare", str(file))
    assert "ratio to before" in table
    assert table.count("| double_dome_10mm | 322 | float32 | cpu |") == 2


@pytest.mark.slow
def test_a_checkout_is_timed_against_itself_in_turns():
    table = benchmark("against", str(ROOT), "--turns", "2", "--blocks", "1")
    assert "double_dome_10mm, 322 elements, float32, 1 threads, 2 turns of 20 steps" in table
    assert [line.split(" | ")[3] for line in table.splitlines() if line.startswith("| the other")] == ["1.000"]


def test_elements_of_all_sheets_count():
    sheets = [SimpleNamespace(blank=SimpleNamespace(element_count=count)) for count in (7, 5)]
    assert element_count(SimpleNamespace(setup=SimpleNamespace(sheets=sheets))) == 12


def test_processor_time_is_that_of_a_process_and_of_those_it_waits_for():
    work = "import time\nwhile time.process_time() < 0.3: pass"
    outer = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {work!r}])"
    assert times.processor_time([sys.executable, "-c", outer], dict(os.environ)) >= 0.3
    with pytest.raises(subprocess.CalledProcessError):
        times.processor_time([sys.executable, "-c", "raise SystemExit(1)"], dict(os.environ))


def test_every_compilation_begins_with_an_empty_cache(monkeypatch):
    asked = []

    def processor_time(command, variables):
        cache = Path(variables["WARP_CACHE_PATH"])
        assert list(cache.iterdir()) == []
        (cache / "compiled").touch()
        asked.append(command[1:])
        return 1.0

    monkeypatch.setattr(times, "processor_time", processor_time)
    for precision in ("float32", "float64"):
        assert times.seconds_to_compile("double-dome", "twill", precision) == 1.0
    options = ("--scene", "double-dome", "--unit-cell", "twill", "--precision", "float64", "--processes", "1")
    assert asked[1] == ["-m", "weavesim", "compile", *options]


@pytest.mark.slow
def test_a_start_ends_when_the_run_begins_or_says_why_none_does():
    start = start_of(ROOT, COARSE)
    assert start.processor > 0.0 and start.wall > 0.0
    with pytest.raises(SystemExit, match="(?s)no run has begun: .*mesh-size"):
        start_of(ROOT, ("picture-frame", "--mesh-size", "wide"))


@pytest.mark.slow
def test_the_parts_of_a_whole_run_are_no_more_than_all():
    run = whole_run(COARSE)
    assert min(run) > 0.0
    assert run.start + run.stepping + run.after < run.all
    with pytest.raises(SystemExit, match="exit code"):
        whole_run(("picture-frame", "--mesh-size", "wide"))


@pytest.mark.slow
def test_the_bytes_of_a_step_are_the_sum_of_their_parts_and_more_in_contact():
    lines = benchmark("counts", "--precision", "float32").splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if "---" not in line]
    of = {row[0]: [float(cell) for cell in row[1:]] for row in cells[1:]}
    total, _ = of.pop("sum"), of.pop("state")
    assert np.sum(list(of.values()), axis=0) == pytest.approx(total, abs=0.5 * len(of))
    # a free patch, then double domes of 2.5 and 10 mm: three tools, three numbers of each, read and written
    free, dome, coarse = of["friction springs of tools"]
    assert free == 0.0 and 2 * 3 * 3 * 4 <= dome < coarse < 1.2 * 2 * 3 * 3 * 4


def test_the_yarns_bound_the_stable_step_and_no_other_stiffness_does():
    """An implicit treatment of a term could gain no more than this (decision 69)."""
    table = benchmark("stiffnesses", "--mesh-size", "0.01")
    gain = {
        name: float(gain) for name, gain in re.findall(r"^\| ([\w -]+?) \| \S+ \((.*?)\)", table, flags=re.MULTILINE)
    }
    assert gain.pop("none") == 1.0
    assert gain.pop("yarns and locking") > 5.0
    assert set(gain) == {"transverse shear", "bending", "in-plane bending", "compression"}
    assert all(1.0 <= each < 1.05 for each in gain.values())


@pytest.mark.slow
def test_a_batch_gets_the_bits_of_single_runs():
    text = benchmark("batch", "--count", "3", "--checked", "2", "--share", "0.02", "--looks", "2")
    assert "3 variants of 322 elements, 0 not finished" in text
    assert text.count("same bits") == 2
