"""A linear membrane as a unit cell."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from ...checks import Positive
from ...ranges import Quantity
from .contract import EnergyCell, UnitCell


class LinearMembrane(EnergyCell):
    """n_1 = C_11 e_1 + C_12 e_2, n_2 = C_12 e_1 + C_22 e_2, with e = stretch - 1; no shear, no unknowns."""

    depends_on_shear: ClassVar[bool] = False

    warp_stiffness: Annotated[Positive, Quantity("membrane stiffness")] = Field(description="C_11 [N/m]")
    weft_stiffness: Annotated[Positive, Quantity("membrane stiffness")] = Field(description="C_22 [N/m]")
    coupling_stiffness: Annotated[float, Quantity("membrane stiffness")] = Field(
        default=0.0, allow_inf_nan=False, description="C_12 [N/m]"
    )

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if self.coupling_stiffness**2 > self.warp_stiffness * self.weft_stiffness:
            raise ValueError(
                f"coupling_stiffness = {self.coupling_stiffness:.4g} N/m: its square may not exceed "
                "warp_stiffness * weft_stiffness, or stretching releases energy"
            )
        return self

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        return {
            "linear-membrane": partial(cls, warp_stiffness=2.0e6, weft_stiffness=1.5e6, coupling_stiffness=0.3e6)
        }  # fmt: skip

    def functions(self) -> dict[str, Any]:
        from ...kernels.cell.energies import membrane_energy, membrane_gradient

        return {"energy": membrane_energy, "gradient": membrane_gradient}

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        coupling = abs(self.coupling_stiffness)
        return self.warp_stiffness + coupling, self.weft_stiffness + coupling
