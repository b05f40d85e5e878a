"""The unit cell by itself, on arrays of stretches and shear angles: for tests, plots and calibration."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..rows import CellForceRow, ConvergenceRow, StrainRow, TangentRow
from .law import CellLaw, cell_answer_struct, tangent_struct


@wp.func
def store_force(target: Any, i: int, answer: Any):
    target[CellForceRow.warp, i] = answer.warp_force[0]
    target[CellForceRow.weft, i] = answer.weft_force[0]
    target[CellForceRow.moment, i] = answer.moment[0]
    target[CellForceRow.crossover_pressure, i] = answer.pressure[0]


@wp.func
def store_tangent(target: Any, i: int, t: Any):
    target[TangentRow.c11, i] = t.c11[0]
    target[TangentRow.c12, i] = t.c12[0]
    target[TangentRow.c22, i] = t.c22[0]
    target[TangentRow.c13, i] = t.c13[0]
    target[TangentRow.c23, i] = t.c23[0]
    target[TangentRow.c33, i] = t.c33[0]


@cache
def response_struct(real: type):
    """What cells answer; one column per cell."""

    @wp.struct
    class Response:
        unknowns: wp.array2d(dtype=real)
        force: wp.array2d(dtype=real)  # rows: see CellForceRow
        energy: wp.array2d(dtype=real)  # parts [J/m^2]
        tangent: wp.array2d(dtype=real)  # rows: see TangentRow
        convergence: wp.array2d(dtype=real)  # rows: see ConvergenceRow

    return Response


@cache
def unit_cell_response_kernel(real: type, cell: CellLaw):
    """Every item has its cell and strains; the branch from rest is followed in equal increments."""
    lanes = lane_types(real, 1).lanes
    Response, UnitCell = response_struct(real), cell.parameters(real)
    CellAnswer, Tangent = cell_answer_struct(real, 1, cell.row_count, cell.slope_count), tangent_struct(real, 1)
    unknown_count, part_count = cell.unknown_count, len(cell.energy_names)
    solve, cell_energies, cell_tangent, snap_loss = cell.solve, cell.energies, cell.tangent, cell.snap_loss

    @wp.kernel(module="unique", enable_backward=False)
    def unit_cell_response(
        # In
        cells: wp.array(dtype=UnitCell),
        strain: wp.array2d(dtype=real),  # rows: see StrainRow
        start: wp.array2d(dtype=real),  # unknowns at rest
        increment_count: wp.int32,
        # Out
        response: Response,
    ):
        i = wp.tid()
        parameters = cells[wp.min(i, cells.shape[0] - 1)]
        answer = CellAnswer()
        q = answer.unknowns
        for k in range(unknown_count):
            q[k, 0] = start[k, i]
        strain1 = lanes()
        strain2 = lanes()
        angle = lanes()
        worst = real(0.0)
        most = real(0.0)
        lost = real(0.0)
        for increment in range(increment_count):
            share = real(increment + 1) / real(increment_count)
            strain1 = lanes(share * strain[StrainRow.warp, i])
            strain2 = lanes(share * strain[StrainRow.weft, i])
            angle = lanes(share * strain[StrainRow.shear_angle, i])
            before = q
            answer = solve(parameters, strain1, strain2, angle, before, CellAnswer())
            q = answer.unknowns
            # written so that a NaN counts as the worst, and stays
            worst = wp.where(answer.residual[0] <= worst or worst != worst, worst, answer.residual[0])
            most = wp.max(most, answer.iterations[0])
            freed = snap_loss(parameters, strain1, strain2, angle, before, q)
            lost = lost + freed[0]
        parts = cell_energies(parameters, strain1, strain2, angle, q, lanes(real(1.0)))
        for k in range(unknown_count):
            response.unknowns[k, i] = q[k, 0]
        for k in range(part_count):
            response.energy[k, i] = parts[k, 0]
        store_force(response.force, i, answer)
        store_tangent(response.tangent, i, cell_tangent(parameters, strain1, strain2, angle, q, Tangent()))
        response.convergence[ConvergenceRow.worst_residual, i] = worst
        response.convergence[ConvergenceRow.most_iterations, i] = most
        response.convergence[ConvergenceRow.snap_loss, i] = lost

    return unit_cell_response
