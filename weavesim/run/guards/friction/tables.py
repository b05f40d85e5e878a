"""Uses of a friction table beyond its ends: the first place and time, and how far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ....kernels.contact.friction import NO_ARGUMENT, UNMET
from ....process.friction import Friction
from ....process.friction_device import argument_kind

# Reduction of a viscosity that is told.
LEAST_VISCOUS_SHARE = 0.99
# Larger than any argument that a law has met, and smaller than ``UNMET`` in single precision.
LARGEST_MET = 0.5 * float(UNMET)
# Beyond an end by less than this share of the largest argument is rounding.
ROUNDING = 1.0e-6


class BeyondTables:
    """What was asked of several tables beyond their ends.

    Attributes:
        found: by a name of the contact and its law: time [s], place (x, y) on the flat blank [m], the farthest excess,
            and what the law covers.
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
        short = np.where(low < LARGEST_MET, arguments[0] - low, 0.0)
        excess = np.maximum(np.where(high > -LARGEST_MET, high - arguments[-1], 0.0), short)
        worst = int(np.argmax(excess))
        if excess[worst] > ROUNDING * arguments[-1]:
            law = {
                "unit": friction.argument_unit,
                "argument": friction.argument_name,
                "ends": arguments[[0, -1]].tolist(),
            }
            # stages may give a contact another law
            key = f"{name}\n{friction.argument_name}\n{arguments[0]:g}\n{arguments[-1]:g}"
            known = self.found.setdefault(key, {"name": name, "time": time, "place": places[worst].tolist(), **law})
            known["excess"] = max(float(excess[worst]), known.get("excess", 0.0))

    def told(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """What is told of every contact and law, and what was found."""
        for found in self.found.values():
            unit, (first, last) = found["unit"], found["ends"]
            text = (
                f"the friction table is used beyond its ends, by {found['excess']:.4g} {unit} of {found['argument']} "
                f"(it covers {first:.4g} to {last:.4g} {unit})"
            )
            yield text, found

    def memory(self) -> Mapping[str, Any]:
        """For a checkpoint."""
        return {"beyond": self.found}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take it back."""
        self.found = dict(memory["beyond"])
