"""Friction laws of a contact: a coefficient, or a table of it, and a viscous film (docs/plies.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Discriminator, SerializeAsAny, Tag, model_validator

from ..checks import Kinded, NotNegative, Positive
from ..quantities import Numbers
from ..ranges import Quantity


class Friction(Kinded):
    """How two surfaces in contact resist sliding on each other.

    Attributes:
        argument_name, argument_unit: what the coefficient depends on, in the unit of the kernels; None for nothing.
    """

    argument_name: ClassVar[str | None] = None
    argument_unit: ClassVar[str] = ""

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Arguments, ascending, and coefficients, (n,); one entry for a constant."""
        return np.zeros(1), np.zeros(1)


class Coulomb(Friction):
    """The same coefficient everywhere.

    Attributes:
        coefficient: friction over normal force.
    """

    positional = ("coefficient",)

    coefficient: Annotated[NotNegative, Quantity("friction")]

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """One entry, at an argument of zero: the coefficient, (1,) each."""
        return np.zeros(1), np.array([self.coefficient])


class AmongLaws(Coulomb):
    """The coefficient of a tool in a stage, where other stages have laws for tools: the kernels are theirs."""

    is_kind: ClassVar[bool] = False

    @classmethod
    def of(cls, friction: Friction | float) -> Self:
        """That of a coefficient, which has been checked."""
        return cls.model_construct(coefficient=float(law_of(friction).table()[1][0]))


class Tabulated(Friction):
    """Base class of coefficients from a table: linear between its points, constant beyond them.

    Use beyond the table is reported, with place and time.

    Attributes:
        coefficients: one per argument.
    """

    is_kind: ClassVar[bool] = False
    arguments_name: ClassVar[str]

    coefficients: Annotated[Numbers, Quantity("friction")]

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        arguments = getattr(self, self.arguments_name)
        if len(arguments) < 2 or len(arguments) != len(self.coefficients):
            raise ValueError(
                f"it has {len(arguments)} {self.arguments_name} and {len(self.coefficients)} coefficients; give the "
                "same number of both, at least two"
            )
        if min(self.coefficients) < 0.0 or min(arguments) < 0.0:
            raise ValueError(f"{self.arguments_name} and coefficients must not be negative")
        late = np.flatnonzero(np.diff(arguments) <= 0.0)
        if len(late):
            k = int(late[0])
            raise ValueError(
                f"{self.arguments_name} goes from {arguments[k]:g} to {arguments[k + 1]:g}; it must increase"
            )
        return self

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Arguments and coefficients, (n,) each."""
        return np.array(getattr(self, self.arguments_name)), np.array(self.coefficients)


def _kind_of_friction(value: object) -> str:
    return "law" if isinstance(value, Friction | Mapping) else "number"


# A coefficient, or a law.
FrictionValue = Annotated[
    Annotated[NotNegative, Quantity("friction"), Tag("number")] | Annotated[SerializeAsAny[Friction], Tag("law")],
    Discriminator(_kind_of_friction),
]


# Of a tool.
NO_YARNS = (
    "YarnAngleFriction depends on the angle between the warps of two plies, and a tool has no yarns: give a "
    "coefficient, or one of Coulomb, PressureFriction, StribeckFriction, ViscousFilm"
)


def law_of(friction: Friction | float) -> Friction:
    """A law; a number is the coefficient of ``Coulomb``."""
    return friction if isinstance(friction, Friction) else Coulomb(float(friction))


def in_words(friction: Friction | float) -> str:
    """For logs and reports."""
    if not isinstance(friction, Friction):
        return f"friction {friction:g}"
    _, coefficients = friction.table()
    low, high = float(coefficients.min()), float(coefficients.max())
    return f"{type(friction).__name__} {low:g}" + ("" if low == high else f" to {high:g}")


class PressureFriction(Tabulated):
    """A coefficient that depends on the pressure.

    Attributes:
        pressures: increasing [Pa].
    """

    positional = ("pressures", "coefficients")
    arguments_name = "pressures"
    argument_name, argument_unit = "pressure", "Pa"

    pressures: Annotated[Numbers, Quantity("pressure")]


class YarnAngleFriction(Tabulated):
    """A coefficient that depends on the angle between the warps of the two plies in touch.

    Attributes:
        angles: increasing, from 0 to 90 [degrees].
    """

    positional = ("angles", "coefficients")
    arguments_name = "angles"
    argument_name, argument_unit = "angle between the warps", "rad"

    angles: Annotated[Numbers, Quantity("angle", at_most=90.0)]

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Angles [rad] and coefficients, (n,) each."""
        angles, coefficients = super().table()
        return np.radians(angles), coefficients


class StribeckFriction(Tabulated):
    """A coefficient that depends on the Hersey number: viscosity times sliding speed over pressure.

    Attributes:
        hersey_numbers: increasing [m].
        viscosity: of the resin between the surfaces [Pa s].
    """

    positional = ("hersey_numbers", "coefficients", "viscosity")
    arguments_name = "hersey_numbers"
    argument_name, argument_unit = "Hersey number", "m"

    hersey_numbers: Annotated[Numbers, Quantity("Hersey number")]
    viscosity: Annotated[Positive, Quantity("viscosity")]


def has_law(friction: Friction | float) -> bool:
    """Whether a friction is more than a coefficient."""
    return not isinstance(friction, Coulomb | float | int)


class ViscousFilm(Friction):
    """A film of resin between surfaces in contact: the drag per area is viscosity times speed over thickness.

    Attributes:
        viscosity: of the resin [Pa s].
        thickness: of the film [m].
        coefficient: of Coulomb friction beside it.
    """

    positional = ("viscosity", "thickness", "coefficient")

    viscosity: Annotated[Positive, Quantity("viscosity")]
    thickness: Annotated[Positive, Quantity("film thickness")]
    coefficient: Annotated[NotNegative, Quantity("friction")] = 0.0

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """One entry, (1,) each: the coefficient beside the film, at an argument of zero."""
        return np.zeros(1), np.array([self.coefficient])
