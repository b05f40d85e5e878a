"""Where and why a state became non-finite."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..engine.model import Model
from ..engine.state import State
from ..kernels.pass_entries import PassEntry
from ..sheet.blank import Blank
from .frame import Frame, SheetFrame

# Of the thickness: deeper in each other, the side of a contact is no longer sure.
LARGEST_PLY_PENETRATION = 0.3
# Of the lists of creases of a sheet that touches itself.
CROWDED = "more edges of creases came near to each other than there is room for, so that contacts are missed"
CROWDED_ADVICE = "elements have folded onto each other: refine the mesh, or press less"


class Failure(NamedTuple):
    """A state that is no longer finite.

    Attributes:
        text: for the user, with element and likely cause.
        time: at which it was seen [s].
        sheet: name of the suspect; None if there is none.
        place: of the first suspect, (x, y) on the flat blank [m].
    """

    text: str
    time: float
    sheet: str | None = None
    place: tuple[float, float] | None = None


def find_failure(model: Model, state: State, last: Frame) -> Failure | None:
    """What is wrong if the state is no longer finite; None if it is finite.

    Args:
        model, state: of the run.
        last: the last good frame.
    """
    finite_step = math.isfinite(state.step) and state.step > 0.0
    suspects = []
    for sheet, own, frame in zip(model.sheets, state.sheets, last.sheets, strict=True):
        good = np.isfinite(sheet.read_motion(own.motion)[:, : sheet.blank.node_count]).all(axis=(0, 2))
        if not good.all() or (not finite_step and len(model.sheets) == 1):
            suspects.append((sheet.name, *_suspect(sheet.blank, frame, ~good, sheet.name, len(model.sheets))))
    if not suspects and finite_step:
        return _late_contact(model, state) or _pressed_through(model, state)
    nobody = None, "its stable step is not positive; no sheet has lost a node yet", None
    sheet_name, where, place = suspects[0] if suspects else nobody
    text = (
        f"the state became non-finite after {state.step_count} steps, {state.time:.4g} s; the last "
        f"good frame is {last.index} at {last.time:.4g} s. {where}"
    )
    return Failure(text, state.time, sheet_name, place)


def _late_contact(model: Model, state: State) -> Failure | None:
    for creases, kept in zip(model.creases, state.creases, strict=True):
        if kept.is_crowded():
            text = f"{creases.own_pass.name}: before {state.time:.4g} s {CROWDED}; {CROWDED_ADVICE}"
            return Failure(text, state.time, creases.sheet.name, None)
    for each, own in zip(model.passes, state.passes, strict=True):
        if own.entry.numpy()[PassEntry.late] > 0.0:
            text = (
                f"{each.name}: before {state.time:.4g} s a node went past the facets on which it "
                "was looked for, so that a contact may have been missed: elements have turned over, or sheets slide "
                "faster than the search allows; refine the mesh, or move the tools more slowly"
            )
            return Failure(text, state.time, each.slave.name, None)
    return None


def _suspect(
    blank: Blank, last: SheetFrame, bad_node: np.ndarray, sheet: str, sheet_count: int
) -> tuple[str, tuple[float, float]]:
    """The first suspect in words, and its place."""
    bad_element = bad_node[blank.quads].any(axis=1)
    strain = np.maximum(np.abs(last.fields["warp_stretch"] - 1.0), np.abs(last.fields["weft_stretch"] - 1.0))
    suspect = int(np.argmax(np.where(bad_element, strain, -1.0))) if bad_element.any() else int(np.argmax(strain))
    x, y = blank.element_centres()[suspect, :2]
    angle = math.degrees(last.fields["shear_angle"][suspect])
    if abs(angle) > 80.0:
        cause = "its shear angle is beyond any locking: give the shear law a locking branch, or a smaller stroke"
    elif strain[suspect] > 0.2:
        cause = "its yarns are stretched or compressed far beyond the fabric: a tool moves too far or too fast"
    else:
        cause = "it failed within one frame: a tool that moves too fast, or two tools that meet through the sheet"
    of_sheet = f" of sheet {sheet}" if sheet_count > 1 else ""
    text = (
        f"Element {suspect}{of_sheet}, at ({x:.4g}, {y:.4g}) m on the flat "
        f"blank, is the first suspect: shear angle {angle:.1f} degrees, stretches "
        f"{last.fields['warp_stretch'][suspect]:.3f} and {last.fields['weft_stretch'][suspect]:.3f}; {cause}"
    )
    return text, (float(x), float(y))


def _pressed_through(model: Model, state: State) -> Failure | None:
    """A sheet that is so deep in itself that it might leave on the wrong side."""
    for each, own in zip(model.passes, state.passes, strict=True):
        depth, limit = float(own.entry.numpy()[PassEntry.deepest]), LARGEST_PLY_PENETRATION * each.thickness
        if each.is_own and depth > limit:
            rows = own.read_rows(each)
            node = int((rows["depth"] - rows["entry"]).argmax())
            for creases, kept in zip(model.creases, state.creases, strict=True):
                if creases.own_pass is each:
                    node = kept.deepest_node(creases, above=float((rows["depth"] - rows["entry"]).max()), other=node)
            x, y = each.slave.blank.material_coordinates[node]
            whole = 2.0 if each.place.plane else 1.0  # to its mirror image, whose plane is half-way
            text = (
                f"sheet {each.slave.name} is pressed {1e3 * whole * depth:.3g} mm into itself after "
                f"{state.step_count} steps, {state.time:.4g} s, near ({x:.4g}, {y:.4g}) m on the flat blank; "
                f"{1e3 * whole * limit:.3g} mm, {LARGEST_PLY_PENETRATION:.0%} of the thickness, are allowed, beyond "
                "which it might leave on the wrong side: that takes a pressure of about "
                f"{depth * each.area_stiffness:.3g} Pa; raise stiffness_share of its self_contact, up to 0.2, press "
                "less, or move the tools more slowly"
            )
            return Failure(text, state.time, each.slave.name, (float(x), float(y)))
    return None
