"""Energies, forces and slips of the interfaces between plies, computed from the state without changing it."""

from __future__ import annotations

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

    Attributes:
        passes: of all interfaces.
    """

    def __init__(self, model: Model) -> None:
        self.passes, self._contacts = model.passes, model.contacts

    def entries(self, state: State, ahead: State) -> dict[str, float]:
        """Entries of the ledger, summed over the interfaces [J], given the state after the next step."""
        totals = dict.fromkeys(ENTRIES, 0.0)
        for of_interface in self.by_interface(state, ahead):
            for name, value in of_interface.items():
                totals[name] += value
        return totals

    def by_interface(self, state: State, ahead: State) -> list[dict[str, float]]:
        """The same of every interface, then of every sheet that touches itself."""
        result = [dict.fromkeys(ENTRIES, 0.0) for _ in self._contacts]
        started = state.step_count > 0
        for model, own in zip(self.passes, ahead.passes, strict=True):
            for name, value in _entries(model, own, started).items():
                result[model.place.interface][name] += value
        return result


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
