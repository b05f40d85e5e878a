"""The response of any unit cell by itself, for any number of strains and cells at once."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from ..device import exclusive, initialise, is_compiled, load_kernel, resolve_device, resolve_precision
from ..errors import InputError
from ..kernels.cell.response import response_struct, unit_cell_response_kernel
from ..kernels.rows import CellForceRow, ConvergenceRow, StrainRow, TangentRow
from ..ranges import unusual_values
from .cell import UnitCell

logger = logging.getLogger(__name__)

# Rows of the symmetric tangent.
TANGENT = (
    (TangentRow.c11, TangentRow.c12, TangentRow.c13),
    (TangentRow.c12, TangentRow.c22, TangentRow.c23),
    (TangentRow.c13, TangentRow.c23, TangentRow.c33),
)


@dataclass(frozen=True)
class UnitCellResponse:
    """Response to n strains; all values per reference area or width.

    Attributes:
        unknowns: internal unknowns, (n, unknown_count); of the plain weave the height changes w_1, w_2 [m].
        force_per_width: n_1, n_2, (n, 2) [N/m].
        moment: m = dpsi/dgamma, (n,) [N/m].
        crossover_force: force that presses warp and weft together at a physical crossover, (n,) [N].
        energy: parts of psi, (n, part_count) [J/m^2], in the order of ``energy_names``.
        energy_names: names of the parts.
        tangent: derivatives of (n_1, n_2, m) with respect to (warp stretch, weft stretch, shear angle) with the
            unknowns in equilibrium, (n, 3, 3) [N/m].
        residual: largest relative residual on the path, (n,).
        iterations: largest number of Newton steps in one increment, not counting its last, (n,).
        snap_loss: energy released by jumps to other equilibria on the path, (n,) [J/m^2].
    """

    unknowns: np.ndarray
    force_per_width: np.ndarray
    moment: np.ndarray
    crossover_force: np.ndarray
    energy: np.ndarray
    energy_names: tuple[str, ...]
    tangent: np.ndarray
    residual: np.ndarray
    iterations: np.ndarray
    snap_loss: np.ndarray


def responds_at_once(cell: UnitCell, *, precision: str = "float64", device: str = "cpu") -> bool:
    """Whether the kernel that ``respond`` needs for cells of this class is compiled already."""
    initialise()
    kernel = unit_cell_response_kernel(resolve_precision(precision).real, cell.law())
    return is_compiled(kernel, resolve_device(device))


@exclusive()
def respond(
    cells: UnitCell | Sequence[UnitCell],
    stretch: ArrayLike,
    shear_angle: ArrayLike = 0.0,
    *,
    increment_count: int = 50,
    start: np.ndarray | None = None,
    precision: str = "float64",
    device: str = "cpu",
) -> UnitCellResponse:
    """Follow each cell from rest to ``stretch`` and ``shear_angle`` in equal increments.

    Args:
        cells: one cell for all rows of ``stretch``, or one per row; all of the same class.
        stretch: of warp and weft, (n, 2).
        shear_angle: one for all rows, or (n,) [rad]; below pi/2.
        start: first guess of the unknowns, (n, unknown_count); those of the cell at rest by default.

    Values outside their plausible range are logged as warnings.

    Raises:
        InputError: strains that are not finite, stretches that are not positive, or shapes that do not match.
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
    angle = np.asarray(shear_angle, dtype=float)
    if angle.shape not in ((), (count,)) or not np.all(np.abs(angle) < 0.5 * np.pi):
        raise InputError(f"shear_angle: one angle or {count} are needed, in radians and below pi/2")
    cells = [cells] if isinstance(cells, UnitCell) else list(cells)
    distinct = {id(cell): cell for cell in cells}
    for sentence in dict.fromkeys(sentence for cell in distinct.values() for sentence in unusual_values(cell)):
        logger.warning("%s: %s", type(cells[0]).__name__, sentence)
    if len(cells) not in (1, count):
        raise InputError(f"{len(cells)} cells for {count} pairs of stretches: give one, or {count}")
    law = cells[0].law()
    if any(cell.law() is not law for cell in distinct.values()):
        raise InputError("cells of several classes were given: call respond for each class separately")
    parameters = {key: cell.device_parameters(precision) for key, cell in distinct.items()}
    if start is None:
        initial = {key: cell.initial_unknowns for key, cell in distinct.items()}
        start = np.array([initial[id(cell)] for cell in cells])
    first_guess = np.zeros((count, law.row_count))
    first_guess[:, : law.unknown_count] = start
    strain = np.empty((StrainRow.row_count(), count))
    strain[[StrainRow.warp, StrainRow.weft]], strain[StrainRow.shear_angle] = stretch.T - 1.0, angle
    row_counts = {
        "unknowns": law.row_count,
        "force": CellForceRow.row_count(),
        "energy": len(law.energy_names),
        "tangent": TangentRow.row_count(),
        "convergence": ConvergenceRow.row_count(),
    }
    response = response_struct(real)()
    for name, row_count in row_counts.items():
        setattr(response, name, wp.zeros((row_count, count), dtype=real, device=wp_device))
    kernel = unit_cell_response_kernel(real, law)
    load_kernel(kernel, wp_device)
    wp.launch(
        kernel,
        dim=count,
        inputs=[
            wp.array([parameters[id(cell)] for cell in cells], dtype=law.parameters(real), device=wp_device),
            wp.array(strain, dtype=real, device=wp_device),
            wp.array(first_guess.T.copy(), dtype=real, device=wp_device),
            increment_count,
        ],
        outputs=[response],
        device=wp_device,
    )
    unknowns, force, energy, tangent, convergence = (
        getattr(response, name).numpy().astype(np.float64).T for name in row_counts
    )
    return UnitCellResponse(
        unknowns=unknowns[:, : law.unknown_count],
        force_per_width=force[:, [CellForceRow.warp, CellForceRow.weft]],
        moment=force[:, CellForceRow.moment],
        crossover_force=force[:, CellForceRow.crossover_pressure] * np.array([cell.crossover_area for cell in cells]),
        energy=energy,
        energy_names=law.energy_names,
        tangent=tangent[:, TANGENT],
        residual=convergence[:, ConvergenceRow.worst_residual],
        iterations=convergence[:, ConvergenceRow.most_iterations],
        snap_loss=convergence[:, ConvergenceRow.snap_loss],
    )
