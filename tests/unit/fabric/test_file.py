"""Fabrics from files: values are read back, and mistakes are reported."""

import json
import re

import numpy as np
import pytest

from tests.support.paths import ROOT
from weavesim.checks import types_within
from weavesim.errors import InputError
from weavesim.fabric import Fabric, Origin
from weavesim.fabric.cell.weaves import TwillWeave
from weavesim.fabric.families import kinds_within
from weavesim.fabric.file import load_fabric, resolve_fabric
from weavesim.fabric.presets import PRESETS, glass_polypropylene

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
        return [written(item) for item in value] if isinstance(value, tuple) else value

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
        (("frame.csv", "none.csv"), r"line 8: shear.angle: table .*none.csv: cannot be read"),
        (
            ("force_kn", "force_n"),
            "frame.csv, line 1: no column force_n among 'angle_deg', 'force_kn'; did you",
        ),
        (("from_picture_frame", "from_nothing"), "has the constructors .*from_picture_frame"),
        (("MomentCurve.", "Moments."), "one of .*MomentCurve"),
        (("frame_side = 0.25", ""), "frame_side"),
        (("areal_density = 0.6", "areal_density = -1"), "areal_density"),
        (("areal_density = 0.6", "arealdensity = 1"), "arealdensity"),
        (('based_on = "glass-polypropylene"', 'based_on = "cotton"'), "based_on = 'cotton'"),
        (('kind = "YarnBending"', ""), "has no kind"),
        (("[shear]", "[shear"), "line"),
        (("limit = [0.5]", "limit = [-0.5]"), r"\[shear_friction\] ShearFriction: limit"),
        (("scale = 1000.0", 'scale = "x"'), r"machine_force: scale = 'x'"),
        (("frame_side = 0.25", "frame_side = 0"), r"\[shear\] MomentCurve.from_picture_frame: frame_side = 0"),
        (("frame_side = 0.25", 'frame_side = "wide"'), r"\[shear\].*frame_side = 'wide'"),
        (("frame_side = 0.25", "frame_side = 250"), "frame_side = 250: at most 5 m is allowed: write 0.25 for 250 mm"),
        (("fabric_side = 0.2", "fabric_side = 0.3"), "fabric_side = 0.3 m: must not exceed that of the frame"),
        (("areal_density = 0.6", "areal_density = 600"), "areal_density = 600.*write 0.6 for 600"),
        (("areal_density = 0.6", "thickness = 1.2"), "thickness = 1.2.*write 0.0012 for 1.2 mm"),
        (("areal_density = 0.6", "areal_density = true"), "areal_density = True.*not true or false"),
        (
            ("limit = [0.5]", "limit = [0.5, 1.0]\nangle = [0.0, 40.0]"),
            "write 0.6981 for 40 degrees",
        ),
        (("crossover_friction_length = 1e-4", "crossover_friction_length = 0.1"), "write 0.0001 for 0.1 mm"),
        (("curvature = [0.0, 10.0, 40.0]", "curvature = 3"), r"line 23: \[bending.warp\] BendingCurve: curvature = 3"),
        (("stiffness = 40.0\n", ""), "ShearFriction: stiffness: is required"),
    ],
)
def test_mistakes_are_reported(folder, change, message):
    text = TOML.replace(*change)
    assert text != TOML
    path = folder / "wrong.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as raised:
        load_fabric(path)
    assert "wrong.toml" in str(raised.value)


def test_a_number_with_two_readings_is_reported_with_its_line(folder):
    (folder / "frame.csv").write_text('angle_deg,force_kn\n0,0\n20,"1,005"\n')
    with pytest.raises(
        InputError, match="line 8: shear.angle: table .*line 3: '1,005' has two readings, 1.005 and 1005"
    ):
        load_fabric(folder / "ours.toml")


def test_unknown_names_are_refused(tmp_path):
    with pytest.raises(InputError, match="choose one of glass-polypropylene"):
        resolve_fabric("cotton")
    with pytest.raises(InputError, match="cannot be read"):
        resolve_fabric(str(tmp_path / "missing.toml"))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('kind = "MomentCurve.from_stress_polynomial"\ntangent_coefficients = ["x"]\nthickness = 1e-3',
         r"\[shear\] MomentCurve.from_stress_polynomial: "),
        ('kind = "MomentCurve.from_stress_polynomial"\ntangent_coefficients = [1e4]\nthickness = 1e-3\n'
         'convention = "x"',
         "convention = 'x': \"yarn frame\" or \"moment\" is needed"),
        ('kind = "MomentCurve.from_normalised_force"\nangle = [0, 0.5]\nforce_per_length = [0, 2]\n'
         'convention = "frame side"\nframe_side = 0.2\nfabric_side = 0', "fabric_side = 0"),
        ('kind = "MomentCurve.from_normalised_force"\nangle = [0, 0.5]\nforce_per_length = [0]\n'
         'convention = "fabric area"', "2 of angle, 1 of force_per_length: the same number"),
        ('kind = "MomentCurve.from_picture_frame"\nangle = [0, 0.5]\nmachine_force = [0, "2"]\nframe_side = 0.2',
         "machine_force: a list of finite numbers is needed"),
        ('kind = "MomentCurve"\nangle = [0, 0.5]\nmoment_values = [0, -2]', "moments must not be negative"),
    ],
)  # fmt: skip
def test_mistakes_in_a_shear_test_are_reported(tmp_path, table, message):
    path = tmp_path / "wrong.toml"
    path.write_text(f'based_on = "glass-polypropylene"\n[shear]\n{table}\n')
    with pytest.raises(InputError, match=message):
        load_fabric(path)


def test_what_is_missing_is_named_without_a_dump(tmp_path):
    path = tmp_path / "bare.toml"
    path.write_text('name = "bare"\nthickness = 1e-3\n')
    with pytest.raises(InputError, match="areal_density: is required; unit_cell: is required") as raised:
        load_fabric(path)
    assert "thickness" not in str(raised.value)


def test_a_measured_loop_comes_from_a_file(tmp_path):
    """Both halves of one loop, from the same columns of a CSV file."""
    angle = np.array([0.0, 0.2, 0.5, 0.8])
    middle, half = 4.0 * angle**2, np.array([0.3, 0.3, 0.4, 0.6])
    rows = "\n".join(f"{a},{m + h},{m - h}" for a, m, h in zip(angle, middle, half, strict=True))
    (tmp_path / "loop.csv").write_text(f"angle,up,down\n{rows}\n")
    columns = "\n".join(
        f'{name} = {{csv = "loop.csv", column = "{column}"}}'
        for name, column in (("angle", "angle"), ("loading", "up"), ("unloading", "down"))
    )
    path = tmp_path / "ours.toml"
    path.write_text(
        'based_on = "glass-polypropylene"\n'
        f'[shear]\nkind = "MomentCurve.from_loading_and_unloading"\n{columns}\nlocking_angle = 0.9\n'
        f'[shear_friction]\nkind = "ShearFriction.from_loading_and_unloading"\n{columns}\nstiffness = 40.0\n'
    )
    fabric = load_fabric(path)
    np.testing.assert_allclose(fabric.shear.moment(angle), middle, atol=1e-12)
    np.testing.assert_allclose(fabric.shear_friction.limit_at(angle), half, atol=1e-12)
    assert fabric.shear.locking_angle == 0.9
    # up and down again along the law itself: the loop that was measured
    path = np.concatenate([np.linspace(0.0, 0.8, 801), np.linspace(0.8, 0.0, 801)])
    moment = fabric.shear.moment(path) + fabric.shear_friction.moment_along(path)
    np.testing.assert_allclose(moment[[200, 500, 800]], (middle + half)[1:], rtol=1e-6)
    assert moment[801 + 300] == pytest.approx((middle - half)[2], rel=1e-6)


def test_the_documented_files_are_read(tmp_path):
    """The examples of docs/fabrics.md, with a test to go with them."""
    page = (ROOT / "docs" / "fabrics.md").read_text()
    (tmp_path / "frame.csv").write_text("angle_deg,force [N]\n0,0\n20,5\n40,20\n")
    woven, membrane, sourced = (text.split("```")[0] for text in page.split("```toml\n")[1:])
    (tmp_path / "ours.toml").write_text(woven)
    fabric = load_fabric(tmp_path / "ours.toml")
    assert isinstance(fabric.unit_cell, TwillWeave)
    assert fabric.bending.warp.friction_limit == 1.0e-2
    assert fabric.has_inner_friction
    (tmp_path / "membrane.toml").write_text(membrane)
    assert load_fabric(tmp_path / "membrane.toml").unit_cell.warp_stiffness == 2.0e6
    (tmp_path / "sourced.toml").write_text(sourced)
    fabric = load_fabric(tmp_path / "sourced.toml")
    assert fabric.origin_of("shear.moment_values").scatter == 0.12 and fabric.origin_of("bending.modulus").assumed
    (tmp_path / "membrane.toml").write_text(membrane + "crossover_friction_length = 1e-4\n")
    with pytest.raises(InputError, match="LinearMembrane reports no pressure"):
        load_fabric(tmp_path / "membrane.toml")


@pytest.mark.parametrize(
    ("based_on", "message"),
    [
        ("[1]", "line 1: based_on = a list: a preset, or .*presets are glass-polypropylene"),
        ("{a = 1}", "based_on = a dict: a preset"),
        ("1", "based_on = 1: a preset"),
        ("true", "based_on = True: a preset"),
        ('"ours.toml"', "based_on = 'ours.toml': a preset"),
        ('"glass-polypropylen"', "did you mean 'glass-polypropylene'"),
        ("2024-01-01", "based_on: 2024-01-01 is a date"),
    ],
)
def test_a_fabric_is_based_on_a_preset_only(tmp_path, based_on, message):
    path = tmp_path / "ours.toml"
    path.write_text(f"based_on = {based_on}\n")
    with pytest.raises(InputError, match=message):
        load_fabric(path)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("thicknes = 1e-3", "line 2: Fabric: thicknes = 0.001: unknown name; did you mean 'thickness'"),
        ("Thickness = 1e-3", "did you mean 'thickness'"),
        ("[shears]", r"line 2: \[shears\] unknown name; did you mean 'shear'"),
        ("[qqqqqq]", r"line 2: \[qqqqqq\] unknown name; a fabric has no such table"),
        ("shear = 5", "line 2: Fabric: shear = 5: one of LinearShear, MomentCurve is needed"),
        ("shear = [5]", "line 2: Fabric: shear"),
        ('thickness = "1.2"', "line 2: Fabric: thickness = '1.2': a number is needed, not a text"),
        ("[shear]\nkind = 'LinearShear'\nmodulis = 1e6", r"line 4: \[shear\] LinearShear: .*did you mean 'modulus'"),
        ("[shear]\nkind = 'LinearShaer'", r"line 2: \[shear\] kind = 'LinearShaer': .*did you mean 'LinearShear'"),
        (
            "[shear]\nkind = 'LinearShear'\n[shear.modulus]\na = 1",
            "line 4: shear.modulus: a value is needed, not a table",
        ),
    ],
)
def test_mistakes_have_their_line_and_the_nearest_name(tmp_path, line, message):
    path = tmp_path / "ours.toml"
    path.write_text(f'based_on = "glass-polypropylene"\n{line}\n')
    with pytest.raises(InputError, match=message):
        load_fabric(path)


def test_a_preset_is_no_file():
    with pytest.raises(InputError, match="this is a preset, no file; take weavesim.resolve_fabric"):
        load_fabric("assumed-twill")


@pytest.mark.parametrize("read", [load_fabric, resolve_fabric])
@pytest.mark.parametrize("value", [None, 3, b"a.toml", ["a.toml"], {"name": "a"}])
def test_what_is_no_path_is_refused(read, value):
    with pytest.raises(InputError, match="the path of a file is needed"):
        read(value)


def test_the_name_of_a_file_is_no_trap(tmp_path):
    path = tmp_path / ("o\u2028x" * 30 + ".toml")
    path.write_text('based_on = "glass-polypropylene"\n')
    fabric = load_fabric(path)
    assert fabric.name.isprintable() and len(fabric.name) <= 100 and fabric.source.isprintable()


def test_the_guide_has_every_number():
    """What it is, typical values, the test, and what to do without it: for every field that holds numbers."""
    page = (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")
    guide = page.split("## Every number")[1].split("## Loading and unloading")[0]
    told = set(re.findall(r"`(\w+)`", guide))
    for kind in (Fabric, *kinds_within(Fabric).values()):
        if not kind.__module__.startswith("weavesim.") or kind is Origin:
            continue
        for name, field in kind.model_fields.items():
            types = set(types_within(field.annotation))
            if types & {int, float}:
                assert name in told, f"docs/fabrics.md does not say how to find {kind.__name__}.{name}"
