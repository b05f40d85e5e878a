"""Stable time step from the condensed tangent of every element's own unit cell (docs/theory.md, section 7)."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw, tangent_struct
from ..cell.newton import emitted_late
from ..lane_types import lane_types
from ..lanes import dot, fill, larger, magnitude, square_root, where_positive
from ..laws.contract import device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import ClockEntry, InertiaRow, MotionRow
from .coupling import coupled_function, sizes_function
from .eigenvalue import in_tangent_plane, largest_in_plane, largest_of_pencil, symmetric2_struct, symmetric4_struct
from .kinematics import (
    corner_angles,
    mean_angles,
    membrane_function,
    shape_functions,
    shape_struct,
    vectors_functions,
)
from .laws import SheetTraits, sheet_struct
from .membrane import bundling_stiffness, unknowns_function
from .shear import sticking_function


@cache
def step_bounds_struct(real: type):
    """Limits of the stable step that do not depend on the state, as a Warp struct."""

    @wp.struct
    class StepBounds:
        warp: real  # largest stiffness of the cell along warp and weft, and in shear [N/m]
        weft: real
        shear: real
        bending: real  # largest bending stiffness of any curvature [N m]
        contact_frequency: real  # squared, of the springs of contact and grippers [1/s^2]
        sample_frequency: real  # of that, of the springs between nodes [1/s^2]
        sample_turning: real  # what the latter do to directors, times the squared radius of their inertia [m^2/s^2]
        steps_ahead: wp.int32  # steps until the next update

    return StepBounds


def frequency_lane_count(lane_count: int, cell: CellLaw) -> int:
    """Lanes of ``element_frequency_kernel`` in a run with ``lane_count``: one for a cell that works lane by lane."""
    return 1 if cell.lane_by_lane else lane_count


@cache
def ahead_function(cell: CellLaw):
    """Function for the strains that the cells may reach before the next update."""
    cell_shears = cell.depends_on_shear

    @wp.func
    def strains_ahead(x: Any, v: Any, m: Any, horizon: Any):
        """Extrapolation of yarn strains and angle over ``horizon`` [s]; x are positions, v velocities."""
        zero = fill(m.angle, 0.0)
        strain1 = m.strain1 + horizon * (larger(dot(x.by1, v.by1), zero) / m.stretch1)
        strain2 = m.strain2 + horizon * (larger(dot(x.by2, v.by2), zero) / m.stretch2)
        angle = m.angle
        if wp.static(cell_shears):
            # dgamma/da_1 = (a_2 - a_1 m12/m11)/J
            rate = dot(x.by2, v.by1) - dot(x.by1, v.by1) * m.m12 / m.m11
            rate = (rate + dot(x.by1, v.by2) - dot(x.by2, v.by2) * m.m12 / m.m22) / m.area_ratio
            angle = angle + horizon * rate
        return strain1, strain2, angle

    return strains_ahead


@cache
def cell_tangent_function(real: type, lane_count: int, cell: CellLaw):
    """Function for the ``Tangent`` of one stable state of a block's unit cells.

    A tangent above that of any state of the cell comes from differences across a kink, where a yarn goes slack; it is
    replaced by the largest one.
    """
    Tangent = tangent_struct(real, lane_count)
    stable_tangent, cell_shears, late = cell.stable_tangent, cell.depends_on_shear, cell.lane_by_lane

    @wp.func
    def cell_tangent(cell: Any, bounds: Any, strain1: Any, strain2: Any, angle: Any, start: Any, state: int):
        if wp.static(late):
            _late = wp.grad(emitted_late)(wp.float64(0.0))
        t = stable_tangent(cell, strain1, strain2, angle, start, state, Tangent())
        c11 = t.c11
        c12 = t.c12
        c22 = t.c22
        c13 = t.c13
        c23 = t.c23
        c33 = t.c33
        zero = fill(c11, 0.0)
        beyond = larger(magnitude(c11) - fill(c11, bounds.warp), magnitude(c22) - fill(c11, bounds.weft))
        beyond = larger(beyond, magnitude(c12) - fill(c11, wp.sqrt(bounds.warp * bounds.weft)))
        if wp.static(cell_shears):
            beyond = larger(beyond, magnitude(c33) - fill(c11, bounds.shear))
            beyond = larger(beyond, magnitude(c13) - fill(c11, wp.sqrt(bounds.warp * bounds.shear)))
            beyond = larger(beyond, magnitude(c23) - fill(c11, wp.sqrt(bounds.weft * bounds.shear)))
            c13 = where_positive(beyond, zero, c13)
            c23 = where_positive(beyond, zero, c23)
            c33 = where_positive(beyond, fill(c11, bounds.shear), c33)
        c11 = where_positive(beyond, fill(c11, bounds.warp), c11)
        c12 = where_positive(beyond, zero, c12)
        c22 = where_positive(beyond, fill(c11, bounds.weft), c22)
        return Tangent(c11, c12, c22, c13, c23, c33, t.n1, t.n2, t.moment, t.pressure)

    return cell_tangent


@cache
def sheet_tangent_function(cell: CellLaw, traits: SheetTraits):
    """Function for the ``Tangent`` of cell and sheet together."""
    shear_tangent, cell_shears = device_law(traits.shear).tangent, cell.depends_on_shear
    shear_slides = traits.shear_friction != ""
    sticking_shear = sticking_function(traits) if shear_slides else None

    @wp.func
    def sheet_tangent(laws: Any, m: Any, sine: Any, cosine: Any, c: Any):
        """c: the cell's tangent; yarn tension is included, compression is not."""
        zero = fill(sine, 0.0)
        t = shear_tangent(laws, m, sine, cosine, type(c)())
        if wp.static(shear_slides):
            t = sticking_shear(laws, m.angle, c.pressure, t)
        if wp.static(cell_shears):
            t.c13 = t.c13 + c.c13
            t.c23 = t.c23 + c.c23
            t.c33 = t.c33 + c.c33
            t.moment = t.moment + c.moment
        t.c11 = c.c11 + t.c11 + fill(sine, laws.compressive_stiffness)
        t.c12 = c.c12 + t.c12
        t.c22 = c.c22 + t.c22 + fill(sine, laws.compressive_stiffness)
        t.n1 = larger(c.n1, zero) + t.n1
        t.n2 = larger(c.n2, zero) + t.n2
        return t

    return sheet_tangent


@wp.func
def squared_gradients(shape: Any, b: Any):
    """B: sum over the corners of N_,alpha N_,beta [1/m^2], into an empty matrix."""
    two = shape.bp1.dtype(2.0)
    b.a11 = two * (shape.bp1 * shape.bp1 + shape.bq1 * shape.bq1)
    b.a22 = two * (shape.bp2 * shape.bp2 + shape.bq2 * shape.bq2)
    b.a12 = two * (shape.bp1 * shape.bp2 + shape.bq1 * shape.bq2)
    return b


@wp.func
def inverse_metric(m: Any, raised: Any):
    """Inverse of the metric of a1 and a2, into an empty matrix."""
    raised.a11 = m.m22 / (m.area_ratio * m.area_ratio)
    raised.a12 = -(m.m12 / (m.area_ratio * m.area_ratio))
    raised.a22 = m.m11 / (m.area_ratio * m.area_ratio)
    return raised


@wp.func
def largest_across(t: Any, m: Any, slope: Any, raised: Any, b: Any):
    """Largest eigenvalue of motions across the plane: tension, shear and transverse shear."""
    turn = t.moment / m.area_ratio
    h = type(b)()
    h.a11 = t.n1 / m.stretch1 - turn * m.m12 / m.m11 + slope * raised.a11
    h.a12 = turn + slope * raised.a12
    h.a22 = t.n2 / m.stretch2 - turn * m.m12 / m.m22 + slope * raised.a22
    return largest_of_pencil(h, b)


@wp.func
def press_directors(size: Any, bounds: Any, inverse_density: Any):
    """Contact between nodes presses on the sagitta, which directors describe: fill what that adds to ``Sizes``."""
    quarter = fill(inverse_density, 0.25)
    share = where_positive(inverse_density, quarter / inverse_density, fill(inverse_density, 0.0))
    directors = bounds.sample_turning * size.inverse_squared_radius
    size.contact_directors = share * directors
    size.contact_coupling = share * square_root(bounds.sample_frequency * directors)
    return size


@cache
def element_frequency_function(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Function for the squares of the highest frequencies of a block of elements, bounded from above [1/s^2].

    The bound is the largest eigenvalue of a 2 x 2 matrix of norms: of the second derivatives with respect to positions,
    to directors, and to both, each over the lumped masses. In a flat element the first splits into motions in the
    plane, across it, and hourglass modes, of which the largest counts.
    """
    lanes, layout, state_count = lane_types(real, lane_count).lanes, (real, lane_count), cell.stable_state_count
    Sheet, StepBounds, Shape = sheet_struct(*layout, cell, traits), step_bounds_struct(real), shape_struct(*layout)
    Symmetric2, Symmetric4 = symmetric2_struct(*layout), symmetric4_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, strains_ahead = membrane_function(*layout), ahead_function(cell)
    read_unknowns, cell_tangent = unknowns_function(*layout, cell), cell_tangent_function(*layout, cell)
    sheet_tangent, measure = sheet_tangent_function(cell, traits), sizes_function(*layout, traits.flat)
    couple, widening = coupled_function(traits), device_law(traits.bending).widening

    @wp.func
    def frequencies_of_block(
        # In
        block: wp.int32,
        sheet: Sheet,
        bounds: StepBounds,
        motion: wp.array(dtype=real),
        cell_unknowns: wp.array2d(dtype=lanes),
        inertia: wp.array2d(dtype=lanes),  # rows: see InertiaRow
        clock: wp.array(dtype=wp.float64),
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        elements = sheet.elements
        laws = sheet.laws
        shape = shape_functions(elements, block, Shape())
        x, means = positions(elements, block, shape, motion)
        d = vectors(elements, block, shape, motion, MotionRow.director)
        v = vectors(elements, block, shape, motion, MotionRow.velocity)
        m = stretch_membrane(x.by1, x.by2)
        inverse_product = lanes(real(1.0)) / (m.stretch1 * m.stretch2)
        sine = m.m12 * inverse_product
        cosine = m.area_ratio * inverse_product
        b = squared_gradients(shape, Symmetric2())
        raised = inverse_metric(m, Symmetric2())
        slope = laws.transverse_shear_stiffness * m.area_ratio
        bundling = bundling_stiffness(laws, shape)
        difference, square = corner_angles(mean_angles(elements, block, motion), m.angle)

        # twice as far as the next update, for safety
        horizon = real(2.0) * real(clock[ClockEntry.step]) * real(bounds.steps_ahead)
        strain1, strain2, angle = strains_ahead(x, v, m, horizon)
        start = read_unknowns(cell_unknowns, block)
        in_plane = lanes()
        across = lanes()
        count = int(state_count)  # a constant would be unrolled, with a copy of the cell's iteration for each state
        for state in range(count):
            c = cell_tangent(sheet.cell, bounds, strain1, strain2, angle, start, state)
            t = sheet_tangent(laws, m, sine, cosine, c)
            t.c33 = t.c33 + real(4.0) * bundling
            t.moment = t.moment + bundling * difference
            h = in_tangent_plane(t, m, sine, cosine, Symmetric4())
            in_plane = larger(in_plane, largest_in_plane(h, b))
            across = larger(across, largest_across(t, m, slope, raised, b))

        size = measure(elements, block, x, d, m, raised, b, inertia[InertiaRow.inverse_squared_radius, block])
        bending = (bounds.bending * widening(m, sine)) * size.gradient
        inverse_density = inertia[InertiaRow.inverse_areal_density, block]
        size = press_directors(size, bounds, inverse_density)
        largest = couple(laws, bending, slope, shape, b, size, in_plane, across)
        squared_frequency[block] = real(4.0) * inverse_density * largest + lanes(bounds.contact_frequency)

    return frequencies_of_block


@cache
def element_frequency_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per block of steps: squares of the highest frequencies of every element."""
    lanes, Sheet = lane_types(real, lane_count).lanes, sheet_struct(real, lane_count, cell, traits)
    StepBounds = step_bounds_struct(real)
    frequencies_of_block = element_frequency_function(real, lane_count, cell, traits)

    @wp.kernel(module="unique", enable_backward=False)
    def element_frequencies(
        # In
        first: wp.int32,
        sheet: Sheet,
        bounds: StepBounds,
        motion: wp.array(dtype=real),
        cell_unknowns: wp.array2d(dtype=lanes),
        inertia: wp.array2d(dtype=lanes),
        clock: wp.array(dtype=wp.float64),
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        block = first + wp.tid()
        frequencies_of_block(block, sheet, bounds, motion, cell_unknowns, inertia, clock, squared_frequency)

    return element_frequencies
