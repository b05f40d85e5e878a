"""Energies, fields and resultants of the current state, for output frames (docs/theory.md, section 8). One lane."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw, cell_answer_struct
from ..cell.newton import emitted_late
from ..curve import spring_energy
from ..lane_types import lane_types
from ..lanes import dot, fill, where_positive
from ..laws.contract import device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import CellReportRow, ElementField, MotionRow, ResultantRow, SheetEnergy, SlipRow
from .bending import WARP, WEFT, bending_friction_energy, resultants_struct, transverse_shear
from .hourglass import hourglass_function, hourglass_stiffnesses
from .kinematics import (
    bend_function,
    corner_angles,
    mean_angles,
    membrane_function,
    shape_functions,
    shape_struct,
    vectors_functions,
)
from .laws import SheetTraits, sheet_struct
from .membrane import bundling_stiffness, unknowns_function
from .shear import moment_resultants
from .thickness import compressive_energy, compressive_force

# Number of the first of the rows of resultants, behind those of the fields.
RESULTANTS = ElementField.row_count()


@cache
def cell_energies_function(real: type, cell: CellLaw):
    """Function for the ``CellAnswer`` of an element's unit cell; books the energy, changes no state."""
    part_count, solve, cell_energies = len(cell.energy_names), cell.solve, cell.energies
    CellAnswer = cell_answer_struct(real, 1, cell.row_count, cell.slope_count)
    read_unknowns, late = unknowns_function(real, 1, cell), cell.lane_by_lane

    @wp.func
    def book_cell(cell: Any, e: int, m: Any, area: Any, cell_unknowns: Any, energies: Any):
        if wp.static(late):
            _late = wp.grad(emitted_late)(wp.float64(0.0))
        start = read_unknowns(cell_unknowns, e)
        answer = solve(cell, m.strain1, m.strain2, m.angle, start, CellAnswer())
        parts = cell_energies(cell, m.strain1, m.strain2, m.angle, answer.unknowns, area)
        for k in range(part_count):
            energies[k, e] = parts[k]
        return answer

    return book_cell


@cache
def shear_energies_function(part_count: int, traits: SheetTraits):
    """Function that books the energy of shear with its friction, and returns the moment [N/m]."""
    law, shear_slides = device_law(traits.shear), traits.shear_friction != ""
    shear_energy, shear_moment = law.energy, law.moment

    @wp.func
    def book_shear(laws: Any, e: int, m: Any, area: Any, cell_moment: Any, slip: Any, energies: Any):
        energy = shear_energy(laws, m)
        moment = shear_moment(laws, m) + cell_moment
        if wp.static(shear_slides):
            spring = slip[SlipRow.shear_spring, e]
            energy = energy + spring_energy(laws.shear_friction.stiffness, spring)
            moment = moment + laws.shear_friction.stiffness * spring
            energies[part_count + SheetEnergy.shear_friction_loss, e] = area * slip[SlipRow.shear_friction_loss, e]
        energies[part_count + SheetEnergy.shear, e] = area * energy
        return moment

    return book_shear


@cache
def bending_energies_function(real: type, part_count: int, traits: SheetTraits):
    """Function that books the energies of bending with its friction, and of transverse shear."""
    Resultants = resultants_struct(real, 1)
    law, bending_slides = device_law(traits.bending), traits.bending_friction
    bending_resultants, bending_energy = law.resultants, law.energy

    @wp.func
    def book_bending(laws: Any, e: int, m: Any, b: Any, area: Any, slip: Any, energies: Any):
        r = transverse_shear(laws, m, b, bending_resultants(laws, m, b, Resultants()))
        energy = bending_energy(laws, m, b, r)
        if wp.static(bending_slides):
            warp, weft = bending_friction_energy(laws, e, slip)
            energy = energy + warp + weft
            energies[part_count + SheetEnergy.bending_friction_loss, e] = area * slip[SlipRow.bending_friction_loss, e]
        energies[part_count + SheetEnergy.bending, e] = area * energy
        half = area.dtype(0.5)
        energies[part_count + SheetEnergy.transverse_shear, e] = (
            half * area * (r.shear_force1 * b.g1 + r.shear_force2 * b.g2)
        )

    return book_bending


@cache
def hourglass_energy_function(flat: bool):
    """Function for twice psi of the stabilisation [J/m^2]."""
    hourglass_strains = hourglass_function(flat)

    @wp.func
    def hourglass_energy(elements: Any, laws: Any, e: int, shape: Any, x: Any, d: Any, m: Any, b: Any):
        in_plane, warping_stiffness, director_stiffness = hourglass_stiffnesses(laws, shape)
        warping, director1, director2 = hourglass_strains(elements, e, shape, x, d, b)
        height = dot(x.hourglass, m.normal) / m.area_ratio
        return (
            in_plane * (dot(x.hourglass, x.hourglass) - height * height)
            + warping_stiffness * warping * warping
            + director_stiffness * (director1 * director1 + director2 * director2)
        )

    return hourglass_energy


@cache
def resultants_function(real: type, traits: SheetTraits):
    """Function that writes the resultants of an element; friction is that of its springs, which it does not move."""
    Resultants = resultants_struct(real, 1)
    shear_resultants, shear_slides = device_law(traits.shear).resultants, traits.shear_friction != ""
    bending_resultants, bending_slides = device_law(traits.bending).resultants, traits.bending_friction

    @wp.func
    def write_resultants(laws: Any, e: int, m: Any, b: Any, cell_moment: Any, slip: Any, out: Any):
        moment, shear12 = shear_resultants(laws, m)
        moment = moment + cell_moment
        if wp.static(shear_slides):
            moment = moment + laws.shear_friction.stiffness * slip[SlipRow.shear_spring, e]
        one = fill(moment, 1.0)
        turned11, turned12, turned22 = moment_resultants(
            moment, m.m12, one / m.stretch1, one / m.stretch2, m.inverse_ratio
        )
        out[RESULTANTS + ResultantRow.shear11, e] = turned11
        out[RESULTANTS + ResultantRow.shear12, e] = turned12 + shear12
        out[RESULTANTS + ResultantRow.shear22, e] = turned22
        r = bending_resultants(laws, m, b, Resultants())
        if wp.static(bending_slides):
            two = one.dtype(2.0)
            warp = laws.bending_friction.stiffness[WARP] * slip[SlipRow.warp_bending_spring, e]
            weft = laws.bending_friction.stiffness[WEFT] * slip[SlipRow.weft_bending_spring, e]
            r.moment11 = r.moment11 + warp / m.m11
            r.moment22 = r.moment22 + weft / m.m22
            r.t11 = r.t11 - two * warp * b.k11 / (m.m11 * m.m11)
            r.t22 = r.t22 - two * weft * b.k22 / (m.m22 * m.m22)
        out[RESULTANTS + ResultantRow.bending11, e] = r.t11
        out[RESULTANTS + ResultantRow.bending12, e] = r.t12
        out[RESULTANTS + ResultantRow.bending22, e] = r.t22
        r = transverse_shear(laws, m, b, r)
        out[RESULTANTS + ResultantRow.moment11, e] = r.moment11
        out[RESULTANTS + ResultantRow.moment12, e] = r.moment12
        out[RESULTANTS + ResultantRow.moment22, e] = r.moment22
        out[RESULTANTS + ResultantRow.transverse1, e] = r.shear_force1
        out[RESULTANTS + ResultantRow.transverse2, e] = r.shear_force2

    return write_resultants


@cache
def element_ledger_kernel(real: type, cell: CellLaw, traits: SheetTraits):
    """Energies [J], fields and resultants of every element; does not change the state."""
    lanes, layout, part_count = lane_types(real, 1).lanes, (real, 1), len(cell.energy_names)
    Sheet, Shape = sheet_struct(*layout, cell, traits), shape_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, bend = membrane_function(*layout), bend_function(*layout, traits.flat, traits.skewed)
    book_cell, book_shear = cell_energies_function(real, cell), shear_energies_function(part_count, traits)
    book_bending = bending_energies_function(real, part_count, traits)
    hourglass_energy, write_resultants = hourglass_energy_function(traits.flat), resultants_function(real, traits)

    @wp.kernel(module="unique", enable_backward=False)
    def element_ledger(
        # In
        sheet: Sheet,
        motion: wp.array(dtype=real),
        earlier_motion: wp.array(dtype=real),  # the one that contains the mean angles of the nodes
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),  # rows: see CellReportRow
        slip: wp.array2d(dtype=lanes),  # rows: see SlipRow
        # Out
        energies: wp.array2d(dtype=lanes),  # rows: the parts of the unit cell, SheetEnergy
        fields: wp.array2d(dtype=lanes),  # rows: ElementField, ResultantRow
    ):
        e = wp.tid()
        elements = sheet.elements
        laws = sheet.laws
        area = elements.area[e]
        half = real(0.5)
        shape = shape_functions(elements, e, Shape())
        x, means = positions(elements, e, shape, motion)
        d = vectors(elements, e, shape, motion, MotionRow.director)
        m = stretch_membrane(x.by1, x.by2)
        b = bend(elements, e, shape, x, d)

        answer = book_cell(sheet.cell, e, m, area, cell_unknowns, energies)
        moment = book_shear(laws, e, m, area, answer.moment, slip, energies)
        book_bending(laws, e, m, b, area, slip, energies)
        hourglass = hourglass_energy(elements, laws, e, shape, x, d, m, b)
        difference, square = corner_angles(mean_angles(elements, e, earlier_motion), m.angle)
        in_plane_bending = (half * laws.in_plane_bending_stiffness) * where_positive(area, fill(area, 1.0), lanes())
        energies[part_count + SheetEnergy.compression, e] = half * area * compressive_energy(laws, m)
        energies[part_count + SheetEnergy.in_plane_bending, e] = in_plane_bending * square
        energies[part_count + SheetEnergy.hourglass, e] = half * area * hourglass
        energies[part_count + SheetEnergy.snap_loss, e] = area * cell_report[CellReportRow.snap_loss, e]
        energies[part_count + SheetEnergy.surplus, e] = area * cell_report[CellReportRow.surplus, e]

        fields[ElementField.shear_angle, e] = m.angle
        fields[ElementField.warp_stretch, e] = m.stretch1
        fields[ElementField.weft_stretch, e] = m.stretch2
        fields[ElementField.warp_force, e] = answer.warp_force + compressive_force(laws, m.stretch1)
        fields[ElementField.weft_force, e] = answer.weft_force + compressive_force(laws, m.stretch2)
        fields[ElementField.crossover_pressure, e] = answer.pressure
        fields[ElementField.area_ratio, e] = m.area_ratio
        fields[ElementField.shear_moment, e] = moment
        write_resultants(laws, e, m, b, answer.moment, slip, fields)
        fields[RESULTANTS + ResultantRow.in_plane_moment, e] = bundling_stiffness(laws, shape) * difference

    return element_ledger
