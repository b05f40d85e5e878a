"""A shear law from a measured curve, with constructors for the usual tests."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ...checks import NotNegative, Positive
from ...errors import InputError
from ...quantities import finite
from ...ranges import Quantity, argument
from ..curve import (
    CURVE_PIECE_COUNT,
    Column,
    Extrapolation,
    MeasuredCurve,
    check_curve,
    check_table,
    measured_columns,
    noise,
)
from ..device_form import DeviceForm, Tabulated
from .law import LARGEST_SHEAR_ANGLE, ShearLaw

# Spacing of the kernels' table: closer points count as one [rad].
RESOLUTION = LARGEST_SHEAR_ANGLE / CURVE_PIECE_COUNT


class MomentCurve(ShearLaw):
    """Shear moment per reference area m(gamma) [N/m] as a curve, odd in gamma, with a locking branch.

    Constructors take the other fields of the class as ``options``.
    """

    angle: Annotated[tuple[float, ...], Quantity("shear angle")] = Field(description="increasing angles from 0 [rad]")
    moment_values: Annotated[tuple[float, ...], Quantity("shear moment")] = Field(
        description="m at these angles, without locking; cubic between them, without overshoot [N/m]"
    )
    locking_angle: Annotated[Positive, Quantity("shear angle")] = Field(
        default=math.radians(60.0), description="start of the locking branch [rad]"
    )
    locking_stiffness: Annotated[NotNegative, Quantity("shear stiffness")] = Field(
        default=0.0,
        description="slope dm/dgamma that locking adds, at most a tenth of the yarn stiffness per width [N/m]",
    )
    locking_width: Annotated[Positive, Quantity("locking width")] = Field(
        default=math.radians(5.0), description="angle over which that slope builds up [rad]"
    )
    smoothing: Annotated[NotNegative, Quantity("friction moment")] = Field(
        default=0.0,
        description="root mean square distance from the points that the curve may have [N/m]; 0 goes through each, but "
        "for those closer than 0.18 degrees, which count as one",
    )
    extrapolation: Extrapolation = Field(
        default="end slope",
        description='beyond the last angle: "end slope" (at least 0), "constant", or "trusted": the end slope of a law '
        "that holds there too, so that its use is not reported",
    )

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.angle, self.moment_values, ("angles", "moments"), from_zero=True)
        scatter = noise(np.array(self.angle), np.array(self.moment_values))
        if max(self.moment_values) <= 0.0 > min(self.moment_values):
            raise ValueError(
                f"moments must not be negative, but all are (down to {min(self.moment_values):.4g} N/m): change the "
                "sign, which is the machine's; in a reference to a table, scale = -1"
            )
        if min(self.moment_values) < 0.0 and self.smoothing == 0.0:
            raise ValueError(
                f"moments must not be negative (the smallest is {min(self.moment_values):.4g} N/m): shear may not "
                "release energy; remove the machine's own force from the test data, and noise, for example with "
                f"smoothing = {scatter:.2g}"
            )
        check_table(self.measured, LARGEST_SHEAR_ANGLE, self.angle[-1], "rad", scatter)
        return self

    @property
    def measured(self) -> MeasuredCurve:
        """The curve without locking, of angles >= 0."""
        return MeasuredCurve.of_test(
            self.angle, self.moment_values, resolution=RESOLUTION, smoothing=self.smoothing,
            extrapolation=self.extrapolation,
        )  # fmt: skip

    @property
    def trusted_angle(self) -> float | None:
        return None if self.extrapolation == "trusted" else self.angle[-1]

    @classmethod
    def from_polynomial(
        cls, coefficients: Sequence[float], *, trusted_angle: float = math.radians(55.0), **options: Any
    ) -> MomentCurve:
        """m = c_1 gamma + c_2 gamma^2 + ... [N/m] for gamma > 0 in rad, ``coefficients`` from c_1 on.

        Beyond ``trusted_angle`` [rad] the curve is extrapolated with its end slope.

        Raises:
            InputError: no coefficients, or ones that are no numbers.
        """
        coefficients = _coefficients("coefficients", coefficients)
        angle = np.linspace(0.0, argument("trusted_angle", trusted_angle, "shear angle"), 221)
        return cls(
            angle=tuple(angle.tolist()),
            moment_values=tuple(np.polynomial.Polynomial((0.0, *coefficients))(angle).tolist()),
            **options,
        )

    @classmethod
    def from_stress_polynomial(
        cls,
        tangent_coefficients: tuple[float, ...],
        thickness: float,
        *,
        convention: Literal["yarn frame", "moment"] = "yarn frame",
        trusted_angle: float = math.radians(55.0),
        **options: Any,
    ) -> MomentCurve:
        """From a published d tau / d gamma = c_0 + c_1 gamma + ... [Pa], gamma in rad.

        convention "yarn frame": tau is a nominal shear stress over the yarn's current frame, m = t tau cos(gamma);
        "moment": m = t tau. Beyond ``trusted_angle`` the curve is extrapolated with its end slope.

        Raises:
            InputError: no coefficients, or ones that are no numbers.
        """
        tangent_coefficients = _coefficients("tangent_coefficients", tangent_coefficients)
        thickness = argument("thickness", thickness, "sheet thickness")
        angle = np.linspace(0.0, argument("trusted_angle", trusted_angle, "shear angle"), 221)
        stress = np.polynomial.Polynomial(tangent_coefficients).integ()(angle)
        if convention not in ("yarn frame", "moment"):
            raise InputError(f'convention = {convention!r}: "yarn frame" or "moment" is needed')
        factor = np.cos(angle) if convention == "yarn frame" else 1.0
        return cls(angle=tuple(angle.tolist()), moment_values=tuple((thickness * stress * factor).tolist()), **options)

    @classmethod
    def from_picture_frame(
        cls,
        angle: Column,
        machine_force: Column,
        *,
        frame_side: float,
        fabric_side: float | None = None,
        **options: Any,
    ) -> MomentCurve:
        """From the raw curve of a picture-frame test, by the power balance of the machine: F d' = A m gamma'.

        Args:
            angle: shear angles from 0 [rad].
            machine_force: force along the diagonal at these angles, minus that of the empty frame [N].
            frame_side: distance L between the hinges [m]; the diagonal is d = 2 L cos(pi/4 - gamma/2).
            fabric_side: side of the sheared square of fabric [m]; that of the frame if None.

        Raises:
            InputError: columns of unequal length or without numbers, or impossible sides.
        """
        angle, force = measured_columns(angle=angle, machine_force=machine_force)
        frame_side, fabric_side = _checked_sides(frame_side, frame_side if fabric_side is None else fabric_side)
        moment = force * frame_side * np.sin(0.25 * math.pi - 0.5 * angle) / fabric_side**2
        return cls(angle=tuple(angle.tolist()), moment_values=tuple(moment.tolist()), **options)

    @classmethod
    def from_normalised_force(
        cls,
        angle: Column,
        force_per_length: Column,
        *,
        convention: Literal["frame side", "fabric area"],
        frame_side: float | None = None,
        fabric_side: float | None = None,
        **options: Any,
    ) -> MomentCurve:
        """From a normalised picture-frame curve [N/m]; F_s = F/(2 cos(pi/4 - gamma/2)) is the force along a side.

        Args:
            angle: shear angles from 0 [rad].
            force_per_length: the normalised force.
            convention: "frame side": F_s / L_frame, so m = N cos(gamma) (L_frame/L_fabric)^2, both sides needed;
                "fabric area": F_s L_frame / L_fabric^2, so m = N cos(gamma). Equal where the fabric fills the frame.
            frame_side, fabric_side: L_frame and L_fabric [m].

        Raises:
            InputError: an unknown convention, columns of unequal length or without numbers, or impossible sides.
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
        return cls(
            angle=tuple(angle.tolist()), moment_values=tuple((force * np.cos(angle) * ratio).tolist()), **options
        )

    @classmethod
    def from_loading_and_unloading(
        cls, angle: Column, loading: Column, unloading: Column, **options: Any
    ) -> MomentCurve:
        """Elastic curve from a measured loop: its middle. ``ShearFriction`` takes half its height.

        Args:
            angle: from 0 [rad].
            loading, unloading: moments per reference area with increasing and decreasing angle [N/m].

        Raises:
            InputError: columns of unequal length or without numbers, or a middle below zero.
        """
        angle, up, down = measured_columns(angle=angle, loading=loading, unloading=unloading)
        return cls(angle=tuple(angle.tolist()), moment_values=(0.0, *(0.5 * (up + down))[1:].tolist()), **options)

    def moment(self, angle: np.ndarray, thickness: float = 0.0) -> np.ndarray:
        """m(gamma) [N/m], including locking, of the shape of the angles."""
        size = np.abs(angle)
        x = np.maximum(size - self.locking_angle, 0.0)
        width = self.locking_width
        locking = self.locking_stiffness * np.where(x < width, x**2 / (2.0 * width), x - 0.5 * width)
        return np.sign(angle) * (self.measured(size) + locking)

    def device_form(self, thickness: float) -> DeviceForm:
        table = Tabulated(lambda angle: self.moment(angle, thickness), LARGEST_SHEAR_ANGLE)
        return DeviceForm("weavesim.kernels.laws.moment_curve", curves={"curve": table})

    @property
    def locking_slope(self) -> float:
        return self.locking_stiffness

    def locking_at_most(self, slope: float) -> Self:
        return self.model_copy(update={"locking_stiffness": min(self.locking_stiffness, slope)})


def _checked_sides(frame_side: float, fabric_side: float) -> tuple[float, float]:
    """Sides of frame and fabric [m]; raises InputError if they are impossible."""
    frame_side, fabric_side = (
        argument(name, side, "frame side") for name, side in (("frame_side", frame_side), ("fabric_side", fabric_side))
    )
    if fabric_side > frame_side:
        raise InputError(f"fabric_side = {fabric_side:.4g} m: must not exceed that of the frame, {frame_side:.4g} m")
    return frame_side, fabric_side


def _coefficients(name: str, values: Sequence[float]) -> tuple[float, ...]:
    if isinstance(values, str) or not np.iterable(values) or not len(values):
        raise InputError(f"{name} = {values!r}: a list of at least one number is needed")
    return tuple(finite(f"{name}[{row}]", value) for row, value in enumerate(values))
