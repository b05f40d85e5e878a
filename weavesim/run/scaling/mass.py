"""The largest mass scaling that keeps a stated error, found by runs on a coarser mesh."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Sequence

import numpy as np

from ...engine.model import Model
from ...engine.setup import Setup
from ...errors import InputError, RunError, logged_from
from ...measures.border import outline
from ...process.scaling.mass import ANGLE_TOLERANCE, DRAW_IN_TOLERANCE, KEPT_SHARE, MassScaling, ScalingTry
from ...quantities import positive
from ..frame import Frame, Outcome
from ..interruption import Interrupted
from ..simulation import Simulation
from ..staging.part import Part
from ..verdict import Judged

logger = logging.getLogger(__name__)

# Elements of the coarse mesh over those of the run. A mesh twice as coarse may fold where the run does not.
COARSENING = 1.5
# Factors of the time step that are tried, until one changes too much.
FACTORS = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)

# (mesh size [m], target step [s] or None for no scaling) -> the set-up.
Make = Callable[[float, float | None], Setup]


def choose_mass_scaling(
    make: Make,
    mesh_size: float,
    *,
    angle_tolerance: float = ANGLE_TOLERANCE,
    draw_in_tolerance: float = DRAW_IN_TOLERANCE,
    factors: Sequence[float] = FACTORS,
) -> MassScaling:
    """The largest of ``factors`` whose run on a coarser mesh keeps both tolerances; larger ones are not tried.

    The inertia that scaling adds is the same share of that of the sheet on both meshes. Weight is scaled too: a set-up
    that gravity drives keeps no tolerance.

    Args:
        make: the set-up of a mesh size and a target step.
        mesh_size: of the run [m].
        angle_tolerance: of the shear angles at the end [degrees].
        draw_in_tolerance: of the positions of the border at the end [m].
        factors: of the time step, increasing, above one.

    Raises:
        InputError: a bad number, or a set-up that cannot be coarsened.
        RunError: the coarse run without scaling had to stop.
        KeyboardInterrupt: a signal ended one of the runs.
    """
    mesh_size, angle_tolerance = positive("mesh_size", mesh_size), positive("angle_tolerance", angle_tolerance)
    draw_in_tolerance = positive("draw_in_tolerance", draw_in_tolerance)
    if not len(factors) or min(factors) <= 1.0 or any(np.diff(factors) <= 0.0):
        raise InputError(f"factors = {tuple(factors)}: increasing numbers above 1 are needed")
    coarse_size = COARSENING * mesh_size
    own, coarse = make(mesh_size, None), make(coarse_size, None)
    _check_coarsened(own, coarse)
    _tell("%s: looking for the largest mass scaling, by runs on elements of %.3g mm", own.name, 1e3 * coarse_size)
    unscaled = _run(coarse)
    step, tries = unscaled.model.reference_step, list[ScalingTry]()
    for factor in factors:
        try:
            scaled = _run(make(coarse_size, factor * step))
        except RunError as error:
            logger.info("step x %g: %s", factor, error)
            angle = draw_in = ratio = None
            speed_up, accepted = factor, False
        else:
            angle, draw_in = _changes(unscaled, scaled.frame)
            ratio = Judged(scaled).number("kinetic_energy_ratio")
            speed_up = unscaled.state.step_count / scaled.state.step_count
            accepted = angle <= angle_tolerance and draw_in <= draw_in_tolerance
        tries.append(
            ScalingTry(
                factor=float(factor), angle_error=angle, draw_in_error=draw_in, kinetic_ratio=_finite(ratio),
                speed_up=speed_up, accepted=accepted,
            )
        )  # fmt: skip
        _tell("%s: %s", own.name, tries[-1].line)
        if not accepted:
            break
    chosen = max((each.factor for each in tries if each.accepted), default=1.0)
    result = MassScaling(
        factor=chosen, target_step=chosen * Model(own).reference_step if chosen > 1.0 else None, mesh_size=mesh_size,
        coarse_size=coarse_size, angle_tolerance=angle_tolerance, draw_in_tolerance=draw_in_tolerance,
        kept_share=KEPT_SHARE, tries=tuple(tries),
    )  # fmt: skip
    logger.info("%s", result.report())
    return result


def with_mass_scaling(setup: Setup, found: MassScaling) -> Setup:
    """A set-up that runs at the step that was found, and tells so in its summary."""
    changed = {"target_step": found.target_step, "mass_scaling": found}
    return setup.model_copy(update={"solver": setup.solver.model_copy(update=changed)})


def _tell(text: str, *values: object) -> None:
    """Log what takes minutes before a run, for commands to show."""
    logger.info(text, *values, extra={"announced": True})


def _check_coarsened(own: Setup, coarse: Setup) -> None:
    """Refuse sheets that have the same mesh at both sizes: nothing could be learned from them."""
    if own.solver.time_step is not None:
        raise InputError(
            f"time_step = {own.solver.time_step:.4g} s: no step above it is taken, so that scaled mass makes no run "
            "faster; leave it out, or the search for a mass scaling"
        )
    for sheet, other in zip(own.sheets, coarse.sheets, strict=True):
        if sheet.blank.element_count <= other.blank.element_count:
            raise InputError(
                f"sheet {sheet.name}: its mesh does not depend on the mesh size, and a mass scaling is sought on "
                f"elements {COARSENING:g} times as large; give a target_step, or an outline that is meshed"
            )


def _run(setup: Setup) -> Simulation:
    """A finished run, for its numbers alone: what its guards say is not the user's run."""
    simulation = Simulation(setup)
    with logged_from(logging.ERROR, "weavesim.run.guards"):
        outcome = simulation.run()
    if outcome is Outcome.INTERRUPTED:
        raise Interrupted(signal.Signals[simulation.interrupted_by]) if simulation.interrupted_by else KeyboardInterrupt
    return simulation


def _finite(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)


def _changes(unscaled: Simulation, frame: Frame) -> tuple[float, float]:
    """Changes of the angles of ``KEPT_SHARE`` of the elements [degrees], and of the border [m], of all sheets."""
    angles, moves = [], []
    for whole, own, other in zip(unscaled.info.sheets, unscaled.frame.sheets, frame.sheets, strict=True):
        angle = np.abs(other.fields["shear_angle"] - own.fields["shear_angle"])
        angles.append(angle[np.isfinite(angle)])  # what a stage has trimmed has none
        part = Part(whole, own.kept)
        border = part.nodes[outline(part.info.blank, whole.symmetry).node]
        border = np.intersect1d(border, Part(whole, other.kept).nodes)
        moves.append(np.linalg.norm((other.position - own.position)[border], axis=1))
    return float(np.degrees(np.quantile(np.concatenate(angles), KEPT_SHARE))), float(np.concatenate(moves).max())
