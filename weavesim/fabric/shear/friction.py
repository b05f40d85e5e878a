"""Friction of the yarns that rotate on each other at the crossovers."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from ...checks import Kinded, NotNegative, Positive
from ...ranges import Quantity
from ..curve import Column, check_curve, check_loop, check_table, measured_columns, noise
from ..device_form import DeviceForm, Tabulated
from .law import LARGEST_SHEAR_ANGLE


class CrossoverFriction(Kinded):
    """Base class of shear friction: spring and slider parallel to the elastic law; kinds differ in the slider's limit.

    The moment k (gamma - slip) stays within the limit, because the slip follows. Unloading starts along k and forms a
    loop whose height is twice the limit; the work lost in slip is booked.
    """

    implied_kind: ClassVar[str | None] = "ShearFriction"

    stiffness: Annotated[Positive, Quantity("shear stiffness")] = Field(
        description="k, slope before the yarns slip, at most a tenth of the yarn stiffness per width [N/m]"
    )

    @abstractmethod
    def limit_under(self, angle: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """Moment at which the yarns slip [N/m], at angles [rad] and crossover pressures >= 0 [Pa]."""

    @abstractmethod
    def device_form(self) -> DeviceForm:
        """The law in the form that the kernels read."""

    @property
    def trusted_angle(self) -> float | None:
        """Angle up to which the limit is measured [rad]; None if it holds at any."""
        return None

    @property
    def pressed_by(self) -> str:
        """The value that makes the limit grow with the crossover pressure, as "name = value"; "" for none."""
        return ""

    def moment_along(self, angle: np.ndarray, crossover_pressure: np.ndarray | float = 0.0) -> np.ndarray:
        """Friction moment [N/m] along a path of angles (n,) [rad] from rest, at crossover pressures [Pa]."""
        angle = np.asarray(angle, dtype=float)
        pressure = np.maximum(np.broadcast_to(crossover_pressure, angle.shape), 0.0)
        free = self.limit_under(angle, pressure) / self.stiffness
        slip, moment = 0.0, np.empty_like(angle)
        for i, (gamma, reach) in enumerate(zip(angle, free, strict=True)):
            slip = gamma - np.clip(gamma - slip, -reach, reach)
            moment[i] = self.stiffness * (gamma - slip)
        return moment


class ShearFriction(CrossoverFriction):
    """Friction at the crossovers with a limit that depends on the angle and increases with yarn tension.

    The limit is ``limit(|gamma|) + crossover_friction_length * pressure``; pressure is the crossover force from the
    unit cell, per reference area. A limit that depends on tension stores no energy, so it has no counterpart in the
    forces along the yarns: the law dissipates and never creates energy.
    """

    limit: Annotated[tuple[NotNegative, ...], Quantity("friction moment")] = Field(
        default=(0.0,),
        description="moment at which the yarns slip without tension, at each angle; constant beyond the last [N/m]",
    )
    angle: Annotated[tuple[float, ...], Quantity("shear angle")] = Field(
        default=(0.0,), description="increasing angles from 0 [rad]"
    )
    crossover_friction_length: Annotated[NotNegative, Quantity("friction length")] = Field(
        default=0.0,
        description="friction coefficient times effective radius of a crossover's contact patch, two thirds of the "
        "radius of a round patch under uniform pressure; times the pressure, it is added to the limit [m]",
    )

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.angle, self.limit, ("angles", "limits"), from_zero=False)
        scatter = noise(np.array(self.angle), np.array(self.limit))
        check_table(self.limit_at, LARGEST_SHEAR_ANGLE, self.angle[-1], "rad", scatter)
        if max(self.limit) == 0.0 and self.crossover_friction_length == 0.0:
            raise ValueError("limit = 0 and crossover_friction_length = 0: this friction has no effect, leave it out")
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
        """Friction from a measured loop: half its height at each angle. ``MomentCurve`` takes its middle.

        Args:
            angle: from 0 [rad].
            loading, unloading: moments per reference area with increasing and decreasing angle [N/m].
            stiffness: slope at which unloading starts minus that of the middle curve [N/m].
            crossover_friction_length: as in the class [m].

        Raises:
            InputError: columns of unequal length or without numbers, or a loop without height.
        """
        angle, up, down = measured_columns(angle=angle, loading=loading, unloading=unloading)
        check_loop(up, down)
        half = np.maximum(0.5 * (up - down), 0.0)
        # at zero angle the loop is closed or was not measured, but friction does not vanish there
        return cls(
            stiffness=stiffness, angle=tuple(angle.tolist()), limit=(float(half[1]), *half[1:].tolist()),
            crossover_friction_length=crossover_friction_length,
        )  # fmt: skip

    def limit_at(self, angle: np.ndarray) -> np.ndarray:
        """Moment at which the yarns slip without tension [N/m], of the shape of the angles."""
        return np.interp(np.abs(angle), self.angle, self.limit)

    @property
    def trusted_angle(self) -> float | None:
        return self.angle[-1] if len(self.angle) > 1 else None

    def limit_under(self, angle: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        return self.limit_at(angle) + self.crossover_friction_length * pressure

    @property
    def pressed_by(self) -> str:
        length = self.crossover_friction_length
        return f"crossover_friction_length = {length:.4g} m" if length > 0.0 else ""

    def device_form(self) -> DeviceForm:
        return DeviceForm(
            "weavesim.kernels.laws.shear_friction",
            {"stiffness": self.stiffness, "crossover_friction_length": self.crossover_friction_length},
            {"limit": Tabulated(self.limit_at, LARGEST_SHEAR_ANGLE)},
        )
