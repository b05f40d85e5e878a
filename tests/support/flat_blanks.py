"""Flat rectangles of which all, a half or a quarter is modelled."""

from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import WHOLE, Symmetry

HALF_LENGTH, HALF_WIDTH = 0.24, 0.14
QUARTER, FULL = Symmetry(("x", "y")), WHOLE
HALF_IN_X, HALF_IN_Y = Symmetry(("x",)), Symmetry(("y",))


def blank_of(symmetry, element_size=0.02, **settings):
    lower = (0.0 if "x" in symmetry.planes else -HALF_LENGTH, 0.0 if "y" in symmetry.planes else -HALF_WIDTH)
    return Blank.rectangle(lower, (HALF_LENGTH, HALF_WIDTH), element_size, **settings)
