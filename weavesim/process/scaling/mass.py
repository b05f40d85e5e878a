"""What a search for the largest mass scaling found: its tolerances, its tries, and the time step that was chosen."""

from __future__ import annotations

from typing import Annotated, TypedDict

from pydantic import Field

from ...checks import NotNegative, Parameters, Positive, Share
from ...ranges import Quantity

# Share of the elements whose angles keep the tolerance.
KEPT_SHARE = 0.95
# Tolerances of the shear angles [degrees], and of the border [m].
ANGLE_TOLERANCE, DRAW_IN_TOLERANCE = 0.5, 0.5e-3


class Tolerances(TypedDict):
    """What a mass scaling has to keep, as arguments of ``choose_mass_scaling``."""

    angle_tolerance: float
    draw_in_tolerance: float


def tolerances_of(angle: float | None, draw_in: float | None) -> Tolerances | None:
    """Tolerances [degrees], [m]: the usual one for one that is not given; None if neither is."""
    if angle is None and draw_in is None:
        return None
    return {
        "angle_tolerance": ANGLE_TOLERANCE if angle is None else angle,
        "draw_in_tolerance": DRAW_IN_TOLERANCE if draw_in is None else draw_in,
    }


class ScalingTry(Parameters):
    """One factor on the coarse mesh, compared with the run without scaling.

    Attributes:
        factor: of the time step; that of the mass is its square.
        angle_error: change of the shear angle that ``kept_share`` of the elements stay below [degrees]; None for a run
            that stopped.
        draw_in_error: largest change of the border's positions [m]; None for a run that stopped.
        kinetic_ratio: kinetic over internal energy, of the summary; None where nothing was stored.
        speed_up: steps of the unscaled run over those of this one.
        accepted: whether both errors are within their tolerances.
    """

    factor: Positive
    angle_error: NotNegative | None
    draw_in_error: NotNegative | None
    kinetic_ratio: NotNegative | None
    speed_up: Positive
    accepted: bool

    @property
    def line(self) -> str:
        """For readers."""
        head = f"step x {self.factor:g} (mass x {self.factor**2:g})"
        if self.angle_error is None or self.draw_in_error is None:
            return f"{head}: the run stopped: too much"
        ratio = "" if self.kinetic_ratio is None else f", kinetic over internal energy {self.kinetic_ratio:.2g}"
        return (
            f"{head}: {self.angle_error:.2g} degrees, {1e3 * self.draw_in_error:.2g} mm, {self.speed_up:.1f} times "
            f"fewer steps{ratio}: {'kept' if self.accepted else 'too much'}"
        )


class MassScaling(Parameters):
    """What was chosen, and why; ``Solver`` takes it beside its ``target_step``, so that a run can tell.

    Attributes:
        factor: of the time step, 1 where nothing was accepted.
        target_step: that gives it on the mesh of the run [s]; None without scaling.
        mesh_size, coarse_size: of the run and of the tries [m].
        angle_tolerance, draw_in_tolerance: as given [degrees], [m].
        kept_share: of the elements, whose angles keep the tolerance.
        tries: in order; the last may not have been accepted.
    """

    factor: Annotated[float, Field(ge=1.0)]
    target_step: Annotated[Positive, Quantity("time step")] | None
    mesh_size: Annotated[Positive, Quantity("mesh size")]
    coarse_size: Annotated[Positive, Quantity("mesh size")]
    angle_tolerance: Annotated[Positive, Quantity("angle error")]
    draw_in_tolerance: Annotated[Positive, Quantity("position error")]
    kept_share: Share = KEPT_SHARE
    tries: tuple[ScalingTry, ...] = ()

    def report(self) -> str:
        """What was tried and chosen, for readers."""
        lines = [
            f"mass scaling for {self.angle_tolerance:g} degrees at {self.kept_share:.0%} of the elements and "
            f"{1e3 * self.draw_in_tolerance:g} mm of draw-in, tried on elements of {1e3 * self.coarse_size:.3g} mm:"
        ]
        lines += [f"  {each.line}" for each in self.tries]
        if self.target_step is None:
            return "\n".join([*lines, "no scaling keeps these tolerances: run without"])
        return "\n".join([*lines, f"chosen: step x {self.factor:g}, target_step = {self.target_step:.4g} s"])

    def as_told(self) -> dict[str, object]:
        """For summary.json: units in the names."""
        units = {
            "target_step": "target_step_s", "mesh_size": "mesh_size_m", "coarse_size": "coarse_mesh_size_m",
            "angle_tolerance": "angle_tolerance_deg", "draw_in_tolerance": "draw_in_tolerance_m",
            "angle_error": "angle_error_deg", "draw_in_error": "draw_in_error_m",
        }  # fmt: skip
        values = self.model_dump()
        tries = [{units.get(name, name): value for name, value in each.items()} for each in values.pop("tries")]
        return {**{units.get(name, name): value for name, value in values.items()}, "tries": tries}
