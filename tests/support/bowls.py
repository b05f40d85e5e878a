"""Sheets that bulge, of any shape."""

import numpy as np

from weavesim.measures.findings import FormedSheet
from weavesim.sheet.blank import Blank


def bowl(width: float, height: float) -> FormedSheet:
    """A rectangle of elements of 12 mm with a bowl of 30 mm in it, and shear angles from 0 to 0.8 across it."""
    blank = Blank.rectangle((-width / 2, -height / 2), (width / 2, height / 2), 0.012)
    position = blank.node_position.copy()
    x, y = (position[:, :2] / (width, height)).T
    position[:, 2] = -0.03 * np.exp(-16.0 * (x * x + y * y))
    count = blank.element_count
    fields = {"shear_angle": np.linspace(0.0, 0.8, count), "thickness": np.full(count, 1e-3)}
    fields |= {"warp_stretch": np.ones(count), "weft_stretch": np.ones(count)}
    return FormedSheet(blank, position, fields, 1e-3, points=np.array([[0.0, 0.0], [width / 4, height / 4]]))
