"""Fabrics: physical parameters with their sources, checked on construction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, SerializeAsAny, model_validator

from ..checks import NotNegative, Parameters, Positive
from ..names import Label
from ..ranges import Quantity, unusual_values
from .bending import BendingLaw
from .cell import UnitCell
from .compaction import Compaction, check_compaction
from .proportions import disproportionate_values, families_apart
from .provenance import Origin, check_provenance, origin_of, out_of_range, still_true
from .shear import CrossoverFriction, LinearShear, ShearLaw

# Stiffness of locking and of friction springs is at most this share of a yarn's stiffness per width: it affects the
# stable step.
LARGEST_LOCKING_SHARE = 0.1


class Stabilisation(Parameters):
    """Shares of the exact stiffness of the hourglass modes; constants of a run.

    The in-plane share is of the shear stiffness, never of the yarns': otherwise a sheet with little shear stiffness
    would be locked by its own stabilisation. The warping mode excludes the twist, so that pure twist stores no energy.
    """

    in_plane: Annotated[NotNegative, Quantity("stabilisation")] = Field(
        default=0.1, description="in-plane modes, share of the shear stiffness"
    )
    warping: Annotated[NotNegative, Quantity("stabilisation")] = Field(
        default=0.1, description="warping mode, share of the transverse shear stiffness"
    )
    director: Annotated[NotNegative, Quantity("stabilisation")] = Field(
        default=0.1,
        description="director modes, share of the bending stiffness; at least 1 in a sheet that may touch itself",
    )


class Fabric(Parameters):
    """A woven fabric: the material of a sheet."""

    name: Label = Field(description="name of the fabric, for reports")
    areal_density: Annotated[Positive, Quantity("areal density")] = Field(
        description="mass per reference area [kg/m^2]"
    )
    thickness: Annotated[Positive, Quantity("sheet thickness")] = Field(description="of the undeformed sheet [m]")
    unit_cell: SerializeAsAny[UnitCell] = Field(description="response of the yarns")
    shear: SerializeAsAny[ShearLaw] = Field(description="elastic law of in-plane shear")
    shear_friction: SerializeAsAny[CrossoverFriction] | None = Field(
        default=None, description="friction of the yarns that rotate on each other, in addition to the elastic law"
    )
    bending: SerializeAsAny[BendingLaw] = Field(kw_only=True, description="law of bending")
    transverse_shear_modulus: Annotated[NotNegative, Quantity("shear modulus")] = Field(
        kw_only=True,
        description="G of equation (6) across the sheet, stress over angle: Q = 5/6 G t gamma, gamma the angle from "
        "the normal to the director [Pa]",
    )
    in_plane_bending_stiffness: Annotated[NotNegative, Quantity("in-plane bending")] = Field(
        default=0.0,
        description="B of psi = 1/2 B |grad gamma|^2: in-plane bending stiffness of the yarns, which keeps the shear "
        "angle from jumping between elements [N m]",
    )
    compressive_stiffness: Annotated[NotNegative, Quantity("compressive stiffness")] = Field(
        default=0.0,
        description="of the sheet itself along yarns in compression, in addition to the unit cell's [N/m]",
    )
    stabilisation: Stabilisation = Field(default=Stabilisation(), description="of the hourglass modes")
    compaction: Compaction = Field(default=Compaction(), description="thickness and fibre content when deformed")
    source: str = Field(default="", description="where the values come from")
    assumed: tuple[str, ...] = Field(
        default=(), description="what has no source, in words; provenance says it of each number"
    )
    provenance: tuple[Origin, ...] = Field(
        default=(), description="where each number comes from, how far it is trusted, and whether it is assumed"
    )

    @model_validator(mode="after")
    def _locking_is_bounded(self) -> Self:
        largest = LARGEST_LOCKING_SHARE * min(self.unit_cell.yarn_stiffness_per_width)
        if self.shear.locking_slope > largest * (1 + 1e-9):
            raise ValueError(
                f"locking_stiffness = {self.shear.locking_slope:.4g} N/m: at most {largest:.4g} N/m, a tenth of "
                f"the yarn stiffness per width, is allowed (it enters the stable time step){self._cell_slip}"
            )
        check_compaction(self.compaction, self.thickness, self.areal_density)
        if self.shear_friction is not None and self.shear_friction.stiffness > largest * (1 + 1e-9):
            raise ValueError(
                f"shear_friction.stiffness = {self.shear_friction.stiffness:.4g} N/m: at most {largest:.4g} N/m, a "
                f"tenth of the yarn stiffness per width, is allowed (it enters the stable time step){self._cell_slip}"
            )
        return self

    @property
    def _cell_slip(self) -> str:
        """A likely slip in the yarns, which limits that depend on them mention."""
        unusual = next(unusual_values(self.unit_cell, "unit_cell"), "") or next(families_apart(self.unit_cell), "")
        return unusual and f"; but {unusual}"

    @model_validator(mode="after")
    def _crossovers_can_rub(self) -> Self:
        pressed_by = self.shear_friction.pressed_by if self.shear_friction else ""
        if pressed_by and not self.unit_cell.has_crossovers:
            raise ValueError(
                f"shear_friction.{pressed_by}: the unit cell {type(self.unit_cell).__name__} reports no pressure "
                "between warp and weft, so it would do nothing; leave it out, or take a cell with crossovers (a cell "
                "of your own: crossover_pressure)"
            )
        return self

    @model_validator(mode="after")
    def _provenance_is_of_this_fabric(self) -> Self:
        check_provenance(self)
        return self

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with some values changed, checked like a new value; numbers that change lose their provenance."""
        changes = dict(update or {})
        if "provenance" in changes or not self.provenance:
            return super().model_copy(update=changes)
        copy = super().model_copy(update={**changes, "provenance": ()})
        return Parameters.model_copy(copy, update={"provenance": still_true(self, copy)})

    def to_toml(self) -> str:
        """All values as a fabric file in TOML; ``load_fabric`` of such a file gives an equal fabric, bit for bit."""
        import tomli_w

        return tomli_w.dumps(_given(self.model_dump(mode="json")))

    def origin_of(self, name: str) -> Origin | None:
        """Where a number comes from, by its name in a fabric file, such as "shear.angle"; None if nobody said."""
        return origin_of(self.provenance, name)

    def disproportions(self) -> Iterator[str]:
        yield from disproportionate_values(self)
        yield from out_of_range(self)

    @property
    def has_bending_friction(self) -> bool:
        """True if the yarns of at least one family have internal bending friction."""
        return max(self.bending.friction_limit) > 0.0

    @property
    def has_inner_friction(self) -> bool:
        """True if yarns or fibres can slip inside the sheet, which makes it history-dependent."""
        return self.shear_friction is not None or self.has_bending_friction

    @property
    def shear_stiffness_scale(self) -> float:
        """Typical shear stiffness [N/m] for the in-plane stabilisation: the mean of m/gamma up to 45 degrees."""
        angle = np.linspace(0.0, math.pi / 4, 46)[1:]
        moment = self.shear.moment(angle, self.thickness)
        if self.shear_friction is not None:
            moment = moment + self.shear_friction.moment_along(angle)
        return float(np.mean(moment / angle))

    @property
    def bending_stiffness_scale(self) -> float:
        """Typical bending stiffness [N m] that the director stabilisation scales with."""
        return self.bending.stiffness_scale(self.thickness)

    @property
    def largest_bending_stiffness(self) -> float:
        """Upper bound of the bending stiffness at any curvature [N m], for the stable step."""
        return self.bending.largest_stiffness(self.thickness)

    @property
    def transverse_shear_stiffness(self) -> float:
        """G_s = 5/6 G t [N/m]."""
        return 5.0 / 6.0 * self.transverse_shear_modulus * self.thickness

    def with_linear_shear(self, modulus: float) -> Fabric:
        """The same fabric with the paper's linear shear law."""
        return self.model_copy(update={"shear": LinearShear(modulus=modulus)})


def _given(value: Any) -> Any:
    """A dumped value without what is not given: TOML has no word for nothing."""
    if isinstance(value, dict):
        return {name: _given(item) for name, item in value.items() if item is not None}
    return [_given(item) for item in value] if isinstance(value, list | tuple) else value
