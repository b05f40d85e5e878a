"""The notebooks: their cells run, on coarse meshes; what they store is what they show, without errors."""

import json
import re
import shutil

import matplotlib
import numpy as np
import pytest

from tests.support.paths import ROOT
from tests.validation.test_docs import anchors, text_of

FOLDER = ROOT / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
# What replaces the cell that is marked as the parameters: meshes and speeds with which nothing is to be believed. Much
# coarser ones take longer, as tools come through the sheet, and guards search for the deepest place.
COARSE = {
    "double_dome": "mesh_size = 0.01\npunch_speed = 5.0\nout = 'out/dome'",
    "own_part": "die = 'tray.stl'\nout = 'out/part'\ncoarse, fine = '20 mm', '18 mm'\nspeed = '5 m/s'\n"
    "frame_count = 2\nwrite = ['summary', 'results']",
    "own_fabric": "frame_mesh, dome_mesh = 0.1, 0.01\npunch_speed = 5.0\nout = 'out/fabric'",
}


def cells(path):
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


def source(cell):
    return "".join(cell["source"])


def played(name, folder):
    """Names that are left after all cells of a notebook, run in ``folder``."""
    names: dict = {}
    marked = 0
    for cell in cells(FOLDER / f"{name}.ipynb"):
        if cell["cell_type"] == "code":
            is_parameters = "parameters" in cell["metadata"].get("tags", ())
            marked += is_parameters
            exec(compile(COARSE[name] if is_parameters else source(cell), f"{name}.ipynb", "exec"), names)
    assert marked == 1
    return names


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    matplotlib.use("agg")
    for file in FOLDER.iterdir():
        if file.suffix != ".ipynb":
            shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    return lambda name: (played(name, tmp_path), capsys.readouterr().out)


def test_the_double_dome(run):
    names, said = run("double_dome")
    assert names["summary"]["outcome"] == names["other"]["outcome"] == "finished"
    assert 20.0 < names["summary"]["max_shear_angle_deg"] < 70.0
    assert "draw_in_long_axis_mm" in said and "verdict:" in said


@pytest.mark.slow
def test_an_own_part(run):
    names, said = run("own_part")
    assert names["summary"]["outcome"] == names["finer"]["outcome"] == "finished"
    assert names["finer"]["element_count"] > names["summary"]["element_count"]
    assert "opening 170 x 140 mm" in said and "smallest radius" in said


def test_an_own_fabric(run):
    names, said = run("own_fabric")
    assert all(result["outcome"] == "finished" for result in names["results"].values())
    assert names["ours"].areal_density == 0.6
    # the frame gives the force that went in, but for the tension of its yarns
    measured, curve = names["measured"], names["curve"]
    force = np.interp(40.0, curve["frame_angle_deg"], curve["force_n"])
    assert force == pytest.approx(measured[measured[:, 0] == 40.0, 1][0], rel=0.1)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_outputs_are_stored_and_without_errors(path):
    assert path.stem in COARSE
    pictures = 0
    for cell in cells(path):
        if cell["cell_type"] == "code":
            assert cell["execution_count"], source(cell)
            kinds = {output["output_type"] for output in cell["outputs"]}
            assert "error" not in kinds
            pictures += sum("image/png" in output.get("data", {}) for output in cell["outputs"])
    assert pictures >= 3
    assert path.stat().st_size < 600_000


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_link_leads_somewhere(path):
    for cell in cells(path):
        if cell["cell_type"] == "markdown":
            for target in re.findall(r"\]\(([^)\s]+)\)", source(cell)):
                place, _, anchor = target.partition("#")
                there = FOLDER / place
                assert there.exists(), target
                assert not anchor or anchor in anchors(text_of(there)), target
