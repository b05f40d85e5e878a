"""Gravity, damping and the dissipation of contact."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import model_validator

from ..checks import NotNegative, Parameters
from ..errors import InputError
from ..quantities import FiniteVector
from ..ranges import Quantity


class Dynamics(Parameters):
    """Loads and dissipation of the time integration.

    Attributes:
        gravity: (3,) [m/s^2].
        damping: mass-proportional damping rate of the nodes [1/s].
        director_damping: the same for the directors [1/s].
        contact_damping_ratio: normal dashpot of the contact, as a share of critical.
        contact_thickness: contact with tools is at half the "initial" or the "current" thickness; the work that a
            change of thickness does on the tools is booked as ``thickness_work``.
        contact_samples: tools are met at the "nodes", or also between them on the "surface" that the directors
            describe; what a change of its curvature does on the tools is booked as ``thickness_work`` too.
        contact_allowance: with "surface", the depth of the surface in a tool, over the thickness, from which it is
            pushed out between nodes too. A few hundredths cost a fraction of what 0, everywhere, costs.

    Raises:
        InputError: an allowance although only nodes meet tools.
    """

    positional = ("gravity", "damping", "director_damping", "contact_damping_ratio", "contact_thickness")

    gravity: Annotated[FiniteVector, Quantity("acceleration")] = (0.0, 0.0, 0.0)
    damping: Annotated[NotNegative, Quantity("damping rate")] = 0.0
    director_damping: Annotated[NotNegative, Quantity("damping rate")] = 0.0
    contact_damping_ratio: Annotated[NotNegative, Quantity("damping ratio")] = 0.1
    contact_thickness: Literal["initial", "current"] = "initial"
    contact_samples: Literal["nodes", "surface"] = "nodes"
    contact_allowance: Annotated[NotNegative, Quantity("contact allowance")] = 0.0

    @model_validator(mode="after")
    def _has_samples(self) -> Self:
        if self.contact_allowance > 0.0 and self.contact_samples == "nodes":
            raise InputError(
                f"contact_allowance = {self.contact_allowance:g}, but only nodes meet tools: it needs "
                'contact_samples = "surface"'
            )
        return self
