"""A trimmed flat pattern formed again: its border meets the part's edge, far within an element."""

from dataclasses import replace

import numpy as np
import pytest

from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.output import ResultFolder
from weavesim.output.comparison.kinematic import of_flat_blank
from weavesim.output.flat.drawing import flat_drawing, write_drawing
from weavesim.output.flat.first_blank import pattern_of_net
from weavesim.output.flat.part_edge import PartEdge
from weavesim.output.flat.pattern import FlatWish, flat_patterns, write_flat
from weavesim.output.stored.file import read_results
from weavesim.run.simulation import Simulation
from weavesim.sheet.outline import Outline

pytest.importorskip("ezdxf")

ELEMENT, EDGE = 0.01, 0.06
ANGLE = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
CIRCLE = EDGE * np.column_stack([np.cos(ANGLE), np.sin(ANGLE)])
# a sheet that pressure lays over a sphere
JOB = """\
name = "cap"

[[ply]]
fabric = "glass-polypropylene"
BLANK
mesh_size = "10 mm"

[[tool]]
name = "sphere"
shape = { kind = "Sphere", radius = "100 mm" }
move = ["0 mm", "0 mm", "-100 mm"]
faces = "up"
friction = 0.1

[[pressure]]
face = "top"
pressure = "20 kPa"
ramp = "10 ms"

[process]
duration = "15 ms"

[output]
frame_count = 2
"""


def formed(folder, blank, out):
    (folder / "cap.toml").write_text(JOB.replace("BLANK", blank))
    setup = setup_of(read_job(folder / "cap.toml"))
    Simulation(setup).run([ResultFolder(folder / out, writers=["results"])])
    return read_results(folder / out)


def test_the_trimmed_pattern_formed_again_meets_the_edge(tmp_path):
    run = formed(tmp_path, 'rectangle = ["160 mm", "160 mm"]', "first")
    (tmp_path / "edge.csv").write_text("x [m],y [m]\n" + "\n".join(f"{x:.9f},{y:.9f}" for x, y in CIRCLE))
    wish = FlatWish(trim=tmp_path / "trim.dxf", part_edge=tmp_path / "edge.csv")
    found = flat_patterns(run, wish)
    write_flat(found, wish)
    outline = Outline(CIRCLE)
    # material comes from further out, and the border has to be drawn in from there
    drawn_in = -outline.nearest(found.plies[0].trim[0])[0]
    again = formed(tmp_path, 'outline = "trim.dxf"\nlayer = "ply"', "again").sheets[0]
    away = outline.nearest(again.position[again.blank.boundary_loop(), :2])[0]
    assert drawn_in.min() > 0.2 * ELEMENT
    assert np.abs(away).max() < 0.1 * ELEMENT


def test_a_first_blank_from_the_net_alone_meets_the_edge(tmp_path):
    """Before any run: the fabric shears a little less than pinned yarns do, and stretches a little."""
    (tmp_path / "cap.toml").write_text(JOB.replace("BLANK", 'rectangle = ["160 mm", "160 mm"]'))
    setup = setup_of(read_job(tmp_path / "cap.toml"))
    blank = setup.sheet.oriented_blank
    drape = of_flat_blank(blank, setup.tools[0], setup.sheet.fabric.thickness)
    pattern = pattern_of_net(drape, blank, setup.sheet.fabric.thickness, "ply", PartEdge("circle", CIRCLE))
    write_drawing(tmp_path / "first.dxf", flat_drawing([replace(pattern, blank=pattern.trim)]))
    sheet = formed(tmp_path, 'outline = "first.dxf"\nlayer = "ply"', "first").sheets[0]
    away = Outline(CIRCLE).nearest(sheet.position[sheet.blank.boundary_loop(), :2])[0]
    assert np.abs(away).max() < 0.1 * ELEMENT
