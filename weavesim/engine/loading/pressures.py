"""The pressures on a sheet, in the form that the kernels read."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.loads.pressure import pressure_struct
from ...sheet.blank import Blank
from ..layout import lanes_view
from ..sheet_model import SheetModel


def device_pressures(sheet: SheetModel) -> Any:
    """``kernels.loads.pressure.pressure_struct`` of a sheet that has some, with all curves on common knots."""
    pressures, blank = sheet.pressures, sheet.blank
    element_count, real, lane_count, device = sheet.element_count, sheet.real, sheet.lane_count, sheet.device
    times = np.unique(np.concatenate([pressure.times for pressure in pressures]))
    share = np.zeros((len(pressures), element_count))
    up = _turns(blank)
    for row, pressure in zip(share, pressures, strict=True):
        acts = pressure.acts_on(blank.element_count) & sheet.kept
        row[: blank.element_count] = np.where(acts, up if pressure.face == "bottom" else -up, 0.0)
    result = pressure_struct(real, lane_count)()
    result.share = lanes_view(wp.array(share, dtype=real, device=device), lane_count)
    result.time = wp.array(times, dtype=wp.float64, device=device)
    result.value = wp.array(np.stack([pressure.at(times) for pressure in pressures]), dtype=wp.float64, device=device)
    return result


def _turns(blank: Blank) -> np.ndarray:
    """1 for elements whose corners turn counter-clockwise as seen from the top, -1 for the others, (element_count,)."""
    corners = blank.node_position[blank.quads]
    area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return np.sign((area * blank.initial_director[blank.quads].mean(axis=1)).sum(axis=1))
