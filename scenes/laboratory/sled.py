"""Friction sled: a weight with the fabric under it is pulled over a table, as in ISO 8295 and ASTM D1894.

The fabric is fixed to the sled: it moves as one, and is free only to settle on the table.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import Friction
from weavesim.process.loads import NodalLoads
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

from ..fabric_test import DIRECTOR_DAMPING, STEP_SAFETY, FabricTestParameters, chosen_fabric, of_curves
from ..scene import Scene

GRAVITY = 9.81
# The weight is laid down, then the sled is pulled; of the duration of the pull.
LAYING_SHARE, RAMP_SHARE = 0.2, 0.3
# Of the displacement, where the speed is constant: the mean is the kinetic friction.
KINETIC = 0.2, 0.8


class SledParameters(FabricTestParameters):
    """Parameters of a friction sled; size and mass are those of ISO 8295."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.0125, description="edge length of an element [m]; friction does not depend on it"
    )
    out: Path = Field(default=Path("out/sled"), description="folder for the results")
    side: Annotated[Positive, Quantity("length", at_most=1.0)] = Field(default=0.0635, description="of the sled [m]")
    mass: Annotated[Positive, Quantity("mass")] = Field(default=0.2, description="of the sled [kg]")
    friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.3, description="Coulomb coefficient between fabric and table"
    )
    distance: Annotated[Positive, Quantity("displacement")] = Field(default=0.02, description="of the pull [m]")
    speed: Annotated[Positive, Quantity("speed")] = Field(
        default=0.1, description="of the pull [m/s]; the law has no rate, so that it need not be the laboratory's"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=200.0, description="mass-proportional damping rate of the settling [1/s]"
    )

    abscissas = (Comparable("displacement", "mm", "displacement_mm"),)
    ordinates = (Comparable("force", "N", "force_n"), Comparable("coefficient", "-", "friction_coefficient"))

    @model_validator(mode="after")
    def _slides(self) -> Self:
        if self.friction == 0.0:
            raise ValueError("friction = 0: a sled without friction needs no force; give a coefficient above 0")
        return self

    def blank_area(self) -> float:
        """Of the fabric under the sled [m^2]."""
        return self.side**2


def normal_force(parameters: SledParameters, fabric: Fabric) -> float:
    """Weight of sled and fabric [N]."""
    return GRAVITY * (parameters.mass + fabric.areal_density * parameters.side**2)


def sled(parameters: SledParameters, fabric: Fabric | None = None, friction: Friction | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters, ``friction`` their coefficient."""
    fabric = fabric or chosen_fabric(parameters)
    half = 0.5 * parameters.side
    blank = Blank.rectangle((-half, -half), (half, half), parameters.mesh_size, height=0.5 * fabric.thickness)
    laying = LAYING_SHARE * parameters.distance / parameters.speed
    stroke = SmoothStroke.ramped(
        parameters.distance, parameters.speed, RAMP_SHARE * parameters.distance / parameters.speed, start_time=laying
    )
    force = np.zeros((blank.node_count, 3))
    force[:, 2] = -GRAVITY * parameters.mass * node_shares(blank)
    support = Support(
        "sled", np.arange(blank.node_count), (Drive(stroke, np.array([1.0, 0.0, 0.0])),), displacements="xy"
    )
    loads = NodalLoads(force, None, (0.0, 0.5 * laying), (0.0, 1.0))
    return Setup(
        "sled", sheets=(Sheet(blank, fabric, supports=(support,), loads=loads),),
        tools=(Tool("table", Plane(), friction=parameters.friction if friction is None else friction),),
        dynamics=Dynamics(
            gravity=(0.0, 0.0, -GRAVITY), damping=parameters.damping, director_damping=DIRECTOR_DAMPING
        ),
        duration=stroke.duration, frame_count=parameters.frame_count,
        solver=parameters.solver(step_safety=STEP_SAFETY),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def node_shares(blank: Blank) -> np.ndarray:
    """Share of each node in the area of a flat blank, (node_count,)."""
    corners = blank.node_position[blank.quads][:, :, :2]
    across, along = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area = 0.5 * np.abs(across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0])
    share = np.bincount(blank.quads.ravel(), np.repeat(0.25 * area, 4), minlength=blank.node_count)
    return share / area.sum()


def record(parameters: SledParameters, fabric: Fabric) -> Curves:
    """Force of every frame, with the coefficient times the weight."""
    weight = normal_force(parameters, fabric)

    def measure(state: Frame) -> dict[str, float]:
        # without tools' strokes the stroke of a frame is a tool's: the table does not move
        displacement = float(state.drive_displacement[0])
        force = float(state.drive_force[0])
        return {
            "time_s": state.time,
            "displacement_mm": 1.0e3 * displacement,
            "force_n": force,
            "normal_force_n": -float(state.tool_reaction[0, 2]),
            "friction_coefficient": force / weight,
            "closed_form_force_n": parameters.friction * weight if displacement > 0.0 else 0.0,
            "given_coefficient": parameters.friction if displacement > 0.0 else 0.0,
        }

    return Curves("sled", measure, [
        Chart(
            "force", "Force of the pull", "Of the sled against the friction of the table.",
            ("displacement_mm", "displacement [mm]"), "force [N]", {"force_n": "computed"},
            {"closed_form_force_n": "coefficient times weight"},
        ),
        Chart(
            "coefficient", "Coefficient of friction", "Force of the pull over the weight of sled and fabric.",
            ("displacement_mm", "displacement [mm]"), "force over weight", {"friction_coefficient": "computed"},
            {"given_coefficient": "given"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries: the largest force, and the mean of the middle of the pull."""
    c = curves.columns
    way = c["displacement_mm"] / max(c["displacement_mm"].max(), 1.0e-30)
    steady = (way > KINETIC[0]) & (way < KINETIC[1])
    force = float(c["force_n"][steady].mean()) if steady.any() else None
    known = float(c["closed_form_force_n"].max())
    return {
        "normal_force_n": float(c["normal_force_n"][-1]),
        "largest_force_n": float(c["force_n"].max()),
        "kinetic_force_n": force,
        "kinetic_friction_coefficient": float(c["friction_coefficient"][steady].mean()) if steady.any() else None,
        "closed_form_force_n": known,
        "force_ratio": force / known if force is not None and known else None,
        **measured_differences(curves),
    }


def wanted(parameters: SledParameters, setup: Setup) -> Wanted:
    """Curve of the force; no draw-in, since the border moves with the sled."""
    return Wanted(curves=record(parameters, setup.sheet.fabric), draw_in=False)


SCENE = Scene(
    name="sled",
    help="Pull a weight with a woven fabric under it over a table.",
    parameters=SledParameters,
    make=sled,
    wanted=wanted,
    findings=of_curves(findings),
)
