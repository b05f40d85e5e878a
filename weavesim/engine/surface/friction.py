"""Friction laws of tools on a sheet: areas of what meets the tools, and the extremes of the laws' arguments."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.contact.friction import UNMET
from ..layout import BLOCK, lanes_view
from ..sheet_model import SheetModel


def argument_rows(sheet: SheetModel, count: int) -> np.ndarray:
    """Extremes of the arguments at the start, (2 tools, count): the smallest and the largest of each tool.

    Args:
        sheet: that meets tools.
        count: of its nodes or samples.
    """
    if not sheet.node_traits.friction_laws:
        return np.zeros((2, BLOCK if count else 0))
    return np.tile([[float(UNMET)], [-float(UNMET)]], (max(sheet.tool_count, 1), count))


def set_friction(touch: Any, sheet: SheetModel, argument: wp.array, *, samples: bool) -> None:
    """Give the friction laws of its tools to the contact of a sheet: the arrays of its state, and areas.

    On a blunt tool nodes and samples share the load as they share the stiffness, and so they share the area; with an
    allowance nodes have all of it, as samples push at a few places only.
    """
    touch.argument = lanes_view(argument, sheet.lane_count)
    area = contact_areas(sheet, samples=samples) if sheet.node_traits.friction_laws else np.zeros(0)
    lanes = np.ascontiguousarray(area.reshape(-1, sheet.lane_count))
    touch.area = (
        wp.array(lanes, dtype=sheet.types.lanes, device=sheet.device)
        if area.size
        else wp.empty(0, dtype=sheet.types.lanes, device=sheet.device)
    )


def contact_areas(sheet: SheetModel, *, samples: bool) -> np.ndarray:
    """Area that each node, or each sample, stands for in contact, with padding [m^2]."""
    return _sample_areas(sheet) if samples else _node_areas(sheet)


def _whole(sheet: SheetModel) -> float:
    """Mass on the springs of nodes and samples over that of the sheet."""
    return 1.0 + len(sheet.samples.places) * float(sheet.samples.mass.sum()) / float(sheet.node_mass.sum())


def _node_areas(sheet: SheetModel) -> np.ndarray:
    """Area that each node stands for in contact, (padded nodes,) [m^2]."""
    area = np.zeros(sheet.node_count)
    np.add.at(area, sheet.blank.quads.ravel(), np.repeat(0.25 * sheet.geometry.area * sheet.kept, 4))
    return area if sheet.samples.allowance > 0.0 else area / _whole(sheet)


def _sample_areas(sheet: SheetModel) -> np.ndarray:
    """Area that each sample stands for in contact, (samples,) [m^2], those of all elements one after the other."""
    area, places = np.zeros(sheet.element_count), len(sheet.samples.places)
    area[: sheet.blank.element_count] = sheet.geometry.area[sheet.samples.order]
    return np.tile(area * (1.0 - 1.0 / _whole(sheet)) / max(places, 1), places)
