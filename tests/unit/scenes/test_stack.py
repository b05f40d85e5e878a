"""The set-ups of the scene ``stack``: plies on each other, interfaces, tools with room for them; what is refused."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.scenes.stack import DEFAULTS, StackParameters, stack, wanted

COARSE = {"mesh_size": 0.02}
THICKNESS = glass_polypropylene().thickness


def made(**given):
    return stack(StackParameters(**(COARSE | given)))


def heights(setup) -> list[float]:
    return [float(sheet.blank.node_position[:, 2].mean()) for sheet in setup.sheets]


def test_the_default_is_the_public_deck():
    setup = made()
    assert [sheet.name for sheet in setup.sheets] == ["ply_1", "ply_2"]
    for sheet, angle in zip(setup.sheets, (0.0, 45.0), strict=True):
        assert np.degrees(np.arctan2(*sheet.blank.warp_direction[0, 1::-1])) == pytest.approx(angle)
        assert np.ptp(sheet.blank.material_coordinates, axis=0) == pytest.approx([0.3, 0.3])
    punch, die = setup.tools
    assert (punch.shape.radius, die.shape.radius, die.shape.edge_radius) == (0.075, 0.080, 0.0075)
    assert max(punch.motion.curve()[1]) == pytest.approx(0.05)
    assert {tool.friction for tool in setup.tools} == {0.0}
    (interface,) = setup.worlds[0].interfaces
    assert (interface.lower, interface.upper, interface.friction.coefficient) == ("ply_1", "ply_2", 0.0)


@pytest.mark.parametrize("tools", DEFAULTS)
def test_plies_rest_on_each_other_between_the_tools(tools):
    setup = made(tools=tools, lay_up="[0/90]s", ply_thickness=0.5e-3)
    assert heights(setup) == pytest.approx([-0.75e-3, -0.25e-3, 0.25e-3, 0.75e-3])
    assert {sheet.fabric.thickness for sheet in setup.sheets} == {0.5e-3}
    assert [(each.lower, each.upper) for each in setup.worlds[0].interfaces] == [
        ("ply_1", "ply_2"), ("ply_2", "ply_3"), ("ply_3", "ply_4"),
    ]  # fmt: skip
    punch, die, *_ = setup.tools
    assert punch.shape.origin[2] - punch.shape.radius == pytest.approx(1.0e-3)
    assert die.shape.origin[2] == pytest.approx(-1.0e-3)


def test_the_dome_leaves_room_for_the_stack_and_has_friction():
    setup = made(tools="double-dome", lay_up="0/90")
    punch, die, holder = setup.tools
    assert die.shape.radius - punch.shape.radius == pytest.approx(2.0 * THICKNESS)
    assert {tool.friction for tool in setup.tools} == {0.2} == {setup.worlds[0].interfaces[0].friction.coefficient}
    assert made(tools="double-dome", ply_friction=0.0).worlds[0].interfaces[0].friction.coefficient == 0.0


def test_a_quarter_is_computed_where_all_plies_are_symmetric():
    assert made(lay_up="0/90").worlds[0].symmetry.planes == ("x", "y")
    assert made(lay_up="0/30").worlds[0].symmetry.planes == ()
    assert made(lay_up="0/90", part="half").worlds[0].symmetry.planes == ("y",)
    quarter = made(lay_up="0/90").sheets[0].blank
    assert quarter.material_coordinates.min() == 0.0 and quarter.material_coordinates.max() == 0.15


def test_plies_meet_themselves_if_asked():
    setup = made(lay_up="0/90", self_contact=True, ply_friction=0.3)
    assert {sheet.self_contact.friction.coefficient for sheet in setup.sheets} == {0.3}
    assert made(lay_up="0/90").sheets[0].self_contact is None


def test_plies_meet_tools_between_their_nodes_if_asked():
    dynamics = made(lay_up="0/90", contact_samples="surface").worlds[0].dynamics
    assert (dynamics.contact_samples, dynamics.contact_allowance) == ("surface", 0.04)
    assert made(lay_up="0/90").worlds[0].dynamics.contact_allowance == 0.0


def test_one_ply_has_no_interface():
    assert made(lay_up="45").worlds[0].interfaces == ()


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"lay_up": "0/90s"}, "'s' is not expected there"),
        ({"lay_up": "[0/90]3"}, "punch and die leave 5 mm"),
        ({"part": "quarter"}, "a ply at 45 degrees is not symmetric"),
        ({"lay_up": "0.785398"}, "45 degrees in radians"),
        ({"blank_holder_force": 100.0}, "has no effect without"),
        ({"contact_allowance": 0.1}, "has no effect without"),
        ({"tools": "double-dome", "lay_up": "[0/90]30"}, "wider than the blank"),
        ({"ply_thickness": 1.0}, "at most 0.05 m"),
    ],
)
def test_what_makes_no_stack_is_refused(given, problem):
    with pytest.raises(InputError, match=problem):
        made(**given)


@pytest.mark.parametrize("tools", DEFAULTS)
def test_points_lie_on_the_computed_part(tools):
    parameters = StackParameters(tools=tools, lay_up="0/90", **COARSE)
    setup = stack(parameters)
    points = wanted(parameters, setup)
    points.check(tuple_of_infos(setup))
    assert len(points.points) >= 10


def tuple_of_infos(setup):
    from weavesim.run.start import sheet_infos

    return tuple(sheet_infos(setup))
