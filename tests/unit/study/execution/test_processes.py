"""Processes of this machine: they die, and their runs do not."""

import os
import signal

from tests.support.studies import Silence, conducted, made, slow, write_small_job
from weavesim.study.execution.processes import ProcessExecutor
from weavesim.study.job_subject import JobSubject
from weavesim.study.read import study_of_options
from weavesim.study.record import write_runs
from weavesim.study.subject import FunctionSubject, FunctionTask
from weavesim.study.table import RunTable


def deadly(x):
    """Kills its process at 3, every time."""
    if x == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": float(x)}


def broken(x):
    raise MemoryError("no room")


def test_a_task_that_kills_its_process_or_raises_costs_no_other():
    """And tasks are taken as there is room for them."""
    taken, found = [], []
    executor = ProcessExecutor(2, retries=1)

    def tasks():
        for x in range(6):
            taken.append(x)
            yield str(x), FunctionTask(broken if x == 5 else deadly, {"x": x})

    try:
        for result in executor.run(tasks()):
            found.append(result)
            assert len(taken) - sum(r.final for r in found) <= 2
    finally:
        executor.close()
    assert {r.key for r in found if r.found} == {"0", "1", "2", "4"}
    bad = {key: [r for r in found if r.key == key] for key in ("3", "5")}
    assert [r.final for r in bad["3"]] == [r.final for r in bad["5"]] == [False, True]
    assert "SIGKILL" in bad["3"][0].error and bad["5"][0].error == "MemoryError: no room"
    assert executor.process_ids == []


def test_a_killed_process_loses_nothing_and_the_table_is_that_of_a_serial_study(tmp_path):
    study, subject = made({"x": (1.0, 2.0)}, ["root"], counts={"x": 10}), FunctionSubject(slow)
    executor = ProcessExecutor(2)

    class Kills(Silence):
        def ended(self, status, seconds):
            super().ended(status, seconds)
            if self.done == 4:
                os.kill(executor.process_ids[0], signal.SIGKILL)

    progress = Kills()
    parallel = conducted(study, subject, tmp_path / "parallel.sqlite", executor, progress)
    serial = conducted(study, subject, tmp_path / "serial.sqlite")
    for name, results in (("parallel", parallel), ("serial", serial)):
        write_runs(tmp_path / f"{name}.csv", results)
    assert (tmp_path / "parallel.csv").read_bytes() == (tmp_path / "serial.csv").read_bytes()
    assert progress.done == progress.total == 10
    assert any("SIGKILL" in text for text in progress.texts)
    with RunTable(tmp_path / "parallel.sqlite") as table:
        assert table.run_count() == 10
        assert sum(outcome == "again" for _, _, outcome in table.attempts()) == 1


def test_runs_of_a_job_in_processes_have_the_bits_of_a_serial_study(tmp_path):
    job = write_small_job(tmp_path)
    study = study_of_options(job, ["spring.corner.stiffness=500:2000:3"], ["max_shear_p99", "step_count"])
    parallel = conducted(study, JobSubject(job, threads=1), tmp_path / "parallel.sqlite", ProcessExecutor(2))
    serial = conducted(study, JobSubject(job, threads=2), tmp_path / "serial.sqlite")
    assert [a.numbers for a in parallel.answers] == [a.numbers for a in serial.answers]
    assert len({a.numbers["max_shear_p99_deg"] for a in serial.answers}) == 3
