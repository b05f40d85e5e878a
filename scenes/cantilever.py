"""Cantilever test (Peirce): a strip clamped flat at one end hangs over under its own weight.

The bending stiffness follows from the angle between the horizontal and the chord from clamp to tip, and the length of
the overhang, by Peirce's formula or from the heavy elastica. For a strip twice as long as (D / weight per area)^(1/3)
the chord of the elastica is at 41.5 degrees; there Peirce's formula gives 1.057 D.
"""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from weavesim.checks import NotNegative, Positive
from weavesim.device import Precision
from weavesim.engine.setup import Rest, Setup
from weavesim.errors import InputError
from weavesim.fabric.bending.law import YarnName
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.closed_forms import elastica_profile, elastica_stiffness, peirce_stiffness
from weavesim.fabric.compaction import Compaction
from weavesim.fabric.fabric import LARGEST_LOCKING_SHARE, Fabric
from weavesim.output.curves import Chart, Curves, LastCurve
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.process.dynamics import Dynamics
from weavesim.process.supports import Support
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

from .fabric_test import FabricTestParameters, chosen_fabric
from .scene import Scene

if TYPE_CHECKING:
    from weavesim.run.simulation import Simulation

logger = logging.getLogger(__name__)

GRAVITY = 9.81
# With yarns of this stiffness per width, relative to the weight of the whole strip, the weight stretches the strip by
# less than 0.02 %. Stiffer yarns only reduce the time step, so they are softened.
LARGEST_STRETCH_STIFFNESS = 1.0e4
# Spacing of the straight yarns that replace them [m].
YARN_SPACING = 0.005
# At rest: kinetic over internal energy, once the first mode has decayed. Single precision keeps about 1e-7.
REST = 1.0e-6
# Along the overhang: with 5 elements the stiffness comes out 3 % too low, with 3 elements 9 %, with 1 element 66 %.
SMALLEST_ELEMENT_COUNT = 5
# Earliest and latest end, in units of 1/omega of the first mode.
SHORTEST_TIME, LONGEST_TIME = 10.0, 30.0


class CantileverParameters(FabricTestParameters):
    """Parameters of a cantilever test."""

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.005, description="edge length of an element [m]"
    )
    out: Path = Field(default=Path("out/cantilever"), description="folder for the results")
    # the clamp carries a few hundredths of a newton; rounding in single precision is nearly one per cent of that
    precision: Precision = Field(default=Precision.DOUBLE, description="scalar type of state and kernels")
    yarn: YarnName = Field(default="warp", description="yarn family along the strip")
    length: Annotated[Positive, Quantity("length")] | None = Field(
        default=None, description="length of the overhang [m]; by default the chord reaches about 41.5 degrees"
    )
    width: Annotated[Positive, Quantity("length", at_most=1.0)] = Field(
        default=0.025, description="width of the strip [m]"
    )
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = Field(
        default=None, description="mass-proportional damping rate [1/s]; the default is critical for the first mode"
    )

    abscissas = (Comparable("x", "mm", "x_mm"),)
    ordinates = (Comparable("drop", "mm", "drop_mm"),)

    def blank_area(self) -> float | None:
        """Of the strip [m^2], if its length is given."""
        return None if self.length is None else self.length * self.width


def strip_stiffness(fabric: Fabric, yarn: YarnName) -> float:
    """Bending stiffness D per width [N m] of a strip along ``yarn`` that is free to bend across.

    For a moment-curvature curve it is the initial slope, without friction.
    """
    return fabric.bending.strip_stiffness(yarn, fabric.thickness)


def bends_linearly(fabric: Fabric, yarn: YarnName) -> bool:
    """True if bending along ``yarn`` is fully described by one stiffness: no curve, no friction."""
    return fabric.bending.bends_linearly(yarn)


def overhang(parameters: CantileverParameters, fabric: Fabric) -> float:
    """Length of the overhang [m]: as given, or twice the bending length (D/w)^(1/3)."""
    stiffness = strip_stiffness(fabric, parameters.yarn)
    if stiffness <= 0.0:
        raise InputError(
            f"cantilever: the fabric's bending stiffness along the {parameters.yarn} is zero; it would hang"
        )
    return parameters.length or 2.0 * (stiffness / (fabric.areal_density * GRAVITY)) ** (1.0 / 3.0)


def softened(fabric: Fabric, stiffness: float) -> Fabric:
    """The fabric with straight yarns of at most ``stiffness`` per width [N/m] instead of its unit cell."""
    stiffness = min(stiffness, *fabric.unit_cell.yarn_stiffness_per_width)
    # as stiff in compression as in tension; with E I = E A l0^2 / 3 there is still a single equilibrium
    bending = stiffness * YARN_SPACING * (0.5 * YARN_SPACING) ** 2 / 3.0
    cell = PlainWeave.straight(stiffness_per_width=stiffness, spacing=YARN_SPACING, bending=1.001 * bending)
    # the same stiffness in both directions: a jump where a yarn goes slack would excite vibrations (theory, section 7)
    changes: dict[str, Any] = {"unit_cell": cell, "compressive_stiffness": 0.0, "shear_friction": None}
    changes["compaction"] = Compaction()
    # locking stiffness is limited to a tenth of that of the yarns; the strip does not shear
    changes["shear"] = fabric.shear.locking_at_most(LARGEST_LOCKING_SHARE * stiffness)
    return fabric.model_copy(update=changes)


def cantilever(parameters: CantileverParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    fabric = fabric or chosen_fabric(parameters)
    length, stiffness = overhang(parameters, fabric), strip_stiffness(fabric, parameters.yarn)
    if round(length / parameters.mesh_size) < SMALLEST_ELEMENT_COUNT:
        raise InputError(
            f"mesh_size = {parameters.mesh_size} m: at least {SMALLEST_ELEMENT_COUNT} elements along the overhang of "
            f"{length:.4g} m are needed, or the strip hangs too low; at most {length / SMALLEST_ELEMENT_COUNT:.4g} m "
            "is allowed"
        )
    half = 0.5 * parameters.width
    blank = Blank.rectangle(
        (0.0, -half), (length, half), parameters.mesh_size, yarn_angle=0.0 if parameters.yarn == "warp" else 90.0
    )
    clamp = Support("clamp", np.flatnonzero(blank.node_position[:, 0] < 1.0e-9))
    # the first mode of a straight cantilever; a hanging strip is at least as fast as a pendulum of its length
    frequency = 3.516 * math.sqrt(stiffness / (fabric.areal_density * length**4))
    damping = 2.0 * frequency if parameters.damping is None else parameters.damping
    weight = fabric.areal_density * GRAVITY * length
    soft = softened(fabric, LARGEST_STRETCH_STIFFNESS * weight)
    return Setup(
        "cantilever", sheets=(Sheet(blank, soft, supports=(clamp,)),),
        dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY), damping=damping, director_damping=damping),
        duration=LONGEST_TIME / frequency, rest=Rest(SHORTEST_TIME / frequency, REST),
        frame_count=parameters.frame_count, solver=parameters.solver(),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def chord_angle(blank: Blank, position: np.ndarray) -> float:
    """Angle of the line from the clamp to the tip below the horizontal [rad]."""
    x = blank.node_position[:, 0]
    tip = position[x > x.max() - 1.0e-9].mean(axis=0)
    return math.atan2(-tip[2], tip[0])


def record(blank: Blank) -> Curves:
    """Curve of the tip as it comes to rest."""

    def measure(state: Frame) -> dict[str, float]:
        tip = state.position[blank.node_position[:, 0] > blank.node_position[:, 0].max() - 1.0e-9].mean(axis=0)
        return {
            "time_s": state.time,
            "tip_x_mm": 1.0e3 * tip[0],
            "tip_drop_mm": -1.0e3 * tip[2],
            "chord_angle_deg": math.degrees(chord_angle(blank, state.position)),
            "clamp_force_n": float(state.support_force[0, 2]),
        }

    return Curves("cantilever", measure, [
        Chart(
            "chord_angle", "The strip comes to rest", "Angle of the line from the clamp to the tip.",
            ("time_s", "time [s]"), "chord below the horizontal [degrees]", {"chord_angle_deg": "computed"}, {},
        ),
    ])  # fmt: skip


def profile(parameters: CantileverParameters, fabric: Fabric, blank: Blank) -> LastCurve:
    """The hanging strip from the side, with the heavy elastica of the fabric's stiffness if that is one number."""
    along, station = np.unique(blank.node_position[:, 0], return_inverse=True)
    count = np.bincount(station)
    known = np.full(len(along), math.nan), np.full(len(along), math.nan)
    if bends_linearly(fabric, parameters.yarn):
        known = elastica_profile(
            overhang(parameters, fabric), strip_stiffness(fabric, parameters.yarn), fabric.areal_density * GRAVITY,
            along,
        )  # fmt: skip

    def measure(state: Frame) -> dict[str, np.ndarray]:
        x, drop = (np.bincount(station, state.position[:, axis]) / count for axis in (0, 2))
        # at the computed places, so that both are over one abscissa
        elastica = np.interp(x, known[0], known[1], right=math.nan)
        return {"x_mm": 1.0e3 * x, "drop_mm": -1.0e3 * drop, "elastica_drop_mm": 1.0e3 * elastica}

    return LastCurve("profile", measure, [
        Chart(
            "profile", "The hanging strip", "From the side, drop downwards from the clamp.",
            ("x_mm", "distance from the clamp [mm]"), "drop below the clamp [mm]", {"drop_mm": "computed"},
            {"elastica_drop_mm": "heavy elastica"}, equal_scales=True, downwards=True,
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(parameters: CantileverParameters, fabric: Fabric, simulation: Simulation) -> dict[str, Any]:
    """Summary entries: angle of the chord, and the bending stiffness derived from it.

    Ratios to the input stiffness are None if the moment is a curve or has friction: the stiffness then varies with
    curvature, and there is no single value to compare with.
    """
    length, weight = overhang(parameters, fabric), fabric.areal_density * GRAVITY
    angle = chord_angle(simulation.setup.sheet.blank, simulation.frame.position)
    given = strip_stiffness(fabric, parameters.yarn)
    peirce, elastica = (f(angle, length, weight) for f in (peirce_stiffness, elastica_stiffness))
    comparable = bends_linearly(fabric, parameters.yarn)
    if not comparable:
        logger.info(
            "the bending moment along the %s is a curve or has friction: its initial slope %.4g N m is not compared "
            "with the stiffness that the chord angle gives", parameters.yarn, given,
        )  # fmt: skip
    return {
        "overhang_mm": 1.0e3 * length,
        "chord_angle_deg": math.degrees(angle),
        "bending_length_mm": 1.0e3 * (peirce / weight) ** (1.0 / 3.0),
        "input_bending_stiffness_n_m": given,
        "peirce_bending_stiffness_n_m": peirce,
        "elastica_bending_stiffness_n_m": elastica,
        "peirce_over_input": peirce / given if comparable else None,
        "elastica_over_input": elastica / given if comparable else None,
    }


def wanted(parameters: CantileverParameters, setup: Setup) -> Wanted:
    """Curve of the tip, and the profile; no draw-in, which is meaningless here."""
    blank = setup.sheet.blank
    last = profile(parameters, chosen_fabric(parameters), blank)
    return Wanted(curves=record(blank), last_curve=last, draw_in=False)


SCENE = Scene(
    name="cantilever",
    help="Let a strip of woven fabric hang over an edge.",
    parameters=CantileverParameters,
    make=cantilever,
    wanted=wanted,
    findings=lambda parameters, simulation, wanted: {
        **findings(parameters, chosen_fabric(parameters), simulation),
        **(measured_differences(wanted.last_curve) if wanted.last_curve else {}),
    },
)
