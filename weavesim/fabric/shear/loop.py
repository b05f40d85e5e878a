"""What loading and unloading in shear say of elastic moment and friction, and what is assumed without unloading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ..curve import Column, measured_columns
from .friction import ShearFriction
from .loop_fit import fitted, prepared
from .moment_curve import MomentCurve

if TYPE_CHECKING:
    from ..fabric import Fabric

# Points of the friction limit that are tried beside one; more must be worth it.
LIMIT_POINT_COUNTS = (2, 4)
# Residuals above this multiple of the noise are of a loop that has another form.
WELL_FITTED = 2.0


@dataclass(frozen=True)
class LoopSplit:
    """Elastic moment and friction of a measured loop.

    Attributes:
        elastic: the elastic law.
        friction: the friction; None if the loop has no height beyond its noise.
        limit_angle, limit_error: angles at which the limit was fitted (m,) [rad], and half of its 95 % interval [N/m].
        stiffness_interval: 95 % interval of the friction's stiffness [N/m].
        residual: root mean square distance of the test from both laws together [N/m].
        noise: standard deviation of the test from one point to the next [N/m].
        unloaded_between: smallest and largest angle at which unloading tells the friction [rad].
        notes: what one should know before using it.
    """

    elastic: MomentCurve
    friction: ShearFriction | None
    limit_angle: np.ndarray
    limit_error: np.ndarray
    stiffness_interval: tuple[float, float]
    residual: float
    noise: float
    unloaded_between: tuple[float, float]
    notes: tuple[str, ...]


def split_loop(
    angle: Column, moment: Column, *, from_rest: bool = True, crossover_friction_length: float = 0.0, **options: Any
) -> LoopSplit:
    """Elastic moment and friction of a test that loads and unloads, by least squares over the whole of it.

    The test is followed by an elastic curve and a spring and slider (``ShearFriction``), so that the start and the
    place where unloading sets in, in which friction has not its limit, do no harm. Below and above the angles at which
    unloading was measured the limit stays what it is at their ends.

    Args:
        angle: shear angle along the test, in the order of time, once or several times up and down (n,) [rad].
        moment: per reference area (n,) [N/m], as ``MomentCurve`` makes it from forces; without the machine's own.
        from_rest: the test starts with a fresh specimen; False for one that was sheared before, whose friction at
            the start is fitted too.
        crossover_friction_length: of the friction, which a test without tension does not tell [m].
        options: other fields of ``MomentCurve``.

    Raises:
        InputError: columns of unequal length or without numbers, no unloading, unloading above loading, or too few
            points.
    """
    angle, moment = measured_columns(angle=angle, moment=moment)
    test, notes = prepared(angle, moment)
    first = fitted(test, 1, from_rest)
    others = [fitted(test, count, from_rest, first) for count in LIMIT_POINT_COUNTS]
    best = min([first, *others], key=lambda fit: fit.criterion)
    if best.residual > WELL_FITTED * test.scatter + 0.01 * test.largest:
        notes.append(
            f"the test is {best.residual:.3g} N/m from both laws together, and its noise is {test.scatter:.3g} N/m: "
            "its loop has another form"
        )
    elastic = MomentCurve(
        angle=tuple(best.knots.tolist()), moment_values=(0.0, *np.maximum(best.elastic[1:], 0.0).tolist()), **options
    )
    friction = None
    if best.limits.max() > max(3.0 * test.scatter / math.sqrt(len(test.angle)), 1.0e-3 * test.largest):
        limits, knots = best.limits, best.limit_knots
        if knots[0] > 0.0:  # the limit below the unloading is that at its end
            limits, knots = np.append(limits[0], limits), np.append(0.0, knots)
        friction = ShearFriction(
            stiffness=best.stiffness, limit=tuple(limits.tolist()), angle=tuple(knots.tolist()),
            crossover_friction_length=crossover_friction_length,
        )  # fmt: skip
    else:
        notes.append("the loop has no height beyond its noise: all is elastic")
    return LoopSplit(
        elastic, friction, best.limit_knots, best.limit_error, best.stiffness_interval, best.residual, test.scatter,
        test.unloaded_between, tuple(notes),
    )  # fmt: skip


def split_jump(
    angle: Column, moment: Column, *, line: tuple[float, float], onset: float
) -> tuple[np.ndarray, ShearFriction]:
    """An assumption where only loading is known: what the moment jumps up by at the start is friction.

    The jump is the value at zero of a straight line through the points within ``line``. A test to which it is applied
    loads as before; what it does when it unloads is assumed.

    Args:
        angle: increasing (n,) [rad].
        moment: (n,) [N/m].
        line: angles between which the moment rises along a line behind the jump [rad].
        onset: angle at which the jump is over [rad].

    Returns:
        The elastic moment at the angles (n,) [N/m], and the friction.

    Raises:
        InputError: fewer than three points within ``line``, or no jump.
    """
    angle, moment = measured_columns(angle=angle, moment=moment)
    on_line = (angle >= line[0] * (1.0 - 1.0e-9)) & (angle <= line[1] * (1.0 + 1.0e-9))
    if np.count_nonzero(on_line) < 3:
        low, high = np.degrees(line)
        raise InputError(f"line = {low:.3g} to {high:.3g} degrees: at least three points are needed there")
    limit = float(np.polynomial.Polynomial.fit(angle[on_line], moment[on_line], 1)(0.0))
    if limit <= 0.0:
        raise InputError(f"the line through these points is {limit:.3g} N/m at zero: there is no jump, so no friction")
    friction = ShearFriction(stiffness=limit / onset, limit=(limit,))
    return np.maximum(moment - friction.moment_along(angle), 0.0), friction


def unloading_doubt(fabric: Fabric) -> str:
    """Why nobody knows what a fabric does when its shear is reversed; "" if that is measured, or nothing is said.

    Elastic moment and friction load alike; unloading tells them apart. A fabric of which everything is assumed makes no
    claim at all.
    """
    if "everything" in fabric.assumed:
        return ""
    if fabric.shear_friction is None:
        origin = fabric.origin_of("shear_friction")
        if origin is None and fabric.shear.trusted_angle is not None:
            return "no unloading is known: all of the measured moment is taken as elastic"
    else:
        names = ["limit", *type(fabric.shear_friction).model_fields]
        origins = [fabric.origin_of(f"shear_friction.{name}") for name in names]
        origin = next((one for one in origins if one is not None and one.assumed), None)
    return "; ".join(filter(None, [origin.source, origin.note])) if origin is not None and origin.assumed else ""
