"""Energies and fields of the current state, for output frames only (docs/theory.md, section 8). One lane."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw, cell_answer_struct
from ..cell.newton import emitted_late
from ..curve import spring_energy
from ..lanes import dot, fill, lane_types, where_positive
from ..laws.contract import device_law
from ..operators import div, mul  # noqa: F401
from ..rows import CellReportRow, ElementField, MotionRow, SheetEnergy, SlipRow
from .bending import bending_friction_energy, resultants_struct, transverse_shear
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
from .membrane import unknowns_function
from .thickness import compressive_energy, compressive_force


@cache
def cell_energies_function(real: type, cell: CellLaw):
    """Function for the ``CellAnswer`` of an element's unit cell; books the energy, changes no state."""
    part_count, solve, cell_energies = len(cell.energy_names), cell.solve, cell.energies
    CellAnswer = cell_answer_struct(real, 1, cell.row_count)
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
def element_ledger_kernel(real: type, cell: CellLaw, traits: SheetTraits):
    """Energies [J] and fields of every element; does not change the state."""
    lanes, layout, part_count = lane_types(real, 1).lanes, (real, 1), len(cell.energy_names)
    Sheet, Shape = sheet_struct(*layout, cell, traits), shape_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, bend = membrane_function(*layout), bend_function(*layout, traits.flat, traits.skewed)
    book_cell, book_shear = cell_energies_function(real, cell), shear_energies_function(part_count, traits)
    book_bending = bending_energies_function(real, part_count, traits)
    hourglass_energy = hourglass_energy_function(traits.flat)

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
        fields: wp.array2d(dtype=lanes),  # rows: see ElementField
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

    return element_ledger
