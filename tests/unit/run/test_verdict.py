"""Numbers of a run, each with its unit."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.runs import small_run
from tests.support.summary_keys import keys_without_unit
from weavesim.measures.units import split_unit
from weavesim.process.dynamics import Dynamics
from weavesim.run.verdict import RUN_FINDINGS, summary
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool


@pytest.fixture(scope="module")
def pulled():
    """A square whose right half moves away, above a table that it does not touch."""
    velocity = np.zeros((25, 3))
    velocity[:, 0] = 2.0 * np.linspace(0.0, 1.0, 5).repeat(5)
    simulation = small_run(initial_velocity=velocity, tools=[Tool("table", Plane(origin=(0.0, 0.0, -0.1)))])
    simulation.run()
    return simulation


def test_every_number_is_in_the_summary_by_its_key_and_in_order(pulled):
    not_here = {"sheet_intersections", "interfaces", "stages", "trims", "mass_scaling"}
    assert list(summary(pulled)) == [finding.key for finding in RUN_FINDINGS if finding.key not in not_here]
    for finding in RUN_FINDINGS:
        assert split_unit(finding.key) == (finding.name, finding.unit) and finding.description
    assert not keys_without_unit(summary(pulled))


def test_a_number_without_its_unit_is_found():
    entry = {"name": "a / b", "force_N": 1.0, "max_pressure_Pa": 2.0, "max_slip_mm": 3.0, "open": True}
    doubt = {"value": 1.0, "limit": 2.0}
    numbers = {"interfaces": [entry], "step_count": 4, "peak_tool_force_n": {"punch": 5.0}, "doubts": [doubt]}
    wrong = {"time": 1.0, "value": 2.0, "largest": {"angle": [3.0]}}
    expected = ["interfaces.force_N", "interfaces.max_pressure_Pa", "time", "value", "largest.angle"]
    assert keys_without_unit(numbers | wrong) == expected


def test_no_depth_in_a_tool_is_given_where_there_is_none(pulled):
    """Not even minus infinity, which no JSON has."""
    depths = {"penetration_at_nodes_mm", "penetration_of_surface_mm", "penetration_at_element_centres_mm"}
    assert {finding.key for finding in RUN_FINDINGS} - set(small_run().summary()) >= depths
    gap = -(100.0 - 0.5e3 * pulled.info.sheet.fabric.thickness)
    for key in depths:
        assert summary(pulled)[key] == pytest.approx(gap, rel=1e-3)


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
    entries = [entry for entry in pulled.watch.history if entry["internal"] > 0.0]
    numbers = summary(pulled)
    assert numbers["hourglass_energy_ratio"] == max(entry["hourglass"] / entry["internal"] for entry in entries)
    supplied = max(abs(entry["supplied"]) for entry in pulled.watch.history)
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


def test_no_ratio_is_formed_with_nothing():
    """Nothing is supplied: rounding over rounding would be 1e293, or "energy is made or lost"."""
    still = small_run()
    still.run()
    numbers = summary(still)
    absent = {"damping_loss_ratio", "gravity_work_ratio", "energy_balance_error"}
    assert not absent & set(numbers)
    assert numbers["kinetic_energy_ratio"] == numbers["hourglass_energy_ratio"] == 0.0
    assert still.doubts() == []


@pytest.mark.parametrize("speed", [1e-9, 1e-6, 1e-4])
def test_hardly_anything_is_nothing(speed):
    """A drift of far less than the thickness, with damping that takes all of it, or without."""
    for damping in (0.0, 1e5):
        drifting = small_run(
            initial_velocity=np.full((25, 3), speed), dynamics=Dynamics(damping=damping), accept_unusual=True
        )
        drifting.run()
        assert drifting.doubts() == []


def test_energy_from_nothing_is_still_doubted(pulled):
    """Its own growth is the scale: what appears without work is not hidden by having been nothing."""
    run = Grown(pulled, 3.0)
    assert summary(run)["energy_balance_error"] == pytest.approx(1.0)


@pytest.mark.parametrize(("made", "ratio"), [(0.0, 0.0), (0.2, 0.2)])
def test_what_is_stored_at_the_start_is_no_error(pulled, made, ratio):
    """A ring in touch stores a little in contact before anything moves: energy that is made afterwards counts."""
    run, stored = Grown(pulled, 0.0), 1.0e-3
    rest = dict.fromkeys(run.watch.history[0], 0.0)
    first = rest | {"contact": stored, "used": stored, "balance_error": -stored}
    work = rest | {"internal": 1.0, "contact": stored, "tool_work": 1.0, "supplied": 1.0, "time": 1.0,
                   "used": 1.0 + stored + made, "balance_error": -stored - made}  # fmt: skip
    run.watch.history[:] = [first, work]
    assert summary(run)["energy_balance_error"] == pytest.approx(ratio / (1.0 + stored + made), abs=1e-12)


class Grown:
    """A run to which nothing is supplied, and whose energy grows all the same [J]."""

    def __init__(self, run, energy):
        self._run = run
        entry = dict.fromkeys(run.history[0], 0.0)
        grown = entry | {"kinetic": energy, "used": energy, "balance_error": -energy, "time": 1.0}
        self.watch = SimpleNamespace(
            history=[entry, grown], extremes=run.watch.extremes, conditions=run.watch.conditions, stacks=()
        )

    def __getattr__(self, name):
        return getattr(self._run, name)
