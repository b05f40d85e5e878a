"""The contract of a unit cell: its response to the strains of an element (docs/theory.md, section 2)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types

LARGEST_UNKNOWN_COUNT = 4
# Largest number of Newton iterations of a cell in one step; the remainder is reported as its residual.
MAXIMUM_ITERATIONS = 40


@cache
def cell_answer_struct(real: type, lane_count: int, row_count: int, slope_count: int = 0):
    """Response of a unit cell; ``row_count`` and ``slope_count`` are those of its ``CellLaw``."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class CellAnswer:
        warp_force: lanes  # n_1, n_2, m [N/m]
        weft_force: lanes
        moment: lanes
        pressure: lanes  # between warp and weft, per reference area [N/m^2]
        energy: lanes  # psi [J/m^2]
        residual: lanes  # relative
        iterations: lanes
        unknowns: wp.types.matrix((row_count, lane_count), real)
        if slope_count:
            slopes: wp.types.matrix((slope_count, lane_count), real)  # of the unknowns by the strains, for ``follow``

    return CellAnswer


@cache
def tangent_struct(real: type, lane_count: int):
    """First and second derivatives of an energy with respect to (stretch 1, stretch 2, shear angle) [N/m]."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Tangent:
        c11: lanes
        c12: lanes
        c22: lanes
        c13: lanes
        c23: lanes
        c33: lanes
        n1: lanes
        n2: lanes
        moment: lanes
        pressure: lanes  # of a unit cell, see CellAnswer

    return Tangent


@dataclass(frozen=True, eq=False)
class CellLaw:
    """One kind of unit cell, as the kernels use it: its parameters, its unknowns, and functions of lanes.

    Every function gets the cell's struct and the strains (warp, weft, shear angle) first; q is a matrix with one row of
    lanes per unknown. A struct is made by ``type(empty)(...)`` in one expression: written member by member, the answer
    of the plain weave made the kernel of the forces 5 % slower (float32, 16 lanes).

    Attributes:
        name: for messages.
        parameters: ``parameters(real)`` is the struct of the cell's constants in one precision.
        constants: its array ``constants`` from the cell's parameters by name; None if it holds the parameters.
        unknown_count: number n of unknowns, 0 to 4.
        energy_names: the parts of the energy, entries of the ledger.
        depends_on_shear: False skips all terms that would be zero.
        lane_by_lane: True if its functions process one lane after the other, so that wide kernels gain nothing.
        stable_state_count: number of states for ``stable_tangent``.
        solve: (..., start q, an empty ``CellAnswer``) -> ``CellAnswer``.
        energies: (..., q, area) -> one row per part [J]; like ``tangent`` for kernels of one lane.
        tangent: (..., q, an empty ``Tangent``) -> ``Tangent`` at equilibrium, without n_1, n_2, m and the pressure.
        stable_tangent: (..., q, state, an empty ``Tangent``) -> ``Tangent`` with the yarns in tension, as soon as the
            cell is pulled. There are several states where one is not enough.
        follow: (struct, changes of both stretches and of the angle since the last answer, its ``slopes``, its q) -> q
            to start from, for several lanes; None for a cell that starts from the last q.
        slope_count: number of ``slopes`` with which it answers, kept behind the unknowns.
        snap_loss: (..., start q, q) -> energy released by a jump to another equilibrium [J/m^2], 0 without a jump.
    """

    name: str
    parameters: Callable[[type], Any]
    unknown_count: int
    energy_names: tuple[str, ...]
    depends_on_shear: bool
    lane_by_lane: bool
    stable_state_count: int
    solve: Any
    energies: Any
    tangent: Any
    stable_tangent: Any
    snap_loss: Any
    follow: Any = None
    slope_count: int = 0
    constants: Callable[[Mapping[str, float]], list[float]] | None = None

    @property
    def row_count(self) -> int:
        """Rows of unknowns; a cell without unknowns has one unused row."""
        return max(self.unknown_count, 1)

    @property
    def kept_row_count(self) -> int:
        """Rows that are kept from step to step: unknowns, then ``slopes``."""
        return self.row_count + self.slope_count
