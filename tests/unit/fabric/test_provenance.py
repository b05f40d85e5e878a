"""Where numbers come from: named, checked, kept in files, and lost by numbers that change."""

import json
import math
import tomllib

import pytest

from tests.support.runs import one_sheet_setup
from weavesim import Blank, Fabric, InputError, LinearShear, Origin, Setup, glass_polypropylene, load_fabric
from weavesim.fabric import PRESETS, BendingCurve, IsotropicBending, YarnBending
from weavesim.fabric.provenance import given_numbers, numbers_of, origin_of, still_true, without

GLASS = glass_polypropylene()


def test_numbers_are_named_as_in_files_with_unit_and_meaning():
    numbers = numbers_of(GLASS)
    assert numbers["unit_cell.warp_modulus"][1:3] == (31.8e9, "Pa")
    assert numbers["thickness"].meaning == "of the undeformed sheet" and numbers["thickness"].values == (1.2e-3,)
    assert len(numbers["shear.angle"].values) == 221 and numbers["shear.angle"].unit == "rad"
    assert numbers["shear_friction"].value is None and numbers["shear_friction"].values == ()
    assert "shear_friction" not in given_numbers(GLASS) and "unit_cell.contact" not in numbers
    assert not {"name", "source", "assumed", "provenance"} & {name.split(".")[0] for name in numbers}
    curve = BendingCurve.from_kawabata(rigidity=1e-3, hysteresis=2e-2)
    bent = GLASS.model_copy(update={"bending": YarnBending(warp=curve, weft=1e-3, twist=1e-4)})
    assert {"bending.warp.curvature", "bending.weft", "bending.twist"} <= set(given_numbers(bent))


def test_the_innermost_name_counts():
    table, number = Origin(of="bending", source="a"), Origin(of=["bending.modulus"], source="b")
    assert origin_of((table, number), "bending.modulus") is number
    assert origin_of((table, number), "bending.poisson_ratio") is table
    assert origin_of((table, number), "thickness") is None
    assert Origin(of="thickness", source="x").of == ("thickness",)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"of": "thicknes", "source": "x"}, "thicknes is no number of this fabric; did you mean 'thickness'"),
        ({"of": ["thickness", "thickness"], "source": "x"}, "thickness is named twice"),
        ({"of": "bending", "source": "x", "range": (0, 1)}, "bending is a table; a range needs"),
        ({"of": "shear_friction", "source": "x", "range": (0, 1)}, "shear_friction is not given"),
        ({"of": [], "source": "x"}, "at least one number is needed"),
        ({"of": "thickness", "source": " "}, "source: a text is needed"),
        ({"of": "thickness", "source": "x", "range": (2, 1)}, "the least value comes first"),
        ({"of": "thickness", "source": "x", "scatter": 0}, "scatter = 0: a number above 0"),
        ({"of": "thickness", "source": "x" * 3000}, "at most 2000 characters"),
        ({"of": "thickness", "source": "x", "rnage": (1, 2)}, "rnage.*did you mean 'range'"),
        ({"of": "thickness"}, "source: is required"),
    ],
)
def test_what_cannot_be_meant_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        GLASS.model_copy(update={"provenance": (Origin(**given),)})


def test_a_number_outside_its_own_range_is_a_question(tmp_path):
    origin = Origin(of="thickness", source="ours", range=(0.8, 1.4))  # in mm
    said = list(GLASS.model_copy(update={"provenance": (origin,)}).disproportions())
    assert said and said[0].startswith("thickness = 0.0012 m, but its provenance trusts 0.8 to 1.4 m")
    origin = Origin(of="shear.angle", source="ours", range=(5.0, 35.0))  # in degrees
    assert "shear.angle is from 0 to" in next(GLASS.model_copy(update={"provenance": (origin,)}).disproportions())
    path = tmp_path / "ours.toml"
    path.write_text(
        'based_on = "glass-polypropylene"\n[[provenance]]\nof = "thickness"\nsource = "ours"\nrange = [0.8, 1.4]\n'
    )
    with pytest.raises(InputError, match="check the units of both"):
        load_fabric(path)
    assert load_fabric(path, accept_unusual=True).origin_of("thickness").source == "ours"


def test_numbers_that_change_lose_their_provenance():
    changed = GLASS.model_copy(update={"thickness": 1.3e-3, "bending": IsotropicBending(modulus=20.0e6)})
    assert changed.origin_of("thickness") is None
    assert changed.origin_of("areal_density") == GLASS.origin_of("areal_density")
    assert changed.origin_of("bending.modulus") == GLASS.origin_of("bending.modulus")  # the same number
    sheared = GLASS.with_linear_shear(0.2e6)
    assert sheared.shear == LinearShear(modulus=0.2e6) and sheared.origin_of("shear.modulus") is None
    assert not any(name.startswith("shear.") for origin in sheared.provenance for name in origin.of)
    kept = Origin(of="thickness", source="ours")
    assert GLASS.model_copy(update={"thickness": 1.3e-3, "provenance": (kept,)}).provenance == (kept,)


def test_what_is_said_of_a_table_holds_for_the_part_that_stays():
    fabric = GLASS.model_copy(update={"provenance": (Origin(of=("bending", "thickness"), source="x"),)})
    softer = fabric.model_copy(update={"bending": IsotropicBending(modulus=1.0e6)})
    assert [origin.of for origin in softer.provenance] == [("bending.poisson_ratio", "thickness")]
    assert [origin.of for origin in still_true(fabric, fabric)] == [("bending", "thickness")]
    assert [origin.of for origin in without(fabric.provenance, ["bending"])] == [("thickness",)]
    assert without(GLASS.provenance, numbers_of(GLASS)) == ()


FILE = """
based_on = "glass-polypropylene"
thickness = 0.9e-3
[bending]
kind = "IsotropicBending"
modulus = 20.0e6
[[provenance]]
of = "thickness"
source = "micrometer, five places"
range = [0.85e-3, 0.95e-3]
[[provenance]]
of = ["bending", "unit_cell.contact_modulus"]
source = "guess"
assumed = true
note = "until the cantilever is repaired"
"""


def test_a_file_says_where_its_own_numbers_come_from(tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text(FILE)
    fabric = load_fabric(path)
    assert fabric.origin_of("thickness").range == (0.85e-3, 0.95e-3)
    assert fabric.origin_of("bending.modulus").note.startswith("until")  # given again: no longer that of the preset
    assert fabric.origin_of("bending.poisson_ratio").assumed
    assert fabric.origin_of("unit_cell.contact_modulus").source == "guess"
    assert fabric.origin_of("unit_cell.warp_modulus") == GLASS.origin_of("unit_cell.warp_modulus")
    path.write_text(FILE.partition("[[provenance]]")[0])
    fabric = load_fabric(path)  # without saying anything
    assert fabric.origin_of("thickness") is None and fabric.origin_of("bending.modulus") is None
    assert fabric.origin_of("areal_density") == GLASS.origin_of("areal_density")
    path.write_text(FILE.replace("[[provenance]]", "[provenance]", 1).partition("[[provenance]]")[0])
    assert load_fabric(path).origin_of("thickness").source.startswith("micrometer")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('provenance = "Cao"', "provenance = 'Cao': give a list"),
        ('[[provenance]]\nof = "thicknes"\nsource = "x"', "ours.toml, line 2: .*no number of this fabric"),
        ('[[provenance]]\nsource = "x"', r"ours.toml, line 2: \[provenance\] Origin: of: is required"),
        ('[[provenance]]\nof = 3\nsource = "x"', "of = 3: give a list"),
        ('[[provenance]]\nof = "thickness"\nsource = "x"\nrange = [1.0]', "range"),
        ('[[provenance]]\nof = "thickness"\nsource = 5', "source = 5: a text is needed"),
        ("provenance = [1, 2]", "provenance.0 = 1: a Origin is needed"),
    ],
)
def test_mistakes_in_a_file_are_told_with_their_place(line, message, tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text(f'based_on = "glass-polypropylene"\n{line}\n')
    with pytest.raises(InputError, match=message):
        load_fabric(path)


def test_provenance_survives_json_files_and_setups(tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text(FILE)
    fabric = load_fabric(path)
    assert Fabric.from_json(fabric.to_json()) == fabric
    (tmp_path / "ours.json").write_text(fabric.to_json())
    assert load_fabric(tmp_path / "ours.json") == fabric
    setup = one_sheet_setup(name="p", blank=Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.05), fabric=fabric, duration=1e-3)
    again = Setup.from_json(setup.to_json()).worlds[0].sheets[0].fabric
    assert again == fabric and again.origin_of("thickness").source == "micrometer, five places"
    written = json.loads(setup.to_json())["worlds"][0]["sheets"][0]["fabric"]["provenance"]
    assert len(written) == len(fabric.provenance)


def test_files_from_before_there_was_provenance_are_read(tmp_path):
    values = json.loads(GLASS.to_json())
    del values["provenance"]
    path = tmp_path / "old.json"
    path.write_text(json.dumps(values))
    assert load_fabric(path) == GLASS.model_copy(update={"provenance": ()})
    assert list(load_fabric(path).disproportions()) == []


def test_the_file_above_is_toml():
    assert math.isclose(tomllib.loads(FILE)["provenance"][0]["range"][0], 0.85e-3)


@pytest.mark.parametrize("name", PRESETS)
def test_toml_gives_an_equal_fabric(name, tmp_path):
    fabric = PRESETS[name]()
    path = tmp_path / "copy.toml"
    path.write_text(fabric.to_toml())
    assert load_fabric(path) == fabric


def test_toml_of_a_fabric_with_everything(tmp_path):
    curve = BendingCurve.from_kawabata(rigidity=1e-3, hysteresis=2e-2)
    origin = Origin(of=("bending.warp",), source='a "text" \\ with\nlines', note="é µ")
    fabric = GLASS.model_copy(update={"bending": YarnBending(warp=curve, weft=1e-3, twist=1e-4)})
    fabric = fabric.model_copy(update={"provenance": (*fabric.provenance, origin)})
    path = tmp_path / "copy.toml"
    path.write_text(fabric.to_toml(), encoding="utf-8")
    assert load_fabric(path) == fabric
