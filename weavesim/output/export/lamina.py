"""Elastic constants of the layers in exported decks: the user's, of the consolidated part, or assumed ones.

The forming run knows the dry or molten fabric, never the part that it becomes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from ...checks import Parameters, Positive
from ...ranges import Quantity, read_parameters


class Lamina(Parameters):
    """A layer of parallel fibres, axis 1 along them, alike in all directions across them."""

    modulus_along: Annotated[Positive, Quantity("yarn modulus")] = Field(description="E_1 along the fibres [Pa]")
    modulus_across: Annotated[Positive, Quantity("yarn modulus")] = Field(description="E_2 = E_3 across them [Pa]")
    poisson_ratio: float = Field(gt=-1.0, lt=1.0, description="nu_12 = nu_13")
    poisson_ratio_across: float = Field(default=0.45, gt=-1.0, lt=1.0, description="nu_23")
    shear_modulus: Annotated[Positive, Quantity("shear modulus")] = Field(description="G_12 = G_13 [Pa]")
    shear_modulus_across: Annotated[Positive, Quantity("shear modulus")] = Field(description="G_23 [Pa]")
    density: Annotated[Positive, Quantity("fibre density")] = Field(description="[kg/m^3]")
    source: str = Field(default="", description="where the values come from")

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        ratio = self.modulus_across / self.modulus_along
        if self.poisson_ratio**2 * ratio >= 1.0 or 1.0 - self.poisson_ratio_across <= (
            2.0 * self.poisson_ratio**2 * ratio
        ):
            raise ValueError(
                f"poisson_ratio = {self.poisson_ratio:g} and poisson_ratio_across = {self.poisson_ratio_across:g}: "
                f"with E_1/E_2 = {1.0 / ratio:.4g} the material would release energy when strained; check both"
            )
        return self

    @classmethod
    def from_file(cls, path: str | Path) -> Self:
        """From a TOML or JSON file with these names.

        Raises:
            InputError: a file that cannot be read, or values that are not allowed or not usual.
        """
        return read_parameters(cls, path, "lamina file")


# E-glass (73 GPa) in polypropylene (1.5 GPa), 35 % fibres: rule of mixtures along the fibres, Halpin-Tsai across them.
ASSUMED = Lamina(
    modulus_along=26.5e9,
    modulus_across=3.5e9,
    poisson_ratio=0.3,
    shear_modulus=1.2e9,
    shear_modulus_across=1.2e9,
    density=1480.0,
    source="ASSUMED: glass/polypropylene at 35 % fibres; give your own with --lamina",
)
