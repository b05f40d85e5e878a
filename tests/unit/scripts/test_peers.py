"""The comparison with other solvers: its accuracy measures on states known by hand, and its set-up."""

import subprocess
import sys

import numpy as np
import pytest

from scripts.peers.accuracy import measures
from scripts.peers.competition import newton_versions
from scripts.peers.problem import Problem
from scripts.peers.report import report
from tests.support.paths import ROOT

SCRIPTS = ROOT / "scripts"


@pytest.fixture
def problem() -> Problem:
    """Two by two quadrilaterals of 10 mm that touch the top of a ball of 0.1 m."""
    index = np.arange(9).reshape(3, 3)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    x, y = np.meshgrid([-0.01, 0.0, 0.01], [-0.01, 0.0, 0.01], indexing="ij")
    return Problem(
        fabric="cloth", position=np.column_stack([x.ravel(), y.ravel(), np.full(9, 0.1005)]), velocity=np.zeros((9, 3)),
        quads=quads, areal_density=0.5, thickness=1e-3, membrane=5e3, shear=50.0, bending=1e-5, radius=0.1,
        friction=0.3, gravity=9.81, damping=15.0, duration=0.1,
    )  # fmt: skip


def test_sheet_at_rest_measures_nothing(problem):
    result = measures(problem, problem.position, problem.velocity)
    assert result.pop("finite")
    assert result == pytest.approx(dict.fromkeys(result, 0.0), abs=1e-12)


def test_measures_of_a_deformed_moving_sheet(problem):
    # pulled along x, the rows beyond the middle pushed back, corners down by 1, 2, 3, 6 mm, the middle by 1 mm
    position = problem.position * [1.03, 1.0, 1.0]
    position[problem.position[:, 0] > 0.0] -= [0.002, 0.0, 0.0]
    position[[0, 2, 6, 8, 4], 2] -= [0.001, 0.002, 0.003, 0.006, 0.001]
    result = measures(problem, position.astype(np.float32), np.full((9, 3), [0.0, 3.0, 4.0]))
    along = np.hypot([[10.3, 8.3], [10.3, 8.3], [10.3, 8.3]], [[1.0, 3.0], [1.0, 1.0], [2.0, 6.0]]) / 10.0 - 1.0
    across = np.hypot(10.0, [[1.0, 2.0], [1.0, 1.0], [3.0, 6.0]]) / 10.0 - 1.0
    edges = np.concatenate([along, across])
    assert edges.min() < 0.0
    assert result["largest_edge_stretch"] == pytest.approx(edges.max(), rel=1e-4)
    assert result["mean_edge_stretch"] == pytest.approx(np.abs(edges).mean(), rel=1e-4)
    assert result["largest_yarn_stretch"] == pytest.approx(edges.mean(axis=1).max(), rel=1e-4)
    assert result["penetration"] == pytest.approx(0.1005 - np.linalg.norm([0.0083, 0.01, 0.0945]), rel=1e-4)
    assert result["corner_drop"] == pytest.approx(3e-3, rel=1e-4)
    # half of areal density times area times speed squared
    assert result["kinetic_energy"] == pytest.approx(0.5 * 0.5 * 0.02**2 * 5.0**2)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_exploded_state_is_reported(problem, bad):
    position = problem.position.copy()
    position[3, 1] = bad
    row = {"contestant": "a", "fabric": "cloth", "membrane": 1.0, "shear": 1.0, "bending": 1.0, "step_us": 1.0}
    row |= {"iterations": 3, "elements": 8, "element": "triangles", "rate": 1e6, "seconds_per_simulated": 1.0}
    row |= {"simulated_s": 0.1} | measures(problem, position, problem.velocity)
    assert row["finite"] is False
    assert "not finite" in report([row])


def test_contestant_that_failed_is_reported():
    text = report([{"contestant": "a", "fabric": "cloth", "device": "cpu", "error": "ended early"}])
    assert text.endswith("a, cloth: ended early")


def test_problem_survives_its_file(problem, tmp_path):
    problem.save(tmp_path / "problem.npz")
    again = Problem.load(tmp_path / "problem.npz")
    assert again.fabric == "cloth" and again.bending == problem.bending
    assert np.array_equal(again.triangles, problem.triangles)
    assert again.cell_area == pytest.approx(1e-4)


def test_without_newton_the_command_says_how_to_get_it(tmp_path):
    # an interpreter without any package stands for one without Newton
    bare = tmp_path / "python"
    bare.write_text(f'#!/bin/sh\nexec {sys.executable} -S -I "$@"\n')
    bare.chmod(0o755)
    code = (
        "import runpy, sys\n"
        "sys.argv = sys.argv[1:]\n"
        "try:\n"
        "    runpy.run_path(sys.argv[0], run_name='__main__')\n"
        "finally:\n"
        "    print('heavy' if 'warp' in sys.modules or 'weavesim' in sys.modules else 'light')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(SCRIPTS / "benchmark.py"), "peers", "--newton-python", str(bare)],
        capture_output=True, text=True, check=False, env={"COLUMNS": "500", "PATH": "/usr/bin:/bin"},
    )  # fmt: skip
    assert done.returncode == 2
    assert f'{bare} -m pip install "newton>=1.8"' in done.stderr
    assert "light" in done.stdout


def test_unknown_interpreter_has_no_newton(tmp_path):
    assert newton_versions(str(tmp_path / "missing")) is None
