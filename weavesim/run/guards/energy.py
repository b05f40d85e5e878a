"""Energies that must stay small for a quasi-static run of a sound mesh."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from .guard import Doubt, Level
from .limit import LimitGuard

if TYPE_CHECKING:
    from ..frame import Frame
    from ..ledger import Ledger
    from ..sheet_ledger import SheetLedger
    from ..verdict import Judged


SCALED = (
    "the scaling of the mass was found for a stated error of shear angles and draw-in, which it keeps on a coarser "
    "mesh (mass_scaling in the summary); forces, stresses and energies have the inertia of the added mass"
)


# Share of a run from which on its balance of energies may end it.
FIRST_JUDGED = 0.1


class EnergyBalance(LimitGuard):
    """What was supplied is stored or lost."""

    name = "energy_balance"
    watches = "the energy balance"
    lasting = True
    key = "energy_balance_error"
    text = "the error of the energy balance over the work"
    largest = 0.05
    level = Level.DO_NOT_USE
    advice = "energy is made or lost, do not use the result; a smaller time step or float64 tells more"

    def so_far(self, run: Judged) -> Iterable[Doubt]:
        """The same from a tenth of the run on: the first works are small, and errors are weighed against them."""
        return self.after(run) if run.run.frame.time >= FIRST_JUDGED * run.run.info.duration else ()

    def where(self, run: Judged) -> Mapping[str, Any]:
        """When it was largest."""
        return {"time": _time_of_largest(run.balance_errors)}


class _Placed(LimitGuard):
    """A share of energies that remembers, at every look, where in the sheets most of the energy was.

    Attributes:
        energy: of the ledger.
    """

    energy: ClassVar[str] = ""

    def __init__(self) -> None:
        self._places: dict[float, tuple[str, float, float]] = {}

    def most(self, ledger: SheetLedger) -> tuple[float, np.ndarray]:
        """The most that an element or a node of a sheet has [J], and its place on the flat blank [m]."""
        raise NotImplementedError

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Look where most of it is now."""
        found = [(*self.most(sheet), sheet.name) for sheet in ledger.sheets]
        _, place, name = max(found, key=lambda each: each[0])
        self._places[frame.time] = (name, float(place[0]), float(place[1]))

    def memory(self) -> Mapping[str, Any]:
        """Time, sheet and place of every look."""
        return {"places": [[time, *place] for time, place in self._places.items()]}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._places = {time: (name, x, y) for time, name, x, y in memory["places"]}

    def states(self, run: Judged) -> list[dict[str, float]]:
        """Those that are judged."""
        return run.stored

    def where(self, run: Judged) -> Mapping[str, Any]:
        """When the share was largest, and where most of the energy then was."""
        time = _time_of_largest(run.shares(self.energy, self.states(run)))
        if time not in self._places:
            return {"time": time}
        name, x, y = self._places[time]
        return {"time": time, "sheet": name, "place": (x, y)}


class KineticEnergy(_Placed):
    """A forming run is slow enough."""

    name = "kinetic_energy"
    watches = "kinetic over internal energy"
    key = "kinetic_energy_ratio"
    energy = "kinetic"
    text = "kinetic over internal energy in the last quarter"
    largest = 0.05
    advice = "the run is not quasi-static, slow the tools down"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """With a scaling of the mass that was found for a stated error, what that error says, and what it does not."""
        chosen = run.run.model.setup.solver.mass_scaling
        for doubt in super().after(run):
            yield replace(doubt, advice=SCALED) if chosen and chosen.target_step else doubt

    def most(self, ledger: SheetLedger) -> tuple[float, np.ndarray]:
        """Kinetic energy of the node that has most of it [J], and where that node is on the flat blank, (2,) [m]."""
        return ledger.fastest_node()

    def states(self, run: Judged) -> list[dict[str, float]]:
        """Those of the last quarter."""
        return run.last_quarter


class HourglassEnergy(_Placed):
    """The stabilisation carries little."""

    name = "hourglass_energy"
    watches = "hourglass over internal energy"
    key = "hourglass_energy_ratio"
    energy = "hourglass"
    text = "hourglass over internal energy"
    largest = 0.05
    advice = "refine the mesh"

    def most(self, ledger: SheetLedger) -> tuple[float, np.ndarray]:
        """Hourglass energy of the element that has most of it [J], and where that is on the flat blank, (2,) [m]."""
        return ledger.largest_energy("hourglass")


class DampingLoss(LimitGuard):
    """Damping takes little; a falling sheet comes to rest by damping alone."""

    name = "damping_loss"
    watches = "the energy lost in damping"
    key = "damping_loss_ratio"
    text = "damping loss over the energy of the run"
    advice = "lower the damping"

    def where(self, run: Judged) -> Mapping[str, Any]:
        """When the power of the damping was largest."""
        return {"time": _time_of_largest(run.damping_rates)}

    def limit(self, run: Judged) -> float:
        """Less where gravity does not do the work."""
        return 0.05 if (run.number("gravity_work_ratio") or 0.0) < 0.5 else 1.0


class AddedMass(LimitGuard):
    """Mass scaling adds little."""

    name = "added_mass"
    watches = "the mass that scaling added"
    key = "added_mass_ratio"
    text = "the added mass over the blank's"
    largest = 0.05
    advice = "it changes the dynamics: give a smaller target_step"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """A note where the scaling was found for a stated error."""
        chosen = run.run.model.setup.solver.mass_scaling
        for doubt in super().after(run):
            is_found = chosen and chosen.target_step
            yield replace(doubt, level=Level.NOTE, advice=SCALED) if is_found else doubt

    def where(self, run: Judged) -> Mapping[str, Any]:
        """The sheet with most of it; it is there from the start."""
        return {"sheet": max(run.run.model.sheets, key=lambda sheet: sheet.added_mass_ratio).name}


def _time_of_largest(values: list[tuple[float, float]]) -> float | None:
    """Time of the largest of values with their times [s]; one that is not a number is above all others."""
    return values[int(np.argmax([value for value, _ in values]))][1] if values else None
