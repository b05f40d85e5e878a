"""No option of a scene is ignored in silence: it changes the set-up or what is shown, or it is refused."""

from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import pytest

from weavesim.app.options import Need, RunOptions
from weavesim.errors import InputError
from weavesim.scenes.scene import known_scenes

SCENES = {name: found.load() for name, found in known_scenes().items()}
# Where and what a run writes, and what it accepts, change no number; another device has to be there; a mass scaling is
# sought before the run, test_scene.py.
LEFT_OUT = {
    "out", "write", "without", "overwrite", "checkpoint_interval", "accept_unusual", "device", "strict", "limits",
    "solver_fields", "stop_on", "mass_scaling_angle", "mass_scaling_draw_in",
}  # fmt: skip
# Changes only what a run records; tests/validation/ have its effect.
RECORDED = {("picture-frame", "load_factor")}
# Coarse, so that a set-up is made at once.
COARSE = {
    "double-dome": {"mesh_size": 0.03}, "grippers": {"mesh_size": 0.012}, "hemisphere": {"mesh_size": 0.018},
    "picture-frame": {"mesh_size": 0.02},
    "bias-extension": {"mesh_size": 0.0125}, "cantilever": {"mesh_size": 0.0125},
    "biaxial": {"mesh_size": 0.025}, "uniaxial": {"mesh_size": 0.0125}, "compaction": {"mesh_size": 0.025},
    "sled": {"mesh_size": 0.03}, "pure-bending": {"mesh_size": 0.001}, "cusick-drape": {"mesh_size": 0.007},
    "stack": {"mesh_size": 0.02}, "diaphragm": {"mesh_size": 0.016},
}  # fmt: skip
# Other values of options whose range or meaning does not allow just any.
OTHERS: dict[str, Any] = {
    "mesh_size": lambda value: 0.8 * value,
    "yarn_angle": lambda value: 90.0,
    "fabric": lambda value: "twill",
    "blank_holder_force": lambda value: 100.0,
    "blank_holder_gap": lambda value: 1.0e-4,
    "blank_holder_stop": lambda value: 1.0e-4,
    "blank_holder_segments": lambda value: 8,
    "blank_holder_loads": lambda value: "100, gap 0.0001",
    "time_step": lambda value: 1.0e-7,
    "target_step": lambda value: 1.0e-5,
    "threads": lambda value: 1,
    "length": lambda value: 1.1 * (value or 0.1),
    "arm_length": lambda value: 0.05,
    "misalignment": lambda value: 5.0,
    "damping": lambda value: 7.0,
    "gripper_force": lambda value: 20.0,
    "gripped_share": lambda value: 0.8,
    "gripper_count": lambda value: 1,
    "measured_columns": lambda value: "neither, nor",
    "frame_side": lambda value: 0.3,
    "lay_up": lambda value: "[0/45]s",
    "ply_thickness": lambda value: 5.0e-4,
    "ply_friction": lambda value: 0.3,
    "friction": lambda value: 0.15,
    "punch_speed": lambda value: 0.9 * (value or 0.25),
    "stroke": lambda value: 0.9 * (value or 0.05),
}
# What has to be given too, for an option to have its effect.
TOGETHER: dict[str | tuple[str, str], dict[str, Any]] = {
    ("stack", "blank_holder_force"): {"tools": "double-dome", "lay_up": "0/90"},
    "blank_holder_loads": {"blank_holder_segments": 8},
    "shear_modulus": {"shear_law": "linear"},
    "unit_scale": {"punch": "ball"},
    "tools_are_cut": {"punch": "ball"},
    "measured_columns": {"measured": "measured.csv"},
}
# Usual columns of all tests.
MEASURED = (
    "angle [deg],displacement [mm],force [N],strain [%],warp force [N/m],curvature [1/m],moment [N],x [mm],drop [mm],"
    "radius [mm],pressure [kPa],thickness [mm]\n" + "".join(",".join([str(k)] * 12) + "\n" for k in range(3))
)
TRIES = [(scene, name) for scene, found in SCENES.items() for name in found.parameters.model_fields]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Inputs for options that name files."""
    import trimesh

    folder = tmp_path_factory.mktemp("inputs")
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    ball.apply_translation([0.0, 0.0, 0.05])
    ball.export(folder / "ball.stl")
    (folder / "measured_angles.csv").write_text("point,angle_deg\n1,20\n")
    (folder / "measured_outline.csv").write_text("x_mm,y_mm\n0,100\n100,100\n")
    (folder / "measured.csv").write_text(MEASURED)
    return folder


def parts(annotation: Any) -> set[Any]:
    """Plain types of an annotation."""
    if get_origin(annotation) is Annotated:
        return parts(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return set().union(*map(parts, get_args(annotation))) - {NoneType}
    return {annotation}


def other_value(name: str, field: Any, files: Path) -> Any:
    """A value of an option that is not its default."""
    default = field.get_default(call_default_factory=True)
    if name in OTHERS:
        return OTHERS[name](default)
    (kind,) = parts(field.annotation)
    if get_origin(kind) is Literal:
        return next(choice for choice in get_args(kind) if choice != default)
    if kind is bool:
        return not default
    if kind is Path:
        return files / (f"{name}.csv" if "measured" in name else "ball.stl")
    if kind is int:
        return default + 1
    if kind is float:
        return 0.9 * default
    return next(choice for choice in kind if choice != default)


def result(scene: Any, given: dict[str, Any]) -> tuple:
    """All that options decide: the set-ups, and what is shown."""
    parameters = scene.parameters(**given)
    setups = scene.setups(parameters)
    shown = []
    for setup in setups.values():
        for value in vars(scene.wanted(parameters, setup)).values() if scene.wanted else ():
            shown.append(repr(value.measured if hasattr(value, "charts") else value))
    return tuple((case, setup.content_hash) for case, setup in setups.items()), tuple(shown)


@cache
def result_without(name: str, given: tuple[tuple[str, Any], ...]) -> tuple:
    """``result`` of a scene before one more option is given: the same for most of its options."""
    return result(SCENES[name], dict(given))


# What a refusal says that does not name the option.
REFUSED_WITH = {"measured_columns": "no column neither", "tools_are_cut": "must end at the plane"}


@pytest.mark.parametrize(
    ("name", "option"),
    [(name, option) for name, option in TRIES if option not in LEFT_OUT and (name, option) not in RECORDED],
)
def test_every_option_has_an_effect_or_is_refused(name, option, files):
    scene = SCENES[name]
    value = other_value(option, scene.parameters.model_fields[option], files)
    base = COARSE[name]
    together = {
        key: other if not isinstance(other, str) else files / f"{other}.stl" if "ball" in other
        else files / other if other.endswith(".csv") else other
        for key, other in TOGETHER.get((name, option), TOGETHER.get(option, {})).items()
    }  # fmt: skip
    if together:
        with pytest.raises(InputError, match=f"{option} = .*: has no effect without"):
            scene.parameters(**base, **{option: value})
    if option == "unit_scale":
        value = 0.9
    before = result_without(name, tuple({**base, **together}.items()))
    try:
        after = result(scene, {**base, **together, option: value})
    except InputError as refused:  # such as a whole ball that is said to be cut
        assert REFUSED_WITH.get(option, option) in str(refused)
        return
    assert after != before


def test_every_scene_is_walked():
    assert set(COARSE) == set(SCENES) and len(TRIES) > 70


@pytest.mark.parametrize(
    ("scene", "given", "message"),
    [
        ("double-dome", {"unit_scale": 0.001}, "without a mesh for punch, die or blank_holder"),
        ("double-dome", {"tools_are_cut": True}, "without a mesh for punch, die or blank_holder"),
        ("double-dome", {"shear_modulus": 1e6}, "without shear_law = linear"),
        ("double-dome", {"blank_holder_force": 100.0, "blank_holder_gap": 1e-4}, "both a force and a gap"),
        ("picture-frame", {"shear_modulus": 1e6}, "without shear_law = linear"),
        ("bias-extension", {"shear_modulus": 1e6}, "without shear_law = linear"),
        ("cantilever", {"shear_modulus": 1e6}, "without shear_law = linear"),
        ("hemisphere", {"device": "cuda:0", "threads": 2}, "without device = cpu"),
    ],
)
def test_options_without_effect_are_refused(scene, given, message):
    with pytest.raises(InputError, match=message):
        SCENES[scene].setups(SCENES[scene].parameters(**given))


def test_the_needs_of_base_classes_are_kept():
    class Options(RunOptions):
        louder: bool = False
        needs = {"louder": Need("frame_count", lambda options: False)}

    with pytest.raises(InputError, match="louder = True: has no effect without frame_count; leave it out"):
        Options(louder=True)
    with pytest.raises(InputError, match="threads = 2: has no effect without device = cpu"):
        Options(threads=2, device="cuda:0")
    assert Options(louder=False, threads=2).threads == 2


@pytest.mark.parametrize(("scene", "size"), [(name, size) for name in SCENES for size in (1e-4, 3e-5)])
def test_a_mesh_without_end_is_asked_about_before_it_is_made(scene, size):
    given = {"length": 1.0} if scene == "cantilever" else {}
    # a specimen of some centimetres has few elements even then: there the size itself is asked about
    with pytest.raises(
        InputError,
        match=r"divides the blank into about .* elements, which take .* GB|at least .* m|usual are 0.0002 to",
    ):
        SCENES[scene].parameters(mesh_size=size, **given)
