"""Trims and friction of a job: their curves, where they come from, and what is refused."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, changed, write_tray
from weavesim import FrictionOf, InputError
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.stages.told import stage_lines

STAGES = """
[[stage]]
name = "form"
duration = "30 ms"

[[stage]]
name = "trim"
duration = "1 ms"
friction = { die = 0.05 }
[[stage.trim]]
TRIM
"""


def setup_with(folder, trim, *changes):
    text = changed(TRAY + STAGES.replace("TRIM", trim), *changes, count=1)
    return setup_of(read_job(write_tray(folder, text)))


def trim_of(folder, trim):
    (found,) = setup_with(folder, trim).stages[1].trims
    return found


def test_curves_are_rectangles_discs_and_polygons(tmp_path):
    box = trim_of(tmp_path, 'rectangle = ["100 mm", "60 mm"]\ncentre = ["10 mm", "0 mm"]\nkeeps = "outside"')
    assert np.allclose(box.curves[0], [(-0.04, -0.03), (0.06, -0.03), (0.06, 0.03), (-0.04, 0.03)])
    assert (box.view, box.keeps, box.sheet) == ("formed", "outside", "ply")
    disc = trim_of(tmp_path, 'disc = "80 mm"\nview = "blank"')
    assert np.allclose(np.linalg.norm(disc.curves[0], axis=1), 0.04) and disc.view == "blank"
    polygon = trim_of(tmp_path, 'polygon = [["0 mm", "0 mm"], ["50 mm", "0 mm"], ["0 mm", "40 mm"]]')
    assert np.allclose(polygon.curves[0], [(0.0, 0.0), (0.05, 0.0), (0.0, 0.04)])


def test_curves_come_from_tables_and_drawings(tmp_path):
    (tmp_path / "edge.csv").write_text("x [mm],y [mm]\n-50,-30\n50,-30\n50,30\n-50,30\n")
    table = trim_of(tmp_path, 'file = "edge.csv"')
    assert np.allclose(table.curves[0], [(-0.05, -0.03), (0.05, -0.03), (0.05, 0.03), (-0.05, 0.03)])
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new(units=4)
    for half in (50.0, 10.0):
        corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "cut"})
    drawing.saveas(tmp_path / "cut.dxf")
    ring = trim_of(tmp_path, 'file = "cut.dxf"\nlayer = "cut"')
    assert sorted(round(float(np.abs(curve).max()), 9) for curve in ring.curves) == [0.01, 0.05]


def test_friction_and_trims_are_told(tmp_path):
    setup = setup_with(tmp_path, 'disc = "80 mm"')
    assert setup.stages[1].friction == (FrictionOf("die", 0.05),)
    (_, (_, line)) = stage_lines(setup)
    assert "friction 0.05 of die" in line and "ply is trimmed" in line


@pytest.mark.parametrize(
    ("trim", "text"),
    [
        ("", "rectangle, disc, polygon or file"),
        ('disc = "80 mm"\nunit = "mm"', "unit"),
        ('file = "none.csv"', "there is no such file"),
        ('disc = "80 mm"\nply = "top"', "ply = 'top': there is none"),
        ('disc = "4 m"\nview = "blank"', "all of the blank would stay"),
        ('rectangle = ["10 mm", "10 mm"]\ncentre = ["2 m", "0 m"]\nview = "blank"', "nothing of the sheet would stay"),
    ],
)
def test_what_is_no_trim_is_refused_with_its_place(tmp_path, trim, text):
    with pytest.raises(InputError, match=rf"(?s)stage.*{text}"):
        setup_with(tmp_path, trim)


def test_friction_of_what_is_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match="no tool or interface 'dye'.*did you mean 'die'"):
        setup_with(tmp_path, 'disc = "80 mm"', ("{ die = 0.05 }", "{ dye = 0.05 }"))
