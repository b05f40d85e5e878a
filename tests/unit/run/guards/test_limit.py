"""Guards of single numbers: each speaks alone above its limit, and is silent for a sound run."""

import math

import pytest

from tests.support.judged import judged
from weavesim.run.guards import Level, known_guards


@pytest.mark.parametrize(
    ("guard", "name", "value", "level", "message"),
    [
        ("energy_balance", "energy_balance_error", 0.051, Level.DO_NOT_USE,
         "error of the energy balance over the work is 0.051, above 0.05"),
        ("energy_balance", "energy_balance_error", math.nan, Level.DO_NOT_USE, "energy balance"),
        ("kinetic_energy", "kinetic_energy_ratio", 0.2, Level.WARNING, "not quasi-static"),
        ("hourglass_energy", "hourglass_energy_ratio", 0.06, Level.WARNING, "refine the mesh"),
        ("damping_loss", "damping_loss_ratio", 0.06, Level.WARNING, "lower the damping"),
        ("added_mass", "added_mass_ratio", 0.06, Level.WARNING, "added mass"),
        ("penetration_of_surface", "penetration_of_surface_mm", 0.51, Level.WARNING,
         "deepest point of the sheet's surface in a tool [mm] is 0.51, above 0.5"),
        ("penetration_of_surface", "penetration_of_surface_mm", 2.1, Level.DO_NOT_USE, "is 2.1"),
        ("unit_cell_failures", "unit_cell_failures", 1, Level.WARNING, "failed unit cells is 1, above 0"),
    ],
)  # fmt: skip
def test_each_number_is_doubted_alone(guard, name, value, level, message):
    found = [doubt for kind in known_guards().values() for doubt in kind().after(judged(**{name: value}))]
    (doubt,) = found
    assert (doubt.guard, doubt.level) == (guard, level) and message in doubt.message


def test_nothing_speaks_against_a_sound_run():
    assert [doubt for kind in known_guards().values() for doubt in kind().after(judged())] == []
