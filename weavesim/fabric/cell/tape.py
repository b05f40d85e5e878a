"""Unit cell of a stitched unidirectional tape."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from ...checks import NotNegative, Positive
from ...ranges import Quantity
from .contract import EnergyCell, UnitCell
from .weaves import PlainWeave


class UnidirectionalTape(EnergyCell):
    """Stiff tows along the warp direction, held together by stitches that zigzag across them.

    The two diagonals of the stitches carry only tension, once their slack is taken up; thread can slip from one to the
    other against a stiffness. Their strains depend on both stretches and on the shear angle.
    """

    unknown_count: ClassVar[int] = 1
    part_names: ClassVar[tuple[str, ...]] = ("tow", "stitch", "tow_to_tow")

    tow_stiffness: Annotated[Positive, Quantity("membrane stiffness")] = Field(
        description="E A of the tows over their spacing [N/m]"
    )
    tow_compressive_stiffness: Annotated[NotNegative, Quantity("membrane stiffness")] = Field(
        description="the same in compression [N/m]"
    )
    stitch_stiffness: Annotated[NotNegative, Quantity("membrane stiffness")] = Field(
        description="k of the energy 1/2 k strain^2 per area of one diagonal in tension [N/m]"
    )
    slip_stiffness: Annotated[Positive, Quantity("membrane stiffness")] = Field(
        description="k of the energy 1/2 k slip^2 per area; slip is strain transferred between the diagonals [N/m]"
    )
    stitch_pitch: Annotated[Positive, Quantity("yarn spacing")] = Field(
        description="extent of a diagonal along the tows [m]"
    )
    tow_spacing: Annotated[Positive, Quantity("yarn spacing")] = Field(
        description="extent of a diagonal across the tows [m]"
    )
    stitch_slack: Annotated[NotNegative, Quantity("strain")] = Field(
        default=0.0, description="strain of a diagonal at which it begins to pull"
    )
    transverse_stiffness: Annotated[NotNegative, Quantity("membrane stiffness")] = Field(
        default=0.0, description="across the tows in tension, without stitches [N/m]"
    )
    transverse_compressive_stiffness: Annotated[NotNegative, Quantity("membrane stiffness")] = Field(
        default=0.0, description="across the tows in compression, without stitches [N/m]"
    )

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        return {"stitched-tape": cls._glass_tows}

    @classmethod
    def _glass_tows(cls) -> Self:
        """Tows as stiff as the glass/polypropylene yarns; everything else is assumed."""
        tow = min(PlainWeave.glass_polypropylene().yarn_stiffness_per_width)
        return cls(
            tow_stiffness=tow, tow_compressive_stiffness=2.0e-4 * tow, stitch_stiffness=4.0e4, slip_stiffness=1.0e4,
            stitch_pitch=5.2e-3, tow_spacing=5.2e-3, stitch_slack=0.01, transverse_stiffness=1.0e3,
            transverse_compressive_stiffness=2.0e4,
        )  # fmt: skip

    def functions(self) -> dict[str, Any]:
        from ...kernels.cell.energies import tape_energies

        return {"parts": tape_energies}

    @model_validator(mode="after")
    def _holds_across(self) -> Self:
        if self.stitch_stiffness == 0.0 and self.transverse_stiffness == 0.0:
            raise ValueError(
                "stitch_stiffness = 0, transverse_stiffness = 0: nothing holds the tows together; give one of them"
            )
        return self

    @property
    def _stitch_bounds(self) -> tuple[float, float, float]:
        """Stiffness bounds of the stitches alone, for both stretches and the angle [N/m].

        A diagonal's strain changes by at most s per warp stretch, t per weft stretch, and the smaller of the two per
        angle, with s and t the shares of its two legs; (sum a_i e_i)^2 is at most (sum a_i) (sum a_i e_i^2).
        """
        length = math.hypot(self.stitch_pitch, self.tow_spacing)
        s, t = self.stitch_pitch / length, self.tow_spacing / length
        r = min(s, t)
        bound = 2.0 * self.stitch_stiffness * (s + t + r)
        return bound * s, bound * t, bound * r

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        along, across, _ = self._stitch_bounds
        tow = max(self.tow_stiffness, self.tow_compressive_stiffness)
        return tow + along, max(self.transverse_stiffness, self.transverse_compressive_stiffness) + across

    @property
    def shear_stiffness(self) -> float:
        return self._stitch_bounds[2]
