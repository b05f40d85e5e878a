"""The largest mass scaling that keeps a stated error, found by runs on a coarser mesh."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...engine.model import Model
from ...engine.setup import Setup
from ...errors import InputError
from ...measures.border import outline
from ...quantities import positive
from ..frame import Frame
from ..simulation import Simulation
from ..staging.part import Part

logger = logging.getLogger(__name__)

# Elements of the coarse mesh over those of the run. A mesh twice as coarse may fold where the run does not.
COARSENING = 1.5
# Factors of the time step that are tried, until one changes too much.
FACTORS = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
# Share of the elements whose angles keep the tolerance.
KEPT_SHARE = 0.95

# (mesh size [m], target step [s] or None for no scaling) -> the set-up.
Make = Callable[[float, float | None], Setup]


@dataclass(frozen=True)
class ScalingTry:
    """One factor on the coarse mesh, compared with the run without scaling.

    Attributes:
        factor: of the time step; that of the mass is its square.
        angle_error: change of the shear angle that ``KEPT_SHARE`` of the elements stay below [degrees].
        draw_in_error: largest change of the border's positions [m].
        kinetic_ratio: kinetic over internal energy, of the summary.
        speed_up: steps of the unscaled run over those of this one.
        accepted: whether both errors are within their tolerances.
    """

    factor: float
    angle_error: float
    draw_in_error: float
    kinetic_ratio: float
    speed_up: float
    accepted: bool


@dataclass(frozen=True)
class MassScaling:
    """What was chosen, and why.

    Attributes:
        factor: of the time step, 1 where nothing was accepted.
        target_step: that gives it on the mesh of the run [s], for ``Solver``; None without scaling.
        mesh_size, coarse_size: of the run and of the tries [m].
        angle_tolerance, draw_in_tolerance: as given [degrees], [m].
        tries: in order; the last may not have been accepted.
    """

    factor: float
    target_step: float | None
    mesh_size: float
    coarse_size: float
    angle_tolerance: float
    draw_in_tolerance: float
    tries: tuple[ScalingTry, ...]

    def report(self) -> str:
        """What was tried and chosen, for readers."""
        lines = [
            f"mass scaling for {self.angle_tolerance:g} degrees at {KEPT_SHARE:.0%} of the elements and "
            f"{1e3 * self.draw_in_tolerance:g} mm of draw-in, tried on elements of {1e3 * self.coarse_size:.3g} mm:"
        ]
        lines += [
            f"  step x {each.factor:g} (mass x {each.factor**2:g}): {each.angle_error:.2g} degrees, "
            f"{1e3 * each.draw_in_error:.2g} mm, {each.speed_up:.1f} times fewer steps, kinetic over internal energy "
            f"{each.kinetic_ratio:.2g}: {'kept' if each.accepted else 'too much'}"
            for each in self.tries
        ]
        if self.target_step is None:
            return "\n".join([*lines, "no scaling keeps these tolerances: run without"])
        return "\n".join([*lines, f"chosen: step x {self.factor:g}, target_step = {self.target_step:.4g} s"])


def choose_mass_scaling(
    make: Make,
    mesh_size: float,
    *,
    angle_tolerance: float = 0.5,
    draw_in_tolerance: float = 0.5e-3,
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
    """
    mesh_size, angle_tolerance = positive("mesh_size", mesh_size), positive("angle_tolerance", angle_tolerance)
    draw_in_tolerance = positive("draw_in_tolerance", draw_in_tolerance)
    if not len(factors) or min(factors) <= 1.0 or any(np.diff(factors) <= 0.0):
        raise InputError(f"factors = {tuple(factors)}: increasing numbers above 1 are needed")
    coarse_size = COARSENING * mesh_size
    unscaled = Simulation(make(coarse_size, None))
    unscaled.run()
    step, tries = unscaled.model.reference_step, []
    for factor in factors:
        scaled = Simulation(make(coarse_size, factor * step))
        scaled.run()
        angle, draw_in = _changes(unscaled, scaled.frame)
        tries.append(
            ScalingTry(
                factor=float(factor), angle_error=angle, draw_in_error=draw_in,
                kinetic_ratio=float(scaled.summary()["kinetic_energy_ratio"]),
                speed_up=unscaled.state.step_count / scaled.state.step_count,
                accepted=angle <= angle_tolerance and draw_in <= draw_in_tolerance,
            )
        )  # fmt: skip
        if not tries[-1].accepted:
            break
    chosen = max((each.factor for each in tries if each.accepted), default=1.0)
    target = chosen * Model(make(mesh_size, None)).reference_step if chosen > 1.0 else None
    result = MassScaling(
        chosen, target, mesh_size, coarse_size, angle_tolerance, draw_in_tolerance, tuple(tries)
    )  # fmt: skip
    logger.info("%s", result.report())
    return result


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
