"""Units of the keys of a job."""

import pytest

from weavesim import InputError
from weavesim.job.read import read_job
from weavesim.study.key_units import unit_of_key

JOB = """
[fabric.mine]
based_on = "glass-polypropylene"

[[ply]]
fabric = "mine"
rectangle = ["60 mm", "60 mm"]
mesh_size = "10 mm"

[[tool]]
name = "ring"
shape = {kind = "Plane"}
force = "100 N"

[[stage]]
name = "close"
duration = "1 ms"
[[stage.move]]
name = "ring"
fixed = true
"""


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("tools.ring.force", "N"), ("tools.ring.friction", ""), ("tools.ring.faces", ""), ("ply.mesh_size", "m"),
        ("ply.angle", "degrees"), ("stages.close.duration", "s"), ("stages.close.move.ring.mass", "kg"),
        ("process.damping", "1/s"), ("fabric.mine.areal_density", "kg/m^2"),
        ("fabric.mine.unit_cell.crossover_height", "m"),
        ("fabric.mine.bending.modulus", "Pa"), ("fabric.mine.bending.nothing", ""), ("output.frame_count", ""),
        ("tools.ring.nothing", ""), ("nothing.at_all", ""),
    ],
)  # fmt: skip
def test_a_key_has_the_unit_of_its_quantity(tmp_path, key, unit):
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    assert unit_of_key(read_job(path), key) == unit


def test_options_of_a_scene_have_theirs(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('[scene]\nname = "double-dome"\n')
    assert unit_of_key(read_job(path), "scene.blank_holder_force") == "N"
    assert unit_of_key(read_job(path), "scene.part") == ""


def test_a_tool_that_is_not_there_is_told(tmp_path):
    path = tmp_path / "job.toml"
    path.write_text(JOB)
    with pytest.raises(InputError, match="no \\[\\[tool\\]\\] is named 'rong'; there are ring"):
        unit_of_key(read_job(path), "tools.rong.force")
