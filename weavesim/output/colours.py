"""The colour map of film, pictures and report."""

from __future__ import annotations

from functools import cache

import numpy as np

# Shear angles are always shown on this range, so that pictures of different runs can be compared [degrees].
LARGEST_SHOWN_ANGLE = 60.0

# Of lines and sheets that are told apart by colour, encoded sRGB: also by those who are blind for red, green or blue.
DISTINCT_COLOURS = (
    "#5b3fb5", "#e07a1f", "#8da7f7", "#901308", "#38185f", "#9d6785", "#7e74e1", "#e6a3a7", "#5b0019",
)  # fmt: skip

# Inverse of the OKLab colour space (B. Ottosson, 2020): to cone responses, and from their cubes to linear sRGB.
_OKLAB_TO_CONES = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_CONES_TO_LINEAR = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


@cache
def colour_table() -> np.ndarray:
    """256 colours from dark blue to yellow in linear sRGB, (256, 3).

    Lightness increases linearly in OKLab while the hue passes through red, so equal steps look equal and the map also
    works in greyscale.
    """
    s = np.linspace(0.0, 1.0, 256)
    lightness = 0.30 + 0.62 * s
    hue = np.deg2rad(270.0 + 192.0 * s)
    chroma = 0.10 + 0.10 * np.sin(np.pi * s**0.8)
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1)
    return np.clip((lab @ _OKLAB_TO_CONES.T) ** 3 @ _CONES_TO_LINEAR.T, 0.0, 1.0)


def encoded(linear: np.ndarray) -> np.ndarray:
    """Convert linear sRGB to the encoded values that screens and matplotlib use."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)


def shear_colours(angle: np.ndarray) -> np.ndarray:
    """Linear sRGB of shear angles [degrees], (k, 3), regardless of sign."""
    place = np.clip(np.abs(angle) / LARGEST_SHOWN_ANGLE, 0.0, 1.0) * 255.0
    return colour_table()[np.rint(place).astype(int)]


def distinct_colour(place: int) -> tuple[float, float, float]:
    """Linear sRGB of the colour number ``place`` of ``DISTINCT_COLOURS``, which repeat."""
    code = DISTINCT_COLOURS[place % len(DISTINCT_COLOURS)]
    value = np.array([int(code[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    red, green, blue = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).tolist()
    return red, green, blue
