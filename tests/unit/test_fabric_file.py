"""Fabrics from files: what is written comes out, and mistakes are told."""

import json
from pathlib import Path

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric import PRESETS, TwillWeave, glass_polypropylene
from weavesim.fabric_file import load_fabric, resolve_fabric

TOML = """
based_on = "glass-polypropylene"
name = "our fabric"
areal_density = 0.6

[shear]
kind = "MomentCurve.from_picture_frame"
angle = {csv = "frame.csv", column = "angle_deg", scale = 0.017453292519943295}
machine_force = {csv = "frame.csv", column = "force_kn", scale = 1000.0}
frame_side = 0.25
fabric_side = 0.2
locking_angle = 0.9

[shear_friction]
stiffness = 40.0
limit = [0.5]
crossover_friction_length = 1e-4

[bending]
kind = "YarnBending"
twist = 1e-4
weft = 1e-3
warp = {kind = "BendingCurve", curvature = [0.0, 10.0, 40.0], moment_values = [0.0, 0.02, 0.05]}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "frame.csv").write_text("angle_deg,force_kn\n0,0\n20,0.005\n40,0.02\n")
    (tmp_path / "ours.toml").write_text(TOML)
    return tmp_path


def test_a_file_gives_its_fabric(folder):
    fabric = resolve_fabric(str(folder / "ours.toml"))
    base = glass_polypropylene()
    assert (fabric.name, fabric.areal_density, fabric.unit_cell) == ("our fabric", 0.6, base.unit_cell)
    angle = np.radians(40.0)
    moment = 20.0 * 0.25 * np.sin(0.25 * np.pi - 0.5 * angle) / 0.04
    assert float(fabric.shear.moment(angle)) == pytest.approx(moment, rel=1e-12)
    assert fabric.shear.locking_angle == 0.9
    assert fabric.shear_friction.limit == (0.5,)
    assert fabric.bending.warp.moment_values == (0.0, 0.02, 0.05)
    assert "ours.toml" in fabric.source


def test_every_preset_survives_a_file(tmp_path):
    """All parameters of a preset, written with their kinds and read again, give an equal fabric."""

    def written(value):
        if hasattr(value, "model_fields_set"):
            fields = {name: written(getattr(value, name)) for name in type(value).model_fields}
            return {"kind": type(value).__name__} | {name: item for name, item in fields.items() if item is not None}
        return list(value) if isinstance(value, tuple) else value

    for name, make in PRESETS.items():
        fabric = make()
        values = {key: written(getattr(fabric, key)) for key in type(fabric).model_fields}
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps({key: value for key, value in values.items() if value is not None}))
        assert load_fabric(path) == fabric


def test_kind_chooses_the_cell(tmp_path):
    cell = {"kind": "TwillWeave", **glass_polypropylene().unit_cell.model_dump(exclude_none=True)}
    path = tmp_path / "twill.json"
    path.write_text(json.dumps({"based_on": "glass-polypropylene", "unit_cell": cell}))
    assert isinstance(load_fabric(path).unit_cell, TwillWeave)
    assert load_fabric(path).name == "twill"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("frame.csv", "none.csv"), "none.csv cannot be read"),
        (("force_kn", "force"), "has the columns .*force_kn"),
        (("from_picture_frame", "from_nothing"), "has the constructors .*from_picture_frame"),
        (("MomentCurve.", "Moments."), "one of .*MomentCurve"),
        (("frame_side = 0.25", ""), "frame_side"),
        (("areal_density = 0.6", "areal_density = -1"), "areal_density"),
        (("areal_density = 0.6", "arealdensity = 1"), "arealdensity"),
        (('based_on = "glass-polypropylene"', 'based_on = "cotton"'), "based_on = 'cotton'"),
        (('kind = "YarnBending"', ""), "says no kind"),
        (("[shear]", "[shear"), "line"),
        (("limit = [0.5]", "limit = [-0.5]"), "limit"),
    ],
)
def test_mistakes_are_told(folder, change, message):
    text = TOML.replace(*change)
    assert text != TOML
    path = folder / "wrong.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as raised:
        load_fabric(path)
    assert "wrong.toml" in str(raised.value)


def test_a_number_with_a_comma_is_told_with_its_line(folder):
    (folder / "frame.csv").write_text('angle_deg,force_kn\n0,0\n20,"0,005"\n')
    with pytest.raises(InputError, match="line 3.*no number"):
        load_fabric(folder / "ours.toml")


def test_unknown_names_are_refused(tmp_path):
    with pytest.raises(InputError, match="choose one of glass-polypropylene"):
        resolve_fabric("cotton")
    with pytest.raises(InputError, match="cannot be read"):
        resolve_fabric(str(tmp_path / "missing.toml"))


def test_the_documented_file_is_read(tmp_path):
    """The example of docs/fabrics.md, with a test to go with it."""
    page = (Path(__file__).parents[2] / "docs" / "fabrics.md").read_text()
    (tmp_path / "ours.toml").write_text(page.split("```toml\n")[1].split("```")[0])
    (tmp_path / "frame.csv").write_text("angle_deg,force_n\n0,0\n20,5\n40,20\n")
    fabric = load_fabric(tmp_path / "ours.toml")
    assert fabric.unit_cell.warp_stiffness == 2.0e6
    assert fabric.bending.warp.friction_limit == 1.0e-2
    assert fabric.has_inner_friction
