"""``weavesim kinematic``: of a job, and what is refused."""

from functools import partial

import numpy as np
import pytest

from tests.support.jobs import write_tray


@pytest.fixture
def kinematic_command(run_command):
    return partial(run_command, "kinematic")


def test_a_folder_that_is_no_run(kinematic_command, tmp_path):
    code, _, err = kinematic_command(tmp_path)
    assert code == 2 and "it has no results.h5" in err


def test_a_job_that_does_not_exist(kinematic_command, tmp_path):
    code, _, err = kinematic_command(tmp_path / "none.toml")
    assert code == 2 and "none.toml" in err


def test_a_job_that_names_a_scene(kinematic_command, tmp_path):
    job = tmp_path / "job.toml"
    job.write_text('[scene]\nname = "double-dome"\n')
    code, _, err = kinematic_command(job)
    assert code == 2 and "it names a scene; run it, and give the folder of the run" in err


def test_a_net_on_the_punch_of_a_job(kinematic_command, tmp_path):
    job = write_tray(tmp_path)
    code, _, err = kinematic_command(job)
    assert code == 2 and "give the tool with --tool: die, punch" in err
    code, out, err = kinematic_command(job, "--tool", "punch", "--side", 0.01, "--out", tmp_path / "net")
    assert code == 0, err
    assert "on punch: net up to" in out
    assert "% of ply; it ends" in out and "- where there is no more surface, first at x = " in out
    assert {file.name for file in (tmp_path / "net").iterdir()} == {f"kinematic.{e}" for e in ("json", "vtu", "png")}
    code, out, _ = kinematic_command(job, "--tool", "punch", "--side", 0.08, "--out", tmp_path / "net")
    assert code == 0 and "no cell of the net is whole" in out
    code, _, err = kinematic_command(job, "--tool", "punch", "--side", 0.5, "--out", tmp_path / "net")
    assert code == 2 and "at most 0.08 m, half the width of the blank" in err
    code, _, err = kinematic_command(job, "--tool", "punch", "--side", 1e-9, "--out", tmp_path / "net")
    assert code == 2 and "crossings, more than 1,000,000; give at least" in err
    code, _, err = kinematic_command(job, "--tool", "hammer")
    assert code == 2 and "'hammer': choose from die, punch" in err


def test_a_first_blank_of_a_job(kinematic_command, tmp_path):
    from weavesim.job.blanks.outlines import read_drawing

    pytest.importorskip("ezdxf")
    job, drawing = write_tray(tmp_path), tmp_path / "blank.dxf"
    (tmp_path / "edge.csv").write_text("x,y\n-50,-30\n50,-30\n50,30\n-50,30\n")
    options = ["--tool", "punch", "--side", 0.01, "--out", tmp_path / "net", "--blank", drawing]
    edge = ["--part-edge", tmp_path / "edge.csv", "--edge-unit", "mm", "--margin", 0.02]
    code, out, err = kinematic_command(job, *options, *edge)
    assert code == 0, err
    assert "first blank of ply: " in out and "become the part by the net" in out
    # the bottom of the tray is flat there
    assert np.ptp(read_drawing(drawing, layer="ply").outline, axis=0) == pytest.approx([0.14, 0.10], abs=2e-3)
    code, _, err = kinematic_command(job, *options)
    assert code == 2 and "--blank needs the edge of the part" in err
    code, _, err = kinematic_command(job, "--tool", "punch", *edge)
    assert code == 2 and "need a drawing to write" in err
    code, _, err = kinematic_command(tmp_path, *options, *edge)
    assert code == 2 and "--blank is for a job" in err
