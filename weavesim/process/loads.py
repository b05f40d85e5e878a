"""Forces and couples prescribed at the nodes."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import model_validator

from ..arrays import FloatArray
from ..checks import Parameters
from ..errors import InputError
from ..kernels.rows import LoadRow
from ..quantities import Numbers
from ..ranges import Quantity


def check_curve(times: Numbers, values: Numbers, what: str) -> None:
    """Check a curve over time; ``what`` its values are, for the message.

    Raises:
        ValueError: unequal numbers of times and values, none, or times that do not increase.
    """
    if len(times) == 0 or len(times) != len(values) or np.any(np.diff(times) <= 0.0):
        raise ValueError(
            f"{len(times)} times and {len(values)} {what}; give the same number of both, at least one, and times must "
            "increase"
        )


class NodalLoads(Parameters):
    """Dead loads: their directions stay as the sheet moves. Their work is booked as ``load_work``.

    With symmetry planes the loads are those on the modelled part.

    Attributes:
        force: (node_count, 3) [N]; None for none.
        couple: (node_count, 3) [N m], a moment vector; None for none. A director has no stiffness about its own axis,
            so only the part of the moment normal to the director acts.
        times: increasing [s].
        shares: factor of all forces and couples at these times, linear between them, constant before and after.
    """

    positional = ("force", "couple", "times", "shares")

    force: Annotated[FloatArray, Quantity("force")] | None = None
    couple: Annotated[FloatArray, Quantity("couple")] | None = None
    times: Annotated[Numbers, Quantity("time")] = (0.0,)
    shares: Numbers = (1.0,)

    @model_validator(mode="after")
    def _are_a_curve(self) -> Self:
        check_curve(self.times, self.shares, "shares")
        return self

    def arrays(self, node_count: int) -> np.ndarray:
        """Forces and couples at a share of one, rows LoadRow, (row, node_count, 3).

        Raises:
            InputError: an array has the wrong shape or is not finite.
        """
        result = np.zeros((LoadRow.row_count(), node_count, 3))
        for row in LoadRow:
            given = getattr(self, row.name)
            if given is None:
                continue
            if given.shape != (node_count, 3) or not np.isfinite(given).all():
                raise InputError(
                    f"NodalLoads: {row.name} has shape {given.shape}; finite values of shape ({node_count}, 3) are "
                    "needed"
                )
            result[row] = given
        return result

    def share(self, time: float) -> float:
        """Factor at ``time`` [s]."""
        return float(np.interp(time, self.times, self.shares))
