"""Runs of a study in one batch: the numbers of single runs, and what cannot run."""

from tests.support.studies import conducted, made, root_of, write_small_job
from weavesim.study.execution.together import TogetherExecutor
from weavesim.study.job_subject import JobSubject
from weavesim.study.read import study_of_options
from weavesim.study.subject import FunctionSubject


def test_a_batch_has_the_numbers_of_single_runs_and_tells_what_cannot_run(tmp_path):
    job = write_small_job(tmp_path)
    # the last one begins inside the ball
    study = study_of_options(job, ["ply.height=21.0 mm,20.6 mm,12 mm"], ["max_shear_p99"])
    together = conducted(study, JobSubject(job, threads=1), tmp_path / "b.sqlite", TogetherExecutor(2))
    single = conducted(study, JobSubject(job, threads=1), tmp_path / "s.sqlite")
    assert [a.status for a in together.answers] == ["finished", "finished", "refused"]
    assert [(a.status, a.verdict, a.numbers) for a in together.answers] == [
        (a.status, a.verdict, a.numbers) for a in single.answers
    ]
    assert together.answers[2].error == single.answers[2].error


def test_functions_are_called_one_after_the_other(tmp_path):
    study = made({"x": (1.0, 4.0)}, ["root"], counts={"x": 4})
    results = conducted(study, FunctionSubject(root_of), tmp_path / "t.sqlite", TogetherExecutor())
    assert [a.number("root") for a in results.answers] == [1.0, 2.0**0.5, 3.0**0.5, 2.0]
