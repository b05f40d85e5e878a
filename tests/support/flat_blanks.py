"""Flat rectangles of which all, a half or a quarter is modelled."""

from weavesim.sheet.blank import Blank

HALF_LENGTH, HALF_WIDTH = 0.24, 0.14
QUARTER, FULL = ("x", "y"), ()


def blank_of(symmetry, element_size=0.02, **settings):
    lower = (0.0 if "x" in symmetry else -HALF_LENGTH, 0.0 if "y" in symmetry else -HALF_WIDTH)
    return Blank.rectangle(lower, (HALF_LENGTH, HALF_WIDTH), element_size, **settings)
