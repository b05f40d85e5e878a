"""Numbers of a run, each with its unit, and what makes a result doubtful."""

import dataclasses
import re

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.measures.units import split_unit
from weavesim.run.verdict import RUN_FINDINGS, doubts, summary

SOUND = {
    "gravity_work_ratio": 0.0, "energy_balance_error": 0.01, "kinetic_energy_ratio": 0.01,
    "hourglass_energy_ratio": 0.01, "damping_loss_ratio": 0.01, "added_mass_ratio": 0.0,
    "penetration_at_nodes_mm": 0.01, "unit_cell_failures": 0, "min_stretch": 0.99, "max_stretch": 1.01,
}  # fmt: skip


@pytest.fixture(scope="module")
def pulled():
    """A square whose right half moves away."""
    velocity = np.zeros((25, 3))
    velocity[:, 0] = 2.0 * np.linspace(0.0, 1.0, 5).repeat(5)
    simulation = small_run(initial_velocity=velocity)
    simulation.run()
    return simulation


def test_every_number_is_in_the_summary_by_its_key_and_in_order(pulled):
    assert list(summary(pulled)) == [finding.key for finding in RUN_FINDINGS]
    for finding in RUN_FINDINGS:
        assert split_unit(finding.key) == (finding.name, finding.unit) and finding.description


def test_numbers_are_those_of_the_last_frame(pulled):
    numbers, frame = summary(pulled), pulled.frame
    assert numbers["max_shear_angle_deg"] == np.degrees(np.abs(frame.fields["shear_angle"]).max())
    stretch = np.concatenate([frame.fields["warp_stretch"], frame.fields["weft_stretch"]])
    assert (numbers["min_stretch"], numbers["max_stretch"]) == (stretch.min(), stretch.max())
    assert numbers["energies_j"] == frame.energies
    assert numbers["step_count"] * numbers["time_step_s"] == pytest.approx(numbers["time_s"]) == frame.time
    assert (numbers["element_count"], numbers["node_count"], numbers["outcome"]) == (16, 25, "finished")
    assert numbers["gravity_work_ratio"] == 0.0 and numbers["kinetic_energy_ratio"] > 0.0


def test_ratios_are_the_largest_of_the_frames_that_store_enough(pulled):
    entries = [entry for entry in pulled.history if entry["internal"] > 0.0]
    numbers = summary(pulled)
    assert numbers["hourglass_energy_ratio"] == max(entry["hourglass"] / entry["internal"] for entry in entries)
    supplied = max(abs(entry["supplied"]) for entry in pulled.history)
    assert numbers["damping_loss_ratio"] == pulled.frame.energies["damping_loss"] / supplied


def test_numbers_of_a_field_stand_for_all_sheets(pulled):
    other = dataclasses.replace(pulled.frame.sheet, fields={**pulled.frame.fields, "warp_stretch": np.full(16, 1.3)})
    both = TwoSheets(pulled, other)
    assert summary(both)["max_stretch"] == 1.3
    assert summary(both)["min_stretch"] == summary(pulled)["min_stretch"]


class TwoSheets:
    """A run with a second sheet in addition to its own in the last frame."""

    def __init__(self, run, other):
        self._run = run
        self.frame = dataclasses.replace(run.frame, sheets=(run.frame.sheet, other))
        self.info = dataclasses.replace(run.info, sheets=2 * run.info.sheets)

    def __getattr__(self, name):
        return getattr(self._run, name)


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
