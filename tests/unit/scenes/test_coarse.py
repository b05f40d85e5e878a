"""Every scene refuses, or warns of, a mesh on which its result is wrong."""

import pytest

from weavesim.errors import InputError
from weavesim.run.guards import Level
from weavesim.run.simulation import Simulation
from weavesim.scenes.bias_extension import BiasExtensionParameters
from weavesim.scenes.cantilever import CantileverParameters, cantilever
from weavesim.scenes.diaphragm import DiaphragmParameters, diaphragm
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome
from weavesim.scenes.grippers import GrippersParameters
from weavesim.scenes.hemisphere import HemisphereParameters, hemisphere
from weavesim.scenes.laboratory.cusick_drape import CusickDrapeParameters
from weavesim.scenes.laboratory.pure_bending import PureBendingParameters
from weavesim.scenes.laboratory.uniaxial import UniaxialParameters
from weavesim.scenes.picture_frame import PictureFrameParameters
from weavesim.scenes.scene import known_scenes
from weavesim.scenes.stack import StackParameters, stack

COVERED = {
    "bias-extension", "cantilever", "cusick-drape", "diaphragm", "double-dome", "grippers", "hemisphere",
    "picture-frame", "pure-bending", "stack", "uniaxial",
}  # fmt: skip
# A uniform state is exact on any mesh.
UNIFORM = {"biaxial", "compaction", "sled"}


def test_every_scene_is_covered():
    assert set(known_scenes()) == COVERED | UNIFORM


@pytest.mark.parametrize(("make", "message"), [
    (lambda: UniaxialParameters(mesh_size=0.02), "at least 4 elements across the width"),
    (lambda: PureBendingParameters(mesh_size=0.002), "at least 4 elements along half the length"),
    (lambda: CusickDrapeParameters(mesh_size=0.012), "at least 6 elements across the ring"),
])  # fmt: skip
def test_a_specimen_needs_elements_where_its_state_varies(make, message):
    with pytest.raises(InputError, match=f"mesh_size = .* m: {message}.* at most"):
        make()


@pytest.mark.parametrize(("mesh_size", "length"), [(0.1, None), (0.04, None), (0.02, 0.06), (0.002, 0.008)])
def test_a_cantilever_needs_elements_along_its_overhang(mesh_size, length):
    with pytest.raises(InputError, match=r"mesh_size = .* m: at least 5 elements along the overhang of .* at most"):
        cantilever(CantileverParameters(mesh_size=mesh_size, length=length, width=0.02))


def test_five_elements_are_allowed():
    cantilever(CantileverParameters(mesh_size=0.0293))
    cantilever(CantileverParameters(mesh_size=0.01, length=0.05))


@pytest.mark.parametrize("given", [{"mesh_size": 0.1}, {"mesh_size": 0.02, "radius": 0.05}, {"side": 0.06}])
def test_a_cloth_needs_elements_on_its_ball(given):
    with pytest.raises(InputError, match="at least 8 elements over a quarter of the ball"):
        HemisphereParameters(**given)


@pytest.mark.parametrize("given", [{"mesh_size": 0.02}, {"gripper_count": 20}, {"radius": 0.01}])
def test_grippers_and_their_punch_need_elements(given):
    with pytest.raises(InputError, match="at least 5 elements over a quarter of the punch, and 2 along each gripper"):
        GrippersParameters(**given)


@pytest.mark.parametrize(("given", "text"), [
    ({"mesh_size": 0.02}, "at least 4 elements over a quarter of the dome"),
    ({"rise": 0.06}, "at most the radius of the dome"),
    ({"ply_side": 0.31}, "the frame needs two elements beside the plies"),
    ({"radius": 0.09, "rise": 0.04}, "at least four radii of the dome"),
    ({"forming_pressure": 4.0e4}, "the pressure below can fall by at most the vacuum"),
    ({"lay_up": "0/45", "part": "quarter"}, "a ply at 45 degrees is not symmetric"),
])  # fmt: skip
def test_a_diaphragm_needs_room_elements_and_symmetry(given, text):
    with pytest.raises(InputError, match=text):
        diaphragm(DiaphragmParameters(**given))


def test_a_frame_with_misaligned_yarns_needs_elements_along_its_side():
    with pytest.raises(InputError, match="with misaligned yarns at least 4 elements along the side"):
        PictureFrameParameters(mesh_size=0.1, misalignment=2.0)
    PictureFrameParameters(mesh_size=0.1)  # aligned yarns shear evenly: exact


def test_a_bias_strip_needs_elements_across_its_width():
    with pytest.raises(InputError, match="at least 8 elements across the width"):
        BiasExtensionParameters(mesh_size=0.02)


@pytest.mark.parametrize("mesh_size", [0.01, 0.03])
def test_a_double_dome_needs_elements_along_the_edge_of_its_die(mesh_size):
    simulation = Simulation(double_dome(DoubleDomeParameters(mesh_size=mesh_size)))
    (warning,) = [text for text in simulation.warnings if text.startswith("die, blank_holder: ")]
    assert "of their 10 mm radius" in warning


def test_a_stack_needs_elements_along_the_edge_of_its_die():
    simulation = Simulation(stack(StackParameters(lay_up="0/90", tools="double-dome", mesh_size=0.02)))
    (warning,) = [text for text in simulation.warnings if text.startswith("die, blank_holder: ")]
    assert "of their 10 mm radius" in warning


@pytest.mark.parametrize(("case", "mesh_size", "told"), [
    ("low-bending", 0.005, False), ("low-bending", 0.01, True), ("high-bending", 0.01, False),
    ("high-bending", 0.018, True),
])  # fmt: skip
def test_a_cloth_needs_elements_along_its_bending_length(case, mesh_size, told):
    """15 mm with low bending stiffness, 32 mm with high."""
    simulation = Simulation(hemisphere(HemisphereParameters(mesh_size=mesh_size), case))
    found = [doubt for doubt in simulation.doubts() if doubt.guard == "bending_length"]
    assert [doubt.level for doubt in found] == [Level.WARNING] * told
    if told:
        assert f"bends over {15 if case == 'low-bending' else 32.4:.3g} mm" in found[0].text


def test_the_defaults_are_not_warned_of():
    for setup in (
        double_dome(DoubleDomeParameters()),
        hemisphere(HemisphereParameters(), "low-bending"),
        hemisphere(HemisphereParameters(), "high-bending"),
        cantilever(CantileverParameters()),
    ):
        assert Simulation(setup).warnings == [], setup.name
