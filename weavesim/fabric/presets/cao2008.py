"""Measured shear of a glass/polypropylene plain weave, as published by Cao et al. 2008 (``data/README.md``)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...errors import InputError, did_you_mean
from ...tables import Wanted, read_table

FOLDER = Path(__file__).parents[1] / "data" / "cao2008"
CITATION = "Cao et al. 2008, Composites A 39:1037-1053, doi 10.1016/j.compositesa.2008.02.016"
# Laboratories whose picture frames are kept, by the name in the file.
FRAME_LABORATORIES = ("hkust", "kul_1st", "lmsp", "uml", "ut")


def frame_curve(laboratory: str) -> tuple[np.ndarray, np.ndarray]:
    """Angle [rad] and normalised force [N/m] of a laboratory's picture frame, (n,) each, as measured.

    The normalisation is the paper's equation 10: ``convention="fabric area"``, m = N cos(angle).

    Raises:
        InputError: a laboratory that is none of ``FRAME_LABORATORIES``.
    """
    if laboratory not in FRAME_LABORATORIES:
        known = ", ".join(FRAME_LABORATORIES)
        hint = did_you_mean(laboratory, FRAME_LABORATORIES)
        raise InputError(f"laboratory = {laboratory!r}: one of {known} is needed{hint}")
    table = read_table(FOLDER / f"frame_{laboratory}.csv", "table")
    angle, force = table.columns(Wanted("angle", "rad"), Wanted("normalised force", "N/m")).values
    return angle, force


def consensus_moment() -> tuple[np.ndarray, np.ndarray]:
    """Angle [rad] and moment per reference area [N/m] as all laboratories see them together, (n,) each, from 1 degree.

    The mean of two means, of the picture frames and of the bias extensions: each method has its own bias, and there are
    more series of one than of the other. The normalised forces of both are moments over cos(angle).
    """
    table = read_table(FOLDER / "consensus.csv", "table")
    angle, frames, bias = table.columns(
        Wanted("angle", "rad"), Wanted("frame mean", "N/m"), Wanted("bias mean", "N/m")
    ).values
    return angle, 0.5 * (frames + bias) * np.cos(angle)
