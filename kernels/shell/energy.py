"""Energies and fields of the current state, for output frames only (docs/theory.md, section 8). One lane."""

from functools import cache

import warp as wp

from ..cell.law import CellLaw
from ..curve import spring_energy
from ..lanes import angle_of, div, dot, fill, lane_types, mul, where_positive  # noqa: F401 - operators of lanes
from ..rows import CellReportRow, ElementField, MotionRow, SheetEnergy, SlipRow
from .bending import bending_energy, bending_moments, transverse_shear_forces
from .hourglass import hourglass_stiffnesses, hourglass_strains
from .kinematics import (
    corner_angles,
    element_positions,
    element_strains,
    element_struct,
    element_vectors,
    surface_metric,
    yarn_strains,
)
from .laws import SheetTraits, sheet_struct
from .shear import shear_energy, shear_moment
from .thickness import compressive_force


@cache
def element_ledger_kernel(real: type, cell: CellLaw, traits: SheetTraits):
    """Energies [J] and fields of every element; changes nothing of the state."""
    lanes = lane_types(real, 1).lanes
    Elements, UnitCell, SheetLaws = element_struct(real, 1), cell.parameters(real), sheet_struct(real)
    unknown_count, part_count = cell.unknown_count, len(cell.energy_names)
    Unknowns = wp.types.matrix((cell.row_count, 1), real)
    solve, cell_energies = cell.solve, cell.energies
    flat, skewed, curved_shear, bending_kind = traits.flat, traits.skewed, traits.curved_shear, traits.bending
    shear_slides, bending_slides = traits.shear_friction, traits.bending_friction

    @wp.kernel(module="unique", enable_backward=False)
    def element_ledger(
        # In
        elements: Elements,
        cell: UnitCell,
        laws: SheetLaws,
        motion: wp.array(dtype=real),
        mean_angles: wp.array(dtype=real),  # the motion array that has those of the nodes
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),
        slip: wp.array2d(dtype=lanes),
        # Out
        energies: wp.array2d(dtype=lanes),
        fields: wp.array2d(dtype=lanes),
    ):
        e = wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion)
        d1, d2, mean_director, d_hourglass = element_vectors(elements, e, motion, MotionRow.director)
        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        angle = angle_of(m12, area_ratio, stretch1 * stretch2)
        start = Unknowns()
        for k in range(unknown_count):
            start[k] = cell_unknowns[k, e]
        unknowns, warp_force, weft_force, cell_moment, pressure, residual, iterations = solve(
            cell, strain1, strain2, angle, start
        )
        area = elements.area[e]
        parts = cell_energies(cell, strain1, strain2, angle, unknowns, area)
        for k in range(part_count):
            energies[k, e] = parts[k]
        half = real(0.5)
        inverse_ratio = fill(area_ratio, 1.0) / area_ratio
        k11, k12, k22, g1, g2 = element_strains(elements, e, flat, skewed, a1, a2, d1, d2, mean_director)
        moment11, moment12, moment22, b11, b12, b22 = bending_moments(
            laws, bending_kind, m11, m12, m22, inverse_ratio, k11, k12, k22
        )
        q1, q2, s11, s12, s22 = transverse_shear_forces(laws, m11, m12, m22, area_ratio, inverse_ratio, g1, g2)
        in_plane, warping_stiffness, director_stiffness = hourglass_stiffnesses(elements, laws, e)
        warping, twist1, twist2 = hourglass_strains(
            elements, e, flat, a1, a2, mean_director, x_hourglass, d_hourglass, k11, k12, k22
        )
        height = dot(x_hourglass, normal) / area_ratio
        squeeze1 = compressive_force(laws, stretch1)
        squeeze2 = compressive_force(laws, stretch2)
        energies[part_count + SheetEnergy.compression, e] = (
            half * area * (squeeze1 * (stretch1 - fill(stretch1, 1.0)) + squeeze2 * (stretch2 - fill(stretch2, 1.0)))
        )
        shear = shear_energy(laws, curved_shear, m12, angle)
        moment = shear_moment(laws, curved_shear, m12, area_ratio, angle) + cell_moment
        bending = bending_energy(laws, bending_kind, m11, m22, k11, k12, k22, moment11, moment12, moment22)
        if wp.static(shear_slides):
            spring = slip[SlipRow.shear_spring, e]
            shear = shear + spring_energy(laws.shear.friction_stiffness, spring)
            moment = moment + laws.shear.friction_stiffness * spring
            energies[part_count + SheetEnergy.shear_friction_loss, e] = area * slip[SlipRow.shear_friction_loss, e]
        if wp.static(bending_slides):
            bending = (
                bending
                + spring_energy(laws.bending.friction_stiffness[0], slip[SlipRow.warp_bending_spring, e])
                + spring_energy(laws.bending.friction_stiffness[1], slip[SlipRow.weft_bending_spring, e])
            )
            energies[part_count + SheetEnergy.bending_friction_loss, e] = area * slip[SlipRow.bending_friction_loss, e]
        energies[part_count + SheetEnergy.shear, e] = area * shear
        difference, square = corner_angles(elements, e, mean_angles, angle)
        real_element = where_positive(area, fill(area, 1.0), lanes())
        energies[part_count + SheetEnergy.in_plane_bending, e] = (
            (half * laws.in_plane_bending_stiffness) * real_element * square
        )
        energies[part_count + SheetEnergy.bending, e] = area * bending
        energies[part_count + SheetEnergy.transverse_shear, e] = half * area * (q1 * g1 + q2 * g2)
        energies[part_count + SheetEnergy.hourglass, e] = (
            half
            * area
            * (
                in_plane * (dot(x_hourglass, x_hourglass) - height * height)
                + warping_stiffness * warping * warping
                + director_stiffness * (twist1 * twist1 + twist2 * twist2)
            )
        )
        energies[part_count + SheetEnergy.snap_loss, e] = area * cell_report[CellReportRow.snap_loss, e]
        fields[ElementField.shear_angle, e] = angle
        fields[ElementField.warp_stretch, e] = stretch1
        fields[ElementField.weft_stretch, e] = stretch2
        fields[ElementField.warp_force, e] = warp_force + squeeze1
        fields[ElementField.weft_force, e] = weft_force + squeeze2
        fields[ElementField.crossover_pressure, e] = pressure
        fields[ElementField.area_ratio, e] = area_ratio
        fields[ElementField.shear_moment, e] = moment

    return element_ledger
