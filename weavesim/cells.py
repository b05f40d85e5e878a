"""Unit cells: the contract that every cell fulfils, the paper's plain weave, and others beside it.

A cell is a set of checked parameters and an energy per reference area, psi(warp stretch, weft stretch, shear angle; q)
with a few internal unknowns q. ``docs/tutorial_unit_cell.md`` makes one.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from .errors import InputError
from .parameters import NotNegative, Parameters, Positive, Share

if TYPE_CHECKING:
    from .device import Precision
    from .kernels.cell import CellLaw

# Relative residual that Newton's method reaches in a run of either precision: of the plain weave, which works in the
# precision of the run, and of all other cells, which work in double precision.
UNIT_CELL_TOLERANCE = {"float32": 2.0e-5, "float64": 1.0e-11}
ENERGY_CELL_TOLERANCE = {"float32": 1.0e-5, "float64": 1.0e-11}


class Cell(Parameters):
    """Base of all unit cells: what a sheet asks of one."""

    @abstractmethod
    def law(self) -> CellLaw:
        """Functions of the cell that the kernels are made with; equal for all cells of a class."""

    @abstractmethod
    def device_parameters(self, precision: Precision) -> Any:
        """The cell's constants in the struct of its law."""

    @property
    @abstractmethod
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        """Bounds C_1, C_2 [N/m] of the cell's stiffness along warp and weft, in any state.

        Twice the energy of a small change (e_1, e_2) of the stretches is at most C_1 e_1^2 + C_2 e_2^2. Time step,
        contact and mass scaling start from them.
        """

    @property
    def shear_stiffness(self) -> float:
        """Bound of dm/dgamma of the cell itself [N/m]; 0 if its energy does not depend on the shear angle."""
        return 0.0

    @property
    def crossover_area(self) -> float:
        """Reference area that carries one physical crossover [m^2], whose force is the pressure times it; 0: none."""
        return 0.0

    @property
    def has_crossovers(self) -> bool:
        """True if the cell tells the pressure between warp and weft, which friction in shear and compaction use."""
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
        """What a user should know before trusting this cell."""
        return []


class EnergyCell(Cell):
    """A cell that is told by its energy alone: a Warp function of doubles.

    A subclass declares its parameters as fields with their unit in the description, sets ``energy``, and says how
    stiff it is at most (``yarn_stiffness_per_width``, ``shear_stiffness``). The functions get a struct with all numbers
    among the fields (a ``parameters`` of its own can add derived ones), the two stretches, the shear angle [rad] and
    the vector of unknowns. Unknowns are dimensionless: a change of one is large.

    Attributes:
        law_name: in compiled code; subclasses that share their functions share it too. The name of the class if None.
        unknown_count: internal unknowns, 0 to 4; the energy is stationary by them.
        depends_on_shear: False spares the shear angle's part if the energy does not use it.
        energy: per reference area [J/m^2].
        parts: instead of ``energy``: a vector whose sum it is, for the ledger, in the order of ``part_names``.
        gradient: derivatives by the stretches, the angle and the unknowns, one vector, if they are known by hand.
        crossover_pressure: force between warp and weft per reference area [N/m^2].
    """

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
        """What the functions get, by name: numbers, and tuples of numbers."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: value for name, value in values.items() if isinstance(value, (int, float))}

    def law(self) -> CellLaw:
        """The cell's functions, compiled once for all cells of the class.

        Raises:
            InputError: an energy that is missing or not a Warp function, too many unknowns, parts without names.
        """
        import warp as wp

        from .kernels.cell import LARGEST_UNKNOWN_COUNT, energy_cell

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
        return energy_cell(
            self.law_name or name,
            tuple((name, np.size(value)) for name, value in self.parameters().items()),
            self.unknown_count,
            part_names=self.part_names,
            depends_on_shear=self.depends_on_shear,
            **functions,
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
            # forces below a thousandth of the stiffness are rather measured against that: rounding makes them noisy
            "force_floor": 1.0e-3 * max(*self.yarn_stiffness_per_width, self.shear_stiffness),
            "resolution": 32.0 * np.finfo(np.float64).eps / tolerance,
        }
        struct = self.law().parameters(precision.real)()
        for name, value in (self.parameters() | settings).items():
            vector = wp.types.vector(np.size(value), wp.float64)
            setattr(struct, name, vector(*value) if isinstance(value, tuple) else float(value))
        return struct


class CrossedYarns(Cell):
    """Warp and weft beam that cross at a contact element: the paper's parameters, and four of our own with defaults.

    A yarn's compressive stiffness E A_c defaults to the Euler-like 3 E I / l0^2: a yarn pushed together is a buckled
    bundle, and a stiffer one gives the cell several equilibria (``warnings`` tells).
    """

    warp_modulus: Positive = Field(description="Young's modulus of the warp yarn [Pa]")
    weft_modulus: Positive = Field(description="Young's modulus of the weft yarn [Pa]")
    contact_modulus: Positive = Field(description="Young's modulus E_3 of the contact element [Pa]")
    warp_cross_section: Positive = Field(description="cross-section of the warp yarn [m^2]")
    weft_cross_section: Positive = Field(description="cross-section of the weft yarn [m^2]")
    contact_cross_section: Positive = Field(
        description="cross-section A_3 of the contact element of the half cell [m^2]"
    )
    warp_second_moment: NotNegative = Field(description="second moment of area of the warp yarn [m^4]")
    weft_second_moment: NotNegative = Field(description="second moment of area of the weft yarn [m^4]")
    warp_half_spacing: Positive = Field(description="L_1, half distance between crossovers along the warp [m]")
    weft_half_spacing: Positive = Field(description="L_2, half distance between crossovers along the weft [m]")
    crossover_height: NotNegative = Field(description="L_3 = h_1 + h_2, distance of the yarn axes at the crossover [m]")
    warp_crimp_share: Share = Field(default=0.5, description="h_1 / L_3")
    warp_compressive_stiffness: NotNegative | None = Field(default=None, description="E A_c of the warp [N]")
    weft_compressive_stiffness: NotNegative | None = Field(default=None, description="E A_c of the weft [N]")
    contact: Literal["bilateral", "unilateral"] = Field(default="bilateral", description="may the yarns separate?")
    contact_stiffness_value: Positive | None = Field(
        default=None, description="E_3 A_3 / L_3 [N/m] given directly; needed where L_3 = 0"
    )

    @model_validator(mode="after")
    def _contact_is_defined(self) -> Self:
        if self.crossover_height == 0.0 and self.contact_stiffness_value is None:
            raise ValueError("crossover_height = 0 leaves E_3 A_3 / L_3 undefined: give contact_stiffness_value [N/m]")
        return self

    @property
    def half_spacing(self) -> tuple[float, float]:
        return self.warp_half_spacing, self.weft_half_spacing

    @property
    def crimp_height(self) -> tuple[float, float]:
        return self.warp_crimp_share * self.crossover_height, (1.0 - self.warp_crimp_share) * self.crossover_height

    @property
    def chord_length(self) -> tuple[float, float]:
        """l0 of warp and weft [m]."""
        return tuple(math.hypot(L, h) for L, h in zip(self.half_spacing, self.crimp_height, strict=True))

    @property
    def axial_stiffness(self) -> tuple[float, float]:
        """E A of warp and weft in tension [N]."""
        return self.warp_modulus * self.warp_cross_section, self.weft_modulus * self.weft_cross_section

    @property
    def bending_stiffness(self) -> tuple[float, float]:
        """E I of warp and weft [N m^2]."""
        return self.warp_modulus * self.warp_second_moment, self.weft_modulus * self.weft_second_moment

    @property
    def euler_stiffness(self) -> tuple[float, float]:
        """3 E I / l0^2 of warp and weft [N], the largest compressive stiffness known to leave one equilibrium."""
        return tuple(3.0 * EI / l0**2 for EI, l0 in zip(self.bending_stiffness, self.chord_length, strict=True))

    @property
    def compressive_stiffness(self) -> tuple[float, float]:
        """E A_c of warp and weft [N]."""
        given = (self.warp_compressive_stiffness, self.weft_compressive_stiffness)
        return tuple(e if g is None else g for g, e in zip(given, self.euler_stiffness, strict=True))

    @property
    def contact_stiffness(self) -> float:
        """E_3 A_3 / L_3 of the half cell [N/m]."""
        if self.contact_stiffness_value is not None:
            return self.contact_stiffness_value
        return self.contact_modulus * self.contact_cross_section / self.crossover_height

    @property
    def crossover_modulus(self) -> float:
        """Two half cells of stiffness E_3 A_3 / L_3 share the area of a crossover; they flatten by a share of L_3."""
        if self.crossover_height == 0.0:
            return math.inf
        return 2.0 * self.contact_stiffness * self.crossover_height / self.crossover_area

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        """E A over the spacing of the yarns: membrane stiffness of straight yarns [N/m]."""
        return (
            self.axial_stiffness[0] / (2.0 * self.weft_half_spacing),
            self.axial_stiffness[1] / (2.0 * self.warp_half_spacing),
        )

    def warnings(self) -> list[str]:
        """What a user should know before trusting this cell."""
        return [
            f"compressive stiffness of the {name} is {given:.4g} N, above the Euler-like {euler:.4g} N: the cell may "
            "have several equilibria; the branch from stretch 1 is followed and what a snap frees is booked"
            for name, given, euler in zip(
                ("warp", "weft"), self.compressive_stiffness, self.euler_stiffness, strict=True
            )
            if given > euler * (1.0 + 1.0e-9)
        ]


class UnitCell(CrossedYarns):
    """Plain-weave unit cell of crossed beams, written by hand for lanes: the paper's cell."""

    def law(self) -> CellLaw:
        from .kernels.plain_weave import PLAIN_WEAVE

        return PLAIN_WEAVE

    def device_parameters(self, precision: Precision) -> Any:
        import warp as wp

        cell = self.law().parameters(precision.real)()
        vec2 = wp.types.vector(2, precision.real)
        length = np.array(self.chord_length)
        cell.half_spacing = vec2(*self.half_spacing)
        cell.crimp_height = vec2(*self.crimp_height)
        cell.chord_length = vec2(*length)
        cell.tensile_stiffness = vec2(*(self.axial_stiffness / length))
        cell.compressive_stiffness = vec2(*(self.compressive_stiffness / length))
        cell.rotation_stiffness = vec2(*(3.0 * np.array(self.bending_stiffness) / length))
        cell.contact_stiffness = self.contact_stiffness
        cell.unilateral = int(self.contact == "unilateral")
        cell.tolerance = UNIT_CELL_TOLERANCE[precision.value]
        # four roundings of each of the two parts whose sum is the elongation
        cell.resolution = 4.0 * np.finfo(precision.numpy).eps / UNIT_CELL_TOLERANCE[precision.value]
        cell.stiffness_floor = 1.0e-9 * max(self.axial_stiffness) / length.max()
        cell.force_floor = 1.0e-9 * max(self.axial_stiffness)
        return cell

    @property
    def crossover_area(self) -> float:
        return 4.0 * self.warp_half_spacing * self.weft_half_spacing

    @classmethod
    def straight(cls, *, stiffness_per_width: float, spacing: float = 0.005, bending: float = 0.0) -> UnitCell:
        """Two straight, uncoupled yarn families of equal tensile and compressive stiffness: a linear membrane.

        Args:
            stiffness_per_width: E A over the yarn spacing [N/m].
            spacing: distance of the yarns [m].
            bending: E I of a yarn [N m^2].
        """
        axial = stiffness_per_width * spacing
        return cls(
            warp_modulus=axial, weft_modulus=axial, contact_modulus=1.0,
            warp_cross_section=1.0, weft_cross_section=1.0, contact_cross_section=1.0,
            warp_second_moment=bending / axial, weft_second_moment=bending / axial,
            warp_half_spacing=0.5 * spacing, weft_half_spacing=0.5 * spacing, crossover_height=0.0,
            warp_compressive_stiffness=axial, weft_compressive_stiffness=axial,
            contact_stiffness_value=axial / spacing,
        )  # fmt: skip


class FloatWeave(CrossedYarns, EnergyCell):
    """A weave whose yarns float over several others: crimped beams of the plain weave, in series with straight floats.

    In a repeat of N crossovers every yarn changes sides twice; the beams are as long as in a plain weave, the other
    N - 2 crossover distances are floats. N = 2 is the plain weave. Unknowns: the height changes at the crossover over
    their scale, and the strains of the floats. The floats stay straight and level: an idealisation.
    """

    law_name: ClassVar[str] = "FloatWeave"
    unknown_count: ClassVar[int] = 4
    depends_on_shear: ClassVar[bool] = False
    part_names: ClassVar[tuple[str, ...]] = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact")

    repeat: int = Field(ge=2, le=16, description="N, crossovers in a repeat along a yarn")

    def functions(self) -> dict[str, Any]:
        from .kernels.cells import floats_crossover_pressure, floats_energies

        return {"parts": floats_energies, "crossover_pressure": floats_crossover_pressure}

    def parameters(self) -> dict[str, float | tuple[float, ...]]:
        return {
            "half_spacing": self.half_spacing,
            "crimp_height": self.crimp_height,
            "chord_length": self.chord_length,
            "float_length": tuple((0.5 * self.repeat - 1.0) * spacing for spacing in self.half_spacing),
            "axial_stiffness": self.axial_stiffness,
            "compressive_stiffness": self.compressive_stiffness,
            "bending_stiffness": self.bending_stiffness,
            "contact_stiffness": self.contact_stiffness,
            "unilateral": float(self.contact == "unilateral"),
            "height_scale": max(self.crossover_height, 0.05 * min(self.half_spacing)),
            # per pair of half beams; 2 L_1 L_2 in a plain weave
            "area": self.repeat * self.warp_half_spacing * self.weft_half_spacing,
        }

    @property
    def crossover_area(self) -> float:
        """Of a crossover at which the yarns are bent: those within floats carry nothing."""
        return 2.0 * self.repeat * self.warp_half_spacing * self.weft_half_spacing


class TwillWeave(FloatWeave):
    """2/2 twill: over two, under two."""

    repeat: Literal[4] = 4


class SatinWeave(FloatWeave):
    """Satin of five or eight harnesses: over all but one."""

    repeat: Literal[5, 8] = Field(default=5, description="harnesses")


class UnidirectionalTape(EnergyCell):
    """Stiff tows along the warp direction, held together by stitches that zigzag across them.

    The stitches' two diagonals carry tension only, once their slack is used up; thread may slip from one to the other
    against a stiffness. They depend on both stretches and on the shear angle.
    """

    unknown_count: ClassVar[int] = 1
    part_names: ClassVar[tuple[str, ...]] = ("tow", "stitch", "tow_to_tow")

    tow_stiffness: Positive = Field(description="E A of the tows over their spacing [N/m]")
    tow_compressive_stiffness: NotNegative = Field(description="the same where they are pushed together [N/m]")
    stitch_stiffness: NotNegative = Field(
        description="k of the energy 1/2 k strain^2 per area of one diagonal in tension [N/m]"
    )
    slip_stiffness: Positive = Field(
        description="of the energy 1/2 k slip^2 per area, where slip is the strain passed from one diagonal on [N/m]"
    )
    stitch_pitch: Positive = Field(description="way of a diagonal along the tows [m]")
    tow_spacing: Positive = Field(description="way of a diagonal across the tows [m]")
    stitch_slack: NotNegative = Field(default=0.0, description="strain of a diagonal at which it begins to pull")
    transverse_stiffness: NotNegative = Field(
        default=0.0, description="across tows pulled apart, without stitches [N/m]"
    )
    transverse_compressive_stiffness: NotNegative = Field(
        default=0.0, description="across tows pushed together, without stitches [N/m]"
    )

    def functions(self) -> dict[str, Any]:
        from .kernels.cells import tape_energies

        return {"parts": tape_energies}

    @model_validator(mode="after")
    def _holds_across(self) -> Self:
        if self.stitch_stiffness == 0.0 and self.transverse_stiffness == 0.0:
            raise ValueError(
                "stitch_stiffness = 0, transverse_stiffness = 0: nothing holds the tows together, give one"
            )
        return self

    @property
    def _stitch_bounds(self) -> tuple[float, float, float]:
        """Of the stitches alone, for both stretches and the angle [N/m].

        A diagonal's strain changes by at most s per warp stretch, t per weft stretch, the smaller of both per angle,
        with s and t the shares of its two legs; (sum a_i e_i)^2 is at most (sum a_i) (sum a_i e_i^2).
        """
        length = math.hypot(self.stitch_pitch, self.tow_spacing)
        s, t = self.stitch_pitch / length, self.tow_spacing / length
        r = min(s, t)
        return tuple(2.0 * self.stitch_stiffness * (s + t + r) * share for share in (s, t, r))

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        along, across, _ = self._stitch_bounds
        tow = max(self.tow_stiffness, self.tow_compressive_stiffness)
        return tow + along, max(self.transverse_stiffness, self.transverse_compressive_stiffness) + across

    @property
    def shear_stiffness(self) -> float:
        return self._stitch_bounds[2]


class LinearMembrane(EnergyCell):
    """n_1 = C_11 e_1 + C_12 e_2, n_2 = C_12 e_1 + C_22 e_2, with e = stretch - 1; no shear, no unknowns."""

    depends_on_shear: ClassVar[bool] = False

    warp_stiffness: Positive = Field(description="C_11 [N/m]")
    weft_stiffness: Positive = Field(description="C_22 [N/m]")
    coupling_stiffness: float = Field(default=0.0, allow_inf_nan=False, description="C_12 [N/m]")

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        if self.coupling_stiffness**2 > self.warp_stiffness * self.weft_stiffness:
            raise ValueError(
                f"coupling_stiffness = {self.coupling_stiffness:.4g} N/m: its square may not exceed "
                "warp_stiffness * weft_stiffness, or stretching releases energy"
            )
        return self

    def functions(self) -> dict[str, Any]:
        from .kernels.cells import membrane_energy, membrane_gradient

        return {"energy": membrane_energy, "gradient": membrane_gradient}

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        coupling = abs(self.coupling_stiffness)
        return self.warp_stiffness + coupling, self.weft_stiffness + coupling
