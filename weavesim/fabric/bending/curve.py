"""Bending of one yarn family by a measured curve, with friction between its fibres."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from ...checks import Kinded, NotNegative
from ...ranges import Quantity, argument
from ..curve import (
    CURVE_PIECE_COUNT,
    Column,
    Extrapolation,
    MeasuredCurve,
    check_curve,
    check_loop,
    check_table,
    measured_columns,
    noise,
)

# A test that ends at a larger radius than 0.2 m says little of draping: the curvature is probably in 1/cm [1/m].
SMALLEST_USUAL_CURVATURE = 5.0


class FamilyBending(Kinded):
    """Base class for the bending of one yarn family that is not a constant stiffness: an odd moment-curvature relation.

    The moment per width is M(kappa) + M_f, where M_f = friction_stiffness (kappa - slip) stays within the friction
    limit because the slip follows: bending starts with the slope of both, softens to that of M alone, and unloads along
    a loop whose height is twice the limit. The work lost in slip is booked.
    """

    friction_limit: Annotated[NotNegative, Quantity("bending moment")] = Field(
        default=0.0, description="largest friction moment [N]"
    )
    friction_stiffness: Annotated[NotNegative, Quantity("bending stiffness")] = Field(
        default=0.0, description="slope that friction adds before it slips [N m]"
    )

    @property
    @abstractmethod
    def end(self) -> float:
        """Curvature up to which the moment is tabulated; linear beyond [1/m]."""

    @abstractmethod
    def moment(self, curvature: np.ndarray) -> np.ndarray:
        """Elastic moment per width [N], of the shape of the curvatures."""

    @property
    @abstractmethod
    def is_constant(self) -> bool:
        """True for a single slope without friction: moment and curvature are proportional."""

    @property
    def trusted_curvature(self) -> float | None:
        """Curvature up to which the curve is measured [1/m]; None if it holds at any."""
        return None

    @property
    def initial_stiffness(self) -> float:
        """Slope at zero curvature, without friction [N m]."""
        step = 1.0e-6 * self.end
        return float(self.moment(np.array(step)) / step)

    @property
    def largest_stiffness(self) -> float:
        """Upper bound of the slope, including friction [N m]."""
        x = np.linspace(0.0, self.end, 2001)
        return float(np.max(np.diff(self.moment(x)) / np.diff(x))) * 1.01 + self.friction_stiffness

    @property
    def typical_stiffness(self) -> float:
        """Mean of moment over curvature along the curve, including friction [N m]."""
        x = np.linspace(0.0, self.end, 101)[1:]
        friction = np.minimum(self.friction_stiffness * x, self.friction_limit)
        return float(np.mean((self.moment(x) + friction) / x))


class BendingCurve(FamilyBending):
    """Moment per width over curvature of one yarn family."""

    curvature: Annotated[tuple[float, ...], Quantity("curvature")] = Field(
        kw_only=True, description="increasing curvatures from 0 [1/m]"
    )
    moment_values: Annotated[tuple[float, ...], Quantity("bending moment")] = Field(
        kw_only=True, description="M at these, moment per width in N m/m; cubic between them, without overshoot [N]"
    )
    smoothing: Annotated[NotNegative, Quantity("bending moment")] = Field(
        default=0.0,
        description="root mean square distance from the points that the curve may have [N]; 0 goes through each, but "
        "for those closer than 1/512 of the last curvature, which count as one",
    )
    extrapolation: Extrapolation = Field(
        default="end slope",
        description='beyond the last curvature: "end slope" (at least 0), "constant", or "trusted": the end slope of a '
        "law that holds there too, so that its use is not reported",
    )

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        check_curve(self.curvature, self.moment_values, ("curvatures", "moments"), from_zero=True)
        scatter = noise(np.array(self.curvature), np.array(self.moment_values))
        if min(self.moment_values) < 0.0 and self.smoothing == 0.0:
            if max(self.moment_values) <= 0.0:
                raise ValueError("moments must not be negative, but all are: change the sign, which is the machine's")
            raise ValueError(
                "moments must not be negative: bending may not release energy; noise can be smoothed, for example with "
                f"smoothing = {scatter:.2g}"
            )
        check_table(self.measured, self.end, self.end, "1/m", scatter)
        if self.friction_limit > 0.0 and self.friction_stiffness == 0.0:
            raise ValueError(
                f"friction_limit = {self.friction_limit:.4g} N needs a friction_stiffness [N m]: the slope before slip"
            )
        return self

    def disproportions(self) -> Iterator[str]:
        if self.trusted_curvature is not None and self.end < SMALLEST_USUAL_CURVATURE:
            yield (
                f"curvature goes to {self.end:.4g} 1/m only, a radius of {1.0 / self.end:.3g} m; usual tests go to "
                f"{SMALLEST_USUAL_CURVATURE:g} 1/m and more: write {100.0 * self.end:.4g} for {self.end:.4g} 1/cm"
            )

    @classmethod
    def straight(cls, stiffness: float) -> BendingCurve:
        """A constant bending stiffness per width [N m]."""
        return cls(curvature=(0.0, 1.0), moment_values=(0.0, stiffness), extrapolation="trusted")

    @classmethod
    def from_loading_and_unloading(
        cls,
        curvature: Column,
        loading: Column,
        unloading: Column,
        *,
        friction_stiffness: float,
    ) -> BendingCurve:
        """From a measured loop: its middle is the elastic curve, half its mean height the friction limit.

        Args:
            curvature: from 0 [1/m].
            loading, unloading: moments per width at these curvatures with increasing and decreasing curvature [N].
            friction_stiffness: initial slope of the test minus that of the middle curve [N m].

        Raises:
            InputError: columns of unequal length or without numbers, or unloading above loading.
        """
        curvature, up, down = measured_columns(curvature=curvature, loading=loading, unloading=unloading)
        check_loop(up, down)
        middle = 0.5 * (up + down)
        middle = np.maximum(middle - middle[0], 0.0)
        return cls(
            curvature=tuple(curvature.tolist()), moment_values=tuple(middle.tolist()),
            friction_limit=float(np.mean(0.5 * (up - down)[1:])), friction_stiffness=friction_stiffness,
        )  # fmt: skip

    @classmethod
    def from_kawabata(cls, rigidity: float, hysteresis: float, *, slip_curvature: float = 10.0) -> BendingCurve:
        """From the two numbers of the Kawabata pure-bending test (KES-FB2): M = B kappa with a loop of height 2HB.

        Args:
            rigidity: B, the slope [N m] (moment per width over curvature).
            hysteresis: 2HB, the height of the loop [N].
            slip_curvature: curvature at which the friction begins to slip [1/m].

        Raises:
            InputError: a slip curvature that is not above 0, or negative numbers.
        """
        rigidity = argument("rigidity", rigidity, "bending stiffness", zero=True)
        hysteresis = argument("hysteresis", hysteresis, "bending moment", zero=True)
        slip_curvature = argument("slip_curvature", slip_curvature, "curvature")
        return cls(
            curvature=(0.0, 1.0), moment_values=(0.0, rigidity), extrapolation="trusted",
            friction_limit=0.5 * hysteresis, friction_stiffness=0.5 * hysteresis / slip_curvature,
        )  # fmt: skip

    @property
    def end(self) -> float:
        return self.curvature[-1]

    def moment(self, curvature: np.ndarray) -> np.ndarray:
        return np.sign(curvature) * self.measured(np.abs(curvature))

    @property
    def measured(self) -> MeasuredCurve:
        """The curve of curvatures >= 0."""
        return MeasuredCurve.of_test(
            self.curvature, self.moment_values, resolution=self.end / CURVE_PIECE_COUNT, smoothing=self.smoothing,
            extrapolation=self.extrapolation,
        )  # fmt: skip

    @property
    def trusted_curvature(self) -> float | None:
        return None if self.extrapolation == "trusted" else self.end

    @property
    def is_constant(self) -> bool:
        slope = np.array(self.moment_values[1:]) / np.array(self.curvature[1:])
        straight = bool(np.ptp(slope) <= 1.0e-9 * slope.max()) and self.extrapolation != "constant"
        return self.friction_limit == 0.0 and straight
