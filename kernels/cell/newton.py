"""Equilibrium of an energy's unknowns by a safeguarded Newton method, and the condensed tangent.

In double precision, one cell at a time. Second derivatives are finite differences of the gradient. This serves cells
whose energy cannot be read as a formula (``energy_cell``); ``lane_newton`` serves all others.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp
from warp import float64 as real

from .law import MAXIMUM_ITERATIONS

# Step of finite differences: unknowns, stretches and angles are all of order one.
LARGEST_FORWARD_STEP = wp.constant(real(1.0e-7))
SMALLEST_FORWARD_STEP = wp.constant(real(1.0e-10))
CENTRAL_STEP = wp.constant(real(1.0e-8))
# Largest change of an unknown in one Newton step, and largest change that is accepted without a check.
STEP_LIMIT = wp.constant(real(0.25))
SMALL_STEP = wp.constant(real(1.0e-3))
# Least stiffness of an unknown over the floor of the forces.
LEAST_STIFFNESS = wp.constant(real(1.0e-12))


@wp.func
def emitted_late(x: wp.float64):
    """Differentiated, without being used, by every function that needs a gradient, directly or indirectly.

    Warp 1.19 emits functions that call wp.grad after all others, but not their callers; so the callers call it too.
    """
    return x


@dataclass(frozen=True)
class CellEnergy:
    """An energy psi(p, x) per reference area, with x = (warp stretch - 1, weft stretch - 1, shear angle, unknowns).

    Attributes:
        unknown_count: may be zero.
        parameters: struct p of the energy's parameters, with ``tolerance``, ``force_floor`` and ``resolution``.
        vector: type of x, of doubles.
        energy: Warp function (p, x) -> psi [J/m^2].
        gradient: Warp function (p, x) -> dpsi/dx.
    """

    unknown_count: int
    parameters: Any
    vector: Any
    energy: wp.Function
    gradient: wp.Function

    @property
    def unknowns(self) -> Any:
        """Type of the vector of unknowns, which has at least one entry."""
        return wp.types.vector(max(self.unknown_count, 1), real)

    @property
    def square(self) -> Any:
        """Type of a matrix of the unknowns."""
        rows = max(self.unknown_count, 1)
        return wp.types.matrix((rows, rows), real)


@cache
def cholesky_functions(n: int, square: Any, unknowns: Any):
    """Warp functions (H, least) -> L and (L, b) -> (L L^T)^-1 b, for the first n rows."""

    @wp.func
    def shifted_factor(h: square, largest: real, shift: real):
        """Lower triangle of H + shift diag |H|, and whether that is positive definite: 1 or 0."""
        factor = square()
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
        return factor, definite

    @wp.func
    def cholesky(h: square, least: real):
        """Lower triangle of H + tau diag |H|, tau the first of 0, 1e-3, 2e-3, ... that makes it positive definite.

        An unknown without stiffness, such as the strain of a float of zero length, gets an artificial one.
        """
        largest = least
        for k in range(n):
            largest = wp.max(largest, wp.abs(h[k, k]))
        factor = square()
        shift = real(0.0)
        for _attempt in range(60):
            factor, definite = shifted_factor(h, largest, shift)
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

    return cholesky, solved


def equilibrium_function(cell: CellEnergy) -> wp.Function:
    """Warp function (p, start) -> (x, gradient, residual, iterations) where dpsi/dq = 0."""
    n, Parameters, vector = cell.unknown_count, cell.parameters, cell.vector
    square, unknowns, gradient_of = cell.square, cell.unknowns, cell.gradient
    cholesky, solved = cholesky_functions(n, square, unknowns)
    descend = descent_function(cell)

    @wp.func
    def relative_residual(p: Parameters, g: vector, stiffest: real):
        """Largest |dpsi/dq| over the size of the forces, a floor, and the rounding error of the stiffest unknown."""
        worst = real(0.0)
        for k in range(n):
            worst = wp.max(worst, wp.abs(g[3 + k]))
            # wp.max drops a NaN
            worst = wp.where(g[3 + k] == g[3 + k], worst, g[3 + k])
        return worst / (wp.abs(g[0]) + wp.abs(g[1]) + wp.abs(g[2]) + p.force_floor + p.resolution * stiffest)

    @wp.func
    def hessian(p: Parameters, x: vector, g: vector, reach: real, stiffest: real):
        """Second derivatives with respect to the unknowns, by steps of ``reach``, and the largest stiffness so far."""
        _late = wp.grad(emitted_late)(real(0.0))
        h = square()
        for k in range(n):
            # towards the minimum: this includes the stiffness of a member that becomes taut before it
            change = wp.where(g[3 + k] > real(0.0), -reach, reach)
            y = x
            y[3 + k] = y[3 + k] + change
            ahead = gradient_of(p, y)
            for j in range(n):
                h[j, k] = (ahead[3 + j] - g[3 + j]) / change
            stiffest = wp.max(stiffest, wp.abs(h[k, k]) * (real(1.0) + wp.abs(x[3 + k])))
        return h, stiffest

    @wp.func
    def newton_step(p: Parameters, h: square, by_q: unknowns):
        """Newton's step, shortened to the limit, and its largest entry."""
        step = solved(cholesky(h, LEAST_STIFFNESS * p.force_floor), by_q)
        longest = real(0.0)
        for k in range(n):
            longest = wp.max(longest, wp.abs(step[k]))
        if longest > STEP_LIMIT:
            step = (STEP_LIMIT / longest) * step
            longest = STEP_LIMIT
        return step, longest

    @wp.func
    def equilibrium(p: Parameters, start: vector):
        """(x, gradient, residual, iterations): a Hessian that is not positive definite is shifted, a step limited."""
        _late = wp.grad(emitted_late)(real(0.0))
        x = start
        g = gradient_of(p, x)
        stiffest = real(0.0)
        reach = LARGEST_FORWARD_STEP
        iterations = real(0.0)
        residual = relative_residual(p, g, stiffest)
        for _iteration in range(MAXIMUM_ITERATIONS):
            # a NaN ends the loop too
            if not residual > p.tolerance:
                break
            h, stiffest = hessian(p, x, g, reach, stiffest)
            by_q = unknowns()
            for k in range(n):
                by_q[k] = g[3 + k]
            step, longest = newton_step(p, h, by_q)
            x, g, share = descend(p, x, step, longest, wp.dot(by_q, step))
            # near a kink, differences with a larger reach would mix both sides
            reach = wp.clamp(real(0.01) * share * longest, SMALLEST_FORWARD_STEP, LARGEST_FORWARD_STEP)
            residual = relative_residual(p, g, stiffest)
            iterations = iterations + real(1.0)
        return x, g, residual, iterations

    return equilibrium


def descent_function(cell: CellEnergy) -> wp.Function:
    """Warp function (p, x, step, its largest entry, slope along it) -> (x there, gradient there, share of the step)."""
    n, Parameters, vector, unknowns = cell.unknown_count, cell.parameters, cell.vector, cell.unknowns
    energy_of, gradient_of = cell.energy, cell.gradient

    @wp.func
    def descend(p: Parameters, x: vector, step: unknowns, longest: real, slope: real):
        """Take the step, shortened while it overshoots or, unless it is small, the energy grows.

        It overshoots if the slope along it has changed sign and kept more than half its size; in both cases the search
        continues until the slope has lost half its size.
        """
        _late = wp.grad(emitted_late)(real(0.0))
        before = real(0.0)
        if longest > SMALL_STEP:
            before = energy_of(p, x)
        y = x
        g = vector()
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
            # between two known points, alternate secant and bisection: at a kink the secant alone converges slowly
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
        return y, g, share

    return descend


def condensed_tangent_function(cell: CellEnergy) -> wp.Function:
    """Warp function (p, x) -> C11, C12, C22, C13, C23, C33 as a vector: psi_ss - psi_sq psi_qq^-1 psi_qs."""
    n, Parameters, vector = cell.unknown_count, cell.parameters, cell.vector
    square, unknowns, gradient_of = cell.square, cell.unknowns, cell.gradient
    cholesky, solved = cholesky_functions(n, square, unknowns)
    size = 3 + n
    whole, stiffness = wp.types.matrix((size, size), real), wp.types.vector(6, real)

    @wp.func
    def full_hessian(p: Parameters, x: vector):
        """By central differences of the gradient."""
        _late = wp.grad(emitted_late)(real(0.0))
        h = whole()
        for k in range(size):
            low = x
            high = x
            low[k] = low[k] - CENTRAL_STEP
            high[k] = high[k] + CENTRAL_STEP
            change = (gradient_of(p, high) - gradient_of(p, low)) / (real(2.0) * CENTRAL_STEP)
            for j in range(size):
                h[j, k] = change[j]
        return h

    @wp.func
    def condensed(p: Parameters, x: vector):
        _late = wp.grad(emitted_late)(real(0.0))
        h = full_hessian(p, x)
        inner = square()
        for j in range(n):
            for k in range(n):
                inner[j, k] = h[3 + j, 3 + k]
        factor = cholesky(inner, LEAST_STIFFNESS * p.force_floor)
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
        c = real(0.5) * (c + wp.transpose(c))
        return stiffness(c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2], c[2, 2])

    return condensed
