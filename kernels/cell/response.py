"""The unit cell by itself, on arrays of stretches and shear angles: for tests, plots and calibration."""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import lane_types
from ..rows import CellForceRow, ConvergenceRow, StrainRow, TangentRow
from .law import CellLaw


@wp.func
def store_force(target: Any, i: int, n1: Any, n2: Any, m: Any, pressure: Any):
    target[CellForceRow.warp, i] = n1[0]
    target[CellForceRow.weft, i] = n2[0]
    target[CellForceRow.moment, i] = m[0]
    target[CellForceRow.crossover_pressure, i] = pressure[0]


@wp.func
def store_tangent(target: Any, i: int, c11: Any, c12: Any, c22: Any, c13: Any, c23: Any, c33: Any):
    target[TangentRow.c11, i] = c11[0]
    target[TangentRow.c12, i] = c12[0]
    target[TangentRow.c22, i] = c22[0]
    target[TangentRow.c13, i] = c13[0]
    target[TangentRow.c23, i] = c23[0]
    target[TangentRow.c33, i] = c33[0]


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
    unknown_count, part_count = cell.unknown_count, len(cell.energy_names)
    Unknowns = wp.types.matrix((cell.row_count, 1), real)
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
        q = Unknowns()
        for k in range(unknown_count):
            q[k, 0] = start[k, i]
        strain1 = lanes()
        strain2 = lanes()
        angle = lanes()
        force1 = lanes()
        force2 = lanes()
        moment = lanes()
        pressure = lanes()
        worst = real(0.0)
        most = real(0.0)
        lost = real(0.0)
        for increment in range(increment_count):
            share = real(increment + 1) / real(increment_count)
            strain1 = lanes(share * strain[StrainRow.warp, i])
            strain2 = lanes(share * strain[StrainRow.weft, i])
            angle = lanes(share * strain[StrainRow.shear_angle, i])
            before = q
            q, force1, force2, moment, pressure, residual, iterations = solve(
                parameters, strain1, strain2, angle, before
            )
            # written so that a NaN counts as the worst
            worst = wp.where(residual[0] <= worst, worst, residual[0])
            most = wp.max(most, iterations[0])
            freed = snap_loss(parameters, strain1, strain2, angle, before, q)
            lost = lost + freed[0]
        parts = cell_energies(parameters, strain1, strain2, angle, q, lanes(real(1.0)))
        c11, c12, c22, c13, c23, c33 = cell_tangent(parameters, strain1, strain2, angle, q)
        for k in range(unknown_count):
            response.unknowns[k, i] = q[k, 0]
        for k in range(part_count):
            response.energy[k, i] = parts[k, 0]
        store_force(response.force, i, force1, force2, moment, pressure)
        store_tangent(response.tangent, i, c11, c12, c22, c13, c23, c33)
        response.convergence[ConvergenceRow.worst_residual, i] = worst
        response.convergence[ConvergenceRow.most_iterations, i] = most
        response.convergence[ConvergenceRow.snap_loss, i] = lost

    return unit_cell_response
