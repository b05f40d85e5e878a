"""Energies, forces and slips of the interfaces between plies, computed from the state without changing it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..engine.model import Model
from ..engine.plies.pass_model import PassModel
from ..engine.plies.pass_state import PassState
from ..engine.sheet_model import TANGENTIAL_RATIO
from ..engine.state import State

# What an interface stores, loses and is supplied with, as the entries of the ledger name it.
ENTRIES = ("ply_contact", "ply_friction_spring", "ply_friction_loss", "ply_damping_loss", "ply_thickness_work")


class InterfaceLedger:
    """Takes the entries of all interfaces of a run.

    Args:
        model: of the run.
        state: of the run, which is read.

    Attributes:
        passes: of all interfaces.
    """

    def __init__(self, model: Model, state: State) -> None:
        self.passes, self._contacts, self._state = model.passes, model.contacts, state
        self._contact_names, self._creases = model.contact_names, model.creases

    def rows(self, index: int) -> dict[str, np.ndarray]:
        """Rows of one pass, of the current state; see ``PassState.read_rows``."""
        return self._state.passes[index].read_rows(self.passes[index])

    def entries(self, state: State, ahead: State) -> dict[str, float]:
        """Entries of the ledger, summed over the interfaces [J], given the state after the next step."""
        totals = dict.fromkeys(ENTRIES, 0.0)
        for of_interface in self.by_interface(state, ahead):
            for name, value in of_interface.items():
                totals[name] += value
        return totals

    def fields(self, sheet: int, ahead: State) -> dict[str, np.ndarray]:
        """Pressures [Pa] and slips [m] on the faces of a sheet that touch others, of its elements, (element_count,).

        The pressure is that of the springs, which dashpots leave out.
        """
        result: dict[str, np.ndarray] = {}
        for model, own in zip(self.passes, ahead.passes, strict=True):
            if model.place.slave == sheet:
                # the side on which a node's own normal does not point to the other face
                below = model.place.side * (model.place.facing or 1) > 0
                face, rows = "below" if below else "above", own.read_rows(model)
                quads = model.slave.blank.quads
                pressure = model.area_stiffness * rows["push"] / model.stiffness
                for name, values in (("pressure", pressure), ("slip", rows["slip"])):
                    key = f"ply_{name}_{face}"
                    result[key] = result.get(key, 0.0) + values[quads].mean(axis=1)
        return result

    def report(self, state: State, ahead: State) -> list[dict[str, Any]]:
        """Numbers of every interface for the summary, by names with units."""
        result: list[dict[str, Any]] = [
            {"name": each, "force_n": 0.0, "max_pressure_pa": 0.0, "max_slip_mm": 0.0, "max_entry_mm": 0.0}
            for each in self._contact_names
        ]
        for entry, energies in zip(result, self.by_interface(state, ahead), strict=True):
            entry |= {f"{name}_j": value for name, value in energies.items()}
        for model, own in zip(self.passes, ahead.passes, strict=True):
            entry, rows = result[model.place.interface], own.read_rows(model)
            entry["force_n"] += float(rows["push"].sum())
            pressure = model.area_stiffness * float((rows["push"] / model.stiffness).max())
            entry["max_pressure_pa"] = max(entry["max_pressure_pa"], pressure)
            for key, row in (("max_slip_mm", "slip"), ("max_entry_mm", "largest_entry")):
                entry[key] = max(entry[key], 1e3 * float(rows[row].max()))
        for (place, entries), creases in zip(self._of_creases(ahead, True), ahead.creases, strict=True):
            deepest = float(creases.largest_entry.numpy().max(initial=0.0))
            result[place]["force_n"] += entries["force"]
            result[place]["max_entry_mm"] = max(result[place]["max_entry_mm"], 1e3 * deepest)
        return result

    def by_interface(self, state: State, ahead: State) -> list[dict[str, float]]:
        """The same of every interface, then of every sheet that touches itself."""
        result = [dict.fromkeys(ENTRIES, 0.0) for _ in self._contacts]
        started = state.step_count > 0
        for model, own in zip(self.passes, ahead.passes, strict=True):
            for name, value in _entries(model, own, started).items():
                result[model.place.interface][name] += value
        for place, entries in self._of_creases(ahead, started):
            for name in ENTRIES:
                result[place][name] += entries[name]
        return result

    def _of_creases(self, ahead: State, started: bool) -> Iterator[tuple[int, dict[str, float]]]:
        """The contact to which the creases of each sheet belong, and their entries."""
        for model, own in zip(self._creases, ahead.creases, strict=True):
            yield model.own_pass.place.interface, own.entries(model, started)


def _entries(model: PassModel, own: PassState, started: bool) -> dict[str, float]:
    rows, stiffness = own.read_rows(model), model.stiffness
    # the pass books a step's work in two halves, so that it is up to date at the instant of the positions
    works = own.total_works() if started else dict.fromkeys(own.total_works(), 0.0)
    spring = 0.5 * TANGENTIAL_RATIO * float(stiffness @ np.square(rows["spring"]).sum(axis=0))
    return {
        "ply_contact": 0.5 * float((np.square(rows["push"]) / stiffness).sum()),
        "ply_friction_spring": spring,
        "ply_friction_loss": works["friction_work"] - spring,
        "ply_damping_loss": works["damping_loss"],
        "ply_thickness_work": works["thickness_work"],
    }
