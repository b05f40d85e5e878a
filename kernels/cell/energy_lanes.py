"""Unit cells from arbitrary energies, all lanes at once (docs/theory.md, section 2).

The functions of a cell are read as formulas; their derivatives are exact, and what is computed in every iteration is
compiled as one loop over the lanes. All of it is in double precision whatever the precision of the run: energies that
are compared, and stiff members in balance, then have sufficient digits, and single precision only rounds input and
output. ``energy_law`` makes a cell lane by lane (``energy_cell``) where its energy cannot be read.
"""

import logging
from collections.abc import Sequence
from functools import cache
from typing import Any

import warp as wp
from warp import float64 as real

from ..formula.values import Unreadable
from ..formula.writer import Constants, lane_loop
from ..lane_types import ALL_LANE_TYPES, CPU_LANE_COUNT, GPU_LANE_COUNT, lane_types
from ..lanes import fill, lane_maximum, larger, magnitude, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .cell_formulas import ANSWERS, STRAIN_COUNT, CellFormulas, cell_formulas, state_names
from .energy_cell import CellFunctions, energy_cell
from .lane_newton import STIFFNESS_ROWS, equilibrium_text, found_names, stiffness_text, tangent_function
from .law import CellLaw

logger = logging.getLogger(__name__)

# A larger change of an unknown in one time step may be a snap.
SNAP_CHANGE = wp.constant(real(0.05))
LANE_COUNTS = (GPU_LANE_COUNT, CPU_LANE_COUNT)
# Tangents are also taken in tension: with slack yarns stretched by this much.
PULL = wp.constant(real(1.0e-3))
# Rows of ``found_names``.
ENERGY, FORCE, PRESSURE, RESIDUAL = (ANSWERS.index(name) for name in ("energy", "warp_force", "pressure", "residual"))
ITERATIONS, FIRST_UNKNOWN = len(ANSWERS), len(ANSWERS) + 1

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
    name: str, formulas: CellFormulas, part_names: tuple[str, ...] = ("unit_cell",), depends_on_shear: bool = True
) -> CellLaw:
    """A cell from the formulas of its energy."""
    n, followed, constants = formulas.unknown_count, tuple(formulas.follow), Constants()
    equilibrium, stiffness, tangent_at, slopes, parts = compiled_functions(formulas, constants)
    state_of, tangent_of = state_function(n), tangent_function(n, tangent_at)
    tangent, stable_tangent = tangent_functions(stiffness, tangent_of, state_of)
    return CellLaw(
        name=name,
        parameters=lambda precision: constants_struct(len(constants)),
        constants=constants.values,
        unknown_count=n,
        energy_names=part_names,
        depends_on_shear=depends_on_shear,
        lane_by_lane=False,
        stable_state_count=2,
        solve=solve_function(n, len(followed), equilibrium),
        energies=energies_function(parts, state_of, len(part_names)),
        tangent=tangent,
        stable_tangent=stable_tangent,
        snap_loss=snap_loss_function(n, slopes, state_of),
        follow=follow_function(n, followed) if followed else None,
        slope_count=len(followed),
    )


# --- compiled formulas ------------------------------------------------------------------------------------------------


def compiled_functions(formulas: CellFormulas, constants: Constants) -> list[wp.Function]:
    """Warp functions: the equilibrium, the stiffness there, and (p, x) -> a row of lanes per formula.

    The latter are those of ``tangent``, of the energy and ``slopes``, and of ``parts``.
    """
    names = state_names(formulas.unknown_count)
    read = {name: f"x.data[{row}][i]" for row, name in enumerate(names)}
    groups = (formulas.tangent, [formulas.evaluation["energy"], *formulas.slopes], formulas.parts)
    # all of them first: together they determine the constants
    solved, stiff = (
        [text(formulas, constants, types) for types in ALL_LANE_TYPES] for text in (equilibrium_text, stiffness_text)
    )
    written = [[lane_loop(group, constants, read, count, "double") for count in LANE_COUNTS] for group in groups]
    Cell = constants_struct(len(constants))
    return [
        solved_function(solved, Cell, max(formulas.unknown_count, 1), len(found_names(formulas))),
        solved_function(stiff, Cell, max(formulas.unknown_count, 1), len(STIFFNESS_ROWS)),
        *(
            compiled_function(snippets, Cell, len(names), len(group))
            for group, snippets in zip(groups, written, strict=True)
        ),
    ]


def solved_function(written: Sequence[str], Cell: Any, unknown_rows: int, rows: int) -> wp.Function:
    """Warp function (p, strains, q) -> rows, with an overload for all kinds of lanes."""
    for types, snippet in zip(ALL_LANE_TYPES, written, strict=True):
        lanes, kind = types.lanes, (types.lane_count, types.real)
        Unknowns, Rows = (wp.types.matrix((count, kind[0]), kind[1]) for count in (unknown_rows, rows))

        @wp.func_native(snippet)
        def solved(p: Cell, warp_strain: lanes, weft_strain: lanes, shear_angle: lanes, q: Unknowns) -> Rows: ...

    return solved


def compiled_function(written: Sequence[str], Cell: Any, state_rows: int, rows: int) -> wp.Function:
    """One Warp function with an overload for every number of lanes."""
    for count, snippet in zip(LANE_COUNTS, written, strict=True):
        State, Rows = wp.types.matrix((state_rows, count), real), wp.types.matrix((rows, count), real)

        # the second is an overload of the first, since it has its name
        @wp.func_native(snippet)
        def compiled(p: Cell, x: State) -> Rows: ...

    return compiled


# --- the contract of kernels/cell/law.py ------------------------------------------------------------------------------


@cache
def state_function(n: int) -> wp.Function:
    """Warp function (strains, q) -> x."""
    row_count = len(state_names(n))
    for types in ALL_LANE_TYPES:
        lanes, count = types.lanes, types.lane_count
        State = wp.types.matrix((row_count, count), real)
        Unknowns = wp.types.matrix((max(n, 1), count), types.real)
        values = ["strain1[i]", "strain2[i]", "angle[i]", *(f"q.data[{k}][i]" for k in range(n)), "0.0"]
        body = "".join(f"result.data[{row}][i] = double({value});" for row, value in enumerate(values))
        kind = f"wp::mat_t<{row_count}, {count}, wp::float64>"

        @wp.func_native(f"{kind} result; for (int i = 0; i < {count}; ++i) {{ {body} }} return result;")
        def state_of(strain1: lanes, strain2: lanes, angle: lanes, q: Unknowns) -> State: ...

    return state_of


@cache
def solve_function(n: int, slope_count: int, equilibrium: wp.Function) -> Any:
    """wp.func ``solve`` of the ``CellLaw``, of all lanes."""
    first_slope = FIRST_UNKNOWN + n

    @wp.func
    def solve(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, answer: Any):
        found = equilibrium(p, strain1, strain2, angle, start)
        answer.energy = found[ENERGY]
        answer.warp_force = found[FORCE]
        answer.weft_force = found[FORCE + 1]
        answer.moment = found[FORCE + 2]
        answer.pressure = found[PRESSURE]
        answer.residual = found[RESIDUAL]
        answer.iterations = found[ITERATIONS]
        unknowns = type(start)()
        for k in range(n):
            unknowns[k] = found[FIRST_UNKNOWN + k]
        answer.unknowns = unknowns
        if wp.static(slope_count > 0):
            slopes = answer.slopes
            for k in range(slope_count):
                slopes[k] = found[first_slope + k]
            answer.slopes = slopes
        return answer

    return solve


@cache
def follow_function(n: int, followed: tuple[tuple[int, int], ...]) -> wp.Function:
    """``follow``: unknowns to start from, the last ones moved with the strains, if none moves as much as in a snap.

    ``followed`` are the numbers of unknown and strain of each slope.
    """
    slope_count = len(followed)
    changes = ("change1[i]", "change2[i]", "turn[i]")
    moves = [
        [f"slopes.data[{row}][i] * {changes[s]}" for row, (k, s) in enumerate(followed) if k == u] for u in range(n)
    ]
    for types in ALL_LANE_TYPES:
        lanes, count, scalar = types.lanes, types.lane_count, f"wp::{types.real.__name__}"
        Slopes, Unknowns = (wp.types.matrix((size, count), types.real) for size in (slope_count, n))
        lines = [f"{scalar} moved{k} = {' + '.join(terms) or '0'};" for k, terms in enumerate(moves)]
        # not a number compares false
        near = " & ".join(f"(moved{k} < limit) & (moved{k} > -limit)" for k in range(n))
        lines += [f"result.data[{k}][i] = last.data[{k}][i] + (near ? moved{k} : {scalar}(0));" for k in range(n)]
        lines.insert(n, f"const bool near = {near};")
        snippet = f"""wp::mat_t<{n}, {count}, {scalar}> result;
        const {scalar} limit = {scalar}({float(SNAP_CHANGE)!r});
        for (int i = 0; i < {count}; ++i) {{ {" ".join(lines)} }}
        return result;"""

        @wp.func_native(snippet)
        def moved(change1: lanes, change2: lanes, turn: lanes, slopes: Slopes, last: Unknowns) -> Unknowns: ...

    @wp.func
    def follow(p: Any, change1: Any, change2: Any, turn: Any, slopes: Any, last: Any):
        return moved(change1, change2, turn, slopes, last)

    return follow


def energies_function(parts: wp.Function, state_of: wp.Function, part_count: int) -> Any:
    """wp.func ``energies`` of the ``CellLaw``, of all lanes."""

    @wp.func
    def energies(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
        values = parts(p, state_of(strain1, strain2, angle, q))
        result = wp.matrix(shape=(part_count, 1), dtype=area.dtype)
        for k in range(part_count):
            result[k] = area * narrowed(values[k], area)
        return result

    return energies


def tangent_functions(
    stiffness: wp.Function, tangent_of: Any, state_of: wp.Function
) -> tuple[wp.Function, wp.Function]:
    """``tangent`` and ``stable_tangent``."""

    @wp.func
    def tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, t: Any):
        c = tangent_of(p, state_of(strain1, strain2, angle, q))
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
        warp = strain1
        weft = strain2
        if state == 1:
            warp = larger(strain1, fill(strain1, 0.0)) + fill(strain1, strain1.dtype(PULL))
            weft = larger(strain2, fill(strain2, 0.0)) + fill(strain2, strain2.dtype(PULL))
        c = stiffness(p, warp, weft, angle, q)
        return type(t)(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9])

    return tangent, stable_tangent


def snap_loss_function(n: int, slopes: wp.Function, state_of: wp.Function) -> Any:
    """wp.func ``snap_loss`` of the ``CellLaw``, of all lanes."""

    @wp.func
    def snap_loss(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
        jump = fill(strain1, 0.0)
        for k in range(n):
            jump = larger(jump, magnitude(q[k] - start[k]))
        loss = fill(strain1, 0.0)
        if lane_maximum(jump) > strain1.dtype(SNAP_CHANGE):
            before = state_of(strain1, strain2, angle, start)
            after = state_of(strain1, strain2, angle, q)
            g = slopes(p, before)
            h = slopes(p, after)
            freed = g[0] - h[0]
            # descending, a convex energy releases less than its initial slope predicts: that is a fast but steady
            # change, whose work was done by the forces
            promised = fill(freed, 0.0)
            for k in range(n):
                promised = promised + g[1 + STRAIN_COUNT + k] * (before[STRAIN_COUNT + k] - after[STRAIN_COUNT + k])
            snapped = where_positive(freed - promised, narrowed(freed, loss), loss)
            loss = where_positive(jump - fill(jump, jump.dtype(SNAP_CHANGE)), snapped, loss)
        return loss

    return snap_loss
