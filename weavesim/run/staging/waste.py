"""Sheets that a stage trims: what stays, what is lost, and the state without it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...engine.model import Model
from ...engine.staging.acting import Acting
from ...engine.staging.trimming import cut, refuse_gripped, trims_of
from ...engine.state import SheetState, State
from ...kernels.rows import VELOCITY_REMAINDER, MotionRow
from ...sheet.topology import flat_areas
from .change import positions_of


class SheetCut(NamedTuple):
    """What the trims of a stage leave of a sheet.

    Attributes:
        sheet: its place in the run.
        before: elements that were there, (element_count,) bool.
        kept: elements that stay.
        off: furthest that a node of the new border lies from the curves [m].
    """

    sheet: int
    before: np.ndarray
    kept: np.ndarray
    off: float


def cut_sheets(now: Acting, model: Model, state: State, kept: Sequence[np.ndarray | None]) -> list[SheetCut]:
    """Cut the sheets as a stage wants, one for each of its trims; the state is read.

    Args:
        now: the stage.
        model, state: of the run, with the sheets as they were.
        kept: elements of every sheet that are there, or None for all.

    Raises:
        ValueError: a trim that leaves nothing or several pieces, or cuts away what a gripper holds.
    """
    sheets, found = model.setup.sheets, []
    there = [np.ones(len(s.kept), dtype=bool) if k is None else k for s, k in zip(model.sheets, kept, strict=True)]
    for trim, place in trims_of(now.stage, sheets):
        blank = model.sheets[place].blank
        plan = positions_of(model, state, place)[:, :2] if trim.view == "formed" else blank.material_coordinates
        result = cut(trim, blank, plan, there[place])
        refuse_gripped(sheets[place], result.kept, now.grippers)
        found.append(SheetCut(place, there[place], result.kept, result.off))
        there[place] = result.kept
    return found


def waste_of(each: SheetCut, whole: Model, state: State) -> dict[str, Any]:
    """What a trim takes away, for the summary.

    Args:
        each: the cut.
        whole, state: of the run before it.
    """
    old, own = whole.sheets[each.sheet], state.sheets[each.sheet]
    gone = each.before & ~each.kept
    quads, area = old.blank.quads[gone], old.geometry.area[gone]
    mass = np.zeros(old.blank.node_count)
    np.add.at(mass, quads.ravel(), np.repeat(0.25 * old.areal_density[gone] * area, 4))
    velocity = old.read_motion(own.motion)[MotionRow.velocity.vector, : old.blank.node_count].astype(np.float64)
    return {
        "sheet": old.name,
        "element_count": int(gone.sum()),
        "area_mm2": 1e6 * float(flat_areas(old.blank)[gone].sum()),
        "mass_kg": float(mass.sum()),
        "momentum_n_s": (mass @ velocity).tolist(),
        "off_curve_mm": 1e3 * each.off,
    }


def clear_waste(state: State, model: Model) -> None:
    """Make waste stand still, without force and memory; ``model`` is that of what stays."""
    for sheet, own in zip(model.sheets, state.sheets, strict=True):
        if sheet.kept.all():
            continue
        count = sheet.blank.node_count
        motion = sheet.read_motion(own.motion)
        for vector in (MotionRow.velocity.vector, VELOCITY_REMAINDER, MotionRow.spin.vector):
            motion[vector, :count][sheet.waste] = 0.0
        sheet.write_motion(own.motion, motion)
        _clear_elements(own, ~sheet.kept, sheet.initial_unknowns())
        springs = sheet.friction_layout.read(own.friction)
        springs[:, :count][:, sheet.waste] = 0.0
        own.friction.assign(sheet.friction_layout.flat(springs))
        if own.holding.size:
            holding = own.holding.numpy()
            holding[:count][sheet.waste] = 0.0
            own.holding.assign(holding)


def _clear_elements(own: SheetState, gone: np.ndarray, unknowns: np.ndarray) -> None:
    """Elements at rest, as padding is."""
    count = len(gone)
    values = own.cell_unknowns.numpy()
    values[:, :count][:, gone] = unknowns[:, :count][:, gone]
    own.cell_unknowns.assign(values)
    for array in (own.cell_report, own.slip):
        values = array.numpy()
        if values.shape[1] >= count:
            values[:, :count][:, gone] = 0.0
            array.assign(values)
