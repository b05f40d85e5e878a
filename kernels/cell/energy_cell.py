"""Unit cells from arbitrary energies (docs/theory.md, section 2).

For the strains of an element, warp stretch - 1, weft stretch - 1 and shear angle, a cell returns the derivatives of its
energy psi per reference area: n_1 = dpsi/dlambda_1, n_2 = dpsi/dlambda_2, m = dpsi/dgamma. It may have internal
unknowns q with dpsi/dq = 0. Kernels are generated for one cell, with its functions compiled into them.

``energy_cell`` makes a cell from one scalar function. Its derivatives are from ``wp.grad`` unless given, second
derivatives from differences of the first. It works in double precision whatever the precision of the run, lane by
lane: differences, and energies that are compared, then have sufficient digits, and single precision only rounds input
and output. A cell works like this where its energy cannot be read as a formula, which a warning says; where it can,
``energy_lanes`` makes the cell, for all lanes at once and with exact derivatives.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp
from warp import float64 as real

from .law import CellLaw
from .newton import CellEnergy, condensed_tangent_function, emitted_late, equilibrium_function

# A larger change of an unknown in one time step may be a snap.
SNAP_CHANGE = wp.constant(real(0.05))
# Tangents are also taken in tension: with slack yarns stretched by this much.
PULL = wp.constant(real(1.0e-3))


@cache
def parameter_struct(name: str, fields: tuple[tuple[str, int], ...]):
    """A struct with a double, or a vector of ``length`` doubles, per field, and the settings of the iteration."""

    def kind(length: int):
        return wp.float64 if length == 1 else wp.types.vector(length, wp.float64)

    members = {field: kind(length) for field, length in fields}
    members |= {"tolerance": wp.float64, "force_floor": wp.float64, "resolution": wp.float64}
    return wp.struct(type(name, (), {"__annotations__": members, "__module__": __name__}))


@dataclass(frozen=True)
class CellFunctions:
    """Warp functions of (parameters, warp stretch, weft stretch, shear angle, q), all per reference area.

    All arguments are doubles, q is a vector of at least one double. The unknowns are dimensionless, scaled so that a
    change of 1 is large.

    Attributes:
        energy: psi [J/m^2]; optional if ``parts`` is given.
        parts: a vector with the parts of the energy, for the ledger.
        gradient: optional: a vector with the hand-written derivatives with respect to warp stretch, weft stretch, shear
            angle and the unknowns.
        crossover_pressure: force between warp and weft [N/m^2].
    """

    energy: wp.Function | None = None
    parts: wp.Function | None = None
    gradient: wp.Function | None = None
    crossover_pressure: wp.Function | None = None


@cache
def energy_cell(
    name: str,
    fields: tuple[tuple[str, int], ...],
    unknown_count: int,
    functions: CellFunctions,
    part_names: tuple[str, ...] = ("unit_cell",),
    depends_on_shear: bool = True,
) -> CellLaw:
    """A cell from its energy.

    Args:
        name: for messages.
        fields: names and lengths of the parameters in the struct that the functions get.
        unknown_count: length of q; 0 if there are no unknowns.
        functions: the energy and optional functions.
        part_names: of the energy.
        depends_on_shear: False if the shear angle is not used.
    """
    Parameters, energy, parts = parameter_struct(name, fields), functions.energy, functions.parts
    if energy is None:
        energy = sum_function(Parameters, unknown_count, parts, len(part_names))
    cell = cell_energy(Parameters, unknown_count, energy, functions.gradient)
    lane_state, condensed = lane_state_function(cell), condensed_tangent_function(cell)
    crossover_of = crossover_function(cell, functions.crossover_pressure)
    solve, stable_tangent = solution_functions(cell, crossover_of, condensed, lane_state)
    energies = energies_function(cell, parts_function(cell, parts, len(part_names)), len(part_names), lane_state)
    return CellLaw(
        name=name,
        parameters=lambda precision: Parameters,
        unknown_count=unknown_count,
        energy_names=part_names,
        depends_on_shear=depends_on_shear,
        lane_by_lane=True,
        stable_state_count=2,
        solve=solve,
        energies=energies,
        tangent=tangent_function(condensed, lane_state),
        stable_tangent=stable_tangent,
        snap_loss=snap_loss_function(cell, lane_state),
    )


# --- the energy as a function of one vector, and its derivatives ------------------------------------------------------


def sum_function(Parameters: Any, unknown_count: int, parts: wp.Function, part_count: int) -> wp.Function:
    """The energy as the sum of its parts, with their arguments."""
    unknowns = wp.types.vector(max(unknown_count, 1), real)

    @wp.func
    def total_energy(p: Parameters, warp_stretch: real, weft_stretch: real, shear_angle: real, q: unknowns):
        values = parts(p, warp_stretch, weft_stretch, shear_angle, q)
        total = real(0.0)
        for k in range(part_count):
            total = total + values[k]
        return total

    return total_energy


def unknowns_function(n: int) -> wp.Function:
    """Warp function x -> q."""
    vector, unknowns = wp.types.vector(3 + n, real), wp.types.vector(max(n, 1), real)

    @wp.func
    def unknowns_of(x: vector):
        q = unknowns()
        for k in range(n):
            q[k] = x[3 + k]
        return q

    return unknowns_of


def cell_energy(Parameters: Any, n: int, energy: wp.Function, gradient: wp.Function | None) -> CellEnergy:
    """The energy as a function of one vector; its gradient hand-written, or from ``wp.grad``."""
    vector, unknowns_of = wp.types.vector(3 + n, real), unknowns_function(n)

    @wp.func
    def energy_of(p: Parameters, x: vector):
        return energy(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))

    if gradient is not None:

        @wp.func
        def gradient_of(p: Parameters, x: vector):
            return gradient(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))

    else:

        @wp.func
        def gradient_of(p: Parameters, x: vector):
            by_parameters, by_x = wp.grad(energy_of)(p, x)
            return by_x

    return CellEnergy(n, Parameters, vector, energy_of, gradient_of)


def parts_function(cell: CellEnergy, parts: wp.Function | None, part_count: int) -> wp.Function:
    """Warp function (p, x) -> vector of the energy's parts; without parts, the energy is the only one."""
    Parameters, vector, energy_of = cell.parameters, cell.vector, cell.energy
    unknowns_of = unknowns_function(cell.unknown_count)
    part_vector, has_parts = wp.types.vector(part_count, real), parts is not None

    @wp.func
    def parts_of(p: Parameters, x: vector):
        values = part_vector()
        if wp.static(has_parts):
            values = parts(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))
        else:
            values[0] = energy_of(p, x)
        return values

    return parts_of


def crossover_function(cell: CellEnergy, pressure_of: wp.Function | None) -> wp.Function:
    """Warp function (p, x) -> force between warp and weft per reference area; zero if the cell has none."""
    Parameters, vector, unknowns_of = cell.parameters, cell.vector, unknowns_function(cell.unknown_count)
    has_crossover = pressure_of is not None

    @wp.func
    def crossover_of(p: Parameters, x: vector):
        pressure = real(0.0)
        if wp.static(has_crossover):
            pressure = pressure_of(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))
        return pressure

    return crossover_of


# --- the contract of kernels/cell/law.py, lane by lane ----------------------------------------------------------------
# Loops over lanes are not unrolled: sixteen lanes of Newton's method would be sixteen copies of it.


def lane_state_function(cell: CellEnergy) -> wp.Function:
    """Warp function (strains, q, lane) -> x."""
    n, vector = cell.unknown_count, cell.vector

    @wp.func
    def lane_state(strain1: Any, strain2: Any, angle: Any, q: Any, i: int):
        x = vector()
        x[0] = real(strain1[i])
        x[1] = real(strain2[i])
        x[2] = real(angle[i])
        for k in range(n):
            x[3 + k] = real(q[k, i])
        return x

    return lane_state


def solution_functions(
    cell: CellEnergy, crossover_of: wp.Function, condensed: wp.Function, lane_state: wp.Function
) -> tuple[wp.Function, wp.Function]:
    """``solve`` and ``stable_tangent``."""
    n, equilibrium, energy_of = cell.unknown_count, equilibrium_function(cell), cell.energy

    @wp.func
    def solve(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, answer: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        q = type(start)()
        force1 = type(strain1)()
        force2 = type(strain1)()
        moment = type(strain1)()
        pressure = type(strain1)()
        energy = type(strain1)()
        residual = type(strain1)()
        iterations = type(strain1)()
        i = wp.int32(0)
        while i < len(strain1):
            x, g, worst, count = equilibrium(p, lane_state(strain1, strain2, angle, start, i))
            for k in range(n):
                q[k, i] = strain1.dtype(x[3 + k])
            force1[i] = strain1.dtype(g[0])
            force2[i] = strain1.dtype(g[1])
            moment[i] = strain1.dtype(g[2])
            pressure[i] = strain1.dtype(crossover_of(p, x))
            energy[i] = strain1.dtype(energy_of(p, x))
            residual[i] = strain1.dtype(worst)
            iterations[i] = strain1.dtype(count)
            i = i + 1
        return type(answer)(force1, force2, moment, pressure, energy, residual, iterations, q)

    @wp.func
    def stable_tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int, t: Any):
        """State 0: the current one; 1: the same, with slack yarns just pulled taut."""
        _late = wp.grad(emitted_late)(real(0.0))
        c11 = type(strain1)()
        c12 = type(strain1)()
        c22 = type(strain1)()
        c13 = type(strain1)()
        c23 = type(strain1)()
        c33 = type(strain1)()
        force1 = type(strain1)()
        force2 = type(strain1)()
        moment = type(strain1)()
        pressure = type(strain1)()
        i = wp.int32(0)
        while i < len(strain1):
            x = lane_state(strain1, strain2, angle, q, i)
            if state == 1:
                x[0] = wp.max(x[0], real(0.0)) + PULL
                x[1] = wp.max(x[1], real(0.0)) + PULL
            x, g, residual, iterations = equilibrium(p, x)
            c = condensed(p, x)
            c11[i] = strain1.dtype(c[0])
            c12[i] = strain1.dtype(c[1])
            c22[i] = strain1.dtype(c[2])
            c13[i] = strain1.dtype(c[3])
            c23[i] = strain1.dtype(c[4])
            c33[i] = strain1.dtype(c[5])
            force1[i] = strain1.dtype(g[0])
            force2[i] = strain1.dtype(g[1])
            moment[i] = strain1.dtype(g[2])
            pressure[i] = strain1.dtype(crossover_of(p, x))
            i = i + 1
        return type(t)(c11, c12, c22, c13, c23, c33, force1, force2, moment, pressure)

    return solve, stable_tangent


def energies_function(cell: CellEnergy, parts_of: wp.Function, part_count: int, lane_state: wp.Function) -> wp.Function:
    """wp.func ``energies`` of the ``CellLaw``, one lane at a time."""

    @wp.func
    def energies(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
        values = parts_of(p, lane_state(strain1, strain2, angle, q, 0))
        result = wp.matrix(shape=(part_count, 1), dtype=area.dtype)
        for k in range(part_count):
            result[k, 0] = area[0] * area.dtype(values[k])
        return result

    return energies


def tangent_function(condensed: wp.Function, lane_state: wp.Function) -> wp.Function:
    """wp.func ``tangent`` of the ``CellLaw``, of one lane."""

    @wp.func
    def lane(like: Any, value: real):
        return type(like)(like.dtype(value))

    @wp.func
    def tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, t: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        c = condensed(p, lane_state(strain1, strain2, angle, q, 0))
        zero = type(strain1)()
        return type(t)(
            lane(zero, c[0]),
            lane(zero, c[1]),
            lane(zero, c[2]),
            lane(zero, c[3]),
            lane(zero, c[4]),
            lane(zero, c[5]),
            zero,
            zero,
            zero,
            zero,
        )

    return tangent


def snap_loss_function(cell: CellEnergy, lane_state: wp.Function) -> wp.Function:
    """wp.func ``snap_loss`` of the ``CellLaw``, one lane at a time."""
    n, energy_of, gradient_of = cell.unknown_count, cell.energy, cell.gradient

    @wp.func
    def snap_loss(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        loss = type(strain1)()
        i = wp.int32(0)
        while i < len(strain1):
            before = lane_state(strain1, strain2, angle, start, i)
            after = lane_state(strain1, strain2, angle, q, i)
            jump = real(0.0)
            for k in range(n):
                jump = wp.max(jump, wp.abs(after[3 + k] - before[3 + k]))
            if jump > SNAP_CHANGE:
                freed = energy_of(p, before) - energy_of(p, after)
                # descending, a convex energy releases less than its initial slope predicts: that is a fast but steady
                # change, whose work was done by the forces
                g = gradient_of(p, before)
                promised = real(0.0)
                for k in range(n):
                    promised = promised + g[3 + k] * (before[3 + k] - after[3 + k])
                if freed > promised:
                    loss[i] = strain1.dtype(freed)
            i = i + 1
        return loss

    return snap_loss
