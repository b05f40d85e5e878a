"""Bias-extension test: a strip with its yarns at 45 degrees to the pull, clamped at both short ends.

With inextensible yarns the strip has three kinds of zones: C in the middle, where all yarns end at free edges, shears
as a trellis; B, where one family is clamped, shears half as much; A at the clamps does not shear.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.closed_forms import bias_zone_areas, moment_along, trellis_angle, trellis_angle_rate
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.strokes import SmoothStroke
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank

from .fabric_test import FabricTestParameters, chosen_fabric, of_curves, pulled_strip
from .scene import Scene

RAMP_SHARE = 0.2
# Across the width: the zone boundaries are one element wide.
SMALLEST_ELEMENT_COUNT = 8


class BiasExtensionParameters(FabricTestParameters):
    """Parameters of a bias-extension test."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.00625, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/bias_extension"), description="folder for the results")
    length: Annotated[Positive, Quantity("length", at_most=2.0)] = Field(
        default=0.2, description="length between the clamps [m]; at least twice the width"
    )
    width: Annotated[Positive, Quantity("length", at_most=1.0)] = Field(default=0.1, description="[m]")
    largest_angle: Annotated[Positive, Quantity("angle")] = Field(
        default=40.0, lt=80.0, description="kinematic shear angle of the central zone [degrees]"
    )
    speed: Annotated[Positive, Quantity("speed")] = Field(default=0.25, description="speed of the moving clamp [m/s]")
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=50.0, description="mass-proportional damping rate [1/s]"
    )

    abscissas = (Comparable("displacement", "mm", "displacement_mm"),)
    ordinates = (Comparable("force", "N", "force_n"), Comparable("angle", "deg", "zone_c_angle_deg"))

    @model_validator(mode="after")
    def _has_a_central_zone(self) -> Self:
        if self.length < 2.0 * self.width * (1.0 - 1.0e-9):
            raise ValueError(
                f"length = {self.length} m and width = {self.width} m: the length must be at least twice the width, so "
                "that the central zone reaches from edge to edge"
            )
        if round(self.width / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements across the width of "
                f"{self.width} m are needed to distinguish the zones; at most "
                f"{self.width / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    def blank_area(self) -> float:
        """Of the strip [m^2]."""
        return self.length * self.width

    @property
    def zone_length(self) -> float:
        """D = length - width: diagonal of the trellis that the central zone is part of [m]."""
        return self.length - self.width


def zones(parameters: BiasExtensionParameters, points: np.ndarray) -> np.ndarray:
    """0, 1, 2 for the zones A, B, C of flat points (..., 2) [m], the strip's centre at the origin."""
    from_clamp = 0.5 * parameters.length - np.abs(points[..., 0])
    off_axis = np.abs(points[..., 1])
    half = 0.5 * parameters.width
    return (from_clamp >= half - off_axis).astype(int) + (from_clamp >= half + off_axis)


def zone_areas(parameters: BiasExtensionParameters) -> tuple[float, float, float]:
    """Areas of the zones A, B, C [m^2]."""
    return bias_zone_areas(parameters.length, parameters.width)


def kinematic_angle(parameters: BiasExtensionParameters, displacement: float) -> tuple[float, float]:
    """Shear angle of the central zone [rad], and its rate over the displacement of the clamp [rad/m]."""
    side = math.sqrt(0.5) * parameters.zone_length
    diagonal = parameters.zone_length + displacement
    return float(trellis_angle(diagonal, side)), float(trellis_angle_rate(diagonal, side))


def closed_form_force(parameters: BiasExtensionParameters, fabric: Fabric, displacement: float) -> float:
    """Force on the clamp [N] from F d' = A_C m(gamma) gamma' + A_B m(gamma/2) gamma'/2, for inextensible yarns.

    It does not include yarn tension: of a friction that increases with tension it has only the part without tension.
    """
    angle, rate = kinematic_angle(parameters, displacement)
    _, half_zone, central_zone = zone_areas(parameters)
    path = np.linspace(0.0, angle, 101)
    moment, half_moment = (float(moment_along(fabric, share * path)[-1]) for share in (1.0, 0.5))
    return (central_zone * moment + 0.5 * half_zone * half_moment) * rate


def bias_extension(
    parameters: BiasExtensionParameters, fabric: Fabric | None = None, blank: Blank | None = None
) -> Setup:
    """The test.

    Args:
        parameters: of the test.
        fabric: replaces the preset and shear law in the parameters.
        blank: replaces the mesh with edges along the strip; the strip along x, its centre at the origin.
    """
    fabric = fabric or chosen_fabric(parameters)
    half_length, half_width = 0.5 * parameters.length, 0.5 * parameters.width
    if blank is None:
        blank = Blank.rectangle(
            (-half_length, -half_width), (half_length, half_width), parameters.mesh_size, yarn_angle=45.0
        )
    return pulled_strip("bias_extension", parameters, fabric, blank, clamp_stroke(parameters), parameters.damping)


def clamp_stroke(parameters: BiasExtensionParameters) -> SmoothStroke:
    """Displacement of the moving clamp, up to the largest kinematic angle."""
    half_angle = math.radians(0.5 * (90.0 - parameters.largest_angle))
    distance = parameters.zone_length * (math.sqrt(2.0) * math.cos(half_angle) - 1.0)
    return SmoothStroke.ramped(distance, parameters.speed, RAMP_SHARE * distance / parameters.speed)


def record(parameters: BiasExtensionParameters, fabric: Fabric, blank: Blank) -> Curves:
    """Zone angles and force of every frame, with the predictions of kinematics and shear law.

    A zone's angle is the mean of the elements with all corners inside it.
    """
    zone = zones(parameters, 0.999 * blank.material_coordinates[blank.quads])
    inside = [np.all(zone == index, axis=1) for index in range(3)]

    def measure(state: Frame) -> dict[str, float]:
        angle, _ = kinematic_angle(parameters, state.stroke)
        found = np.degrees(state.fields["shear_angle"])
        means = {
            f"zone_{name}_angle_deg": abs(found[chosen].mean()) if chosen.any() else math.nan
            for name, chosen in zip("abc", inside, strict=True)
        }
        return {
            "time_s": state.time,
            "displacement_mm": 1.0e3 * state.stroke,
            "kinematic_angle_deg": math.degrees(angle),
            "kinematic_half_angle_deg": 0.5 * math.degrees(angle),
            **means,
            "force_n": float(state.support_force[1, 0]),
            "fixed_clamp_force_n": -float(state.support_force[0, 0]),
            "closed_form_force_n": closed_form_force(parameters, fabric, state.stroke),
        }

    return Curves("bias_extension", measure, [
        Chart(
            "force", "Force of the clamps",
            "Force against displacement, with that of the shear law in three zones from the power balance.",
            ("displacement_mm", "displacement [mm]"), "force [N]",
            {"force_n": "moving clamp", "fixed_clamp_force_n": "fixed clamp"},
            {"closed_form_force_n": "shear law, three zones"},
        ),
        Chart(
            "zones", "Shear angle of the zones",
            "Mean of the elements entirely within a zone: A at the clamps, B next to them, C in the middle.",
            ("displacement_mm", "displacement [mm]"), "shear angle [degrees]",
            {"zone_c_angle_deg": "zone C", "zone_b_angle_deg": "zone B", "zone_a_angle_deg": "zone A"},
            {"kinematic_angle_deg": "kinematics, zone C", "kinematic_half_angle_deg": "kinematics, zone B"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries at the last frame; the force is the mean of both clamps."""
    c = {name: float(values[-1]) for name, values in curves.columns.items()}
    force = 0.5 * (c["force_n"] + c["fixed_clamp_force_n"])
    return {
        **{f"zone_{name}_angle_deg": c[f"zone_{name}_angle_deg"] for name in "abc"},
        "kinematic_angle_deg": c["kinematic_angle_deg"],
        "force_n": force,
        "closed_form_force_n": c["closed_form_force_n"],
        "force_ratio": force / c["closed_form_force_n"] if c["closed_form_force_n"] else None,
        **measured_differences(curves),
    }


def wanted(parameters: BiasExtensionParameters, setup: Setup) -> Wanted:
    """Curves of the zones and the force; no draw-in, since the border moves with the clamps."""
    return Wanted(curves=record(parameters, setup.sheet.fabric, setup.sheet.blank), draw_in=False)


SCENE = Scene(
    name="bias-extension",
    help="Pull a woven fabric in its bias direction.",
    parameters=BiasExtensionParameters,
    make=bias_extension,
    wanted=wanted,
    findings=of_curves(findings),
)
