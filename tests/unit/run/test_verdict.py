"""Why a result should not be trusted."""

import re

import pytest

from weavesim.run.verdict import doubts

SOUND = {
    "gravity_work_ratio": 0.0, "energy_balance_error": 0.01, "kinetic_energy_ratio": 0.01,
    "hourglass_energy_ratio": 0.01, "damping_loss_ratio": 0.01, "added_mass_ratio": 0.0,
    "penetration_at_nodes_mm": 0.01, "unit_cell_failures": 0, "min_stretch": 0.99, "max_stretch": 1.01,
}  # fmt: skip


def test_nothing_speaks_against_a_sound_run():
    assert doubts(SOUND, 1e-3) == []


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("energy_balance_error", 0.051, "error of the energy balance over the work is 0.051, above 0.05"),
        ("energy_balance_error", float("nan"), "energy balance"),
        ("kinetic_energy_ratio", 0.2, "not quasi-static"),
        ("hourglass_energy_ratio", 0.06, "refine the mesh"),
        ("damping_loss_ratio", 0.06, "lower the damping"),
        ("added_mass_ratio", 0.06, "added mass"),
        ("penetration_at_nodes_mm", 0.051, r"deepest node in a tool \[mm\] is 0.051, above 0.05"),
        ("unit_cell_failures", 1, "failed unit cells is 1, above 0"),
        ("min_stretch", 0.89, "stretches range from 0.890 to 1.010"),
        ("max_stretch", float("nan"), "stretches range"),
    ],
)
def test_each_doubt_is_said_alone(name, value, message):
    (found,) = doubts(SOUND | {name: value}, 1e-3)
    assert re.search(message, found)


def test_what_falls_may_lose_its_energy_to_damping():
    assert doubts(SOUND | {"damping_loss_ratio": 0.9, "gravity_work_ratio": 0.9}, 1e-3) == []
