"""Variants that run at once get what each gets alone; one that fails costs the others nothing."""

import os
import signal
import sys
import threading

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.support.runs import one_sheet_setup
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run import simulation as simulation_module
from weavesim.run.batch import batch as module
from weavesim.run.batch.batch import run_batch
from weavesim.run.diagnosis import Failure
from weavesim.run.frame import Outcome
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

TIMES = {"wall_time_s", "stepping_time_s", "output_time_s", "element_steps_per_second", "threads", "run_id"}


def variant(speed=1.0, friction=0.2, height=-0.0307, size=0.005, **given):
    """A patch of 20 mm that falls onto a ball of 30 mm."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), size)
    ball = Tool("ball", Sphere(0.03, origin=(0.01, 0.01, height)), friction=friction)
    settings = {"name": "patch", "duration": 1e-3, "frame_count": 3, "threads": 1} | given
    return one_sheet_setup(
        blank=blank, fabric=glass_polypropylene(), tools=(ball,),
        initial_velocity=np.tile([0.0, 0.0, -speed], (blank.node_count, 1)), **settings,
    )  # fmt: skip


VARIANTS = [variant(speed, friction) for speed in (0.5, 1.0, 2.0) for friction in (0.0, 0.3)]


def numbers(summary):
    """A summary without what no two runs share."""
    return {key: value for key, value in summary.items() if key not in TIMES}


@pytest.fixture(scope="module")
def singles():
    runs = [Simulation(setup) for setup in VARIANTS]
    for run in runs:
        run.run()
    return runs


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_variants_get_the_bits_of_single_runs(singles, threads):
    for batch, single in zip(run_batch(VARIANTS, threads=threads), singles, strict=True):
        assert batch.finished and batch.setup is single.setup
        assert batch.frame.position.tobytes() == single.frame.position.tobytes()
        assert batch.frame.energies == single.frame.energies
        for name, values in single.frame.fields.items():
            assert batch.frame.fields[name].tobytes() == values.tobytes()
        assert batch.history == tuple(single.history)
        assert numbers(batch.summary) == numbers(single.summary())
        assert batch.doubts == tuple(single.doubts()) and batch.verdict == single.verdict


def test_variants_differ():
    ends = {run.frame.position.tobytes() for run in run_batch(VARIANTS)}
    assert len(ends) == len(VARIANTS)


def test_meshes_and_precisions_may_differ():
    setups = [
        variant(size=size, precision=precision) for size in (0.004, 0.005) for precision in ("float32", "float64")
    ]
    for batch, setup in zip(run_batch(setups), setups, strict=True):
        single = Simulation(setup)
        single.run()
        assert batch.frame.position.tobytes() == single.frame.position.tobytes()


def test_a_variant_that_cannot_start_costs_the_others_nothing():
    good, bad, other = run_batch([variant(), variant(height=-0.02), variant(friction=0.1)])
    assert good.finished and other.finished
    assert bad.outcome is None and bad.frame is None and bad.summary == {} and bad.verdict == "not run"
    assert "overlaps the blank" in bad.failure


def test_a_variant_that_is_lost_says_so(monkeypatch):
    find = simulation_module.find_failure

    def find_or_lose(model, state, frame):
        return Failure("lost on the way", 0.0) if model.setup.name == "lost" else find(model, state, frame)

    monkeypatch.setattr(simulation_module, "find_failure", find_or_lose)
    good, lost = run_batch([variant(), variant(name="lost")])
    assert good.finished and good.failure is None
    assert lost.outcome is Outcome.NOT_FINITE and lost.failure == "lost on the way" and lost.frame is not None


def test_every_variant_has_its_observers_and_is_announced():
    seen, found = {index: Frames() for index in range(3)}, {}
    run_batch(
        VARIANTS[:3],
        observers=lambda index: (seen[index],),
        finished=lambda index, run: found.update({index: run.summary()["step_count"]}),
    )
    for index, setup in enumerate(VARIANTS[:3]):
        assert len(seen[index].all) == setup.frame_count + 1
        assert found[index] == seen[index].all[-1].step_count


def test_a_mistake_of_the_caller_is_raised():
    def fail(index, run):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        run_batch(VARIANTS[:2], finished=fail)


def test_bad_input_of_the_batch_is_refused():
    with pytest.raises(InputError, match="abacus"):
        run_batch(VARIANTS, device="abacus")
    with pytest.raises(InputError, match="threads"):
        run_batch(VARIANTS, threads=0)
    with pytest.raises(InputError, match="entry 1 is a str; values of Setup are needed"):
        run_batch([variant(), "setup.json"])
    assert run_batch([]) == []


def test_one_variant_gets_all_threads(monkeypatch):
    used = []
    run_batch([variant()], threads=2, finished=lambda index, run: used.append(run.setup.solver.threads))
    run_batch([variant()] * 5, threads=2, finished=lambda index, run: used.append(run.setup.solver.threads))
    assert used == [2, 1, 1, 1, 1, 1]


def test_a_signal_ends_the_batch_in_order():
    before, running = sys.getswitchinterval(), threading.Event()

    class Trigger(Frames):
        def frame(self, frame):
            super().frame(frame)
            if not running.is_set():
                running.set()
                os.kill(os.getpid(), signal.SIGINT)

    runs = run_batch([variant(duration=5e-2) for _ in range(6)], threads=2, observers=lambda index: (Trigger(),))
    assert {run.outcome for run in runs} == {Outcome.INTERRUPTED, None}
    assert sys.getswitchinterval() == before != module.SWITCH_INTERVAL
