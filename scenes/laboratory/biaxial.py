"""Biaxial test: a square of fabric is pulled along both yarn families, in any ratio of their strains.

The whole border moves as the strains say, so that the state is uniform: what a unit cell does at these stretches. A
cruciform specimen has this state in its middle.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.closed_forms import yarn_forces
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

from ..fabric_test import DIRECTOR_DAMPING, STEP_SAFETY, FabricTestParameters, chosen_fabric, of_curves
from ..scene import Scene

RAMP_SHARE = 0.2

YARNS = ("warp", "weft")


class PulledSquareParameters(FabricTestParameters):
    """What tests that pull a square along both yarn families have in common."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.0125, description="edge length of an element [m]; the state is uniform, and any mesh is exact"
    )
    side: Annotated[Positive, Quantity("length", at_most=2.0)] = Field(
        default=0.05, description="side of the square [m]"
    )
    speed: Annotated[Positive, Quantity("speed")] = Field(
        default=0.02, description="speed at which the sides of the square part [m/s]"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=1000.0, description="mass-proportional damping rate [1/s]"
    )

    def blank_area(self) -> float:
        """Of the square [m^2]."""
        return self.side**2


class BiaxialParameters(PulledSquareParameters):
    """Parameters of a biaxial test."""

    out: Path = Field(default=Path("out/biaxial"), description="folder for the results")
    ratio: Annotated[NotNegative, Quantity("strain ratio")] = Field(
        default=1.0, description="strain of the weft over that of the warp; with 0 the weft is held"
    )
    largest_strain: Annotated[Positive, Quantity("strain", at_most=0.5)] = Field(
        default=0.01, description="of the family that is strained more"
    )

    abscissas = (Comparable("strain", "%", "largest_strain_percent"),)
    ordinates = (
        Comparable("warp force", "N/m", "warp_force_n_per_m"), Comparable("weft force", "N/m", "weft_force_n_per_m")
    )  # fmt: skip

    @property
    def strains(self) -> tuple[float, float]:
        """Largest strain of warp and weft."""
        return self.largest_strain * min(1.0, 1.0 / max(self.ratio, 1.0)), self.largest_strain * min(1.0, self.ratio)


def pulled_square(name: str, parameters: PulledSquareParameters, fabric: Fabric, strains: tuple[float, float]) -> Setup:
    """A square that is pulled by its border until warp and weft have these strains."""
    half = 0.5 * parameters.side
    blank = Blank.rectangle((-half, -half), (half, half), parameters.mesh_size)
    distance = max(strains) * parameters.side
    stroke = SmoothStroke.ramped(distance, parameters.speed, RAMP_SHARE * distance / parameters.speed)
    border = np.unique(blank.boundary_loop())
    drives = []
    for axis, share in enumerate(np.array(strains) / max(strains)):
        direction = np.zeros((len(border), 3))
        direction[:, axis] = blank.node_position[border, axis] / parameters.side
        # a family that is held has a drive too: the force along it is the family's
        drives.append(Drive(scaled(stroke, float(share)), direction))
    return Setup(
        name, sheets=(Sheet(blank, fabric, supports=(Support("border", border, tuple(drives)),)),),
        dynamics=Dynamics(damping=parameters.damping, director_damping=DIRECTOR_DAMPING),
        duration=stroke.duration, frame_count=parameters.frame_count,
        solver=parameters.solver(step_safety=STEP_SAFETY),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def scaled(stroke: SmoothStroke, share: float) -> SmoothStroke:
    """``share`` times a stroke."""
    return stroke.mapped(lambda d: share * d, lambda d: np.full_like(d, share))


def biaxial(parameters: BiaxialParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    return pulled_square("biaxial", parameters, fabric or chosen_fabric(parameters), parameters.strains)


def record(parameters: BiaxialParameters, fabric: Fabric) -> Curves:
    """Strains and forces of every frame, with those of the unit cell by itself."""

    def measure(state: Frame) -> dict[str, float]:
        strain = state.drive_displacement / parameters.side
        force = state.drive_force / parameters.side
        known = yarn_forces(fabric, 1.0 + strain[None])[0]
        return {
            "time_s": state.time,
            "largest_strain_percent": 100.0 * strain.max(),
            "warp_strain_percent": 100.0 * strain[0],
            "weft_strain_percent": 100.0 * strain[1],
            "warp_force_n_per_m": force[0],
            "weft_force_n_per_m": force[1],
            "closed_form_warp_force_n_per_m": known[0],
            "closed_form_weft_force_n_per_m": known[1],
            "crossover_pressure_pa": state.fields["crossover_pressure"].mean(),
        }

    return Curves("biaxial", measure, [
        Chart(
            "force", "Force per width of warp and weft",
            f"Against the strain of the family that is strained more; weft over warp strain {parameters.ratio:g}.",
            ("largest_strain_percent", "strain [%]"), "force per width [N/m]",
            {"warp_force_n_per_m": "warp", "weft_force_n_per_m": "weft"},
            {"closed_form_warp_force_n_per_m": "warp, unit cell", "closed_form_weft_force_n_per_m": "weft, unit cell"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries: forces at the last frame, and the largest deviation over the largest force."""
    c = curves.columns
    error = max(np.abs(c[f"{yarn}_force_n_per_m"] - c[f"closed_form_{yarn}_force_n_per_m"]).max() for yarn in YARNS)
    size = max(np.abs(c[f"closed_form_{yarn}_force_n_per_m"]).max() for yarn in YARNS)
    return {
        **{f"{yarn}_strain_percent": float(c[f"{yarn}_strain_percent"][-1]) for yarn in YARNS},
        **{f"{yarn}_force_n_per_m": float(c[f"{yarn}_force_n_per_m"][-1]) for yarn in YARNS},
        "largest_force_error_ratio": float(error / size) if size else None,
        **measured_differences(curves),
    }


def wanted(parameters: BiaxialParameters, setup: Setup) -> Wanted:
    """Curves of both families; no draw-in, since the border moves with the clamps."""
    return Wanted(curves=record(parameters, setup.sheet.fabric), draw_in=False)


SCENE = Scene(
    name="biaxial",
    help="Pull a woven fabric along both yarns.",
    parameters=BiaxialParameters,
    make=biaxial,
    wanted=wanted,
    findings=of_curves(findings),
)
