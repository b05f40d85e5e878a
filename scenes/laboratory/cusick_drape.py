"""Cusick drape: a round specimen hangs over the edge of a round disc, and its shadow is measured.

The drape coefficient is the area of the shadow beyond the disc over that of the flat specimen beyond the disc: 100 %
for a board, less for cloth that hangs in folds. ISO 9073-9 and BS 5058: disc of 180 mm, specimen of 240, 300 or 360 mm.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Rest, Setup
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import LARGEST_LOCKING_SHARE, Fabric
from weavesim.fabric.file import FABRIC_HELP
from weavesim.fabric.shear import MomentCurve, ShearFriction
from weavesim.output.curves import Chart, Curves, LastCurve
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.supports import Support
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

from ..cantilever import softened
from ..fabric_test import FabricTestParameters, chosen_fabric
from ..hemisphere import unevenness
from ..scene import Scene

GRAVITY = 9.81
COTTON = "cotton"
# Yarns per width over the weight of the overhang per width: the weight stretches them by less than 0.1 %.
STRETCH_STIFFNESS = 2.0e3
# Transverse shear over bending of the overhang: stiffer sheets shear no less visibly, and their directors move slowly.
SHEAR_OVER_BENDING = 1.0e4
SMALLEST_ELEMENT_COUNT = 6
# At rest, and the earliest and the latest end in periods of a pendulum as long as the overhang.
REST, EARLIEST, LATEST = 1.0e-6, 2.0, 12.0
# Damping over the critical one of that pendulum: laid down slowly, as in the test. A specimen with friction in its
# yarns that swings hangs lower, since friction holds it where it has been.
DAMPING_RATIO = 1.0
# Of a fold, over the radius of the specimen.
SMALLEST_FOLD = 0.02
# Of the circle, for the shadow.
SECTOR_COUNT = 720


class CusickDrapeParameters(FabricTestParameters):
    """Parameters of a Cusick drape test."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.006, description="edge length of an element at the rim [m]"
    )
    out: Path = Field(default=Path("out/cusick_drape"), description="folder for the results")
    fabric: str = Field(default=COTTON, description=f'"{COTTON}" (a shirting, assumed), {FABRIC_HELP}')
    radius: Annotated[Positive, Quantity("length")] = Field(default=0.15, description="of the specimen [m]")
    disc_radius: Annotated[Positive, Quantity("length")] = Field(default=0.09, description="of the disc [m]")
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None, description="mass-proportional damping rate [1/s]; the default follows from the overhang"
    )
    seed: int = Field(default=0, ge=0, description="random seed of the unevenness that triggers the folds")

    abscissas = (Comparable("angle", "deg", "angle_deg"),)
    ordinates = (Comparable("radius", "mm", "shadow_radius_mm"),)

    @model_validator(mode="after")
    def _hangs_over(self) -> Self:
        if self.disc_radius >= self.radius:
            raise ValueError(
                f"disc_radius = {self.disc_radius} m: smaller than the specimen's, {self.radius} m, is needed"
            )
        if round((self.radius - self.disc_radius) / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements across the ring of "
                f"{self.radius - self.disc_radius:.4g} m are needed; at most "
                f"{(self.radius - self.disc_radius) / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    def blank_area(self) -> float:
        """Of the ring [m^2]."""
        return math.pi * (self.radius**2 - self.disc_radius**2)


def cotton() -> Fabric:
    """A cotton shirting with values that are usual in the Kawabata system; all of them are assumed.

    Bending B = 0.06 gf cm^2/cm, shear G = 1 gf/cm/degree, 120 g/m^2, both yarns alike. Its hysteresis is left out, so
    that the result does not depend on how the specimen was laid down.
    """
    gram_force = 9.80665e-3
    rigidity, shear = 0.06 * gram_force * 1.0e-2, gram_force / 1.0e-2 / math.radians(1.0)
    stiffness, spacing = 1.0e4, 1.0e-3  # of yarns per width [N/m], and between them [m]
    thickness, largest_angle = 0.4e-3, math.radians(60.0)
    return Fabric(
        name="assumed cotton shirting", areal_density=0.12, thickness=thickness,
        unit_cell=PlainWeave.straight(
            stiffness_per_width=stiffness, spacing=spacing, bending=1.001 * stiffness * spacing**3 / 12.0
        ),
        shear=MomentCurve(angle=(0.0, largest_angle), moment_values=(0.0, shear * largest_angle)),
        bending=IsotropicBending(modulus=12.0 * rigidity / thickness**3),
        transverse_shear_modulus=6.0 * rigidity / thickness**3,
        in_plane_bending_stiffness=1.0e-6,
        source="none; values that are usual for cotton shirting in the Kawabata system",
        assumed=("everything",),
    )  # fmt: skip


def specimen_fabric(parameters: CusickDrapeParameters) -> Fabric:
    """The fabric in the parameters, or the assumed cotton."""
    if parameters.fabric != COTTON:
        return chosen_fabric(parameters)
    fabric = cotton()
    return fabric.with_linear_shear(parameters.shear_modulus) if parameters.shear_law == "linear" else fabric


def ring(parameters: CusickDrapeParameters) -> Blank:
    """The part of the specimen beyond the disc, in rings of elements; the warp along x."""
    around = max(16, round(2.0 * math.pi * parameters.radius / parameters.mesh_size))
    across = round((parameters.radius - parameters.disc_radius) / parameters.mesh_size)
    radius = np.linspace(parameters.disc_radius, parameters.radius, across + 1)
    angle = 2.0 * math.pi * np.arange(around) / around
    place = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle), np.zeros(around)], axis=-1)
    index = np.arange((across + 1) * around).reshape(across + 1, around)
    following = np.roll(index, -1, axis=1)
    quads = np.stack([index[:-1], index[1:], following[1:], following[:-1]], axis=-1).reshape(-1, 4)
    return Blank.from_mesh(place.reshape(-1, 3), quads)


def cusick_drape(parameters: CusickDrapeParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces that in the parameters."""
    fabric = fabric or specimen_fabric(parameters)
    blank = ring(parameters)
    overhang = parameters.radius - parameters.disc_radius
    distance = np.hypot(*blank.material_coordinates.T)
    held = np.flatnonzero(distance < parameters.disc_radius * (1.0 + 1.0e-9))
    start = unevenness(blank, parameters.seed) * ((distance - parameters.disc_radius) / overhang)[:, None]
    start[held] = 0.0
    frequency = math.sqrt(GRAVITY / overhang)
    damping = 2.0 * DAMPING_RATIO * frequency if parameters.damping is None else parameters.damping
    period = 2.0 * math.pi / frequency
    return Setup(
        "cusick_drape",
        sheets=(
            Sheet(blank, hanging(fabric, overhang), supports=(Support("disc", held),), initial_velocity=start),
        ),
        dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY), damping=damping, director_damping=damping),
        duration=LATEST * period, rest=Rest(EARLIEST * period, REST),
        frame_count=parameters.frame_count, solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def hanging(fabric: Fabric, overhang: float) -> Fabric:
    """The fabric with yarns and transverse shear no stiffer than the overhang needs; its friction stays."""
    largest = SHEAR_OVER_BENDING * fabric.largest_bending_stiffness / overhang**2 / (5.0 / 6.0 * fabric.thickness)
    fabric = fabric.model_copy(update={"transverse_shear_modulus": min(fabric.transverse_shear_modulus, largest)})
    stiffness = STRETCH_STIFFNESS * fabric.areal_density * GRAVITY * overhang
    stiffness = min(stiffness, *fabric.unit_cell.yarn_stiffness_per_width)
    soft, friction = softened(fabric, stiffness), fabric.shear_friction
    if friction is None:
        return soft
    # friction springs are limited to a tenth of the yarns; pressure of crossovers is not known of straight yarns
    changes: dict[str, Any] = {"stiffness": min(friction.stiffness, 0.99 * LARGEST_LOCKING_SHARE * stiffness)}
    if isinstance(friction, ShearFriction):
        changes["crossover_friction_length"] = 0.0
        if max(friction.limit) == 0.0:
            return soft
    return soft.model_copy(update={"shear_friction": friction.model_copy(update=changes)})


def shadow(position: np.ndarray, quads: np.ndarray, disc_radius: float) -> np.ndarray:
    """Radius of the shadow (SECTOR_COUNT,) [m] by the angle around the axis: disc and sheet seen from above."""
    corners = position[quads][:, :, :2]
    # so many points in each element that no sector between two of them is left out
    angle = np.arctan2(corners[:, :, 1], corners[:, :, 0])
    widest = np.abs((angle - angle[:, :1] + math.pi) % (2.0 * math.pi) - math.pi).max()
    count = 2 + math.ceil(3.0 * widest * SECTOR_COUNT / (2.0 * math.pi))
    s, t = (values.ravel() for values in np.meshgrid(np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, count)))
    weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
    points = np.einsum("pc,ecd->epd", weights, corners).reshape(-1, 2)
    sector = ((np.arctan2(points[:, 1], points[:, 0]) / (2.0 * math.pi) % 1.0) * SECTOR_COUNT).astype(int)
    radius = np.full(SECTOR_COUNT, disc_radius)
    np.maximum.at(radius, sector % SECTOR_COUNT, np.hypot(*points.T))
    return radius


def fold_count(radius: np.ndarray, height: float) -> int:
    """Maxima of a shadow's radius around the axis that stand ``height`` [m] above the valleys beside them."""
    from scipy.signal import find_peaks

    once = np.roll(radius, -int(np.argmin(radius)))
    return len(find_peaks(np.append(once, once[0]), prominence=height)[0])


def drape_coefficient(radius: np.ndarray, parameters: CusickDrapeParameters) -> float:
    """Of a shadow with these radii [m]."""
    inner, outer = parameters.disc_radius**2, parameters.radius**2
    return float((np.mean(radius**2) - inner) / (outer - inner))


def record(parameters: CusickDrapeParameters, blank: Blank) -> Curves:
    """Drape coefficient of every frame."""

    def measure(state: Frame) -> dict[str, float]:
        radius = shadow(state.position, blank.quads, parameters.disc_radius)
        return {
            "time_s": state.time,
            "drape_coefficient_percent": 100.0 * drape_coefficient(radius, parameters),
            "lowest_point_mm": 1.0e3 * float(state.position[:, 2].min()),
        }

    return Curves("cusick_drape", measure, [
        Chart(
            "coefficient", "The specimen comes to rest", "Area of the shadow beyond the disc over that when flat.",
            ("time_s", "time [s]"), "drape coefficient [%]", {"drape_coefficient_percent": "computed"}, {},
        ),
    ])  # fmt: skip


def outline(parameters: CusickDrapeParameters, blank: Blank) -> LastCurve:
    """Outline of the shadow at the last frame."""
    middle = (np.arange(SECTOR_COUNT) + 0.5) / SECTOR_COUNT * 2.0 * math.pi

    def measure(state: Frame) -> dict[str, np.ndarray]:
        radius = shadow(state.position, blank.quads, parameters.disc_radius)
        return {
            "angle_deg": np.degrees(middle),
            "shadow_radius_mm": 1.0e3 * radius,
            "disc_radius_mm": np.full(SECTOR_COUNT, 1.0e3 * parameters.disc_radius),
            "flat_radius_mm": np.full(SECTOR_COUNT, 1.0e3 * parameters.radius),
            "shadow_x_mm": 1.0e3 * radius * np.cos(middle),
            "shadow_y_mm": 1.0e3 * radius * np.sin(middle),
        }

    return LastCurve("shadow", measure, [
        Chart(
            "shadow", "Shadow of the draped specimen", "Seen from above; the warp is along x.",
            ("shadow_x_mm", "x [mm]"), "y [mm]", {"shadow_y_mm": "shadow"}, {}, equal_scales=True,
        ),
        Chart(
            "shadow_radius", "Radius of the shadow", "Around the axis, from the warp on.",
            ("angle_deg", "angle [degrees]"), "radius [mm]", {"shadow_radius_mm": "computed"},
            {"flat_radius_mm": "flat specimen", "disc_radius_mm": "disc"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(parameters: CusickDrapeParameters, blank: Blank, position: np.ndarray) -> dict[str, Any]:
    """Summary entries of the last frame."""
    radius = shadow(position, blank.quads, parameters.disc_radius)
    return {
        "drape_coefficient_percent": 100.0 * drape_coefficient(radius, parameters),
        "shadow_area_m2": math.pi * float(np.mean(radius**2)),
        "fold_count": fold_count(radius, SMALLEST_FOLD * parameters.radius),
        "largest_drop_mm": -1.0e3 * float(position[:, 2].min()),
    }


def wanted(parameters: CusickDrapeParameters, setup: Setup) -> Wanted:
    """Coefficient and shadow; no draw-in, which is meaningless here."""
    blank = setup.sheet.blank
    return Wanted(curves=record(parameters, blank), last_curve=outline(parameters, blank), draw_in=False)


SCENE = Scene(
    name="cusick-drape",
    help="Let a round specimen of woven fabric hang over a disc.",
    parameters=CusickDrapeParameters,
    make=cusick_drape,
    wanted=wanted,
    findings=lambda parameters, simulation, wanted: {
        **findings(parameters, simulation.setup.sheet.blank, simulation.frame.position),
        **(measured_differences(wanted.last_curve) if wanted.last_curve else {}),
    },
)
