"""Uniaxial test: a strip of fabric is pulled along one yarn family, clamped at its ends and free at its sides.

The yarns across are free to pull in, except near the clamps: far from these the strip is in the state in which the
family across carries no force.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.bending.law import YarnName
from weavesim.fabric.closed_forms import free_stretch, yarn_forces
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.strokes import SmoothStroke
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank

from ..fabric_test import FabricTestParameters, chosen_fabric, of_curves, pulled_strip
from ..scene import Scene

RAMP_SHARE = 0.2
# Across the width: the clamps' hold on the yarns across ends within about a width.
SMALLEST_ELEMENT_COUNT = 4
# Share of the length around the middle where the strain across is read.
MIDDLE = 0.4


class UniaxialParameters(FabricTestParameters):
    """Parameters of a uniaxial test; the strip is that of ISO 13934-1."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.01, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/uniaxial"), description="folder for the results")
    yarn: YarnName = Field(default="warp", description="yarn family along the pull")
    length: Annotated[Positive, Quantity("length", at_most=2.0)] = Field(
        default=0.2, description="length between the clamps [m]"
    )
    width: Annotated[Positive, Quantity("length", at_most=1.0)] = Field(default=0.05, description="[m]")
    largest_strain: Annotated[Positive, Quantity("strain", at_most=0.5)] = Field(
        default=0.01, description="displacement of the clamp over the length"
    )
    speed: Annotated[Positive, Quantity("speed")] = Field(default=0.1, description="speed of the moving clamp [m/s]")
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=500.0, description="mass-proportional damping rate [1/s]"
    )

    abscissas = (Comparable("strain", "%", "strain_percent"), Comparable("displacement", "mm", "displacement_mm"))
    ordinates = (Comparable("force", "N/m", "force_n_per_m"), Comparable("force", "N", "force_n"))

    @model_validator(mode="after")
    def _is_fine_enough(self) -> Self:
        if round(self.width / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements across the width of "
                f"{self.width} m are needed for the hold of the clamps; at most "
                f"{self.width / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    def blank_area(self) -> float:
        """Of the strip [m^2]."""
        return self.length * self.width


def uniaxial(parameters: UniaxialParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    fabric = fabric or chosen_fabric(parameters)
    half_length, half_width = 0.5 * parameters.length, 0.5 * parameters.width
    blank = Blank.rectangle(
        (-half_length, -half_width), (half_length, half_width), parameters.mesh_size,
        yarn_angle=0.0 if parameters.yarn == "warp" else 90.0,
    )  # fmt: skip
    distance = parameters.largest_strain * parameters.length
    stroke = SmoothStroke.ramped(distance, parameters.speed, RAMP_SHARE * distance / parameters.speed)
    return pulled_strip("uniaxial", parameters, fabric, blank, stroke, parameters.damping)


def record(parameters: UniaxialParameters, fabric: Fabric, blank: Blank) -> Curves:
    """Force and strains of every frame, with those of a strip that is free to pull in everywhere.

    The closed form has the strain of the clamps along the whole strip, and no force across: without the clamps' hold,
    the force is a little less.
    """
    pulled = 0 if parameters.yarn == "warp" else 1
    along, across = ("warp_stretch", "weft_stretch")[:: 1 - 2 * pulled]
    middle = np.abs(blank.element_centres()[:, 0]) < 0.5 * MIDDLE * parameters.length
    # on the whole path at once: a bisection per frame would take as long as the run
    path = 1.0 + np.linspace(0.0, parameters.largest_strain, 101)
    free = free_stretch(fabric, path, pulled=pulled)
    pair = (path, free) if pulled == 0 else (free, path)
    known = yarn_forces(fabric, np.stack(pair, axis=1))[:, pulled]

    def measure(state: Frame) -> dict[str, float]:
        stretch = 1.0 + state.stroke / parameters.length
        force = 0.5 * float(state.support_force[1, 0] - state.support_force[0, 0])
        return {
            "time_s": state.time,
            "displacement_mm": 1.0e3 * state.stroke,
            "strain_percent": 100.0 * (stretch - 1.0),
            "middle_strain_percent": 100.0 * (state.fields[along][middle].mean() - 1.0),
            "across_strain_percent": 100.0 * (state.fields[across][middle].mean() - 1.0),
            "force_n": force,
            "force_n_per_m": force / parameters.width,
            "closed_form_force_n": parameters.width * float(np.interp(stretch, path, known)),
            "closed_form_force_n_per_m": float(np.interp(stretch, path, known)),
            "closed_form_across_strain_percent": 100.0 * (float(np.interp(stretch, path, free)) - 1.0),
        }

    return Curves("uniaxial", measure, [
        Chart(
            "force", "Force per width", f"Pull along the {parameters.yarn}; strain is that of the clamps.",
            ("strain_percent", "strain [%]"), "force per width [N/m]", {"force_n_per_m": "computed"},
            {"closed_form_force_n_per_m": "unit cell, free to pull in"},
        ),
        Chart(
            "force_strain", "Force of the clamps", "Not divided by the width.",
            ("strain_percent", "strain [%]"), "force [N]", {"force_n": "computed"},
            {"closed_form_force_n": "unit cell, free to pull in"},
        ),
        Chart(
            "force_displacement", "Force of the clamps", "As the machine records it.",
            ("displacement_mm", "displacement [mm]"), "force [N]", {"force_n": "computed"},
            {"closed_form_force_n": "unit cell, free to pull in"},
        ),
        Chart(
            "across", "Strain across", "Mean around the middle of the strip.",
            ("strain_percent", "strain [%]"), "strain of the yarns across [%]",
            {"across_strain_percent": "computed"}, {"closed_form_across_strain_percent": "unit cell, free to pull in"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries at the last frame."""
    c = {name: float(values[-1]) for name, values in curves.columns.items()}
    known = c["closed_form_force_n_per_m"]
    return {
        **{name: c[name] for name in ("strain_percent", "middle_strain_percent", "across_strain_percent")},
        "force_n": c["force_n"],
        "force_n_per_m": c["force_n_per_m"],
        "closed_form_force_n_per_m": known,
        "force_ratio": c["force_n_per_m"] / known if known else None,
        **measured_differences(curves),
    }


def wanted(parameters: UniaxialParameters, setup: Setup) -> Wanted:
    """Curves of force and strains; no draw-in, since the border moves with the clamps."""
    return Wanted(curves=record(parameters, setup.sheet.fabric, setup.sheet.blank), draw_in=False)


SCENE = Scene(
    name="uniaxial",
    help="Pull a strip of woven fabric along one yarn.",
    parameters=UniaxialParameters,
    make=uniaxial,
    wanted=wanted,
    findings=of_curves(findings),
)
