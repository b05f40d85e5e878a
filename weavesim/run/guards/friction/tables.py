"""Uses of a friction table beyond its ends: the first place and time, and how far."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....kernels.contact.friction import NO_ARGUMENT
from ....process.friction import Friction
from ....process.friction_device import argument_kind

# Reduction of a viscosity that is told.
LEAST_VISCOUS_SHARE = 0.99
# An argument that has not been met: below the start of the smallest.
NEVER = 1.0e29
# Beyond an end by less than this share of the largest argument is rounding.
ROUNDING = 1.0e-6


class BeyondTables:
    """What was asked of several tables beyond their ends.

    Attributes:
        found: by a name of the contact: time [s], place (x, y) on the flat blank [m], and the farthest excess.
    """

    def __init__(self) -> None:
        self.found: dict[str, dict[str, Any]] = {}

    def note(
        self, name: str, friction: Friction, low: np.ndarray, high: np.ndarray, places: np.ndarray, time: float
    ) -> None:
        """Note the extremes of a law's argument so far, of nodes.

        Args:
            name: of the contact.
            friction: its law.
            low, high: extremes, (k,), in the unit of the kernels.
            places: of the nodes, (k, 2) [m].
            time: [s].
        """
        if argument_kind(friction) == NO_ARGUMENT or not len(low):
            return
        arguments, _ = friction.table()
        short = np.where(low < NEVER, arguments[0] - low, 0.0)
        excess = np.maximum(np.where(high > -NEVER, high - arguments[-1], 0.0), short)
        worst = int(np.argmax(excess))
        if excess[worst] > ROUNDING * arguments[-1]:
            known = self.found.setdefault(name, {"time": time, "place": places[worst].tolist()})
            known["excess"] = float(excess[worst])

    def text(self, name: str, friction: Friction) -> str:
        """What is told of one contact."""
        arguments, _ = friction.table()
        return (
            f"the friction table is used beyond its ends, by {self.found[name]['excess']:.4g} "
            f"{friction.argument_unit} of {friction.argument_name} (it covers {arguments[0]:.4g} to "
            f"{arguments[-1]:.4g} {friction.argument_unit})"
        )

    def memory(self) -> Mapping[str, Any]:
        """For a checkpoint."""
        return {"beyond": self.found}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take it back."""
        self.found = dict(memory["beyond"])
