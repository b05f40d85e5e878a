"""Energies that must stay small for a quasi-static run of a sound mesh."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from .guard import Doubt, Level
from .limit import LimitGuard

if TYPE_CHECKING:
    from ..verdict import Judged


SCALED = (
    "the scaling of the mass was found for a stated error of shear angles and draw-in, which it keeps on a coarser "
    "mesh (mass_scaling in the summary); forces, stresses and energies have the inertia of the added mass"
)


class EnergyBalance(LimitGuard):
    """What was supplied is stored or lost."""

    name = "energy_balance"
    watches = "the energy balance"
    key = "energy_balance_error"
    text = "the error of the energy balance over the work"
    largest = 0.05
    level = Level.DO_NOT_USE
    advice = "energy is made or lost, do not use the result; a smaller time step or float64 tells more"


class KineticEnergy(LimitGuard):
    """A forming run is slow enough."""

    name = "kinetic_energy"
    watches = "kinetic over internal energy"
    key = "kinetic_energy_ratio"
    text = "kinetic over internal energy in the last quarter"
    largest = 0.05
    advice = "the run is not quasi-static, slow the tools down"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """With a scaling of the mass that was found for a stated error, what that error says, and what it does not."""
        chosen = run.run.setup.solver.mass_scaling
        for doubt in super().after(run):
            yield doubt if chosen is None else replace(doubt, advice=SCALED)


class HourglassEnergy(LimitGuard):
    """The stabilisation carries little."""

    name = "hourglass_energy"
    watches = "hourglass over internal energy"
    key = "hourglass_energy_ratio"
    text = "hourglass over internal energy"
    largest = 0.05
    advice = "refine the mesh"


class DampingLoss(LimitGuard):
    """Damping takes little; a falling sheet comes to rest by damping alone."""

    name = "damping_loss"
    watches = "the energy lost in damping"
    key = "damping_loss_ratio"
    text = "damping loss over the energy of the run"
    advice = "lower the damping"

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
        chosen = run.run.setup.solver.mass_scaling
        for doubt in super().after(run):
            yield doubt if chosen is None else replace(doubt, level=Level.NOTE, advice=SCALED)
