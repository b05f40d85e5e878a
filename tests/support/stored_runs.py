"""Ends of runs that never were: sheets formed by a formula, as the file of a run would have them."""

from pathlib import Path

import numpy as np

from weavesim.measures.angles import yarn_angles, yarn_vectors
from weavesim.output.stored.file import StoredRun, StoredSheet
from weavesim.output.stored.values import DIRECTIONS, ElementValue
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import WHOLE, Symmetry

THICKNESS = 1.0e-3
# As a run has them; of other values the unit is of no account here.
UNITS = {"thickness": "m", "shear_angle_deg": "degrees", "stress_upper": "N/m^2"}


def stored_sheet(
    blank: Blank, position: np.ndarray, *, name: str = "sheet", symmetry: Symmetry = WHOLE, **values: np.ndarray
) -> StoredSheet:
    """A sheet with its nodes at ``position``, ``THICKNESS`` thick, with further ``values`` of its elements."""
    warp, weft = yarn_vectors(blank, position)
    angles = (np.rad2deg(angle) for angle in yarn_angles(blank, position))
    arrays = {
        **dict(zip(DIRECTIONS, (warp, weft, *angles), strict=True)),
        "thickness": np.full(blank.element_count, THICKNESS),
        "shear_angle_deg": np.rad2deg(np.arcsin(np.einsum("ei,ei->e", warp, weft))),
        **values,
    }
    return StoredSheet(
        name=name, blank=blank, position=position, director=np.tile([0.0, 0.0, 1.0], (blank.node_count, 1)),
        values={key: ElementValue(UNITS.get(key, ""), "", value) for key, value in arrays.items()}, thickness=THICKNESS,
        symmetry=symmetry, tools=(), fabric="test",
    )  # fmt: skip


def stored_run(*sheets: StoredSheet) -> StoredRun:
    """A run that has finished with these."""
    return StoredRun(Path("nowhere"), "20260101T000000Z-00000000", "test", 1.0, "finished", sheets, np.zeros(0))
