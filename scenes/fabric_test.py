"""Common parts of the laboratory's tests: choice of the fabric, measured curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from weavesim.app.options import Need, RunOptions
from weavesim.checks import Positive
from weavesim.engine.setup import Setup
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import FABRIC_HELP, resolve_fabric
from weavesim.output.curves import Curves, MeasuredPoints
from weavesim.output.measured import Comparable, load_measured_curves
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.ranges import Quantity
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

# Only the fabric damps a test. The share dates from when a yarn that rattles between slack and taut gained energy near
# the largest stable step; it no longer does (decision 26). With the usual 0.9 a test takes a third fewer steps; forces
# then differ by 0.2 % of the largest in double precision, by up to 1.7 % in single, whose balance of energy is off by
# 1.5 times as much. The share is kept with the pages that were made with it (docs/verification.md).
STEP_SAFETY = 0.6
# Directors are held where a sheet is clamped, and should not move in a plane sheet [1/s].
DIRECTOR_DAMPING = 1.0e4


class FabricTestParameters(RunOptions):
    """Options common to all fabric tests."""

    fabric: str = Field(default="glass-polypropylene", description=FABRIC_HELP)
    shear_law: Literal["curve", "linear"] = Field(
        default="curve", description="published moment curve, or the paper's linear law, equation (4)"
    )
    shear_modulus: Annotated[Positive, Quantity("shear modulus")] = Field(
        default=0.25e6, description="G_12 of the linear law, twice the stress over the angle [Pa]"
    )
    frame_count: int = Field(default=60, ge=1, description="frames after the first")
    measured: Path | None = Field(
        default=None, description="table with a measured curve, drawn beside the computed one; units in its header"
    )
    measured_columns: str | None = Field(
        default=None,
        description='its columns, comma-separated, the abscissa first, as in "angle, force" [default: by usual names]',
    )

    needs: ClassVar[Mapping[str, Need]] = {
        "shear_modulus": Need("shear_law = linear", lambda options: options.shear_law == "linear"),
        "measured_columns": Need("measured", lambda options: options.measured is not None),
    }
    # What a measured curve can be compared with; a test names its own.
    abscissas: ClassVar[tuple[Comparable, ...]] = ()
    ordinates: ClassVar[tuple[Comparable, ...]] = ()

    def measured_curves(self) -> tuple[MeasuredPoints, ...]:
        """The measured curves, if there are any.

        Raises:
            InputError: a table that cannot be read in exactly one way.
        """
        if self.measured is None:
            return ()
        return load_measured_curves(self.measured, self.abscissas, self.ordinates, self.measured_columns)


def chosen_fabric(parameters: FabricTestParameters) -> Fabric:
    """The fabric of the preset or file in the parameters, with the shear law in the parameters.

    Raises:
        InputError: no such fabric.
    """
    fabric = resolve_fabric(parameters.fabric, accept_unusual=parameters.accept_unusual)
    return fabric.with_linear_shear(parameters.shear_modulus) if parameters.shear_law == "linear" else fabric


def pulled_strip(
    name: str, parameters: FabricTestParameters, fabric: Fabric, blank: Blank, stroke: SmoothStroke, damping: float
) -> Setup:
    """A strip along x that is clamped at both ends, of which one is pulled.

    Args:
        name: of the run.
        parameters: of the test.
        fabric: of the strip.
        blank: the strip.
        stroke: of the moving clamp.
        damping: mass-proportional rate [1/s].
    """
    x = blank.node_position[:, 0]
    fixed, moving = (np.flatnonzero(np.abs(x - place) < 1.0e-9) for place in (x.min(), x.max()))
    pull = Drive(stroke, np.array([1.0, 0.0, 0.0]))
    clamps = Support("clamp", fixed), Support("moving_clamp", moving, (pull,))
    return Setup(
        name, sheets=(Sheet(blank, fabric, supports=clamps),),
        dynamics=Dynamics(damping=damping, director_damping=DIRECTOR_DAMPING),
        duration=stroke.duration, frame_count=parameters.frame_count, solver=parameters.solver(step_safety=STEP_SAFETY),
        accept_unusual=parameters.accept_unusual,
    )  # fmt: skip


def of_curves(findings: Callable[[Curves], dict[str, Any]]) -> Callable[..., dict[str, Any]]:
    """The findings of a scene from those of its curves; none if the curves are not wanted."""
    return lambda parameters, simulation, wanted: findings(wanted.curves) if wanted.curves else {}
