"""The unit cell alone, on arrays of stretches: for tests, plots and calibration."""

from functools import cache

import warp as wp

from .lanes import lane_types, mul
from .unit_cell import condensed_tangent, solve_unit_cell, unit_cell_energies, unit_cell_struct


@cache
def unit_cell_response_kernel(real: type):
    """Every item has a cell and a pair of stretches; the branch from stretch 1 is followed in equal increments."""
    types = lane_types(real, 1)
    lanes = types.lanes
    UnitCell = unit_cell_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def unit_cell_response(
        # In
        cells: wp.array(dtype=UnitCell),
        stretch: wp.array2d(dtype=real),  # rows warp, weft
        start: wp.array2d(dtype=real),  # w_1, w_2 at stretch 1 [m]
        increment_count: wp.int32,
        # Out
        crimp_change: wp.array2d(dtype=real),  # w_1, w_2 [m]
        force: wp.array2d(dtype=real),  # F_1, F_2, crossover force of the half cell [N]
        energy: wp.array2d(dtype=real),  # warp, weft, bending, contact of the half cell [J]
        tangent: wp.array2d(dtype=real),  # K11, K12, K22 [N/m]
        convergence: wp.array2d(dtype=real),  # worst residual, most iterations on the path
    ):
        i = wp.tid()
        cell = cells[wp.min(i, cells.shape[0] - 1)]
        w1 = lanes(start[0, i])
        w2 = lanes(start[1, i])
        u1 = lanes()
        u2 = lanes()
        force1 = lanes()
        force2 = lanes()
        crossover = lanes()
        worst = real(0.0)
        most = real(0.0)
        for k in range(increment_count):
            share = real(k + 1) / real(increment_count)
            u1 = lanes(share * (stretch[0, i] - real(1.0)) * cell.half_spacing[0])
            u2 = lanes(share * (stretch[1, i] - real(1.0)) * cell.half_spacing[1])
            w1, w2, force1, force2, crossover, residual, iterations = solve_unit_cell(cell, u1, u2, w1, w2)
            worst = wp.where(residual[0] <= worst, worst, residual[0])
            most = wp.max(most, iterations[0])
        warp, weft, bending, contact = unit_cell_energies(cell, u1, u2, w1, w2)
        k11, k12, k22 = condensed_tangent(cell, u1, u2, w1, w2, False)
        crimp_change[0, i] = w1[0]
        crimp_change[1, i] = w2[0]
        force[0, i] = force1[0]
        force[1, i] = force2[0]
        force[2, i] = crossover[0]
        energy[0, i] = warp[0]
        energy[1, i] = weft[0]
        energy[2, i] = bending[0]
        energy[3, i] = contact[0]
        tangent[0, i] = k11[0]
        tangent[1, i] = k12[0]
        tangent[2, i] = k22[0]
        convergence[0, i] = worst
        convergence[1, i] = most

    return unit_cell_response
