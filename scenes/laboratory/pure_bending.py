"""Pure bending (Kawabata, KES-FB2): a strip is bent to an arc by a moment, both ways and back.

One half of the strip is computed, clamped in its middle, with a couple at its end; the other half mirrors it. The
moment is the same all along, so that the strip is an arc of one curvature at any size of it. Like the laboratory's
specimen, which is twenty times as wide as long, it stays straight across.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from weavesim.checks import NotNegative, Positive
from weavesim.device import Precision
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.bending import IsotropicBending, YarnBending
from weavesim.fabric.bending.law import YarnName
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.supports import Support
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

from ..cantilever import softened, strip_stiffness
from ..fabric_test import FabricTestParameters, chosen_fabric, of_curves
from ..scene import Scene

# Yarns per width over the bending stiffness per area of the half strip: pure bending does not stretch it.
STRETCH_OVER_BENDING = 1.0e3
# Of the first mode of the half strip: periods in a quarter of the cycle, and share of critical damping.
PERIODS, DAMPING_RATIO = 20.0, 0.1
SMALLEST_ELEMENT_COUNT = 4
# More than this would make the strip meet itself.
LARGEST_TURN = 1.6 * math.pi


class PureBendingParameters(FabricTestParameters):
    """Parameters of a pure-bending test; length and curvature are those of the KES-FB2."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.0005, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/pure_bending"), description="folder for the results")
    precision: Precision = Field(default=Precision.DOUBLE, description="scalar type of state and kernels")
    yarn: YarnName = Field(default="warp", description="yarn family along the strip")
    length: Annotated[Positive, Quantity("length")] = Field(default=0.01, description="between the clamps [m]")
    width: Annotated[Positive, Quantity("length", at_most=1.0)] = Field(
        default=0.001, description="of the strip [m]; the moment per width does not depend on it"
    )
    largest_curvature: Annotated[Positive, Quantity("curvature")] = Field(
        default=250.0, description="to both sides [1/m]"
    )
    frame_count: int = Field(default=120, ge=5, description="frames after the first")
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None, description="mass-proportional damping rate [1/s]; by default 0.1 of critical for the first mode"
    )

    abscissas = (Comparable("curvature", "1/m", "curvature_per_m"),)
    ordinates = (Comparable("moment", "N", "moment_n"),)

    @model_validator(mode="after")
    def _can_be_bent(self) -> Self:
        turn = self.largest_curvature * self.length
        if turn > LARGEST_TURN:
            raise ValueError(
                f"largest_curvature = {self.largest_curvature:.4g} 1/m bends the length of {self.length} m by "
                f"{math.degrees(turn):.0f} degrees, and its ends would meet: at most {LARGEST_TURN / self.length:.4g} "
                "1/m, or a shorter strip"
            )
        if round(0.5 * self.length / self.mesh_size) < SMALLEST_ELEMENT_COUNT:
            raise ValueError(
                f"mesh_size = {self.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements along half the length of "
                f"{self.length} m are needed; at most {0.5 * self.length / SMALLEST_ELEMENT_COUNT:.4g} m is allowed"
            )
        return self

    def blank_area(self) -> float:
        """Of half the strip [m^2]."""
        return 0.5 * self.length * self.width


def loading_moment(parameters: PureBendingParameters, fabric: Fabric) -> float:
    """Moment per width [N] at the largest curvature on first loading, with friction; by the law alone."""
    law = family_law(fabric, parameters.yarn)
    return float(law_path(law, np.linspace(0.0, parameters.largest_curvature, 401))[-1])


def family_law(fabric: Fabric, yarn: YarnName) -> Any:
    """Bending of a yarn family: a stiffness per width [N m], or its curve."""
    if not fabric.bending.bends_linearly(yarn):
        return getattr(fabric.bending, yarn)
    return held_stiffness(fabric, yarn)


def held_stiffness(fabric: Fabric, yarn: YarnName) -> float:
    """Bending stiffness per width [N m] along a yarn of a strip that stays straight across, for small curvatures."""
    law = fabric.bending
    if isinstance(law, IsotropicBending):
        return law.stiffness(fabric.thickness)
    if isinstance(law, YarnBending):
        family = getattr(law, yarn)
        return float(family if isinstance(family, int | float) else family.initial_stiffness)
    return strip_stiffness(fabric, yarn)


def law_path(law: Any, curvature: np.ndarray) -> np.ndarray:
    """Moment per width (n,) [N] along a path of curvatures (n,) [1/m] from rest: curve, and spring with slider."""
    if isinstance(law, float):
        return law * curvature
    moment, slip = np.asarray(law.moment(curvature), dtype=float), 0.0
    if law.friction_limit == 0.0:
        return moment
    reach, friction = law.friction_limit / law.friction_stiffness, np.empty_like(moment)
    for k, kappa in enumerate(curvature):
        slip = kappa - np.clip(kappa - slip, -reach, reach)
        friction[k] = law.friction_stiffness * (kappa - slip)
    return moment + friction


def pure_bending(parameters: PureBendingParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    fabric = fabric or chosen_fabric(parameters)
    stiffness = held_stiffness(fabric, parameters.yarn)
    if stiffness <= 0.0:
        raise InputError(f"pure bending: the fabric has no bending stiffness along the {parameters.yarn}")
    half = 0.5 * parameters.length
    blank = Blank.rectangle(
        (0.0, -0.5 * parameters.width), (half, 0.5 * parameters.width), parameters.mesh_size,
        yarn_angle=0.0 if parameters.yarn == "warp" else 90.0,
    )  # fmt: skip
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    clamp = Support("clamp", np.flatnonzero(x < 1.0e-9))
    # a couple that keeps its axis would also turn a narrow strip aside
    straight = Support("straight_across", np.flatnonzero(x >= 1.0e-9), displacements="y", rotations="xz")
    tip = np.flatnonzero(x > half - 1.0e-9)
    tip = tip[np.argsort(y[tip])]
    share = np.full(len(tip), 1.0)
    share[[0, -1]] = 0.5
    couple = np.zeros((blank.node_count, 3))
    couple[tip, 1] = -loading_moment(parameters, fabric) * parameters.width * share / share.sum()
    # the secant at the largest curvature is the softest the strip may get: its period is the longest
    secant = min(stiffness, loading_moment(parameters, fabric) / parameters.largest_curvature)
    frequency = 3.516 * math.sqrt(secant / (fabric.areal_density * half**4))
    quarter = PERIODS * 2.0 * math.pi / frequency
    times, shares = cycle(quarter)
    damping = 2.0 * DAMPING_RATIO * frequency if parameters.damping is None else parameters.damping
    loads = NodalLoads(None, couple, tuple(times), tuple(shares))
    soft = softened(fabric, STRETCH_OVER_BENDING * fabric.bending.largest_stiffness(fabric.thickness) / half**2)
    return Setup(
        "pure_bending", sheets=(Sheet(blank, soft, supports=(clamp, straight), loads=loads),),
        dynamics=Dynamics(damping=damping, director_damping=damping),
        duration=float(times[-1]), frame_count=parameters.frame_count, solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def cycle(quarter: float) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and shares of the largest moment: there, to the other side, and back again; smooth at the turns."""
    time = np.linspace(0.0, 5.0, 401)
    # rises over the first quarter, then a cosine of one cycle
    share = np.where(time < 1.0, 0.5 * (1.0 - np.cos(np.pi * time)), np.cos(0.5 * np.pi * (time - 1.0)))
    return quarter * time, share


def record(parameters: PureBendingParameters, fabric: Fabric, setup: Setup) -> Curves:
    """Moment and curvature of every frame, with the law along the computed curvatures."""
    blank, loads = setup.sheet.blank, setup.sheet.loads
    x = blank.node_position[:, 0]
    tip = np.flatnonzero(x > x.max() - 1.0e-9)
    law = family_law(fabric, parameters.yarn)
    path: list[float] = []
    largest = loading_moment(parameters, fabric)

    def measure(state: Frame) -> dict[str, float]:
        if state.index == 0:
            path.clear()
        director = state.director[tip].mean(axis=0)
        # the end turns upwards for a positive moment
        turn = math.atan2(-director[0], director[2])
        path.append(turn / (0.5 * parameters.length))
        fine = np.interp(np.linspace(0.0, len(path) - 1.0, 8 * len(path)), np.arange(len(path)), path)
        return {
            "time_s": state.time,
            "curvature_per_m": path[-1],
            "moment_n": largest * (loads.share(state.time) if loads else 0.0),
            "closed_form_moment_n": float(law_path(law, fine)[-1]),
        }

    return Curves("pure_bending", measure, [
        Chart(
            "moment", "Moment against curvature",
            f"Strip along the {parameters.yarn}; the law is that of the fabric along the same curvatures.",
            ("curvature_per_m", "curvature [1/m]"), "moment per width [N]", {"moment_n": "computed"},
            {"closed_form_moment_n": "law of bending"},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries as of a KES-FB2: B is the mean slope, 2HB the mean height of the loop, both between 0.2 and 0.6
    of the largest curvature; and the largest deviation from the law over the largest moment."""
    c = curves.columns
    kappa, moment = c["curvature_per_m"], c["moment_n"]
    error = np.abs(moment - c["closed_form_moment_n"]).max() / max(np.abs(moment).max(), 1.0e-30)
    top, bottom = int(np.argmax(kappa)), int(np.argmin(kappa))
    rigidity = hysteresis = None
    if 0 < top < bottom < len(kappa) - 1:
        down, up = slice(top, bottom + 1), slice(bottom, len(kappa))
        places = np.linspace(0.2, 0.6, 9) * kappa[top]
        places = np.concatenate([-places[::-1], places])
        falling = np.interp(places, kappa[down][::-1], moment[down][::-1])
        rising = np.interp(places, kappa[up], moment[up])
        middle = 0.5 * (falling + rising)
        rigidity = float(np.mean([np.polyfit(places[part], middle[part], 1)[0] for part in (slice(9), slice(9, 18))]))
        hysteresis = float(np.mean(rising - falling))
    return {
        "largest_curvature_per_m": float(kappa[top]),
        "largest_moment_n": float(moment.max()),
        "bending_rigidity_n_m": rigidity,
        "bending_hysteresis_n": hysteresis,
        "largest_moment_error_ratio": float(error),
        **measured_differences(curves),
    }


def wanted(parameters: PureBendingParameters, setup: Setup) -> Wanted:
    """Curve of the moment; no draw-in, which is meaningless here."""
    return Wanted(curves=record(parameters, chosen_fabric(parameters), setup), draw_in=False)


SCENE = Scene(
    name="pure-bending",
    help="Bend a strip of woven fabric both ways by a moment.",
    parameters=PureBendingParameters,
    make=pure_bending,
    wanted=wanted,
    findings=of_curves(findings),
)
