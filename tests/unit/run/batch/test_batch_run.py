"""What is left of a variant."""

import pickle

from tests.support.runs import small_run
from weavesim.run.batch.batch_run import BatchRun


def test_a_run_leaves_values_that_can_be_sent_elsewhere():
    simulation = small_run()
    simulation.run()
    run = pickle.loads(pickle.dumps(BatchRun.of(simulation.setup, simulation)))
    assert run.finished and run.verdict == simulation.verdict
    assert run.frame.position.tobytes() == simulation.frame.position.tobytes()
    assert run.summary["step_count"] == simulation.state.step_count


def test_a_run_that_never_started_is_not_trusted():
    run = BatchRun(small_run().setup, failure="no")
    assert not run.finished and run.verdict == "not run"
