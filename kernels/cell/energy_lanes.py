"""Unit cells from arbitrary energies, all lanes at once (docs/theory.md, section 2).

The functions of a cell are read as formulas; their derivatives are exact, and what is computed in every iteration is
compiled as one loop over the lanes. All of it is in double precision whatever the precision of the run: energies that
are compared, and stiff members in balance, then have sufficient digits, and single precision only rounds input and
output.
"""

import logging
from collections.abc import Sequence
from functools import cache
from typing import Any

import warp as wp
from warp import float64 as real

from ..formula.values import Unreadable
from ..formula.writer import Constants, lane_loop
from ..lanes import (
    ALL_LANE_TYPES,
    CPU_LANE_COUNT,
    GPU_LANE_COUNT,
    fill,
    lane_maximum,
    lane_types,
    larger,
    magnitude,
    where_positive,
)
from ..operators import div, mul  # noqa: F401
from .cell_formulas import STRAIN_COUNT, TANGENT_ENTRIES, CellFormulas, cell_formulas
from .energy_cell import CellFunctions, energy_cell
from .lane_newton import FORCE, SHIFT_COUNT, SLOPE, equilibrium_function, next_shift
from .law import CellLaw

logger = logging.getLogger(__name__)

# A larger change of an unknown in one time step may be a snap.
SNAP_CHANGE = wp.constant(real(0.05))
# Tangents are also taken in tension: with slack yarns stretched by this much.
PULL = wp.constant(real(1.0e-3))

for _types in ALL_LANE_TYPES:
    _double = lane_types(real, _types.lane_count).lanes

    @wp.func_native(f"""
        wp::vec_t<{_types.lane_count}, wp::{_types.real.__name__}> result;
        for (int i = 0; i < {_types.lane_count}; ++i)
            result[i] = a[i];
        return result;
    """)
    def narrowed(a: _double, like: _types.lanes) -> _types.lanes:
        """Lanes of double precision in the precision of ``like``."""


@cache
def constants_struct(count: int) -> Any:
    """The constants of a cell's formulas, and the settings of the iteration."""

    @wp.struct
    class Constants:
        constants: wp.types.vector(max(count, 1), real)
        tolerance: real  # of the relative residual
        force_floor: real  # smallest force that a residual is compared with [N/m]
        resolution: real  # rounding of a force over tolerance and stiffness

    return Constants


@cache
def energy_law(
    name: str,
    fields: tuple[tuple[str, int], ...],
    unknown_count: int,
    functions: CellFunctions,
    part_names: tuple[str, ...] = ("unit_cell",),
    depends_on_shear: bool = True,
) -> CellLaw:
    """A cell from its Warp functions: in lanes if they can be read as formulas, else lane by lane.

    Args:
        name: for messages.
        fields: names and lengths of the parameters.
        unknown_count: length of q; 0 if there are no unknowns.
        functions: the energy and optional functions.
        part_names: of the energy.
        depends_on_shear: False if the shear angle is not used.
    """
    try:
        formulas = cell_formulas(fields, unknown_count, functions)
    except Unreadable as refusal:
        logger.warning("%s: computed lane by lane, several times slower: %s", name, refusal)
        return energy_cell(name, fields, unknown_count, functions, part_names, depends_on_shear)
    return lane_cell(name, formulas, part_names, depends_on_shear)


def lane_cell(
    name: str,
    formulas: CellFormulas,
    part_names: tuple[str, ...] = ("unit_cell",),
    depends_on_shear: bool = True,
) -> CellLaw:
    """A cell from the formulas of its energy."""
    n, constants = len(formulas.state) - STRAIN_COUNT - 1, Constants()
    first, newton, tangent, parts = compiled_functions(name, formulas, constants)
    equilibrium = equilibrium_function(n, first, newton) if n else at_rest_function(first)
    state_of, unknowns_of = state_functions(n)
    tangents = tangent_functions(n, equilibrium, tangent, state_of)
    return CellLaw(
        name=name,
        parameters=lambda precision: constants_struct(len(constants)),
        constants=constants.values,
        unknown_count=n,
        energy_names=part_names,
        depends_on_shear=depends_on_shear,
        lane_by_lane=False,
        stable_state_count=2,
        solve=solve_function(n, equilibrium, state_of, unknowns_of),
        energies=energies_function(parts, state_of, len(part_names)),
        tangent=tangents[0],
        stable_tangent=tangents[1],
        snap_loss=snap_loss_function(n, first, state_of),
    )


# --- compiled formulas ------------------------------------------------------------------------------------------------


def compiled_functions(name: str, formulas: CellFormulas, constants: Constants) -> list[wp.Function]:
    """Warp functions (p, x) -> a row of lanes per formula, of ``first``, ``newton``, ``tangent`` and ``parts``."""
    read = {symbol: f"x.data[{row}][i]" for row, symbol in enumerate(formulas.state)}
    groups = {"first": formulas.first, "newton": formulas.newton, "tangent": formulas.tangent, "parts": formulas.parts}
    counts = (GPU_LANE_COUNT, CPU_LANE_COUNT)
    # all of them first: together they determine the constants
    written = {
        group: [lane_loop(outputs, constants, read, count, "double") for count in counts]
        for group, outputs in groups.items()
    }
    Cell = constants_struct(len(constants))
    return [
        compiled_function(f"{group}_of_{name}", written[group], Cell, len(formulas.state), len(outputs))
        for group, outputs in groups.items()
    ]


def compiled_function(name: str, written: Sequence[str], Cell: Any, state_rows: int, rows: int) -> wp.Function:
    """One Warp function with an overload for every number of lanes."""
    for count, snippet in zip((GPU_LANE_COUNT, CPU_LANE_COUNT), written, strict=True):
        State, Rows = wp.types.matrix((state_rows, count), real), wp.types.matrix((rows, count), real)

        # the second is an overload of the first, since it has its name
        @wp.func_native(snippet)
        def compiled(p: Cell, x: State) -> Rows: ...

    return compiled


# --- the contract of kernels/cell/law.py ------------------------------------------------------------------------------


@cache
def state_functions(n: int) -> tuple[wp.Function, wp.Function]:
    """Warp functions (strains, q) -> x, and (x, matrix like q) -> q."""
    for types in ALL_LANE_TYPES:
        lanes, count = types.lanes, types.lane_count
        State = wp.types.matrix((STRAIN_COUNT + n + 1, count), real)
        Unknowns = wp.types.matrix((max(n, 1), count), types.real)

        rows = ("strain1[i]", "strain2[i]", "angle[i]", *(f"q.data[{k}][i]" for k in range(n)), "0.0")
        to_state = "".join(f"result.data[{row}][i] = double({value});" for row, value in enumerate(rows))
        back = "".join(f"result.data[{k}][i] = x.data[{STRAIN_COUNT + k}][i];" for k in range(n))
        loops = [f"for (int i = 0; i < {count}; ++i) {{ {body} }} return result;" for body in (to_state, back)]
        kind = f"wp::mat_t<{max(n, 1)}, {count}, wp::{types.real.__name__}>"

        @wp.func_native(f"wp::mat_t<{len(rows)}, {count}, wp::float64> result; {loops[0]}")
        def state_of(strain1: lanes, strain2: lanes, angle: lanes, q: Unknowns) -> State: ...

        @wp.func_native(f"{kind} result; {loops[1]}")
        def unknowns_of(x: State, like: Unknowns) -> Unknowns: ...

    return state_of, unknowns_of


def at_rest_function(first: wp.Function) -> Any:
    """``equilibrium`` of a cell without unknowns."""

    @wp.func
    def equilibrium(p: Any, x: Any):
        y = first(p, x)
        # not a number if a force is not
        residual = y.dtype(0.0) * (y[SLOPE] + y[SLOPE + 1] + y[SLOPE + 2])
        return x, y, residual, fill(residual, 0.0)

    return equilibrium


def solve_function(n: int, equilibrium: Any, state_of: wp.Function, unknowns_of: wp.Function) -> Any:
    pressure_row = FORCE + n

    @wp.func
    def solve(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, answer: Any):
        x, y, residual, iterations = equilibrium(p, state_of(strain1, strain2, angle, start))
        return type(answer)(
            narrowed(y[SLOPE], strain1),
            narrowed(y[SLOPE + 1], strain1),
            narrowed(y[SLOPE + 2], strain1),
            narrowed(y[pressure_row], strain1),
            narrowed(y[0], strain1),
            narrowed(residual, strain1),
            narrowed(iterations, strain1),
            unknowns_of(x, start),
        )

    return solve


def energies_function(parts: wp.Function, state_of: wp.Function, part_count: int) -> Any:
    @wp.func
    def energies(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
        values = parts(p, state_of(strain1, strain2, angle, q))
        result = wp.matrix(shape=(part_count, 1), dtype=area.dtype)
        for k in range(part_count):
            result[k] = area * narrowed(values[k], area)
        return result

    return energies


def tangent_functions(
    n: int, equilibrium: Any, tangent_at: wp.Function, state_of: wp.Function
) -> tuple[wp.Function, wp.Function]:
    """``tangent`` and ``stable_tangent``."""
    shift_row, definite_row, pressure_row = STRAIN_COUNT + n, len(TANGENT_ENTRIES), FORCE + n

    @wp.func
    def definite_tangent(p: Any, x: Any):
        zero = fill(x[0], 0.0)
        x[shift_row] = zero
        c = tangent_at(p, x)
        for _attempt in range(SHIFT_COUNT):
            indefinite = where_positive(c[definite_row], zero, fill(zero, 1.0))
            if lane_maximum(indefinite) <= zero[0]:
                break
            x[shift_row] = where_positive(indefinite, next_shift(x[shift_row]), x[shift_row])
            c = tangent_at(p, x)
        return c

    @wp.func
    def as_tangent(c: Any, y: Any, like: Any, t: Any):
        return type(t)(
            narrowed(c[0], like),
            narrowed(c[1], like),
            narrowed(c[2], like),
            narrowed(c[3], like),
            narrowed(c[4], like),
            narrowed(c[5], like),
            narrowed(y[SLOPE], like),
            narrowed(y[SLOPE + 1], like),
            narrowed(y[SLOPE + 2], like),
            narrowed(y[pressure_row], like),
        )

    @wp.func
    def tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, t: Any):
        c = definite_tangent(p, state_of(strain1, strain2, angle, q))
        zero = fill(strain1, 0.0)
        return type(t)(
            narrowed(c[0], zero),
            narrowed(c[1], zero),
            narrowed(c[2], zero),
            narrowed(c[3], zero),
            narrowed(c[4], zero),
            narrowed(c[5], zero),
            zero,
            zero,
            zero,
            zero,
        )

    @wp.func
    def stable_tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int, t: Any):
        """State 0: the current one; 1: the same, with slack yarns just pulled taut."""
        x = state_of(strain1, strain2, angle, q)
        if state == 1:
            for k in range(2):
                x[k] = larger(x[k], fill(x[k], 0.0)) + fill(x[k], PULL)
        x, y, residual, iterations = equilibrium(p, x)
        return as_tangent(definite_tangent(p, x), y, strain1, t)

    return tangent, stable_tangent


def snap_loss_function(n: int, first: wp.Function, state_of: wp.Function) -> Any:
    @wp.func
    def snap_loss(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
        jump = fill(strain1, 0.0)
        for k in range(n):
            jump = larger(jump, magnitude(q[k] - start[k]))
        loss = fill(strain1, 0.0)
        if lane_maximum(jump) > strain1.dtype(SNAP_CHANGE):
            before = state_of(strain1, strain2, angle, start)
            after = state_of(strain1, strain2, angle, q)
            y = first(p, before)
            z = first(p, after)
            freed = y[0] - z[0]
            # descending, a convex energy releases less than its initial slope predicts: that is a fast but steady
            # change, whose work was done by the forces
            promised = fill(freed, 0.0)
            for k in range(n):
                promised = promised + y[FORCE + k] * (before[STRAIN_COUNT + k] - after[STRAIN_COUNT + k])
            snapped = where_positive(freed - promised, narrowed(freed, loss), loss)
            loss = where_positive(jump - fill(jump, jump.dtype(SNAP_CHANGE)), snapped, loss)
        return loss

    return snap_loss
