"""The sheet's own compressive stiffness along its yarns, and its current thickness."""

from typing import Any

import warp as wp

from ..lanes import fill, power, where_positive
from ..operators import add, div, mul, sub  # noqa: F401


@wp.func
def compressive_force(laws: Any, stretch: Any):
    """Force of the sheet itself along a yarn in compression [N/m]; psi = 1/2 k min(stretch - 1, 0)^2."""
    shortening = stretch - fill(stretch, 1.0)
    return laws.compressive_stiffness * where_positive(shortening, fill(stretch, 0.0), shortening)


@wp.func
def compressive_energy(laws: Any, m: Any):
    """Twice psi of the sheet's own compressive stiffness [J/m^2]."""
    one = fill(m.stretch1, 1.0)
    warp = compressive_force(laws, m.stretch1) * (m.stretch1 - one)
    weft = compressive_force(laws, m.stretch2) * (m.stretch2 - one)
    return warp + weft


@wp.func
def current_thickness(laws: Any, area_ratio: Any, crossover_pressure: Any):
    """t = t_0 J^-n / (1 + p/E_c) [m], with the crossover pressure p."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(area_ratio, 0.0))
    flattened = fill(area_ratio, 1.0) + laws.inverse_crossover_modulus * pressed
    return laws.thickness * power(area_ratio, -laws.thickening) / flattened
