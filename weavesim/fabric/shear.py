"""In-plane shear of the sheet: moment per reference area from the shear angle, its history and the crossover force.

All laws speak of one quantity, m = dpsi/dgamma [N/m]: an elastic part (``LinearShear`` or ``MomentCurve``) and, beside
it, the friction of the yarns that turn on each other (``ShearFriction``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ..checks import NotNegative, Parameters, Positive, at_most, positive_number
from ..errors import InputError
from .curve import Column, check_curve, interpolate, measured_columns

# Curves are tabulated up to here [rad].
LARGEST_SHEAR_ANGLE = 0.5 * math.pi
# Larger ones are in a wrong unit [m].
LARGEST_FRAME_SIDE = 5.0
LARGEST_FRICTION_LENGTH = 0.02


class LinearShear(Parameters):
    """The paper's law, equation (4): S_12 = G_12 E_12 with the tensor component E_12 of the Green-Lagrange strain.

    At small angles the stress is therefore G_12 gamma / 2: a modulus meant as tau/gamma has to be doubled here.
    """

    modulus: NotNegative = Field(description="G_12 of equation (4) [Pa]")

    def moment(self, angle: np.ndarray, thickness: float) -> np.ndarray:
        """m(gamma) = dpsi/dgamma at unit stretch, t/2 G_12 sin(gamma) cos(gamma) [N/m]."""
        return 0.5 * thickness * self.modulus * np.sin(angle) * np.cos(angle)


class MomentCurve(Parameters):
    """Shear moment per reference area m(gamma) [N/m] as a curve, odd in gamma, with a locking branch.

    Attributes:
        angle: increasing angles from 0 [rad].
        moment: m at these angles, without locking [N/m]; beyond the last angle its end slope (never negative) goes on.
        locking_angle: where the locking branch begins [rad].
        locking_stiffness: slope dm/dgamma that locking adds, at most a tenth of the yarn stiffness per width [N/m].
        locking_width: angle over which that slope builds up [rad].
    """

    angle: tuple[float, ...]
    moment_values: tuple[float, ...]
    locking_angle: Positive = math.radians(60.0)
    locking_stiffness: NotNegative = 0.0
    locking_width: Positive = math.radians(5.0)

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.angle, self.moment_values, ("angles", "moments"), from_zero=True)
        _check_radians(self.angle)
        if min(self.moment_values) < 0.0:
            raise ValueError(
                f"moments must not be negative (the smallest is {min(self.moment_values):.4g} N/m): shear may not "
                "release energy; take the machine's own force and noise off a test"
            )
        return self

    @classmethod
    def from_polynomial(
        cls, coefficients: Sequence[float], *, trusted_angle: float = math.radians(55.0), **locking: float
    ) -> MomentCurve:
        """m = c_1 gamma + c_2 gamma^2 + ... [N/m] for gamma > 0 in rad, ``coefficients`` from c_1 on.

        Beyond ``trusted_angle`` [rad] the curve goes on along its end slope.
        """
        angle = np.linspace(0.0, trusted_angle, 221)
        return cls(
            angle=tuple(angle),
            moment_values=tuple(np.polynomial.Polynomial((0.0, *coefficients))(angle)),
            **locking,
        )

    @classmethod
    def from_stress_polynomial(
        cls,
        tangent_coefficients: tuple[float, ...],
        thickness: float,
        *,
        convention: Literal["yarn frame", "moment"] = "yarn frame",
        trusted_angle: float = math.radians(55.0),
        **locking: float,
    ) -> MomentCurve:
        """A published d tau / d gamma = c_0 + c_1 gamma + ... [Pa], gamma in rad.

        convention "yarn frame": tau is a nominal shear stress over the yarn's current frame, m = t tau cos(gamma);
        "moment": m = t tau. Beyond ``trusted_angle`` the curve goes on along its end slope.
        """
        angle = np.linspace(0.0, trusted_angle, 221)
        stress = np.polynomial.Polynomial(tangent_coefficients).integ()(angle)
        if convention not in ("yarn frame", "moment"):
            raise InputError(f'convention = {convention!r}: "yarn frame" or "moment" is needed')
        factor = np.cos(angle) if convention == "yarn frame" else 1.0
        return cls(angle=tuple(angle), moment_values=tuple(thickness * stress * factor), **locking)

    @classmethod
    def from_picture_frame(
        cls,
        angle: Column,
        machine_force: Column,
        *,
        frame_side: float,
        fabric_side: float | None = None,
        **locking: float,
    ) -> MomentCurve:
        """The raw curve of a picture-frame test, by the power of the machine: F d' = A m gamma'.

        Args:
            angle: shear angles from 0 [rad].
            machine_force: force along the diagonal at these angles, that of the empty frame taken off [N].
            frame_side: distance of the hinges L [m]; the diagonal is d = 2 L cos(pi/4 - gamma/2).
            fabric_side: side of the sheared square of fabric [m]; the frame's if None.

        Raises:
            InputError: columns of unequal lengths or no numbers, sides that are not possible.
        """
        angle, force = measured_columns(angle=angle, machine_force=machine_force)
        frame_side, fabric_side = _checked_sides(frame_side, frame_side if fabric_side is None else fabric_side)
        moment = force * frame_side * np.sin(0.25 * math.pi - 0.5 * angle) / fabric_side**2
        return cls(angle=tuple(angle), moment_values=tuple(moment), **locking)

    @classmethod
    def from_normalised_force(
        cls,
        angle: Column,
        force_per_length: Column,
        *,
        convention: Literal["frame side", "fabric area"],
        frame_side: float | None = None,
        fabric_side: float | None = None,
        **locking: float,
    ) -> MomentCurve:
        """A normalised picture-frame curve [N/m]; F_s = F/(2 cos(pi/4 - gamma/2)) is the shear force along a side.

        Args:
            angle: shear angles from 0 [rad].
            force_per_length: the normalised force.
            convention: "frame side": F_s / L_frame, so m = N cos(gamma) (L_frame/L_fabric)^2, both sides needed;
                "fabric area": F_s L_frame / L_fabric^2, so m = N cos(gamma). Equal where the fabric fills the frame.
            frame_side, fabric_side: L_frame and L_fabric [m].

        Raises:
            InputError: another convention, columns of unequal lengths or no numbers, sides that are not possible.
        """
        ratio = 1.0
        if convention == "frame side":
            if frame_side is None or fabric_side is None:
                raise InputError('convention "frame side" needs frame_side and fabric_side [m]')
            frame_side, fabric_side = _checked_sides(frame_side, fabric_side)
            ratio = (frame_side / fabric_side) ** 2
        elif convention != "fabric area":
            raise InputError(f'convention = {convention!r}: "frame side" or "fabric area" is needed')
        angle, force = measured_columns(angle=angle, force_per_length=force_per_length)
        return cls(angle=tuple(angle), moment_values=tuple(force * np.cos(angle) * ratio), **locking)

    @classmethod
    def from_loading_and_unloading(
        cls, angle: Column, loading: Column, unloading: Column, **locking: float
    ) -> MomentCurve:
        """The elastic curve of a measured loop: its middle. ``ShearFriction`` has the other half.

        Args:
            angle: from 0 [rad].
            loading, unloading: moments per reference area on the way up and down [N/m].

        Raises:
            InputError: columns of unequal lengths or no numbers, or a middle below zero.
        """
        angle, up, down = measured_columns(angle=angle, loading=loading, unloading=unloading)
        return cls(angle=tuple(angle), moment_values=(0.0, *(0.5 * (up + down))[1:]), **locking)

    def moment(self, angle: np.ndarray, thickness: float = 0.0) -> np.ndarray:
        """m(gamma) [N/m], locking included."""
        size = np.abs(angle)
        x = np.maximum(size - self.locking_angle, 0.0)
        width = self.locking_width
        locking = self.locking_stiffness * np.where(x < width, x**2 / (2.0 * width), x - 0.5 * width)
        return np.sign(angle) * (interpolate(self.angle, self.moment_values, size) + locking)


class ShearFriction(Parameters):
    """Friction of the crossovers: a spring and a slider beside the elastic law, with a limit that yarn tension raises.

    The moment k (gamma - slip) keeps within limit(|gamma|) + crossover_friction_length * pressure, because the slip
    follows; pressure is the crossover force that the unit cell delivers, per reference area. Unloading starts along k
    and makes a loop whose height is twice the limit; what slipping loses is booked. A limit that depends on tension
    stores nothing, so no force along the yarns has to answer it: the law dissipates and never creates energy.

    Attributes:
        stiffness: k, slope before the yarns slip on each other, at most a tenth of the yarn stiffness per width [N/m].
        limit: moment at which they slip, without tension, at each of ``angle`` [N/m]; constant beyond the last.
        angle: increasing angles from 0 [rad].
        crossover_friction_length: friction coefficient times effective radius of a crossover's contact patch (two
            thirds of the radius of a round patch under even pressure) [m]. Each crossover adds that length times its
            force; per area of a crossover this is the length times the pressure.
    """

    stiffness: Positive
    limit: tuple[NotNegative, ...] = (0.0,)
    angle: tuple[float, ...] = (0.0,)
    crossover_friction_length: Annotated[
        NotNegative, at_most(LARGEST_FRICTION_LENGTH, "it is in metres, write 2e-4 for 0.2 mm")
    ] = 0.0

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.angle, self.limit, ("angles", "limits"), from_zero=False)
        _check_radians(self.angle)
        if max(self.limit) == 0.0 and self.crossover_friction_length == 0.0:
            raise ValueError("limit = 0 and crossover_friction_length = 0: such a friction does nothing, leave it out")
        return self

    @classmethod
    def from_loading_and_unloading(
        cls,
        angle: Column,
        loading: Column,
        unloading: Column,
        *,
        stiffness: float,
        crossover_friction_length: float = 0.0,
    ) -> ShearFriction:
        """The friction of a measured loop: half its height at each angle. ``MomentCurve`` has its middle.

        Args:
            angle: from 0 [rad].
            loading, unloading: moments per reference area on the way up and down [N/m].
            stiffness: slope at which unloading starts minus that of the middle [N/m].
            crossover_friction_length: as in the class [m].

        Raises:
            InputError: columns of unequal lengths or no numbers, or a loop without height.
        """
        angle, up, down = measured_columns(angle=angle, loading=loading, unloading=unloading)
        half = np.maximum(0.5 * (up - down), 0.0)
        # at zero angle the loop is closed or not measured: the friction does not vanish there
        return cls(
            stiffness=stiffness, angle=tuple(angle), limit=(half[1], *half[1:]),
            crossover_friction_length=crossover_friction_length,
        )  # fmt: skip

    def limit_at(self, angle: np.ndarray) -> np.ndarray:
        """Moment at which the yarns slip without tension [N/m]."""
        return np.interp(np.abs(angle), self.angle, self.limit)

    def moment_along(self, angle: np.ndarray, crossover_pressure: np.ndarray | float = 0.0) -> np.ndarray:
        """Friction moment [N/m] along a path of angles (n,) [rad] from rest, at pressures of the crossovers [Pa]."""
        angle = np.asarray(angle, dtype=float)
        pressure = np.maximum(np.broadcast_to(crossover_pressure, angle.shape), 0.0)
        free = (self.limit_at(angle) + self.crossover_friction_length * pressure) / self.stiffness
        slip, moment = 0.0, np.empty_like(angle)
        for i, (gamma, reach) in enumerate(zip(angle, free, strict=True)):
            slip = gamma - np.clip(gamma - slip, -reach, reach)
            moment[i] = self.stiffness * (gamma - slip)
        return moment


def _check_radians(angle: Sequence[float]) -> None:
    if angle[-1] > LARGEST_SHEAR_ANGLE:
        raise ValueError(
            f"the last angle is {angle[-1]:.4g} rad: angles must stay below pi/2 rad (1 degree is 0.01745 rad)"
        )


def _checked_sides(frame_side: float, fabric_side: float) -> tuple[float, float]:
    """Sides of frame and fabric [m]; InputError if they are not possible."""
    frame_side, fabric_side = (
        positive_number(name, side, largest=LARGEST_FRAME_SIDE, hint="it is in metres, write 0.25 for 250 mm")
        for name, side in (("frame_side", frame_side), ("fabric_side", fabric_side))
    )
    if fabric_side > frame_side:
        raise InputError(f"fabric_side = {fabric_side:.4g} m: at most that of the frame, {frame_side:.4g} m")
    return frame_side, fabric_side
