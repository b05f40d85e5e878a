"""The colours of film, pictures and page."""

from __future__ import annotations

from functools import cache

import numpy as np

# Shear angles are always shown on this range, so that pictures of different runs can be compared [degrees].
LARGEST_SHOWN_ANGLE = 60.0

# Of lines and sheets that are told apart by colour, encoded sRGB: also by those who are blind for red, green or blue.
DISTINCT_COLOURS = (
    "#5b3fb5", "#e07a1f", "#8da7f7", "#901308", "#38185f", "#9d6785", "#7e74e1", "#e6a3a7", "#5b0019",
)  # fmt: skip

# Of Matplotlib, by S. van der Walt and N. Smith (2015): also the first that the page offers.
COLOUR_MAP = "viridis"


@cache
def colour_table() -> np.ndarray:
    """256 colours from dark violet over green to yellow in linear sRGB, (256, 3).

    Equal steps look equal to those who see all colours and to those who do not, and lightness rises steadily, so that
    the map also works in greyscale.
    """
    from matplotlib import colormaps

    return decoded(np.asarray(colormaps[COLOUR_MAP](np.linspace(0.0, 1.0, 256)))[:, :3])


def encoded(linear: np.ndarray) -> np.ndarray:
    """Convert linear sRGB to the encoded values that screens and matplotlib use."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)


def decoded(values: np.ndarray) -> np.ndarray:
    """The inverse: encoded values as linear sRGB."""
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0.04045) + 0.055) / 1.055) ** 2.4)


def shear_colours(angle: np.ndarray) -> np.ndarray:
    """Linear sRGB of shear angles [degrees], (k, 3), regardless of sign."""
    place = np.clip(np.abs(angle) / LARGEST_SHOWN_ANGLE, 0.0, 1.0) * 255.0
    return colour_table()[np.rint(place).astype(int)]


def distinct_colour(place: int) -> tuple[float, float, float]:
    """Linear sRGB of the colour number ``place`` of ``DISTINCT_COLOURS``, which repeat."""
    code = DISTINCT_COLOURS[place % len(DISTINCT_COLOURS)]
    red, green, blue = decoded(np.array([int(code[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])).tolist()
    return red, green, blue
