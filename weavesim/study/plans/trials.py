"""What a plan asks for, and what it is told: the contract between plans and their conductor."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..factors import Value


@dataclass(frozen=True)
class Trial:
    """A run that is asked for.

    Attributes:
        values: of the factors, in their order.
        role: "design", "noise" or "scenario".
        point: number of the point of the study that it belongs to, from 0.
        repeat: 0 for the point itself, else which change that means nothing.
    """

    values: tuple[Value, ...]
    role: str = "design"
    point: int = 0
    repeat: int = 0


@dataclass(frozen=True)
class Answer:
    """What a run found.

    Attributes:
        trial: that was asked for.
        key: of the run in the table.
        status: "finished", "failed" (it ran and stopped), "refused" (bad input), or "lost" (no worker brought it home).
        verdict: of the run; "" if it has none.
        numbers: all of its summary, by name.
        error: why it did not finish.
    """

    trial: Trial
    key: str
    status: str = "finished"
    verdict: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""

    def number(self, name: str) -> float | None:
        """A measure; None if the run does not have it."""
        value = self.numbers.get(name)
        return float(value) if isinstance(value, int | float) else None


# Yields trials that may run at the same time, and is sent their answers in the same order.
Plan = Generator[Sequence[Trial], Sequence[Answer], None]
