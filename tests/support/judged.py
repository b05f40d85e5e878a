"""Runs as guards see them, with numbers that a test chooses."""

from types import SimpleNamespace
from typing import Any

from weavesim.run.guards import Doubt, known_guards

SOUND = {
    "gravity_work_ratio": 0.0, "energy_balance_error": 0.01, "kinetic_energy_ratio": 0.01,
    "hourglass_energy_ratio": 0.01, "damping_loss_ratio": 0.01, "added_mass_ratio": 0.0,
    "penetration_at_nodes_mm": 0.01, "unit_cell_failures": 0, "min_stretch": 0.99, "max_stretch": 1.01,
}  # fmt: skip


def judged(**numbers: Any) -> Any:
    """A sound run of a sheet 1 mm thick but for these numbers of its summary."""
    return SimpleNamespace(number=(SOUND | numbers).__getitem__, thickness=1.0e-3)


def said(name: str, **numbers: Any) -> list[Doubt]:
    """What one guard says about ``judged``."""
    return list(known_guards()[name]().after(judged(**numbers)))
