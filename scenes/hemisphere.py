"""A square cloth falls onto a ball under gravity and wrinkles, after Figure 5 of the paper.

The same two cases: low bending with high shear stiffness, which can hardly shear and therefore folds, and high bending
with low shear stiffness, which shears over the ball and hangs in few, large folds. The paper gives no numbers: size,
fabric and ball are assumed here.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.app.options import RunOptions
from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.shear import MomentCurve
from weavesim.measures.folds import rim_folds
from weavesim.measures.proximity import close_pairs
from weavesim.process.dynamics import Dynamics
from weavesim.process.friction import Coulomb
from weavesim.process.self_contact import SelfContact
from weavesim.ranges import Quantity
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

from .scene import Scene

if TYPE_CHECKING:
    from weavesim.run.simulation import Simulation

GRAVITY = 9.81
CASES = ("low-bending", "high-bending")
# Sheet bending stiffness [N m] and shear moment per angle [N/m] for each case.
BENDING_STIFFNESS = {"low-bending": 1.0e-5, "high-bending": 1.0e-4}
SHEAR_STIFFNESS = {"low-bending": 50.0, "high-bending": 0.2}
# Directors vibrate a thousand times faster than the cloth falls [1/s].
DIRECTOR_DAMPING = 1.0e3
# No real cloth is perfectly even: a random initial velocity, smooth so that it is the same on every mesh, triggers the
# folds; damping stops it within about 3 mm. Without it the square's symmetry may keep the cloth at four folds [m/s].
UNEVENNESS = 0.05
# Over a quarter of the ball, and from the middle of the cloth to its edge.
SMALLEST_ELEMENT_COUNT = 8
UNEVENNESS_WAVES = range(2, 17)


class HemisphereParameters(RunOptions):
    """Parameters of a hemisphere drape."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.005, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/hemisphere"), description="folder for the results, a subfolder for each case")
    case: Literal["low-bending", "high-bending", "both"] = Field(
        default="both", description="low bending with high shear stiffness, the reverse, or both"
    )
    side: Annotated[Positive, Quantity("length")] = Field(default=0.4, description="side of the square cloth [m]")
    radius: Annotated[Positive, Quantity("length")] = Field(default=0.1, description="radius of the ball [m]")
    friction: Annotated[NotNegative, Quantity("friction")] = Field(
        default=0.3, description="Coulomb coefficient between cloth and ball"
    )
    self_contact: bool = Field(
        default=False, description="the cloth meets itself in folds, with the friction of cloth and ball"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=15.0, description="mass-proportional damping rate, from air drag [1/s]"
    )
    duration: Annotated[Positive, Quantity("duration")] = Field(
        default=2.0, description="time to fall and come to rest [s]"
    )
    seed: int = Field(default=0, ge=0, description="random seed of the unevenness that triggers the folds")
    frame_count: int = Field(default=60, ge=1, description="frames after the first")

    @model_validator(mode="after")
    def _is_fine_enough(self) -> Self:
        length = min(0.5 * math.pi * self.radius, 0.5 * self.side)
        if round(length / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements over a quarter of the "
                f"ball of radius {self.radius} m, and from the middle of the cloth to its edge, are needed; at most "
                f"{length / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    def blank_area(self) -> float:
        """Of the cloth [m^2]."""
        return self.side**2


def cloth(case: str) -> Fabric:
    """A light cloth of one of the two cases; all values are assumed.

    For a larger time step the yarns are soft: the cloth stretches by about 0.1 % under its own weight.
    """
    thickness, spacing, cross_section = 1.0e-3, 1.0e-3, 1.0e-8
    axial_stiffness = 5.0  # E A of a yarn [N]
    yarn_bending = 2.0e-8  # E I of a yarn [N m^2]
    modulus = axial_stiffness / cross_section
    sheet_modulus = 12.0 * BENDING_STIFFNESS[case] / thickness**3
    largest_angle = math.radians(80.0)
    return Fabric(
        name=f"cloth with {case.replace('-', ' ')}",
        areal_density=0.3,
        thickness=thickness,
        unit_cell=PlainWeave(
            warp_modulus=modulus,
            weft_modulus=modulus,
            contact_modulus=1.0e6,
            warp_cross_section=cross_section,
            weft_cross_section=cross_section,
            contact_cross_section=50.0 * cross_section,
            warp_second_moment=yarn_bending / modulus,
            weft_second_moment=yarn_bending / modulus,
            warp_half_spacing=0.5 * spacing,
            weft_half_spacing=0.5 * spacing,
            crossover_height=0.2e-3,
        ),
        shear=MomentCurve(
            angle=(0.0, largest_angle),
            moment_values=(0.0, SHEAR_STIFFNESS[case] * largest_angle),
            locking_angle=math.radians(65.0),
            locking_stiffness=0.02 * axial_stiffness / spacing,
        ),
        bending=IsotropicBending(modulus=sheet_modulus),
        transverse_shear_modulus=0.5 * sheet_modulus,
        in_plane_bending_stiffness=1.0e-5,
        # Full shares: with less, a fold that collapses creases along one row of elements and stays so.
        stabilisation=Stabilisation(warping=1.0, director=1.0),
        source="none",
        assumed=("everything",),
    )


def hemisphere(parameters: HemisphereParameters, case: str, fabric: Fabric | None = None) -> Setup:
    """One case: the cloth is released on top of the ball; ``fabric`` replaces that of the case."""
    fabric = fabric or cloth(case)
    half = 0.5 * parameters.side
    blank = Blank.rectangle(
        (-half, -half), (half, half), parameters.mesh_size, height=parameters.radius + 0.5 * fabric.thickness
    )
    self_contact = SelfContact(Coulomb(parameters.friction)) if parameters.self_contact else None
    start = unevenness(blank, parameters.seed)
    return Setup(
        "hemisphere",
        sheets=(Sheet(blank, fabric, initial_velocity=start, self_contact=self_contact),),
        tools=(Tool("hemisphere", Sphere(parameters.radius), friction=parameters.friction),),
        dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY), damping=parameters.damping, director_damping=DIRECTOR_DAMPING),
        duration=parameters.duration,
        frame_count=parameters.frame_count,
        solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )


def unevenness(blank: Blank, seed: int) -> np.ndarray:
    """Vertical initial velocity, (node_count, 3) [m/s]: waves around the pole of random phase, growing to the rim."""
    x, y = blank.material_coordinates.T
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, len(UNEVENNESS_WAVES))
    waves = sum(np.cos(count * angle + phase) for count, phase in zip(UNEVENNESS_WAVES, phases, strict=True))
    velocity = np.zeros((blank.node_count, 3))
    velocity[:, 2] = UNEVENNESS * (radius / radius.max()) ** 2 * waves / math.sqrt(0.5 * len(UNEVENNESS_WAVES))
    return velocity


def smooth_radius(blank: Blank, radius: float) -> np.ndarray:
    """Distance from the axis in a cloth that lies on the ball without a fold, (node_count,) [m].

    Each point keeps its distance from the top: along the ball down to its equator, then straight down. For that shear
    has to absorb all excess circumference; what a real cloth cannot absorb stands out in folds.
    """
    distance = np.linalg.norm(blank.material_coordinates, axis=1)
    return radius * np.sin(np.minimum(distance / radius, 0.5 * math.pi))


def wrinkles(parameters: HemisphereParameters, simulation: Simulation) -> dict[str, Any]:
    """Folds along the rim, their height relative to a cloth without folds, and parts too close to each other."""
    blank, position = simulation.setup.sheet.blank, simulation.frame.position
    half = 0.5 * simulation.setup.sheet.fabric.thickness
    folds = rim_folds(blank, position, smooth_radius=smooth_radius(blank, parameters.radius + half))
    return {
        "fold_count": folds.fold_count,
        "wrinkle_amplitude_mm": 1.0e3 * folds.amplitude,
        "close_pair_count": close_pairs(position, blank.quads, half),
    }


SCENE = Scene(
    name="hemisphere",
    help="Let a square cloth fall on a hemisphere.",
    parameters=HemisphereParameters,
    make=hemisphere,
    cases=lambda parameters: CASES if parameters.case == "both" else (parameters.case,),
    findings=lambda parameters, simulation, wanted: wrinkles(parameters, simulation),
)
