"""Energy that the time integration makes where the membrane's stiffness jumps, and a force that takes it back.

In a step from n to n + 1 the motion does the work 1/2 (F_n + F_n+1) ds on an element: exactly what central differences
take from the kinetic energy. If the law is linear between both positions, this is the change of the stored energy; if a
yarn goes slack or taut between them, it is not. The difference is the surplus (docs/theory.md, section 7). A force acts
over the mean of two steps, so where the step changes it counts by its impulse over the step between the positions.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill, larger, smaller
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import CellReportRow, ClockEntry
from .law import CellLaw

# Largest share c of the correction c (rho / 4 B dt^2) dlambda. With it an element is stable up to sqrt(1 - c/2) of the
# step without it, 0.911, which must not be below STEP_SAFETY; from 0.32 on no oscillator with two stiffnesses grows.
LARGEST_CORRECTION = wp.constant(0.34)
# Largest surplus of one step over (rho / 4 B dt^2) dlambda^2: five times the most that a kink can make,
# 1/8 (2 STEP_SAFETY)^2 = 0.4. What goes beyond is no error of the integration, but a snap or a cell that failed.
LARGEST_SURPLUS = wp.constant(2.0)


@wp.func
def limited(value: Any, limit: Any):
    """``value`` between -limit and limit, which is not negative."""
    return larger(smaller(value, limit), -limit)


@cache
def take_back_function(real: type, cell: CellLaw):
    """Function that adds the correction to the answer of cell and sheet, and books the surplus."""
    cell_shears = cell.depends_on_shear

    @wp.func
    def take_back(yarn_inertia: Any, block: int, m: Any, clock: Any, answer: Any, report: Any):
        mean_step = real(clock[ClockEntry.mean_step])
        step = real(clock[ClockEntry.step])
        # half the inverse of the step behind these positions; there is none before the first
        last = wp.max(real(2.0) * mean_step - step, real(0.0))
        half = wp.where(last > real(0.1) * step, real(0.5) / last, real(0.0))
        change1 = m.strain1 - report[CellReportRow.warp_strain, block]
        change2 = m.strain2 - report[CellReportRow.weft_strain, block]
        stretched = change1 * change1 + change2 * change2
        strained = stretched
        work = (report[CellReportRow.warp_impulse, block] + mean_step * answer.warp_force) * change1
        work = work + (report[CellReportRow.weft_impulse, block] + mean_step * answer.weft_force) * change2
        if wp.static(cell_shears):
            turn = m.angle - report[CellReportRow.shear_angle, block]
            work = work + (report[CellReportRow.moment_impulse, block] + mean_step * answer.moment) * turn
            strained = strained + turn * turn
            report[CellReportRow.shear_angle, block] = m.angle
            report[CellReportRow.moment_impulse, block] = mean_step * answer.moment
        inertia = yarn_inertia[block] * (real(1.0) / (step * step))
        made = (answer.energy - report[CellReportRow.energy, block]) - half * work
        surplus = report[CellReportRow.surplus, block] + limited(made, real(LARGEST_SURPLUS) * inertia * strained)
        # a force along the rate that takes all of it within a step, or gives back what was lost
        most = fill(surplus, LARGEST_CORRECTION)
        share = inertia * limited(surplus / (inertia * stretched + fill(surplus, 1.0e-30)), most)
        answer.warp_force = answer.warp_force + share * change1
        answer.weft_force = answer.weft_force + share * change2
        # half of its work is done in this step, the other half is part of the next one's
        report[CellReportRow.surplus, block] = surplus - (half * mean_step) * share * stretched
        report[CellReportRow.energy, block] = answer.energy
        report[CellReportRow.warp_strain, block] = m.strain1
        report[CellReportRow.weft_strain, block] = m.strain2
        report[CellReportRow.warp_impulse, block] = mean_step * answer.warp_force
        report[CellReportRow.weft_impulse, block] = mean_step * answer.weft_force
        return answer

    return take_back
