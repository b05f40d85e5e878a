"""Runs whose steps are done together get what each gets alone."""

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.unit.run.batch.test_batch import numbers, variant
from weavesim.errors import InputError
from weavesim.run.batch.batch import Runner, run_batch
from weavesim.run.batch.worlds import Worlds, host_setup
from weavesim.run.frame import Outcome
from weavesim.run.interruption import Interruption
from weavesim.run.simulation import Simulation

VARIANTS = [
    variant(speed, friction, lane_count=1, duration=duration)
    for speed, friction, duration in ((0.5, 0.0, 1e-3), (1.0, 0.3, 1e-3), (2.0, 0.1, 5e-4))
]


def together(setups, **given):
    """Runs of ``setups``, stepped together on this machine's CPU."""
    return Runner(setups, **given).run_together("cpu", range(len(setups)), Interruption())


def test_runs_get_the_numbers_of_single_runs():
    seen = {index: Frames() for index in range(len(VARIANTS))}
    runs = together(VARIANTS, observers=lambda index: (seen[index],))
    for index, setup in enumerate(VARIANTS):
        single = Simulation(setup)
        single.run()
        assert runs[index].finished and runs[index].setup is setup
        assert numbers(runs[index].summary) == numbers(single.summary())
        assert runs[index].history == tuple(single.history)
        assert runs[index].frame.position.tobytes() == single.frame.position.tobytes()
        assert seen[index].outcome is Outcome.FINISHED and len(seen[index].all) == setup.frame_count + 1


def test_fewer_looks_change_no_state():
    few, many = (together(VARIANTS, watch_count=count) for count in (2, 100))
    for index in range(len(VARIANTS)):
        assert few[index].frame.position.tobytes() == many[index].frame.position.tobytes()
        names = [name for name in many[index].summary if "of_run" in name or name.startswith("peak_tool")]
        assert len(names) >= 4
        assert [few[index].summary[name] for name in names] == [many[index].summary[name] for name in names]
    with pytest.raises(InputError, match="watch_count = 0: 1 to"):
        run_batch(VARIANTS, watch_count=0)


def test_those_that_are_not_alike_are_stepped_in_groups():
    other = variant(size=0.004, lane_count=1)
    runs = together([VARIANTS[0], other, VARIANTS[1], variant(height=-0.02)])
    single = Simulation(other)
    single.run()
    assert [runs[index].finished for index in range(4)] == [True, True, True, False]
    assert runs[1].frame.position.tobytes() == single.frame.position.tobytes()
    assert "overlaps the blank" in runs[3].failure


def test_what_differs_is_said():
    simulations = [Simulation(host_setup(setup)) for setup in (VARIANTS[0], variant(size=0.004))]
    with pytest.raises(InputError, match=r"patch and patch cannot share launches: their number of nodes differs \("):
        Worlds("cpu", simulations)


def test_a_signal_stops_all():
    interrupted = Interruption()

    class Trigger(Frames):
        def frame(self, frame):
            super().frame(frame)
            if frame.index == 1:
                interrupted.signal = 2

    seen = [Trigger() for _ in VARIANTS]
    runs = Runner(VARIANTS, observers=lambda index: (seen[index],)).run_together("cpu", range(3), interrupted)
    assert {run.outcome for run in runs.values()} == {Outcome.INTERRUPTED}
    assert all(each.outcome is Outcome.INTERRUPTED for each in seen)
    assert all(np.isfinite(run.frame.position).all() for run in runs.values())
    before = Runner(VARIANTS).run_together("cpu", range(3), interrupted)
    assert [run.outcome for run in before.values()] == [None] * 3


@pytest.mark.gpu
def test_a_batch_on_a_gpu_is_near_that_on_the_host():
    seen = {index: Frames() for index in range(len(VARIANTS))}
    runs = run_batch(VARIANTS, device="cuda:0", observers=lambda index: (seen[index],))
    for index, (run, host) in enumerate(zip(runs, run_batch(VARIANTS), strict=True)):
        assert run.finished and run.summary["device"] == "cuda:0"
        assert len(seen[index].all) == VARIANTS[index].frame_count + 1
        np.testing.assert_allclose(run.frame.position, host.frame.position, atol=2e-5)
