"""Quantities measured on a formed sheet."""

from .angles import (
    locate,
    shear_angle_at,
    smoothed,
    smoothed_shear_angle,
    smoothing_weights,
    ten_points,
    yarn_angles,
    yarn_components,
    yarn_vectors,
)
from .border import (
    MaterialLine,
    Outline,
    border_draw_in,
    draw_in,
    integrated_yarn_stretch,
    outline,
    symmetry_line,
    taut_path_draw_in,
    whole_outline,
)
from .folds import RimFolds, rim_folds
from .proximity import close_pairs
from .stresses import STRESS_FIELDS, stress_fields
from .zigzag import Checkerboard, checkerboard

__all__ = [
    "STRESS_FIELDS",
    "Checkerboard",
    "MaterialLine",
    "Outline",
    "RimFolds",
    "border_draw_in",
    "checkerboard",
    "close_pairs",
    "draw_in",
    "integrated_yarn_stretch",
    "locate",
    "outline",
    "rim_folds",
    "shear_angle_at",
    "smoothed",
    "smoothed_shear_angle",
    "smoothing_weights",
    "stress_fields",
    "symmetry_line",
    "taut_path_draw_in",
    "ten_points",
    "whole_outline",
    "yarn_angles",
    "yarn_components",
    "yarn_vectors",
]
