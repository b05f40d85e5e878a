"""The double dome: a punch of two half-balls and a half-cylinder forms a woven blank through a flat blank holder.

The paper takes its tool from a benchmark whose drawing it does not print. This tool is a parametric, representative double
dome; a user's own tool meshes can take its place.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from weavesim.blank import Blank
from weavesim.errors import InputError
from weavesim.fabric import PRESETS, Fabric, NotNegative, Positive
from weavesim.model import MotionParameters
from weavesim.motion import Driven, Fixed, Motion, Stroke
from weavesim.run_options import RunOptions
from weavesim.shapes import DomeOpening, DomePunch, Shape, rotation_matrix
from weavesim.simulation import Simulation
from weavesim.tool import Tool

# Full blank of the paper [m].
BLANK_LENGTH = 0.470
BLANK_WIDTH = 0.270
# Representative tool [m].
PUNCH_RADIUS = 0.060
DOME_DISTANCE = 0.170
DIE_ENTRY_RADIUS = 0.010
CLEARANCE = 0.0012
# Of the whole holder; a quarter of the blank carries a quarter.
BLANK_HOLDER_MASS = 2.0
BLANK_HOLDER_PRESSURE = 20.0e3
BLANK_HOLDER_RAMP = 2.0e-3
PUNCH_RAMP = 6.0e-3
REST = 2.0e-3


class DoubleDomeParameters(RunOptions):
    """Everything that a double-dome run can be told."""

    out: Path = Field(default=Path("out/double_dome"), description="folder for the results")
    part: Literal["quarter", "half", "full"] = Field(default="quarter", description="share of the blank, by symmetry")
    yarn_angle: float = Field(default=0.0, ge=-90.0, le=90.0, description="angle from the long axis to the warp [degrees]")
    fabric: str = Field(default="glass-polypropylene", description=f"one of {', '.join(PRESETS)}")
    shear_law: Literal["curve", "linear"] = Field(
        default="curve", description="published moment curve, or the paper's linear law, equation (4)"
    )
    shear_modulus: Positive = Field(default=0.25e6, description="G_12 of the linear law [Pa]")
    friction: NotNegative = Field(default=0.2, description="Coulomb coefficient between sheet and tools")
    blank_holder_force: NotNegative | None = Field(
        default=None, description="of the whole holder [N]; the default is 20 kPa on the flange at the start"
    )
    blank_holder_gap: NotNegative | None = Field(
        default=None, description="the holder keeps this distance beyond the thickness [m], instead of a force"
    )
    punch_speed: Positive = Field(default=1.0, description="[m/s]")
    stroke: Positive = Field(
        default=0.0612, description="way of the punch from first touch [m]: depth 60 mm below the die face, plus the thickness"
    )
    damping: NotNegative = Field(default=100.0, description="mass-proportional damping rate [1/s]")
    frames: int = Field(default=60, ge=1, description="frames after the first")


def blank_holder_area() -> float:
    """Flat area of the undeformed blank between die and holder [m^2]."""
    rim = PUNCH_RADIUS + CLEARANCE + DIE_ENTRY_RADIUS
    return BLANK_LENGTH * BLANK_WIDTH - (math.pi * rim**2 + 2.0 * rim * DOME_DISTANCE)


def make_tools(parameters: DoubleDomeParameters, fabric: Fabric, share: float) -> tuple[Tool, ...]:
    """Punch, die and blank holder around a sheet whose mid-surface lies at z = 0."""
    half = 0.5 * fabric.thickness
    down = (0.0, 0.0, -1.0)
    upside_down = rotation_matrix((1.0, 0.0, 0.0), math.pi)
    half_length = 0.5 * DOME_DISTANCE
    opening = DomeOpening(
        radius=PUNCH_RADIUS + CLEARANCE, half_length=half_length, edge_radius=DIE_ENTRY_RADIUS, display_size=(0.52, 0.32)
    )
    punch = DomePunch(radius=PUNCH_RADIUS, half_length=half_length)
    holder_motion: Motion
    gap = 0.0
    if parameters.blank_holder_gap is not None:
        holder_motion, gap = Fixed(), parameters.blank_holder_gap
    else:
        force = parameters.blank_holder_force
        if force is None:
            force = BLANK_HOLDER_PRESSURE * blank_holder_area()
        holder_motion = Driven.constant(force * share, BLANK_HOLDER_MASS * share, BLANK_HOLDER_RAMP)
    return (
        Tool(
            "punch", punch.placed((0.0, 0.0, PUNCH_RADIUS + half)),
            Stroke.smooth(parameters.stroke, parameters.punch_speed, PUNCH_RAMP, start_time=BLANK_HOLDER_RAMP),
            friction=parameters.friction, axis=down,
        ),
        Tool("die", opening.placed((0.0, 0.0, -half)), friction=parameters.friction),
        Tool(
            "blank_holder", opening.placed((0.0, 0.0, half + gap), upside_down), holder_motion,
            friction=parameters.friction, axis=down,
        ),
    )  # fmt: skip


def double_dome(parameters: DoubleDomeParameters) -> Simulation:
    """A ready simulation of the double dome.

    Raises:
        InputError: parameters that contradict each other or the mesh.
    """
    if parameters.blank_holder_force is not None and parameters.blank_holder_gap is not None:
        raise InputError("blank holder: a force and a gap are given; it keeps one or the other")
    if parameters.fabric not in PRESETS:
        raise InputError(f"fabric {parameters.fabric!r} is unknown: choose one of {', '.join(PRESETS)}")
    fabric = PRESETS[parameters.fabric]()
    if parameters.shear_law == "linear":
        fabric = fabric.with_linear_shear(parameters.shear_modulus)
    symmetry = {"quarter": ("x", "y"), "half": ("y",), "full": ()}[parameters.part]
    if parameters.part != "full" and parameters.yarn_angle % 90.0 != 0.0:
        raise InputError(
            f"yarn angle {parameters.yarn_angle} degrees: a {parameters.part} blank is symmetric only at 0 or 90; use the full one"
        )
    lower = tuple(0.0 if axis in symmetry else -0.5 * s for axis, s in zip("xy", (BLANK_LENGTH, BLANK_WIDTH), strict=True))
    blank = Blank.rectangle(
        lower, (0.5 * BLANK_LENGTH, 0.5 * BLANK_WIDTH), parameters.mesh_size, yarn_angle=parameters.yarn_angle
    )
    tools = make_tools(parameters, fabric, {"quarter": 0.25, "half": 0.5, "full": 1.0}[parameters.part])
    duration = tools[0].motion.duration + REST
    return Simulation(
        name="double_dome", blank=blank, fabric=fabric, tools=tools, duration=duration, symmetry=symmetry,
        motion=MotionParameters(damping=parameters.damping, director_damping=parameters.damping),
        device=parameters.device, precision=parameters.precision, threads=parameters.threads,
        frame_count=parameters.frames,
    )  # fmt: skip
