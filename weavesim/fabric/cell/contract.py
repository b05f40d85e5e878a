"""The contract that every unit cell fulfils.

A cell is a set of checked parameters and an energy per reference area, psi(warp stretch, weft stretch, shear angle; q)
with a few internal unknowns q. ``docs/tutorial_unit_cell.md`` shows how to write one.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...checks import Kinded
from ...errors import InputError

if TYPE_CHECKING:
    from ...device import Precision
    from ...kernels.cell.law import CellLaw

# Relative residual that Newton's method reaches in a run of either precision: of the plain weave, which works in the
# precision of the run, and of all other cells, which work in double precision.
UNIT_CELL_TOLERANCE = {"float32": 2.0e-5, "float64": 1.0e-11}
ENERGY_CELL_TOLERANCE = {"float32": 1.0e-5, "float64": 1.0e-11}


class UnitCell(Kinded):
    """Base class of all unit cells: their interface to the sheet."""

    @classmethod
    def examples(cls) -> dict[str, Callable[[], UnitCell]]:
        """One or a few cells of this kind by preset name, for trials, tests and benchmarks; {} for none."""
        return {}

    @abstractmethod
    def law(self) -> CellLaw:
        """Functions of the cell that are compiled into the kernels; the same for all cells of a class."""

    @abstractmethod
    def device_parameters(self, precision: Precision) -> Any:
        """The cell's constants in the struct of its law."""

    @property
    @abstractmethod
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        """Upper bounds C_1, C_2 [N/m] of the cell's stiffness along warp and weft, in any state.

        Twice the energy of a small change (e_1, e_2) of the stretches is at most C_1 e_1^2 + C_2 e_2^2. Time step,
        contact and mass scaling are based on them.
        """

    @property
    def shear_stiffness(self) -> float:
        """Upper bound of dm/dgamma of the cell itself [N/m]; 0 if its energy does not depend on the shear angle."""
        return 0.0

    @property
    def crossover_area(self) -> float:
        """Reference area per physical crossover [m^2]: crossover force = pressure times this area; 0 for none."""
        return 0.0

    @property
    def has_crossovers(self) -> bool:
        """True if the cell reports the pressure between warp and weft, which shear friction and compaction use."""
        return self.crossover_area > 0.0

    @property
    def crossover_modulus(self) -> float:
        """Pressure of the crossovers over their relative flattening [Pa]; infinite if they do not flatten."""
        return math.inf

    @property
    def initial_unknowns(self) -> tuple[float, ...]:
        """Internal unknowns of the undeformed sheet, at which the cell carries no force."""
        return (0.0,) * self.law().unknown_count

    def warnings(self) -> list[str]:
        """Warnings about this cell for the user."""
        return []


class EnergyCell(UnitCell):
    """A cell defined by its energy alone: a Warp function of doubles.

    A subclass declares its parameters as fields with their unit in the description, sets ``energy``, and gives upper
    bounds of its stiffness (``yarn_stiffness_per_width``, ``shear_stiffness``). The functions get a struct with all
    numerical fields (override ``parameters`` to add derived values), the two stretches, the shear angle [rad] and
    the vector of unknowns. Unknowns are dimensionless, scaled so that a change of 1 is large.

    Attributes:
        law_name: in compiled code, common to subclasses that share their functions; None uses the class name.
        unknown_count: internal unknowns, 0 to 4; the energy is stationary with respect to them.
        depends_on_shear: False if the energy does not use the shear angle, which saves computing that part.
        energy: per reference area [J/m^2].
        parts: instead of ``energy``: a vector whose sum is the energy, for the ledger, in the order of ``part_names``.
        gradient: optional hand-written derivatives with respect to stretches, angle and unknowns, in one vector.
        crossover_pressure: force between warp and weft per reference area [N/m^2].
    """

    is_kind: ClassVar[bool] = False

    law_name: ClassVar[str | None] = None
    unknown_count: ClassVar[int] = 0
    depends_on_shear: ClassVar[bool] = True
    part_names: ClassVar[tuple[str, ...]] = ("unit_cell",)
    energy: ClassVar[Any] = None
    parts: ClassVar[Any] = None
    gradient: ClassVar[Any] = None
    crossover_pressure: ClassVar[Any] = None

    def functions(self) -> dict[str, Any]:
        """The Warp functions by name; the same for all cells of a class."""
        return {name: getattr(self, name) for name in ("energy", "parts", "gradient", "crossover_pressure")}

    @property
    def has_crossovers(self) -> bool:
        return self.functions().get("crossover_pressure") is not None

    def parameters(self) -> dict[str, float | tuple[float, ...]]:
        """Parameters for the functions, by name: numbers and tuples of numbers."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: value for name, value in values.items() if isinstance(value, (int, float))}

    def law(self) -> CellLaw:
        """The cell's functions, compiled once for all cells of the class.

        Raises:
            InputError: an energy that is missing or not a Warp function, too many unknowns, parts without names.
        """
        import warp as wp

        from ...kernels.cell.energy_cell import CellFunctions
        from ...kernels.cell.energy_lanes import energy_law
        from ...kernels.cell.law import LARGEST_UNKNOWN_COUNT

        name = type(self).__name__
        functions = {label: function for label, function in self.functions().items() if function is not None}
        if not {"energy", "parts"} & set(functions):
            raise InputError(f"{name}: no energy is given: set energy, or parts, to a Warp function")
        for label, function in functions.items():
            if not isinstance(function, wp.Function):
                raise InputError(f"{name}: {label} = {function!r} is not a Warp function: decorate it with @wp.func")
        if not 0 <= self.unknown_count <= LARGEST_UNKNOWN_COUNT:
            raise InputError(
                f"{name}: unknown_count = {self.unknown_count}: 0 to {LARGEST_UNKNOWN_COUNT} unknowns are possible"
            )
        if "parts" not in functions and len(self.part_names) != 1:
            raise InputError(f"{name}: {len(self.part_names)} part_names but no parts: an energy alone has one name")
        return energy_law(
            self.law_name or name,
            tuple((name, np.size(value)) for name, value in self.parameters().items()),
            self.unknown_count,
            CellFunctions(**functions),
            self.part_names,
            self.depends_on_shear,
        )

    def device_parameters(self, precision: Precision) -> Any:
        import warp as wp

        if len(self.initial_unknowns) != self.unknown_count:
            raise InputError(
                f"{type(self).__name__}: {len(self.initial_unknowns)} initial_unknowns, but unknown_count is "
                f"{self.unknown_count}"
            )
        tolerance = ENERGY_CELL_TOLERANCE[precision.value]
        settings = {
            "tolerance": tolerance,
            # residuals are never relative to less than a thousandth of the stiffness: smaller forces are noise
            "force_floor": 1.0e-3 * max(*self.yarn_stiffness_per_width, self.shear_stiffness),
            "resolution": 32.0 * np.finfo(np.float64).eps / tolerance,
        }
        law = self.law()
        values: dict[str, Any] = self.parameters()
        if law.constants is not None:
            values = {"constants": tuple(law.constants(by_component(values) | settings))}
        struct = law.parameters(precision.real)()
        for name, value in (values | settings).items():
            vector = wp.types.vector(np.size(value), wp.float64)
            setattr(struct, name, vector(*value) if isinstance(value, tuple) else float(value))
        return struct


def by_component(parameters: dict[str, float | tuple[float, ...]]) -> dict[str, float]:
    """Parameters as single numbers ``name[k]``."""
    return {f"{name}[{k}]": entry for name, value in parameters.items() for k, entry in enumerate(np.atleast_1d(value))}
