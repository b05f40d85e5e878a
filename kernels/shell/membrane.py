"""The membrane of an element: its unit cell, its shear, and the bending of its yarns within the plane."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw, cell_answer_struct
from ..cell.newton import emitted_late
from ..lane_types import GPU_LANE_COUNT
from ..lanes import fill, inverses, lane_maximum, larger, where_positive
from ..laws.contract import device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import CellReportRow
from .kinematics import corner_angles
from .laws import SheetTraits
from .shear import moment_resultants, shear_friction_function
from .thickness import compressive_energy, compressive_force


@cache
def unknowns_function(real: type, lane_count: int, cell: CellLaw):
    """Function that reads the unknowns of a block's unit cells, a matrix with a row for each."""
    unknown_count = cell.unknown_count
    Unknowns = wp.types.matrix((cell.row_count, lane_count), real)

    @wp.func
    def read_unknowns(cell_unknowns: Any, block: int):
        unknowns = Unknowns()
        for k in range(unknown_count):
            unknowns[k] = cell_unknowns[k, block]
        return unknowns

    return read_unknowns


@cache
def follow_function(real: type, lane_count: int, cell: CellLaw):
    """Function for the unknowns to start from: those of the last step follow the strains."""
    Slopes, follow, slope_count = wp.types.matrix((cell.slope_count, lane_count), real), cell.follow, cell.slope_count
    first, shears = cell.row_count, cell.depends_on_shear

    @wp.func
    def follow_strains(cell: Any, block: int, m: Any, cell_unknowns: Any, cell_report: Any, last: Any):
        change1 = m.strain1 - cell_report[CellReportRow.warp_strain, block]
        change2 = m.strain2 - cell_report[CellReportRow.weft_strain, block]
        turn = fill(change1, 0.0)
        if wp.static(shears):
            turn = m.angle - cell_report[CellReportRow.shear_angle, block]
        slopes = Slopes()
        for k in range(slope_count):
            slopes[k] = cell_unknowns[first + k, block]
        return follow(cell, change1, change2, turn, slopes, last)

    return follow_strains


@cache
def cell_answer_function(real: type, lane_count: int, cell: CellLaw):
    """Function for the response of a block's unit cells; it stores their unknowns and reports.

    Warp emits functions that use gradients after all others, and a lane-by-lane ``energy_cell`` consists of such
    functions: its callers must look like them, also those in energy.py and frequency.py.
    """
    CellAnswer = cell_answer_struct(real, lane_count, cell.row_count, cell.slope_count)
    read_unknowns = unknowns_function(real, lane_count, cell)
    unknown_count, solve, snap_loss, late = cell.unknown_count, cell.solve, cell.snap_loss, cell.lane_by_lane
    # a GPU waits for bytes sooner than for evaluations: not tried there
    slope_count = cell.slope_count if lane_count > GPU_LANE_COUNT else 0
    follow_strains, first = follow_function(real, lane_count, cell) if slope_count else None, cell.row_count

    @wp.func
    def answer_cell(cell: Any, block: int, m: Any, cell_unknowns: Any, cell_report: Any):
        if wp.static(late):
            _late = wp.grad(emitted_late)(wp.float64(0.0))
        start = read_unknowns(cell_unknowns, block)
        if wp.static(slope_count > 0):
            near = follow_strains(cell, block, m, cell_unknowns, cell_report, start)
            answer = solve(cell, m.strain1, m.strain2, m.angle, near, CellAnswer())
            slopes = answer.slopes
            for k in range(slope_count):
                cell_unknowns[first + k, block] = slopes[k]
        else:
            answer = solve(cell, m.strain1, m.strain2, m.angle, start, CellAnswer())
        unknowns = answer.unknowns
        for k in range(unknown_count):
            cell_unknowns[k, block] = unknowns[k]
        cell_report[CellReportRow.iterations, block] = answer.iterations
        # a NaN, for which no comparison is true, stays as infinity
        worst = larger(cell_report[CellReportRow.worst_residual, block], answer.residual)
        known = answer.residual + fill(answer.residual, 1.0)
        cell_report[CellReportRow.worst_residual, block] = where_positive(known, worst, fill(worst, wp.inf))
        if wp.static(unknown_count > 0):
            freed = snap_loss(cell, m.strain1, m.strain2, m.angle, start, unknowns)
            if lane_maximum(freed) > freed.dtype(0.0):
                cell_report[CellReportRow.snap_loss, block] = cell_report[CellReportRow.snap_loss, block] + freed
                # a loss that the motion does not get back
                cell_report[CellReportRow.energy, block] = cell_report[CellReportRow.energy, block] - freed
        return answer

    return answer_cell


@wp.func
def add_compression(laws: Any, m: Any, answer: Any):
    """The cell's answer with the forces and the energy of the sheet's own compressive stiffness."""
    answer.warp_force = answer.warp_force + compressive_force(laws, m.stretch1)
    answer.weft_force = answer.weft_force + compressive_force(laws, m.stretch2)
    answer.energy = answer.energy + m.strain1.dtype(0.5) * compressive_energy(laws, m)
    return answer


@wp.func
def bundling_stiffness(laws: Any, shape: Any):
    """beta/area of the in-plane bending of the yarns [N/m], which resists variation of the shear angle.

    b_p x b_q is 1/(2 area); the stored area is zero in padding elements.
    """
    bp1 = shape.bp1
    return (bp1.dtype(2.0) * laws.in_plane_bending_stiffness) * (bp1 * shape.bq2 - shape.bp2 * shape.bq1)


@cache
def shear_moment_function(cell: CellLaw, traits: SheetTraits):
    """Function for the total shear moment [N/m], and for T12 in addition to that of the moment; writes the slip."""
    shear_resultants, cell_shears = device_law(traits.shear).resultants, cell.depends_on_shear
    shear_slides = traits.shear_friction != ""
    shear_friction = shear_friction_function(traits) if shear_slides else None

    @wp.func
    def shear_moment(laws: Any, block: int, shape: Any, m: Any, answer: Any, means: Any, slip: Any):
        moment, t12 = shear_resultants(laws, m)
        if wp.static(cell_shears):
            moment = moment + answer.moment
        difference, square = corner_angles(means, m.angle)
        moment = moment + bundling_stiffness(laws, shape) * difference
        if wp.static(shear_slides):
            moment = moment + shear_friction(laws, block, m.angle, answer.pressure, slip)
        return moment, t12

    return shear_moment


@wp.func
def membrane_resultants(laws: Any, m: Any, answer: Any, moment: Any, shear12: Any, r: Any):
    """Set T of shear and of the membrane forces of the answer, which include the sheet's compressive stiffness."""
    inverse1, inverse2 = inverses(m.stretch1, m.stretch2)
    t11 = answer.warp_force * inverse1
    t22 = answer.weft_force * inverse2
    turned11, turned12, turned22 = moment_resultants(moment, m.m12, inverse1, inverse2, m.inverse_ratio)
    r.t11 = t11 + turned11
    r.t12 = turned12 + shear12
    r.t22 = t22 + turned22
    return r
