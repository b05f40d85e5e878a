"""Picture-frame test: a hinged square frame shears a fabric whose yarns lie along its sides.

The frame is four clamps that move as a rhombus; its bars have no mass. With the yarns along the sides the fabric
shears uniformly, so the angle is known from the crosshead displacement and the force from the shear law. The fabric may
be smaller than the frame, and a mechanism may stand between frame and machine: force and displacement are the
machine's.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.closed_forms import moment_along, trellis_angle, trellis_angle_rate
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

from .fabric_test import DIRECTOR_DAMPING, STEP_SAFETY, FabricTestParameters, chosen_fabric, of_curves
from .scene import Scene

# Time to apply the yarn tension, and to start and to stop the crosshead, as a share of the time of its stroke.
TENSION_TIME = 10.0e-3
RAMP_SHARE = 0.2
LARGEST_TENSION_STRETCH = 1.05
# Along a side, with yarns that are not parallel to the sides: aligned yarns shear evenly, and any mesh is exact.
SMALLEST_ELEMENT_COUNT = 4


class PictureFrameParameters(FabricTestParameters):
    """Parameters of a picture-frame test."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.01, description="edge length of an element [m]"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] = Field(
        default=10.0, description="mass-proportional damping rate [1/s]"
    )
    out: Path = Field(default=Path("out/picture_frame"), description="folder for the results")
    side: Annotated[Positive, Quantity("frame side", at_most=2.0)] = Field(
        default=0.2, description="side of the square inner area [m]"
    )
    arm_length: Annotated[NotNegative, Quantity("length")] = Field(
        default=0.0,
        description="length of arms beyond each side, clamped at their ends, with the corners between cut out [m]",
    )
    frame_side: Annotated[Positive, Quantity("frame side", at_most=5.0)] | None = Field(
        default=None, description="distance of the hinges [m]; by default the clamps are the frame's own sides"
    )
    load_factor: Annotated[Positive, Quantity("load factor")] = Field(
        default=1.0,
        description="force of the machine over that along the frame's diagonal: a mechanism that moves the frame this "
        "many times as fast as the machine",
    )
    largest_angle: Annotated[Positive, Quantity("angle")] = Field(
        default=40.0, lt=80.0, description="largest shear angle of the frame [degrees]"
    )
    misalignment: Annotated[float, Quantity("angle")] = Field(
        default=0.0, ge=-45.0, le=45.0, description="angle between yarns and sides [degrees]"
    )
    yarn_tension: Annotated[NotNegative, Quantity("yarn tension")] = Field(
        default=100.0,
        description="tension of both yarn families before shear, applied by stretching the frame [N/m]; without it "
        "the yarns rattle between slack and taut",
    )
    cycle: bool = Field(default=False, description="return to the start: loading and unloading")
    speed: Annotated[Positive, Quantity("speed")] = Field(
        default=0.5, description="speed at which the frame's diagonal grows [m/s]"
    )

    abscissas = (Comparable("angle", "deg", "frame_angle_deg"), Comparable("displacement", "mm", "displacement_mm"))
    ordinates = (
        Comparable("force", "N", "force_n"),
        Comparable("force", "N/m", "normalised_shear_force_n_per_m"),
        Comparable("normalised force", "N/m", "normalised_shear_force_n_per_m"),
    )

    @model_validator(mode="after")
    def _is_fine_enough(self) -> Self:
        if self.misalignment != 0.0 and round(self.side / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: with misaligned yarns at least {SMALLEST_ELEMENT_COUNT} elements "
                f"along the side of {self.side} m are needed; at most "
                f"{self.side / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    @model_validator(mode="after")
    def _fits_in_its_frame(self) -> Self:
        if self.frame_side is not None and self.frame_side < self.clamped_side * (1.0 - 1.0e-9):
            raise ValueError(
                f"frame_side = {self.frame_side} m: the clamped square of {self.clamped_side:.4g} m, side and both "
                "arms, must fit in; give at least that"
            )
        return self

    @property
    def clamped_side(self) -> float:
        """Side of the flat square that the clamps hold, with the arms [m]."""
        return self.side + 2.0 * self.arm_length

    def blank_area(self) -> float:
        """Of the specimen with its arms [m^2]."""
        return self.side * (self.side + 4.0 * self.arm_length)


class PictureFrame:
    """Geometry and motion of the frame.

    Attributes:
        side: from hinge to hinge when shear begins [m].
        share: clamped side over that of the frame.
        stretch: of the yarns due to the tension.
        shear: displacement of the upper hinge relative to the lower one, from the start of shear.
    """

    def __init__(self, parameters: PictureFrameParameters, fabric: Fabric) -> None:
        flat_side = parameters.clamped_side
        self.stretch = tension_stretch(fabric, parameters.yarn_tension)
        self.side = parameters.frame_side or self.stretch * flat_side
        self.share = self.stretch * flat_side / self.side
        self.load_factor = parameters.load_factor
        self.stretching = math.sqrt(2.0) * (self.stretch * flat_side - flat_side)
        half = math.radians(0.5 * (90.0 - parameters.largest_angle))
        stroke = 2.0 * self.side * (math.cos(half) - math.cos(0.25 * math.pi))
        start = TENSION_TIME if self.stretching > 0.0 else 0.0
        ramp = RAMP_SHARE * stroke / parameters.speed
        self.shear = SmoothStroke.ramped(stroke, parameters.speed, ramp, start_time=start)
        if parameters.cycle:
            self.shear = self.shear.and_back()
        self.flat_diagonal = math.sqrt(2.0) * flat_side

    def half_angle(self, displacement: np.ndarray | float) -> np.ndarray:
        """Half the angle at the pulled hinges [rad], from displacements of the upper one [m], of their shape."""
        return np.arccos(math.sqrt(0.5) + np.asarray(displacement) / (2.0 * self.side))

    def support(self, blank: Blank, nodes: np.ndarray) -> Support:
        """The clamped nodes, driven like the frame: the vertical diagonal, then the horizontal one, then both."""
        place = blank.node_position[nodes] / self.flat_diagonal
        vertical, horizontal = place * (0.0, 1.0, 0.0), place * (1.0, 0.0, 0.0)
        narrowing = self.shear.mapped(
            lambda d: 2.0 * self.side * (np.sin(self.half_angle(d)) - math.sqrt(0.5)),
            lambda d: -1.0 / np.tan(self.half_angle(d)),
        )
        drives = [Drive(self.shear, self.share * vertical), Drive(narrowing, self.share * horizontal)]
        if self.stretching > 0.0:
            stretching = SmoothStroke.ramped(self.stretching, 2.0 * self.stretching / TENSION_TIME, 0.5 * TENSION_TIME)
            drives.append(Drive(stretching, vertical + horizontal))
        return Support("frame", nodes, tuple(drives))

    def force(self, frame: Frame) -> float:
        """Force of the machine [N]: work of both diagonals per displacement of the pulled one, times load factor."""
        along = frame.drive_force[0] - frame.drive_force[1] / np.tan(self.half_angle(frame.stroke))
        return float(self.load_factor * along)


def tension_stretch(fabric: Fabric, tension: float) -> float:
    """Equal stretch of both yarn families at which their mean force is ``tension`` [N/m], by bisection.

    Raises:
        InputError: stretches up to 5 % do not give this tension.
    """
    if tension == 0.0:
        return 1.0
    from weavesim.fabric.response import respond

    low, high = 1.0, LARGEST_TENSION_STRETCH

    def force(stretch: float) -> float:
        return float(respond(fabric.unit_cell, [[stretch, stretch]]).force_per_width.mean())

    if force(high) < tension:
        raise InputError(f"yarn tension {tension} N/m: a stretch of 5 % gives only {force(high):.4g} N/m; reduce it")
    while high - low > 1.0e-12:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if force(middle) < tension else (low, middle)
    return 0.5 * (low + high)


def specimen(parameters: PictureFrameParameters) -> tuple[Blank, np.ndarray]:
    """The specimen, with a corner at the top, and indices of its clamped nodes, (k,)."""
    half = 0.5 * parameters.side + parameters.arm_length
    count = max(2, round(parameters.side / parameters.mesh_size))
    arm_count = math.ceil(parameters.arm_length / (parameters.side / count) - 1.0e-9)
    inner = np.linspace(-0.5, 0.5, count + 1) * parameters.side
    arm = np.linspace(0.5 * parameters.side, half, arm_count + 1)[1:]
    line = np.concatenate([-arm[::-1], inner, arm])
    plan = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    index = np.arange(plan.shape[0] * plan.shape[1]).reshape(plan.shape[:2])
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    plan = plan.reshape(-1, 2)
    outside = np.abs(plan[quads].mean(axis=1)) > 0.5 * parameters.side
    used, quads = np.unique(quads[~outside.all(axis=1)], return_inverse=True)
    flat = plan[used]
    turn = math.sqrt(0.5) * np.array([[1.0, 1.0], [-1.0, 1.0]])
    position = np.column_stack([flat @ turn, np.zeros(len(flat))])
    blank = Blank.from_mesh(position, quads.reshape(-1, 4), yarn_angle=45.0 + parameters.misalignment)
    return blank, np.flatnonzero(np.abs(flat).max(axis=1) > half * (1.0 - 1.0e-9))


def picture_frame(parameters: PictureFrameParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    fabric = fabric or chosen_fabric(parameters)
    blank, clamped = specimen(parameters)
    frame = PictureFrame(parameters, fabric)
    return Setup(
        "picture_frame", sheets=(Sheet(blank, fabric, supports=(frame.support(blank, clamped),)),),
        dynamics=Dynamics(damping=parameters.damping, director_damping=DIRECTOR_DAMPING),
        duration=frame.shear.duration, frame_count=parameters.frame_count,
        solver=parameters.solver(step_safety=STEP_SAFETY),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def record(parameters: PictureFrameParameters, fabric: Fabric) -> Curves:
    """Angle and force of every frame, with the predictions of kinematics and shear law.

    The power balance F d' = A m(gamma) gamma' gives F along the frame's diagonal d, and the load factor that of the
    machine; A is the area of the whole fabric, including the arms. The normalised shear force is that along a side,
    F / (2 cos(theta)), times side over area: the moment m over cos(gamma).
    """
    frame = PictureFrame(parameters, fabric)
    blank, _ = specimen(parameters)
    inner = np.abs(blank.element_centres()[:, :2]).sum(axis=1) < math.sqrt(0.5) * parameters.side
    area = parameters.side**2 + 4.0 * parameters.side * parameters.arm_length
    path: list[tuple[float, float]] = []  # angles and crossover pressures so far, for history-dependent laws

    def measure(state: Frame) -> dict[str, float]:
        diagonal = math.sqrt(2.0) * frame.side + state.stroke
        angle = trellis_angle(diagonal, frame.side)
        if state.index == 0:
            path.clear()
        path.append((float(angle), state.fields["crossover_pressure"][inner].mean()))
        moment = float(moment_along(fabric, *np.array(path).T, stretch=frame.stretch)[-1])
        rate = trellis_angle_rate(diagonal, frame.side)
        force = frame.force(state)
        found = np.degrees(state.fields["shear_angle"][inner])
        per_side = 1.0 / (2.0 * np.cos(frame.half_angle(state.stroke)))
        along = force / frame.load_factor
        return {
            "time_s": state.time,
            "displacement_mm": 1.0e3 * state.stroke / frame.load_factor,
            "frame_angle_deg": math.degrees(angle),
            "mean_shear_angle_deg": found.mean(),
            "min_shear_angle_deg": found.min(),
            "max_shear_angle_deg": found.max(),
            "force_n": force,
            "closed_form_force_n": frame.load_factor * area * moment * rate,
            "normalised_shear_force_n_per_m": along * per_side * frame.side / area,
            "closed_form_shear_force_n_per_m": moment * rate * per_side * frame.side,
            "warp_tension_n_per_m": state.fields["warp_force"][inner].mean(),
            "weft_tension_n_per_m": state.fields["weft_force"][inner].mean(),
        }

    return Curves("picture_frame", measure, [
        Chart(
            "force", "Force of the machine",
            "Force against the angle of the frame, with that of the shear law from the power balance.",
            ("frame_angle_deg", "angle of the frame [degrees]"), "force [N]",
            {"force_n": "computed"}, {"closed_form_force_n": "shear law, uniform shear"},
        ),
        Chart(
            "normalised_force", "Normalised shear force",
            "Force along a side of the frame, times the side over the area of the fabric.",
            ("frame_angle_deg", "angle of the frame [degrees]"), "normalised shear force [N/m]",
            {"normalised_shear_force_n_per_m": "computed"},
            {"closed_form_shear_force_n_per_m": "shear law, uniform shear"},
        ),
        Chart(
            "force_displacement", "Force and displacement of the machine", "As the machine records them.",
            ("displacement_mm", "displacement [mm]"), "force [N]",
            {"force_n": "computed"}, {"closed_form_force_n": "shear law, uniform shear"},
        ),
        Chart(
            "angle", "Shear angle of the fabric",
            "Mean and extremes of the inner area against the angle of the frame.",
            ("frame_angle_deg", "angle of the frame [degrees]"), "shear angle [degrees]",
            {"mean_shear_angle_deg": "mean", "min_shear_angle_deg": "smallest", "max_shear_angle_deg": "largest"},
            {"frame_angle_deg": "kinematics"},
        ),
        Chart(
            "tension", "Tension of the yarns", "Mean of the inner area.",
            ("frame_angle_deg", "angle of the frame [degrees]"), "tension [N/m]",
            {"warp_tension_n_per_m": "warp", "weft_tension_n_per_m": "weft"}, {},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries: the largest deviations; that of the force is relative to its largest value."""
    c = curves.columns
    # locking yarns or tension add forces that are not in the shear law
    force_error = np.abs(c["force_n"] - c["closed_form_force_n"]).max() / np.abs(c["closed_form_force_n"]).max()
    travel = 1.0e-3 * np.diff(c["displacement_mm"])
    peak = int(np.argmax(np.abs(c["frame_angle_deg"])))
    return {
        "frame_angle_deg": c["frame_angle_deg"][peak],
        "mean_shear_angle_deg": c["mean_shear_angle_deg"][peak],
        "largest_angle_error_deg": np.abs(c["mean_shear_angle_deg"] - c["frame_angle_deg"]).max(),
        "peak_force_n": c["force_n"][peak],
        "closed_form_peak_force_n": c["closed_form_force_n"][peak],
        "largest_force_error_ratio": force_error,
        "work_of_a_cycle_j": 0.5 * float((c["force_n"][1:] + c["force_n"][:-1]) @ travel),
        **measured_differences(curves),
    }


def wanted(parameters: PictureFrameParameters, setup: Setup) -> Wanted:
    """Curves of angle and force; no draw-in, since the border moves with the frame."""
    return Wanted(curves=record(parameters, setup.sheet.fabric), draw_in=False)


SCENE = Scene(
    name="picture-frame",
    help="Shear a woven fabric in a picture frame.",
    parameters=PictureFrameParameters,
    make=picture_frame,
    wanted=wanted,
    findings=of_curves(findings),
)
