"""What a user can get wrong in a unit cell, and in asking one for its response."""

import numpy as np
import pytest

from tests.support.registered_cells import KnottedNet
from weavesim.errors import InputError
from weavesim.fabric.cell import UnitCell
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.presets import UNIT_CELLS
from weavesim.fabric.response import respond


def test_cells_of_several_classes_are_refused():
    with pytest.raises(InputError, match="several classes"):
        respond([UNIT_CELLS["twill"](), UNIT_CELLS["plain-weave"]()], np.ones((2, 2)))


@pytest.mark.parametrize("angle", [2.0, np.nan, [0.1, 0.2]])
def test_bad_angles_are_refused(angle):
    with pytest.raises(InputError, match="shear_angle"):
        respond(UNIT_CELLS["plain-weave"](), [1.0, 1.0], angle)


def changed_net(**members) -> UnitCell:
    """The user's net with something wrong in it."""
    return type("ChangedNet", (KnottedNet,), members)()


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"energy": None}, "ChangedNet: no energy is given"),
        ({"energy": staticmethod(lambda p, a, b, c, q: 0.0)}, "energy = .* not a Warp function"),
        ({"unknown_count": 5}, "unknown_count = 5: 0 to 4"),
        ({"part_names": ("threads", "knots")}, "2 part_names but no parts"),
        ({"initial_unknowns": property(lambda cell: (0.0,))}, "1 initial_unknowns, but unknown_count is 2"),
    ],
)
def test_mistakes_in_a_cell_are_named(members, message):
    with pytest.raises(InputError, match=message):
        respond(changed_net(**members), [1.0, 1.0])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearMembrane(warp_stiffness=1.0, weft_stiffness=1.0, coupling_stiffness=1.1), "coupling_stiffness"),
        (lambda: UNIT_CELLS["twill"]().model_copy(update={"repeat": 5}), "repeat = 5"),
        (lambda: UNIT_CELLS["satin-5"]().model_copy(update={"repeat": 6}), "repeat = 6"),
        (lambda: UNIT_CELLS["stitched-tape"]().model_copy(update={"tow_stiffness": 0.0}), "tow_stiffness = 0.0"),
        (
            lambda: UNIT_CELLS["stitched-tape"]().model_copy(
                update={"stitch_stiffness": 0.0, "transverse_stiffness": 0.0}
            ),
            "nothing holds the tows together",
        ),
    ],
)
def test_bad_parameters_are_refused_by_name(make, message):
    with pytest.raises(InputError, match=message):
        make()
