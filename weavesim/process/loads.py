"""Forces and couples that are prescribed at the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..kernels.rows import LoadRow


@dataclass(frozen=True)
class NodalLoads:
    """Dead loads: their directions stay as the sheet moves. Their work is booked as ``load_work``.

    With symmetry planes the loads are those on the modelled part.

    Attributes:
        force: (node_count, 3) [N]; None for none.
        couple: (node_count, 3) [N m], a moment vector; None for none. A director has no stiffness about itself, so only
            the part of the moment across the director acts.
        times: increasing [s].
        shares: factor of all forces and couples at these times, linear between them, constant before and after.
    """

    force: np.ndarray | None = None
    couple: np.ndarray | None = None
    times: tuple[float, ...] = (0.0,)
    shares: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        times, shares = np.array(self.times, dtype=np.float64), np.array(self.shares, dtype=np.float64)
        if times.ndim != 1 or len(times) == 0 or times.shape != shares.shape or np.any(np.diff(times) <= 0.0):
            raise InputError(
                f"NodalLoads: {times.size} times and {shares.size} shares; as many of one as of the other are needed, "
                "at least one, and times must increase"
            )
        if not (np.isfinite(times).all() and np.isfinite(shares).all()):
            raise InputError("NodalLoads: times and shares must be finite")

    def arrays(self, node_count: int) -> np.ndarray:
        """Forces and couples at a share of one, rows LoadRow, (row, node_count, 3).

        Raises:
            InputError: an array of another shape, or one that is not finite.
        """
        result = np.zeros((LoadRow.row_count(), node_count, 3))
        for row in LoadRow:
            given = getattr(self, row.name)
            if given is None:
                continue
            values = np.asarray(given, dtype=np.float64)
            if values.shape != (node_count, 3) or not np.isfinite(values).all():
                raise InputError(
                    f"NodalLoads: {row.name} has shape {values.shape}; finite values of shape ({node_count}, 3) are "
                    "needed"
                )
            result[row] = values
        return result

    def share(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return float(np.interp(time, self.times, self.shares))
