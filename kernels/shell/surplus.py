"""Energy that the time integration makes where the membrane's stiffness jumps, and a force that takes it back.

Central differences do the work 1/2 (F_n + F_n+1) ds of every element in a step from n to n+1, exactly. It is the change
of the stored energy where the law is linear between both; where a yarn goes slack or taut within the step it is not.
The difference is the surplus; see docs/theory.md, section 7.
"""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..lanes import fill, larger, smaller, where_positive
from ..operators import div, mul  # noqa: F401
from ..rows import CellReportRow
from .thickness import compressive_energy, compressive_force

# Largest share c of a correction c (rho / 4 B dt^2) dlambda: the stable step of an element with it is
# sqrt(1 - c/2) of that without, which must stay above STEP_SAFETY.
LARGEST_CORRECTION = wp.constant(0.3)
LEAK = wp.constant(1.0)


@cache
def take_back_function(real: type, cell: CellLaw):
    """Function that adds to an answer the force that takes the surplus back, and books both."""
    cell_shears = cell.depends_on_shear

    @wp.func
    def take_back(elements: Any, laws: Any, block: int, m: Any, step: Any, answer: Any, report: Any):
        half = real(0.5)
        n1 = answer.warp_force + compressive_force(laws, m.stretch1)
        n2 = answer.weft_force + compressive_force(laws, m.stretch2)
        change1 = m.strain1 - report[CellReportRow.warp_strain, block]
        change2 = m.strain2 - report[CellReportRow.weft_strain, block]
        energy = answer.energy + half * compressive_energy(laws, m)
        work = (report[CellReportRow.warp_force, block] + n1) * change1
        work = work + (report[CellReportRow.weft_force, block] + n2) * change2
        if wp.static(cell_shears):
            turn = m.angle - report[CellReportRow.shear_angle, block]
            work = work + (report[CellReportRow.moment, block] + answer.moment) * turn
            report[CellReportRow.shear_angle, block] = m.angle
            report[CellReportRow.moment, block] = answer.moment
        surplus = report[CellReportRow.surplus, block] + (energy - report[CellReportRow.energy, block]) - half * work
        inertia = elements.yarn_inertia[block] * (real(1.0) / (step * step))
        size = inertia * (change1 * change1 + change2 * change2) + fill(surplus, 1.0e-30)
        share = smaller(larger(surplus / size, fill(surplus, -LARGEST_CORRECTION)), fill(surplus, LARGEST_CORRECTION)) * inertia
        surplus = surplus - half * share * (change1 * change1 + change2 * change2)
        answer.warp_force = n1 + share * change1
        answer.weft_force = n2 + share * change2
        report[CellReportRow.surplus, block] = where_positive(surplus, surplus, real(LEAK) * surplus)
        report[CellReportRow.energy, block] = energy
        report[CellReportRow.warp_strain, block] = m.strain1
        report[CellReportRow.weft_strain, block] = m.strain2
        report[CellReportRow.warp_force, block] = answer.warp_force
        report[CellReportRow.weft_force, block] = answer.weft_force
        return answer

    return take_back
