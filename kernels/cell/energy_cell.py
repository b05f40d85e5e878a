"""The contract of a unit cell, and how any energy becomes one (docs/theory.md, section 2).

A cell answers the strains of an element, warp stretch - 1, weft stretch - 1 and shear angle, with what follows from its
energy psi per reference area: n_1 = dpsi/dlambda_1, n_2 = dpsi/dlambda_2, m = dpsi/dgamma. What else it needs are
internal unknowns q with dpsi/dq = 0. The kernels are made for one cell: its functions are compiled into them.

``energy_cell`` makes a cell of one scalar function. Its derivatives come from ``wp.grad`` unless given, second ones
from differences of the first. It works in double precision whatever the precision of the run, lane by lane: the
differences, and energies that are compared, then have digits to spare, and single precision only rounds what goes in
and out.
"""

from functools import cache
from typing import Any

import warp as wp

from .law import CellLaw

MAXIMUM_ITERATIONS = 40


@cache
def parameter_struct(name: str, fields: tuple[tuple[str, int], ...]):
    """A struct with one double, or a vector of ``length`` doubles, per field, and the settings of the iteration."""

    def kind(length: int):
        return wp.float64 if length == 1 else wp.types.vector(length, wp.float64)

    members = {field: kind(length) for field, length in fields}
    members |= {"tolerance": wp.float64, "force_floor": wp.float64, "resolution": wp.float64}
    return wp.struct(type(name, (), {"__annotations__": members, "__module__": __name__}))


# A step of differences: unknowns, stretches and angles are all of order one.
LARGEST_FORWARD_STEP = wp.constant(wp.float64(1.0e-7))
SMALLEST_FORWARD_STEP = wp.constant(wp.float64(1.0e-10))
CENTRAL_STEP = wp.constant(wp.float64(1.0e-8))
# Largest change of an unknown in one Newton step, and what is small enough to be taken unseen.
STEP_LIMIT = wp.constant(wp.float64(0.25))
SMALL_STEP = wp.constant(wp.float64(1.0e-3))
# A change of an unknown in one time step beyond this may be a snap.
SNAP_CHANGE = wp.constant(wp.float64(0.05))
# Yarns are looked at in tension: stretched by this much, whatever they are now.
PULL = wp.constant(wp.float64(1.0e-3))


@wp.func
def emitted_late(x: wp.float64):
    """Differentiated, without a use, wherever a gradient is used: see there."""
    return x


@cache
def energy_cell(
    name: str,
    fields: tuple[tuple[str, int], ...],
    unknown_count: int,
    energy: Any = None,
    *,
    parts: Any = None,
    part_names: tuple[str, ...] = ("unit_cell",),
    gradient: Any = None,
    crossover_pressure: Any = None,
    depends_on_shear: bool = True,
) -> CellLaw:
    """A cell from its energy psi(parameters, warp stretch, weft stretch, shear angle, q) per reference area [J/m^2].

    All arguments are doubles, q is a vector of doubles, one at least. The unknowns are dimensionless, so that a change
    of one is large.

    Args:
        name: for messages.
        fields: names of the parameters in the struct that the functions get, and the length of each.
        unknown_count: length of q; 0 if there are no unknowns.
        energy: Warp function of the five arguments; may be left out if ``parts`` is given.
        parts: of the same arguments: a vector with the parts of the energy, for the ledger.
        part_names: their names.
        gradient: of the same arguments: a vector with the derivatives by warp stretch, weft stretch, shear angle and
            the unknowns, if they are known by hand.
        crossover_pressure: of the same arguments: force between warp and weft per reference area [N/m^2].
        depends_on_shear: False if the shear angle is not used.
    """
    n, part_count, rows = unknown_count, len(part_names), max(unknown_count, 1)
    real = wp.float64
    size = 3 + n
    Parameters = parameter_struct(name, fields)
    vector = wp.types.vector(size, real)
    unknowns = wp.types.vector(rows, real)
    part_vector = wp.types.vector(part_count, real)
    square = wp.types.matrix((rows, rows), real)
    stiffness = wp.types.vector(6, real)
    by_hand, has_parts, has_crossover = gradient is not None, parts is not None, crossover_pressure is not None

    # --- the energy as a function of one vector, and its derivatives --------------------------------------------------

    @wp.func
    def unknowns_of(x: vector):
        q = unknowns()
        for k in range(n):
            q[k] = x[3 + k]
        return q

    if energy is not None:

        @wp.func
        def energy_of(p: Parameters, x: vector):
            return energy(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))

    else:

        @wp.func
        def energy_of(p: Parameters, x: vector):
            values = parts(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))
            total = real(0.0)
            for k in range(part_count):
                total = total + values[k]
            return total

    if by_hand:

        @wp.func
        def gradient_of(p: Parameters, x: vector):
            return gradient(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))

    else:

        @wp.func
        def gradient_of(p: Parameters, x: vector):
            by_parameters, by_x = wp.grad(energy_of)(p, x)
            return by_x

    @wp.func
    def parts_of(p: Parameters, x: vector):
        values = part_vector()
        if wp.static(has_parts):
            values = parts(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))
        else:
            values[0] = energy_of(p, x)
        return values

    @wp.func
    def crossover_of(p: Parameters, x: vector):
        pressure = real(0.0)
        if wp.static(has_crossover):
            pressure = crossover_pressure(p, real(1.0) + x[0], real(1.0) + x[1], x[2], unknowns_of(x))
        return pressure

    # Warp 1.19 writes functions that call wp.grad after all others, whose callers it does not move along: so every
    # function below that needs a gradient, also through another one, calls wp.grad itself, for nothing.

    # --- Newton's method ----------------------------------------------------------------------------------------------

    @wp.func
    def cholesky(h: square, least: real):
        """Lower triangle of H + tau diag |H|, tau the first of 0, 1e-3, 2e-3, ... that makes it positive definite.

        An unknown that nothing holds, such as the stretch of a float of no length, gets a stiffness of its own.
        """
        largest = least
        for k in range(n):
            largest = wp.max(largest, wp.abs(h[k, k]))
        factor = square()
        shift = real(0.0)
        for _attempt in range(60):
            definite = real(1.0)
            for i in range(n):
                own = wp.abs(h[i, i])
                idle = own < real(1.0e-12) * largest
                own = wp.where(idle, largest, own)
                for j in range(i + 1):
                    s = h[i, j]
                    for k in range(j):
                        s = s - factor[i, k] * factor[j, k]
                    if i == j:
                        s = wp.where(idle, own, s + shift * own)
                        # written so that a NaN is not definite
                        if not s > real(1.0e-9) * own:
                            definite = real(0.0)
                            s = own
                        factor[i, i] = wp.sqrt(s)
                    else:
                        factor[i, j] = s / factor[j, j]
            if definite > real(0.0):
                break
            shift = wp.max(real(2.0) * shift, real(1.0e-3))
        return factor

    @wp.func
    def solved(factor: square, b: unknowns):
        """(L L^T)^-1 b."""
        y = unknowns()
        for i in range(n):
            s = b[i]
            for k in range(i):
                s = s - factor[i, k] * y[k]
            y[i] = s / factor[i, i]
        z = unknowns()
        for r in range(n):
            i = n - 1 - r
            s = y[i]
            for k in range(r):
                s = s - factor[n - 1 - k, i] * z[n - 1 - k]
            z[i] = s / factor[i, i]
        return z

    @wp.func
    def relative_residual(p: Parameters, g: vector, stiffest: real):
        """Largest |dpsi/dq| over the forces, a floor, and what rounding leaves of the stiffest unknown's."""
        worst = real(0.0)
        for k in range(n):
            worst = wp.max(worst, wp.abs(g[3 + k]))
            # wp.max drops a NaN
            worst = wp.where(g[3 + k] == g[3 + k], worst, g[3 + k])
        return worst / (wp.abs(g[0]) + wp.abs(g[1]) + wp.abs(g[2]) + p.force_floor + p.resolution * stiffest)

    @wp.func
    def equilibrium(p: Parameters, start: vector):
        """(x, gradient, residual, iterations) where dpsi/dq = 0, by a safeguarded Newton method.

        A Hessian that is not positive definite is shifted; a step is limited, and taken back in part while it
        overshoots (the slope along it has changed sign and keeps more than half its size) or, unless it is small, the
        energy grows; then until the slope has lost half its size.
        """
        _late = wp.grad(emitted_late)(real(0.0))
        x = start
        g = gradient_of(p, x)
        stiffest = real(0.0)
        reach = LARGEST_FORWARD_STEP
        iterations = real(0.0)
        residual = relative_residual(p, g, stiffest)
        for _iteration in range(MAXIMUM_ITERATIONS):
            # a NaN ends it too
            if not residual > p.tolerance:
                break
            h = square()
            for k in range(n):
                # towards the minimum: a member that becomes taut on the way is then met with its stiffness
                change = wp.where(g[3 + k] > real(0.0), -reach, reach)
                y = x
                y[3 + k] = y[3 + k] + change
                ahead = gradient_of(p, y)
                for j in range(n):
                    h[j, k] = (ahead[3 + j] - g[3 + j]) / change
                stiffest = wp.max(stiffest, wp.abs(h[k, k]) * (real(1.0) + wp.abs(x[3 + k])))
            by_q = unknowns()
            for k in range(n):
                by_q[k] = g[3 + k]
            step = solved(cholesky(h, real(1.0e-12) * p.force_floor), by_q)
            longest = real(0.0)
            for k in range(n):
                longest = wp.max(longest, wp.abs(step[k]))
            if longest > STEP_LIMIT:
                step = (STEP_LIMIT / longest) * step
                longest = STEP_LIMIT
            slope = wp.dot(by_q, step)
            before = real(0.0)
            if longest > SMALL_STEP:
                before = energy_of(p, x)
            y = x
            share = real(1.0)
            low = real(0.0)
            high = real(0.0)
            fall = slope
            for trial in range(30):
                for k in range(n):
                    y[3 + k] = x[3 + k] - share * step[k]
                g = gradient_of(p, y)
                # directional derivative here: positive beyond the minimum along the step
                rise = real(0.0)
                for k in range(n):
                    rise = rise - g[3 + k] * step[k]
                grown = real(0.0)
                if share * longest > SMALL_STEP:
                    grown = energy_of(p, y) - before - real(1.0e-15) * (wp.abs(before) + p.force_floor)
                # between two known points by turns of the secant and the middle: at a kink the secant alone creeps
                part = real(0.5)
                if rise > real(0.5) * slope or grown > real(0.0):
                    high = share
                    if trial % 2 == 0 and rise > real(0.0):
                        part = wp.clamp(fall / (fall + rise), real(0.1), real(0.9))
                elif high > real(0.0) and rise < real(-0.5) * slope:
                    low = share
                    fall = -rise
                else:
                    break
                share = low + part * (high - low)
            x = y
            # near a kink that is closer than the reach of the differences they would mix both sides
            reach = wp.clamp(real(0.01) * share * longest, SMALLEST_FORWARD_STEP, LARGEST_FORWARD_STEP)
            residual = relative_residual(p, g, stiffest)
            iterations = iterations + real(1.0)
        return x, g, residual, iterations

    @wp.func
    def condensed(p: Parameters, x: vector):
        """C11, C12, C22, C13, C23, C33: psi_ss - psi_sq psi_qq^-1 psi_qs, by central differences of the gradient."""
        _late = wp.grad(emitted_late)(real(0.0))
        h = wp.matrix(shape=(size, size), dtype=real)
        for k in range(size):
            low = x
            high = x
            low[k] = low[k] - CENTRAL_STEP
            high[k] = high[k] + CENTRAL_STEP
            change = (gradient_of(p, high) - gradient_of(p, low)) / (real(2.0) * CENTRAL_STEP)
            for j in range(size):
                h[j, k] = change[j]
        inner = square()
        for j in range(n):
            for k in range(n):
                inner[j, k] = h[3 + j, 3 + k]
        factor = cholesky(inner, real(1.0e-12) * p.force_floor)
        c = wp.matrix(shape=(3, 3), dtype=real)
        for k in range(3):
            column = unknowns()
            for j in range(n):
                column[j] = h[3 + j, k]
            z = solved(factor, column)
            for i in range(3):
                s = h[i, k]
                for j in range(n):
                    s = s - h[i, 3 + j] * z[j]
                c[i, k] = s
        half = real(0.5)
        c = half * (c + wp.transpose(c))
        return stiffness(c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2], c[2, 2])

    # --- functions of lanes -------------------------------------------------------------------------------------------

    @wp.func
    def lane_state(strain1: Any, strain2: Any, angle: Any, q: Any, i: int):
        x = vector()
        x[0] = real(strain1[i])
        x[1] = real(strain2[i])
        x[2] = real(angle[i])
        for k in range(n):
            x[3 + k] = real(q[k, i])
        return x

    @wp.func
    def solve(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        q = type(start)()
        force1 = type(strain1)()
        force2 = type(strain1)()
        moment = type(strain1)()
        pressure = type(strain1)()
        residual = type(strain1)()
        iterations = type(strain1)()
        # a loop at run time: unrolled, sixteen lanes of Newton's method would be sixteen copies of it
        i = wp.int32(0)
        while i < len(strain1):
            x, g, worst, count = equilibrium(p, lane_state(strain1, strain2, angle, start, i))
            for k in range(n):
                q[k, i] = strain1.dtype(x[3 + k])
            force1[i] = strain1.dtype(g[0])
            force2[i] = strain1.dtype(g[1])
            moment[i] = strain1.dtype(g[2])
            pressure[i] = strain1.dtype(crossover_of(p, x))
            residual[i] = strain1.dtype(worst)
            iterations[i] = strain1.dtype(count)
            i = i + 1
        return q, force1, force2, moment, pressure, residual, iterations

    @wp.func
    def energies(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
        values = parts_of(p, lane_state(strain1, strain2, angle, q, 0))
        result = wp.matrix(shape=(part_count, 1), dtype=area.dtype)
        for k in range(part_count):
            result[k, 0] = area[0] * area.dtype(values[k])
        return result

    @wp.func
    def six_lanes(like: Any, c: stiffness):
        return (
            type(like)(like.dtype(c[0])),
            type(like)(like.dtype(c[1])),
            type(like)(like.dtype(c[2])),
            type(like)(like.dtype(c[3])),
            type(like)(like.dtype(c[4])),
            type(like)(like.dtype(c[5])),
        )

    @wp.func
    def tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        return six_lanes(strain1, condensed(p, lane_state(strain1, strain2, angle, q, 0)))

    @wp.func
    def stable_tangent(p: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int):
        """State 0: as it is; 1: the same with its yarns, if slack, just pulled taut."""
        _late = wp.grad(emitted_late)(real(0.0))
        c11 = type(strain1)()
        c12 = type(strain1)()
        c22 = type(strain1)()
        c13 = type(strain1)()
        c23 = type(strain1)()
        c33 = type(strain1)()
        force1 = type(strain1)()
        force2 = type(strain1)()
        moment = type(strain1)()
        pressure = type(strain1)()
        i = wp.int32(0)
        while i < len(strain1):
            x = lane_state(strain1, strain2, angle, q, i)
            if state == 1:
                x[0] = wp.max(x[0], real(0.0)) + PULL
                x[1] = wp.max(x[1], real(0.0)) + PULL
            x, g, residual, iterations = equilibrium(p, x)
            c = condensed(p, x)
            c11[i] = strain1.dtype(c[0])
            c12[i] = strain1.dtype(c[1])
            c22[i] = strain1.dtype(c[2])
            c13[i] = strain1.dtype(c[3])
            c23[i] = strain1.dtype(c[4])
            c33[i] = strain1.dtype(c[5])
            force1[i] = strain1.dtype(g[0])
            force2[i] = strain1.dtype(g[1])
            moment[i] = strain1.dtype(g[2])
            pressure[i] = strain1.dtype(crossover_of(p, x))
            i = i + 1
        return c11, c12, c22, c13, c23, c33, force1, force2, moment, pressure

    @wp.func
    def snap_loss(p: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
        _late = wp.grad(emitted_late)(real(0.0))
        loss = type(strain1)()
        i = wp.int32(0)
        while i < len(strain1):
            before = lane_state(strain1, strain2, angle, start, i)
            after = lane_state(strain1, strain2, angle, q, i)
            jump = real(0.0)
            for k in range(n):
                jump = wp.max(jump, wp.abs(after[3 + k] - before[3 + k]))
            if jump > SNAP_CHANGE:
                freed = energy_of(p, before) - energy_of(p, after)
                # on the way down a convex energy frees less than its slope at the start promises: that is a fast but
                # steady change, whose work the forces have done
                g = gradient_of(p, before)
                promised = real(0.0)
                for k in range(n):
                    promised = promised + g[3 + k] * (before[3 + k] - after[3 + k])
                if freed > promised:
                    loss[i] = strain1.dtype(freed)
            i = i + 1
        return loss

    return CellLaw(
        name=name,
        parameters=lambda precision: Parameters,
        unknown_count=n,
        energy_names=part_names,
        depends_on_shear=depends_on_shear,
        lane_by_lane=True,
        stable_state_count=2,
        solve=solve,
        energies=energies,
        tangent=tangent,
        stable_tangent=stable_tangent,
        snap_loss=snap_loss,
    )
