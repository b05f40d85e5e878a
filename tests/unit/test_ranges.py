"""One table of quantities: what is illegal or unusual is told with the likely slip, wherever it is given."""

import json
import math
import re
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest

from scenes.hemisphere import cloth
from tests.support.paths import ROOT
from weavesim import Dynamics, InputError, Setup, Sheet, Tool
from weavesim.app.command_line import SCENES
from weavesim.app.options import RunOptions
from weavesim.checks import Parameters, Positive, types_within
from weavesim.engine.setup import Solver
from weavesim.fabric import (
    PRESETS,
    BendingCurve,
    Fabric,
    IsotropicBending,
    LinearMembrane,
    LinearShear,
    MomentCurve,
    PlainWeave,
    YarnBending,
    glass_polypropylene,
    load_fabric,
)
from weavesim.process import Stroke
from weavesim.ranges import QUANTITIES, SLIPS, Quantity, argument, illegal, quantity_of, unusual_values
from weavesim.sheet.blank import Blank
from weavesim.tools import Sphere

# Numbers that have no unit and whose limits are their field's own: counts, indices, shares, ratios, colours, matrices;
# ranges of any number.
WITHOUT_QUANTITY = {
    "Compaction.thickening", "CrossedYarns.warp_crimp_share", "Drive.direction", "FloatWeave.repeat",
    "Gripper.direction", "IsotropicBending.poisson_ratio",
    "Lamina.poisson_ratio", "Lamina.poisson_ratio_across", "NodalLoads.shares", "Origin.range", "Origin.scatter",
    "HolderOptions.blank_holder_segments", "PushedTable.segments", "SegmentTable.number",
    "Rotation.axis", "RotationTable.axis", "Setup.frame_count", "Setup.leading_tool",
    "Shape.rotation", "Solver.lane_count", "Solver.step_safety", "Solver.threads", "Tool.axis",
    "Tool.colour", "TriangleMesh.side", "RunOptions.threads", "RunOptions.frame_count", "HemisphereParameters.seed",
    "CusickDrapeParameters.seed", "CalibrationOptions.held_uncertainty", "CalibrationOptions.knots",
    "CalibrationOptions.noise", "GrippersParameters.gripped_share",
    "GrippersParameters.gripper_count", "CalibrationOptions.seed", "CalibrationOptions.starts", "SpringTable.direction",
    "SolverTable.threads", "ToolTable.axis", "MeasureTable.at_least", "MeasureTable.at_most", "NoiseTable.points",
    "NoiseTable.repeats", "MassScaling.factor", "MassScaling.kept_share", "ScalingTry.factor",
    "ScalingTry.angle_error", "ScalingTry.draw_in_error", "ScalingTry.kinetic_ratio", "ScalingTry.speed_up",
    "StudyTable.batch", "StudyTable.budget", "StudyTable.field_points", "StudyTable.retries",
    "StudyTable.risk", "StudyTable.samples", "StudyTable.scenarios", "StudyTable.seed", "VaryTable.count",
}  # fmt: skip


def classes(base=Parameters):
    for kind in base.__subclasses__():
        yield kind
        yield from classes(kind)


def number_fields():
    """Field names, with the class that first defines each, of all of weavesim's own classes."""
    for scene in SCENES.values():
        scene.load()
    import_module("weavesim.app.calibrate_command")
    for kind in set(classes()):
        file = getattr(sys.modules.get(kind.__module__), "__file__", None) or ""
        if not Path(file).is_relative_to(ROOT) or "tests" in Path(file).parts:
            continue
        for name, field in kind.model_fields.items():
            types = {part for part in types_within(field.annotation) if isinstance(part, type)}
            if types & {float, int} and bool not in types:
                owner = [base for base in kind.__mro__ if name in getattr(base, "model_fields", {})][-1]
                yield f"{owner.__name__}.{name}", f"{kind.__name__}.{name}", field


def test_every_number_that_a_user_gives_is_a_quantity():
    missing = {
        own
        for first, own, field in number_fields()
        if quantity_of(field) is None and not {first, own} & WITHOUT_QUANTITY
        and not own.endswith((".frame_count", ".repeat"))
    }  # fmt: skip
    assert not missing


def test_a_description_has_the_unit_of_its_quantity():
    wrong = {}
    for _, own, field in number_fields():
        quantity, found = quantity_of(field), re.search(r"\[([^\]]+)\]", field.description or "")
        if quantity and found and found.group(1) != quantity.row.unit:
            wrong[own] = found.group(1), quantity.row.unit
    assert not wrong


def test_every_option_of_a_scene_says_its_unit():
    for scene in SCENES.values():
        for name, field in scene.load().parameters.model_fields.items():
            quantity = quantity_of(field)
            if quantity and quantity.row.unit not in ("1", "m/unit"):
                assert f"[{quantity.row.unit}]" in field.description, name


@pytest.mark.parametrize("name", QUANTITIES)
def test_plausible_is_within_legal(name):
    row = QUANTITIES[name]
    assert row.legal[0] <= row.plausible[0] < row.plausible[1] <= row.legal[1]
    assert row.unit in SLIPS


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_usual(name):
    assert not list(unusual_values(PRESETS[name]()))


@pytest.mark.parametrize("case", ["low-bending", "high-bending"])
def test_the_cloth_of_the_hemisphere_is_usual(case):
    assert not list(unusual_values(cloth(case)))


FABRIC = glass_polypropylene()
CURVE = {"angle": (0.0, 0.9), "moment_values": (0.0, 10.0)}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: MomentCurve(**CURVE, locking_angle=55), "locking_angle = 55: .*write 0.9599 for 55 degrees"),
        (lambda: MomentCurve(**CURVE, locking_width=5.0), "locking_width = 5.0: .*write 0.08727 for 5 degrees"),
        (lambda: MomentCurve(angle=(0.0, 50.0), moment_values=(0.0, 1.0)), "write 0.8727 for 50 degrees"),
        (lambda: MomentCurve.from_polynomial((1.0, 2.0), trusted_angle=55.0), "trusted_angle = 55: .*0.9599"),
        (lambda: MomentCurve.from_stress_polynomial((1e5,), 1.2), "thickness = 1.2: .*write 0.0012 for 1.2 mm"),
        (lambda: MomentCurve.from_picture_frame((0, 0.5), (0, 1.0), frame_side=250.0), "write 0.25 for 250 mm"),
        (lambda: BendingCurve(curvature=(0.0, 1e8), moment_values=(0.0, 1.0)), "curvature = .*at most 1e"),
        (lambda: IsotropicBending(modulus=1e300), "modulus = 1e.300: at most 1e.13 Pa"),
        (lambda: LinearShear(modulus=1e300), "modulus = 1e.300"),
        (lambda: YarnBending(warp=1e300, weft=1.0, twist=0.0), "warp = 1e.300"),
        (lambda: YarnBending(warp=1.0, weft=1.0, twist=0.0, coupling=-1e300), "coupling = -1e.300"),
        (lambda: PlainWeave.glass_polypropylene(warp_modulus=1e300), "warp_modulus"),
        (lambda: PlainWeave.glass_polypropylene(crossover_height=0.6), "write 0.0006 for 0.6 mm"),
        (lambda: PlainWeave.glass_polypropylene(weft_cross_section=1.0), r"write 1e-06 for 1 mm\^2"),
        (lambda: PlainWeave.glass_polypropylene(warp_half_spacing=2.6), "write 0.0026 for 2.6 mm"),
        (lambda: FABRIC.model_copy(update={"areal_density": 600.0}), r"write 0.6 for 600 g/m\^2"),
        (lambda: FABRIC.model_copy(update={"thickness": 1e-7}), "at least 1e-06 m"),
        (lambda: Sphere(120.0), "radius = 120.0: .*write 0.12 for 120 mm"),
        (lambda: Sphere(0.1, origin=(0.0, 0.0, 1e9)), "origin"),
        (lambda: Tool("t", Sphere(0.1), friction=20.0), "friction = 20.0: .*write 0.2 for 20 per cent"),
        (lambda: Stroke.smooth(61.2, 1.0, 0.0), "write 0.0612 for 61.2 mm"),
        (lambda: Stroke((0.0, 1.0), (0.0, 61.2)), "displacements .*write 0.0612 for 61.2 mm"),
        (lambda: Dynamics(gravity=(0.0, 0.0, -1e9)), "gravity"),
        (lambda: Blank.disc(150.0, 5.0), "radius = 150: .*write 0.15 for 150 mm"),
    ],
)  # fmt: skip
def test_an_illegal_value_is_refused_with_the_likely_slip(make, message):
    with pytest.raises(InputError, match=message):
        make()


BLANK = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.05)


def of(fabric=FABRIC, *, blank=BLANK, tools=(), **given) -> Setup:
    return Setup("test", sheets=[Sheet(blank, fabric)], tools=tools, duration=given.pop("duration", 0.1), **given)


def changed(**values):
    return FABRIC.model_copy(update=values)


SOFT = MomentCurve(**CURVE)


def celled(shear=FABRIC.shear, **values):
    return changed(unit_cell=PlainWeave.glass_polypropylene(**values), shear=shear)


def test_a_limit_that_depends_on_the_yarns_names_the_slip_in_them():
    with pytest.raises(InputError, match="locking_stiffness.*but unit_cell.warp_modulus = 31.8 Pa: .* for 31.8 GPa"):
        celled(warp_modulus=31.8)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (lambda: of(celled(warp_modulus=31.8, shear=SOFT)), "warp_modulus = 31.8 Pa: .*write 3.18e.10 for 31.8 GPa"),
        (lambda: of(celled(contact_modulus=10.0)), "write 1e.10 for 10 GPa|for 10 MPa"),
        (lambda: of(celled(warp_second_moment=4.7e-4 * 1e-3)), "warp_second_moment"),
        (lambda: of(changed(bending=IsotropicBending(modulus=20.0))), "bending.modulus = 20 Pa: .*GPa|MPa"),
        (lambda: of(changed(thickness=0.04, compaction=Fabric.model_fields["compaction"].default)), "thickness"),
        (lambda: of(changed(areal_density=7.43, compaction=Fabric.model_fields["compaction"].default)), "6192 kg/m"),
        (lambda: of(changed(bending=YarnBending(warp=2.9, weft=2.9, twist=0.0))), "droop over 0.735 m"),
        (lambda: of(celled(crossover_height=9e-3)), "crossover_height"),
        (lambda: of(tools=[Tool("die", Sphere(0.1 * 25.4))]), "tool die is 5.08 m across, 50.8 times as large"),
        (lambda: of(tools=[Tool("pin", Sphere(0.05 / 39.37))]), "tool pin .* 39.4 times as small"),
        (lambda: of(tools=[Tool("die", Sphere(0.1), Stroke((0.0, 1.0), (0.0, 0.9)))]), "travels 0.9 m, 9 times"),
        (lambda: of(tools=[Tool("die", Sphere(0.1), Stroke((0.0, 1e-3), (0.0, 0.1)), friction=1.9)]), "friction"),
        (lambda: of(duration=500.0), "duration = 500 s: usual .*write 0.5 for 500 ms"),
        (lambda: of(dynamics=Dynamics(gravity=(0.0, 0.0, -9810.0))), r"write 9.81 for 9810 mm/s\^2"),
        (lambda: of(solver=Solver(time_step=0.5)), "time_step"),
        (lambda: of(blank=Blank.rectangle((0.0, 0.0), (18.5, 10.6), 1.0)), "the blank is 18.5 m across"),
        (lambda: of(blank=Blank.rectangle((0.0, 0.0), (5e-4, 5e-4), 1e-4)), "check both units"),
    ],
)  # fmt: skip
def test_an_unusual_value_is_a_question_that_can_be_answered(given, message):
    with pytest.raises(InputError, match=message) as raised:
        given()
    assert "--accept-unusual" in str(raised.value)


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_slip_is_one_that_people_make(name):
    """Sizes that nobody writes in the other unit, such as 1e9 mN or 0.0001 km, are no likely slip."""
    quantity = Quantity(name)
    low, high = quantity.row.plausible
    for share in (1.2, 3.0, 10.0, 100.0, 1e3, 1e4, 1e6, 1e9):
        for size in {high * share, low / share} - {0.0}:
            text = illegal(size, quantity.row) or quantity.unusual(size)
            assert " km" not in text and " kPa" not in text
            for written, other in re.findall(r"for ([-+.e\d]+) (\S+)", text) if "write" in text else ():
                smallest = 1e-13 if other == "mm^4" else 1e-10 if other == "t/mm^3" else 1e-3
                assert smallest <= float(written) <= 1e5, text
                assert other != "um" or high <= 0.05


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("sheet modulus", 20.0, "write 2e.10 for 20 GPa or 2e.07 for 20 MPa"),
        ("shear modulus", 10.0, "write 1e.10 for 10 GPa or 1e.07 for 10 MPa"),
        ("speed", 300.0, "write 0.3 for 300 mm/s or 0.005 for 300 mm/min"),
        ("mesh size", 1.1e-4, "usual are 0.0002 to 0.1 m$"),
        ("in-plane bending", 5.0, "write 0.005 for 5 N mm"),
        ("shear moment", 0.198, "write 198 for 0.198 N/mm"),
        ("unit scale", 1000.0, "it is 0.001 for a file in millimetres"),
        ("shear angle", 0.03, "usual are 0.05 to 1.571 rad$"),
        ("unit scale", 25.4, "0.0254 for inches"),
    ],
)
def test_the_slip_is_told(name, value, message):
    assert re.search(message, Quantity(name).unusual(value))


def test_the_answer_is_kept_with_the_setup():
    fabric = celled(warp_modulus=31.8, shear=SOFT)
    setup = of(fabric, accept_unusual=True)
    again = Setup.from_json(setup.to_json())
    assert again.accept_unusual and again == setup
    with pytest.raises(InputError, match="warp_modulus"):
        setup.model_copy(update={"accept_unusual": False})


def test_all_unusual_values_are_listed_with_their_places():
    fabric = celled(warp_modulus=31.8, weft_modulus=31.8, shear=SOFT)
    with pytest.raises(InputError) as raised:
        of(fabric, duration=500.0)
    text = str(raised.value)
    assert "3 values are unusual" in text
    assert "worlds[world].sheets[sheet].fabric.unit_cell.weft_modulus" in text


def test_a_fabric_file_asks_too(tmp_path):
    file = tmp_path / "ours.toml"
    file.write_text('based_on = "glass-polypropylene"\n[bending]\nkind = "IsotropicBending"\nmodulus = 20.0\n')
    with pytest.raises(InputError, match=r"ours.toml: .*\n.*bending.modulus = 20 Pa"):
        load_fabric(file)
    assert load_fabric(file, accept_unusual=True).bending.modulus == 20.0


def test_options_ask_too():
    with pytest.raises(InputError, match="mesh_size = 0.2 m: usual"):
        RunOptions(mesh_size=0.2)
    assert RunOptions(mesh_size=0.2, accept_unusual=True).mesh_size == 0.2


def test_slow_forming_is_usual():
    """100 mm at 1 mm/s."""
    of(duration=100.0)


def test_composites_practice_is_usual():
    """Thin spread tow to thick fabrics, and a ply of unidirectional carbon."""
    ply = Fabric(
        name="ply", areal_density=0.2, thickness=1.5e-4,
        unit_cell=LinearMembrane(warp_stiffness=2e7, weft_stiffness=1e4), shear=LinearShear(modulus=1e5),
        bending=YarnBending(warp=0.03, weft=1e-5, twist=1e-5), transverse_shear_modulus=5e6,
    )  # fmt: skip
    assert not list(unusual_values(ply))
    for thickness, density, modulus in ((5e-5, 0.06, 1e8), (2e-3, 2.0, 5e6), (4e-4, 0.2, 2e7), (1.0e-3, 0.3, 2e6)):
        fabric = changed(
            thickness=thickness, areal_density=density, compaction=Fabric.model_fields["compaction"].default,
            unit_cell=PlainWeave.glass_polypropylene(crossover_height=0.5 * thickness, warp_modulus=230e9),
            bending=IsotropicBending(modulus=modulus),
        )  # fmt: skip
        assert not list(unusual_values(fabric)), thickness


@pytest.mark.parametrize("degrees", [15.0, 30.0, 40.0, 45.0, 60.0, 90.0])
def test_angles_in_radians_are_noticed_where_degrees_are_meant(degrees):
    with pytest.raises(InputError, match=f"{degrees:g} degrees in radians"):
        Setup("t", sheets=[Sheet(BLANK, FABRIC, orientation=math.radians(degrees))], duration=0.1)
    assert Quantity("angle").unusual(degrees) is None


def test_zero_and_signs_are_the_fields_matter():
    assert Quantity("shear modulus").unusual(0.0) is None
    assert argument("x", -0.1, "displacement", negative=True) == -0.1
    with pytest.raises(InputError, match="x = -0.1"):
        argument("x", -0.1, "displacement")


def test_an_unusual_argument_is_logged(caplog):
    argument("frame_side", 2.5, "frame side")
    assert "frame_side = 2.5 m is unusual: usual are 0.01 to 2 m" in caplog.text


def test_your_own_field_can_be_a_quantity():
    class Own(Parameters):
        width: Annotated[Positive, Quantity("length")]

    with pytest.raises(InputError, match="width = 25.0: at most 20 m is allowed: write 0.025 for 25 mm"):
        Own(width=25.0)
    assert list(unusual_values(Own(width=7.0)))


def test_arrays_are_checked_by_their_largest_entry():
    velocity = np.zeros((BLANK.node_count, 3))
    velocity[0, 2] = 500.0
    with pytest.raises(InputError, match="initial_velocity = up to 500 m/s: usual .*write 0.5 for 500 mm/s"):
        Setup("t", sheets=[Sheet(BLANK, FABRIC, initial_velocity=velocity)], duration=0.1)


WRONG_UNITS = {
    "locking angle in degrees": ("shear", "locking_angle = 55", "write 0.9599 for 55 degrees"),
    "locking width in degrees": ("shear", "locking_width = 5", "write 0.08727 for 5 degrees"),
    "trusted angle in degrees": ("shear", "angle = [0.0, 25.0, 50.0]", "write 0.8727 for 50 degrees"),
    "crossover in mm": ("unit_cell", "crossover_height = 0.6", "write 0.0006 for 0.6 mm"),
    "spacing in mm": ("unit_cell", "warp_half_spacing = 2.6", "write 0.0026 for 2.6 mm"),
    "area in mm^2": ("unit_cell", "weft_cross_section = 1.0", r"write 1e-06 for 1 mm\^2"),
    "modulus in GPa": ("unit_cell", "weft_modulus = 31.8", "write 3.18e.10 for 31.8 GPa"),
    "contact modulus in MPa": ("unit_cell", "contact_modulus = 10.0", "for 10 [GM]Pa"),
    "bending in MPa": ("bending", "modulus = 20.0", "for 20 [GM]Pa"),
    "bending that is none": ("bending", "modulus = 1e300", "at most 1e.13 Pa"),
    "fibres in g/cm^3": ("compaction", "fibre_density = 2.55", r"write 2550 for 2.55 g/cm\^3"),
    "fibres in g/m^2": ("compaction", "fibre_areal_density = 445.8", r"write 0.4458 for 445.8 g/m\^2"),
}


def file_of(table: str, line: str) -> str:
    """A whole fabric as TOML, of which one value is another."""
    values = {
        "unit_cell": {
            "kind": '"PlainWeave"', "warp_modulus": "31.8e9", "weft_modulus": "31.8e9", "contact_modulus": "10.0e6",
            "warp_cross_section": "1e-6", "weft_cross_section": "1e-6", "contact_cross_section": "1.6e-5",
            "warp_second_moment": "4.7e-16", "weft_second_moment": "4.7e-16", "warp_half_spacing": "2.6e-3",
            "weft_half_spacing": "2.6e-3", "crossover_height": "0.6e-3",
        },
        "shear": {"kind": '"MomentCurve"', "angle": "[0.0, 0.5, 0.9]", "moment_values": "[0.0, 10.0, 40.0]"},
        "bending": {"kind": '"IsotropicBending"', "modulus": "20.0e6"},
        "compaction": {"fibre_areal_density": "0.4458", "fibre_density": "2550.0"},
    }  # fmt: skip
    name, _, value = line.partition(" = ")
    values[table][name] = value
    lines = ["areal_density = 0.743", "thickness = 1.2e-3", "transverse_shear_modulus = 10.0e6"]
    for key, entries in values.items():
        lines += [f"[{key}]", *(f"{entry} = {text}" for entry, text in entries.items())]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", WRONG_UNITS)
@pytest.mark.parametrize("form", ["toml", "json", "command line", "setup from json"])
def test_a_wrong_unit_is_told_alike_wherever_it_is_given(name, form, tmp_path):
    table, line, message = WRONG_UNITS[name]
    toml = file_of(table, line)
    content = tomllib.loads(toml)
    file = tmp_path / ("ours.json" if form == "json" else "ours.toml")
    file.write_text(json.dumps(content) if form == "json" else toml)
    with pytest.raises(InputError, match=message):
        if form == "setup from json":
            setup = json.loads(of().to_json())
            for key, value in content.items():
                old = setup["worlds"][0]["sheets"][0]["fabric"].get(key)
                merge = isinstance(value, dict) and isinstance(old, dict) and old.get("kind") == value.get("kind")
                setup["worlds"][0]["sheets"][0]["fabric"][key] = old | value if merge else value
            Setup.from_json(json.dumps(setup))
        elif form == "command line":
            scene = SCENES["double-dome"].load()
            scene.setups(scene.parameters(fabric=str(file)))
        else:
            load_fabric(file)


def test_the_file_of_these_tests_is_usual(tmp_path):
    (tmp_path / "ours.toml").write_text(file_of("shear", "locking_angle = 0.96"))
    assert load_fabric(tmp_path / "ours.toml").shear.locking_angle == 0.96
