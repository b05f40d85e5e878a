"""What is left of one variant of a batch."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Self

from ...engine.setup import Setup
from ..frame import Frame, Outcome
from ..guards import Doubt, verdict_of
from ..simulation import Simulation


@dataclass(frozen=True, eq=False)
class BatchRun:
    """One variant after its run: values on the host, nothing on a device.

    Attributes:
        setup: as given.
        outcome: how the run ended; None if it never started.
        failure: why it did not start or had to stop; None if neither happened.
        frame: the last one; None if it never started.
        summary: the numbers of the run, as of ``Simulation.summary``; empty if it never started.
        doubts: what speaks against the result, the worst first.
        warnings: for the user.
        history: time, stroke and every entry of the energy ledger, of all frames.
    """

    setup: Setup
    outcome: Outcome | None = None
    failure: str | None = None
    frame: Frame | None = None
    summary: dict[str, Any] = field(default_factory=dict)
    doubts: tuple[Doubt, ...] = ()
    warnings: tuple[str, ...] = ()
    history: tuple[dict[str, float], ...] = ()

    @property
    def finished(self) -> bool:
        """Whether it ran to its end."""
        return self.outcome is Outcome.FINISHED

    @property
    def verdict(self) -> str:
        """ "trusted", "doubtful" or "do not use"; "not run" for a variant that never started."""
        return verdict_of(self.doubts) if self.outcome else "not run"

    @classmethod
    def of(cls, setup: Setup, simulation: Simulation) -> Self:
        """Of a simulation that has ended."""
        return cls(
            setup=setup,
            outcome=simulation.outcome,
            failure=simulation.failure,
            frame=simulation.frame,
            summary=simulation.summary(),
            doubts=tuple(simulation.doubts()),
            warnings=tuple(simulation.warnings),
            history=tuple(simulation.history),
        )
