"""The unit cell's response on its own, for any number of stretches and cells at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from .device import initialise, resolve_device, resolve_precision
from .errors import InputError
from .fabric import UnitCell
from .kernels.unit_cell import unit_cell_struct
from .kernels.unit_cell_response import unit_cell_response_kernel
from .model import fill_unit_cell


@dataclass(frozen=True)
class UnitCellResponse:
    """Answers for n pairs of stretches; all of the half cell, which two make a crossover.

    Attributes:
        height_change: w_1, w_2, (n, 2) [m].
        force: F_1, F_2 along warp and weft of one yarn, (n, 2) [N].
        force_per_width: n_1, n_2, (n, 2) [N/m].
        crossover_force: pressing warp and weft together at a physical crossover (two half cells), (n,) [N].
        energy: axial warp, axial weft, yarn bending, contact, (n, 4) [J].
        tangent: dF_k/du_l with w in equilibrium: K11, K12, K22, (n, 3) [N/m].
        residual: largest relative residual on the path, (n,).
        iterations: most Newton iterations of one increment, (n,).
    """

    height_change: np.ndarray
    force: np.ndarray
    force_per_width: np.ndarray
    crossover_force: np.ndarray
    energy: np.ndarray
    tangent: np.ndarray
    residual: np.ndarray
    iterations: np.ndarray


def respond(
    cells: UnitCell | Sequence[UnitCell],
    stretch: np.ndarray,
    *,
    increment_count: int = 50,
    start: np.ndarray | None = None,
    precision: str = "float64",
    device: str = "cpu",
) -> UnitCellResponse:
    """Follow each cell from stretch 1 to ``stretch`` in equal increments.

    Args:
        cells: one cell for all, or one per row of ``stretch``.
        stretch: of warp and weft, (n, 2).
        start: first guess of the height changes, (n, 2) [m]; zero by default.

    Raises:
        InputError: stretches that are not finite and positive, or shapes that do not fit.
    """
    initialise()
    precision = resolve_precision(precision)
    wp_device, real = resolve_device(device), precision.real
    stretch = np.atleast_2d(np.asarray(stretch, dtype=float))
    if stretch.ndim != 2 or stretch.shape[1] != 2 or not np.all(np.isfinite(stretch)) or stretch.min() <= 0.0:
        raise InputError("stretch: an (n, 2) array of finite, positive stretches of warp and weft is needed")
    if increment_count < 1:
        raise InputError(f"increment_count = {increment_count}: at least 1 is needed")
    count = len(stretch)
    cells = [cells] if isinstance(cells, UnitCell) else list(cells)
    if len(cells) not in (1, count):
        raise InputError(f"{len(cells)} cells for {count} pairs of stretches: give one, or as many")
    structs = []
    for parameters in cells:
        struct = unit_cell_struct(real)()
        fill_unit_cell(struct, parameters, precision)
        structs.append(struct)
    first_guess = np.zeros((count, 2)) if start is None else np.asarray(start, dtype=float)
    rows = [wp.zeros((n, count), dtype=real, device=wp_device) for n in (2, 3, 4, 3, 2)]
    wp.launch(
        unit_cell_response_kernel(real),
        dim=count,
        inputs=[
            wp.array(structs, dtype=unit_cell_struct(real), device=wp_device),
            wp.array(stretch.T.copy(), dtype=real, device=wp_device),
            wp.array(first_guess.T.copy(), dtype=real, device=wp_device),
            increment_count,
        ],
        outputs=rows,
        device=wp_device,
    )
    height_change, force, energy, tangent, convergence = (row.numpy().astype(np.float64).T for row in rows)
    spacing = 2.0 * np.array([[cell.weft_half_spacing, cell.warp_half_spacing] for cell in cells])
    return UnitCellResponse(
        height_change=height_change,
        force=force[:, :2],
        force_per_width=force[:, :2] / spacing,
        crossover_force=2.0 * force[:, 2],
        energy=energy,
        tangent=tangent,
        residual=convergence[:, 0],
        iterations=convergence[:, 1],
    )
