"""Studies on a scheduler with worker processes, of which one is killed, and the scheduler restarted."""

import threading

import pytest

from tests.support.clusters import Cluster, free_port
from tests.support.processes import ENOUGH, wait_for
from tests.support.studies import Silence, conducted, made, slow, write_small_job
from weavesim.errors import InputError
from weavesim.study.execution.cluster import ClusterExecutor
from weavesim.study.job_subject import JobSubject
from weavesim.study.read import study_of_options
from weavesim.study.record import write_runs
from weavesim.study.subject import FunctionSubject
from weavesim.study.table import RunTable

pytest.importorskip("distributed", reason="Dask runs studies on clusters: pip install 'weavesim[cluster]'")


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    """A scheduler starts within this, on whatever machine."""
    monkeypatch.setattr("weavesim.study.execution.cluster.FIRST_WAIT", ENOUGH)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Two workers; whatever a test does to them, as many are there for the next."""
    with Cluster(tmp_path_factory.mktemp("cluster"), 2) as started:
        yield started


def disturbed(cluster, study, subject, folder, *, kill_at, restart_at):
    """The results of a study on a cluster that is disturbed after so many runs; the texts that were said."""
    progress, disturbances = Silence(), []

    def disturb():
        wait_for(lambda: progress.done >= kill_at)
        cluster.kill(cluster.workers[1])
        disturbances.append(progress.done)
        wait_for(lambda: progress.done >= restart_at)
        disturbances.append(progress.done)
        cluster.restart()

    thread = threading.Thread(target=disturb)
    thread.start()
    results = conducted(study, subject, folder / "cluster.sqlite", ClusterExecutor(cluster.address), progress)
    thread.join()
    assert len(disturbances) == 2 and max(disturbances) < progress.total  # before the end
    return results, progress


def check_same(folder, study, subject, results, progress, count):
    """The same table as that of a serial study, and no run lost or counted twice."""
    serial = conducted(study, subject, folder / "serial.sqlite")
    for name, found in (("cluster", results), ("serial", serial)):
        write_runs(folder / f"{name}.csv", found)
    assert (folder / "cluster.csv").read_bytes() == (folder / "serial.csv").read_bytes()
    assert progress.done == progress.total == count
    with RunTable(folder / "cluster.sqlite") as one, RunTable(folder / "serial.sqlite") as other:
        assert list(one.rows()) == list(other.rows())
        assert one.run_count() == other.run_count() == count
        finished = [key for key, _, outcome in one.attempts() if outcome == "finished"]
        assert len(finished) == len(set(finished)) == count


@pytest.mark.slow
def test_a_killed_worker_and_a_restarted_scheduler_change_nothing(cluster, tmp_path):
    study, subject = made({"x": (1.0, 2.0)}, ["root"], counts={"x": 24}), FunctionSubject(slow)
    results, progress = disturbed(cluster, study, subject, tmp_path, kill_at=4, restart_at=10)
    check_same(tmp_path, study, subject, results, progress, 24)


def test_no_scheduler_is_told(monkeypatch):
    monkeypatch.setattr("weavesim.study.execution.cluster.FIRST_WAIT", 0.5)
    with pytest.raises(InputError, match="no scheduler answers"):
        ClusterExecutor(f"tcp://127.0.0.1:{free_port()}")


@pytest.mark.slow
def test_a_job_has_the_same_table_on_a_cluster(cluster, tmp_path):
    job, progress = write_small_job(tmp_path), Silence()
    study = study_of_options(job, ["spring.corner.stiffness=500:2000:3"], ["max_shear_p99", "step_count"])
    subject = JobSubject(job, threads=1)
    results = conducted(study, subject, tmp_path / "cluster.sqlite", ClusterExecutor(cluster.address), progress)
    check_same(tmp_path, study, subject, results, progress, 3)
