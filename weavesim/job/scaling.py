"""A job that asks for mass scaling by a stated error: its set-up on a mesh of another size, and the search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..engine.setup import Setup
from ..errors import InputError
from ..process.scaling.mass import tolerances_of
from ..run.scaling.mass import choose_mass_scaling, with_mass_scaling
from .build import setup_of
from .read import JobFile


def scaled_setup_of(file: JobFile, *, before: Callable[[], object] | None = None) -> Setup:
    """The set-up of a job without a scene, with the mass scaling that it asks for, if it does.

    Args:
        file: with the job.
        before: called before a search, which takes runs.

    Raises:
        InputError: a bad job, or plies whose meshes cannot be coarser.
        RunError: the coarse run without scaling had to stop.
        KeyboardInterrupt: a signal ended the search.
    """
    setup, solver = setup_of(file), file.job.solver
    tolerances = tolerances_of(solver.mass_scaling_angle, solver.mass_scaling_draw_in)
    if tolerances is None:
        return setup
    if before is not None:
        before()
    smallest = min(ply.mesh_size for ply in file.job.ply)

    def make(mesh_size: float, target_step: float | None) -> Setup:
        share = mesh_size / smallest
        plies = tuple(ply.model_copy(update={"mesh_size": share * ply.mesh_size}) for ply in file.job.ply)
        other = setup_of(replace(file, job=file.job.model_copy(update={"ply": plies}))) if share != 1.0 else setup
        return other.model_copy(update={"solver": other.solver.model_copy(update={"target_step": target_step})})

    key = "mass_scaling_draw_in" if solver.mass_scaling_angle is None else "mass_scaling_angle"
    try:
        found = choose_mass_scaling(make, smallest, **tolerances)
    except InputError as error:
        file.refuse(["solver", key], f"{key}: {error}")
    return with_mass_scaling(setup, found)
