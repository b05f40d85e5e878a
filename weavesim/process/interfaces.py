"""Interfaces between the plies of a stack: which sheets touch, in which order, and with which friction."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import SerializeAsAny, model_validator

from ..checks import NotNegative, Parameters, Positive
from ..names import Label
from ..ranges import Quantity
from .friction import Coulomb, Friction


class Interface(Parameters):
    """Contact between two sheets of a world.

    The order is known and stays: the upper sheet lies on the side to which the directors of the lower one point, and
    nothing changes sides.

    Attributes:
        lower, upper: names of the two sheets.
        friction: between them.
        passes: "both" lets the nodes of either sheet meet the facets of the other, as needed near free edges; "one"
            only those of the finer sheet, which is cheaper, with twice the noise of the pressure on the other.
        stiffness_share: share of the largest stiffness that a step allows, which sets the penetration (see
            docs/plies.md); up to 0.2 for compaction under high pressure, for which the step is shorter.
        damping_ratio: normal dashpot as a share of critical; None for that of the world's contact.
    """

    positional = ("lower", "upper", "friction")

    lower: Label
    upper: Label
    friction: SerializeAsAny[Friction] = Coulomb(0.2)
    passes: Literal["both", "one"] = "both"
    stiffness_share: Annotated[Positive, Quantity("stiffness share")] = 0.05
    damping_ratio: Annotated[NotNegative, Quantity("damping ratio")] | None = None

    @model_validator(mode="after")
    def _joins_two(self) -> Self:
        if self.lower == self.upper:
            raise ValueError(f"lower and upper are both {self.lower!r}; an interface joins two sheets")
        return self

    @property
    def name(self) -> str:
        """For outputs: "LOWER / UPPER"."""
        return f"{self.lower} / {self.upper}"
