"""Whole studies of functions through the machinery that runs jobs."""

import math

import pytest

from tests.support.studies import (
    Silence,
    bowl,
    conducted,
    ishigami,
    ishigami_indices,
    made,
    noisy,
    write_small_job,
)  # fmt: skip
from weavesim.errors import InputError
from weavesim.study.job_subject import JobSubject
from weavesim.study.read import read_study, study_of_options
from weavesim.study.schema import MeasureTable, NoiseTable, VaryTable
from weavesim.study.subject import FunctionSubject
from weavesim.study.table import RunTable

CUBE = {"x": (-math.pi, math.pi), "y": (-math.pi, math.pi), "z": (-math.pi, math.pi)}
LEAST = MeasureTable(name="depth", goal="least")


def test_sobol_indices_of_ishigami_lie_in_their_intervals(tmp_path):
    study = made(CUBE, ["f"], method="sobol", samples=1024)
    results = conducted(study, FunctionSubject(ishigami), tmp_path / "t.sqlite")
    first, total = ishigami_indices()
    effects = results.effects(results.measures[0])
    assert len(results.answers) == 1024 * 5
    for effect, one, all_ in zip(effects, first, total, strict=True):
        assert effect.low <= one <= effect.high and effect.total_low <= all_ <= effect.total_high
        assert abs(effect.value - one) < 0.05 and abs(effect.total - all_) < 0.05
        assert effect.high - effect.low < 0.2


def test_an_optimisation_finds_a_known_optimum_within_its_budget(tmp_path):
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, [LEAST], method="optimise", budget=80)
    results = conducted(study, FunctionSubject(bowl), tmp_path / "t.sqlite")
    assert len(results.points) == 80
    x, y = results.best.values
    # of a valley that is 150 deep at its corners
    assert results.best.worth.goals[0] < 1.3
    assert abs(x - 3.0) < 0.5 and abs(y - 7.0) < 0.5


def test_an_optimisation_keeps_limits(tmp_path):
    measures = [LEAST, MeasureTable(name="across", at_most=1.0)]
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, measures, method="optimise", budget=80)
    results = conducted(study, FunctionSubject(bowl), tmp_path / "t.sqlite")
    x, y = results.best.values
    # least where the limit ends: x = 5, and y in the middle of the valley there
    assert 5.0 <= x < 5.6 and abs(y - (7.0 - 0.375 * (x - 3.0))) < 1.0


def test_two_goals_have_a_front(tmp_path):
    measures = [LEAST, MeasureTable(name="across", goal="least")]
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, measures, method="optimise", budget=60)
    front = conducted(study, FunctionSubject(bowl), tmp_path / "t.sqlite").front
    assert len(front) > 3
    ordered = sorted(point.worth.goals for point in front)
    assert all(a[1] > b[1] for a, b in zip(ordered, ordered[1:], strict=False))


def test_a_robust_optimisation_keeps_away_from_an_edge(tmp_path):
    def run(**given):
        study = made({"x": (0.0, 10.0)}, [LEAST], method="optimise", budget=30, **given)
        return conducted(study, FunctionSubject(cliff), tmp_path / f"{len(given)}.sqlite").best

    plain = run(scatter=(VaryTable(key="shift", range=(-1.0e-6, 1.0e-6)),))
    robust = run(scatter=(VaryTable(key="shift", range=(-1.0, 1.0)),))
    assert plain.values[0] > 6.5 and robust.values[0] < 6.2


def cliff(x, shift):
    """Lower and lower, and then up at 7."""
    place = x + shift
    return {"depth": 10.0 - place if place < 7.0 else 20.0}


def test_noise_is_estimated_and_what_is_no_more_than_noise_is_said(tmp_path):
    noise = NoiseTable(repeats=8, points="all")
    study = made({"x": (0.0, 10.0)}, ["line", "chance", "constant"], counts={"x": 12}, noise=noise)
    results = conducted(study, FunctionSubject(noisy, repeats=True), tmp_path / "t.sqlite")
    line, chance, constant = (results.noise(measure) for measure in results.measures)
    assert line.low < 0.5 < line.high and line.degrees == 12 * 8
    assert constant.deviation == 0.0
    remarks = " ".join(results.remarks())
    assert "chance: its differences are no larger than its noise" in remarks
    assert "line: its differences" not in remarks


def test_a_parameter_that_changes_no_measure_is_said(tmp_path):
    study = made({"x": (0.0, 1.0), "y": (0.0, 1.0)}, ["f"], counts={"x": 3, "y": 3})
    results = conducted(study, FunctionSubject(idle), tmp_path / "t.sqlite")
    assert any(text.startswith("y does nothing: in 6 pairs") for text in results.remarks())


def idle(x, y):
    return {"f": 2.0 * x}


def test_a_study_goes_on_where_it_was_and_computes_nothing_twice(tmp_path):
    path, first, second = tmp_path / "t.sqlite", Silence(), Silence()
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, [LEAST], method="optimise", budget=24)

    class Stops(FunctionSubject):
        def case(self, factors, trial):
            if trial.point == 17:
                raise KeyboardInterrupt
            return super().case(factors, trial)

    with pytest.raises(KeyboardInterrupt):
        conducted(study, Stops(bowl), path, progress=first)
    resumed = conducted(study, FunctionSubject(bowl), path, progress=second)
    whole = conducted(study, FunctionSubject(bowl), tmp_path / "whole.sqlite")
    assert 0 < first.done < 24 and second.found == first.done
    assert [a.trial for a in resumed.answers] == [a.trial for a in whole.answers]
    assert [a.numbers for a in resumed.answers] == [a.numbers for a in whole.answers]
    with RunTable(path) as table:
        assert len({key for key, _, _ in table.attempts()}) == len(table.attempts()) == 24


def test_a_larger_study_uses_the_runs_of_a_smaller_one(tmp_path):
    path, progress = tmp_path / "t.sqlite", Silence()
    conducted(made({"x": (0.0, 1.0), "y": (0.0, 1.0)}, ["f"], counts={"x": 2, "y": 2}), FunctionSubject(idle), path)
    study = made({"x": (0.0, 1.0), "y": (0.0, 1.0)}, ["f"], counts={"x": 3, "y": 2})
    conducted(study, FunctionSubject(idle), path, progress=progress)
    assert (progress.found, progress.done, progress.total) == (4, 6, 6)


def test_a_run_that_cannot_be_costs_itself_alone(tmp_path):
    study = made({"x": (-1.0, 1.0)}, ["root"], counts={"x": 4})
    results = conducted(study, FunctionSubject(root), tmp_path / "t.sqlite")
    assert [answer.status for answer in results.answers] == ["refused", "refused", "finished", "finished"]
    assert any("2 of 4 runs were refused, the first one: no root" in text for text in results.remarks())


def root(x):
    if x < 0.0:
        raise InputError("no root")
    return {"root": math.sqrt(x)}


def test_a_measure_that_no_run_has_ends_the_study_after_the_first(tmp_path):
    progress = Silence()
    study = made({"x": (0.0, 1.0)}, ["roots"], counts={"x": 4})
    with pytest.raises(InputError, match="'roots': a run has no such number; did you mean 'root'"):
        conducted(study, FunctionSubject(root), tmp_path / "t.sqlite", progress=progress)
    assert progress.done == 1


@pytest.mark.parametrize(
    ("vary", "measure", "text"),
    [
        ("tools.ball.frction=0.1:0.3:3", "max_shear_p99", "--vary tools.ball.frction.*did you mean 'friction'"),
        ("tools.bal.friction=0.1:0.3:3", "max_shear_p99", "did you mean 'ball'"),
        ("tools.ball.friction=-0.1:0.3:3", "max_shear_p99", "--vary .*friction = -0.1: at least 0 is needed"),
        ("tools.ball.friction=0.1:0.3:3", "max_sheer_p99", "'max_sheer_p99'.*did you mean 'max_shear_p99'"),
    ],
)
def test_bad_studies_of_jobs_are_told_before_anything_runs(tmp_path, vary, measure, text):
    job, progress = write_small_job(tmp_path), Silence()
    with pytest.raises(InputError, match=text):
        conducted(study_of_options(job, [vary], [measure]), JobSubject(job), tmp_path / "t.sqlite", progress=progress)
    assert progress.done == 0


def test_a_key_that_changes_no_set_up_is_refused_before_anything_runs(tmp_path):
    job, progress = write_small_job(tmp_path), Silence()
    path = tmp_path / "study.toml"
    path.write_text(
        """job = "small.toml"
        [[vary]]
        key = "output.without"
        values = [["film"], ["pictures"]]
        [[measure]]
        name = "max_shear_p99"
        """
    )
    with pytest.raises(InputError, match="line 2, .*output.without: it does nothing: .*same to the bit"):
        conducted(read_study(path), JobSubject(job), tmp_path / "t.sqlite", progress=progress)
    assert progress.done == 0


def test_a_fault_of_a_later_parameter_is_not_that_of_the_first(tmp_path):
    job, path = write_small_job(tmp_path), tmp_path / "study.toml"
    path.write_text(
        """job = "small.toml"
[[vary]]
key = "spring.corner.stiffness"
range = ["0.5 N/mm", "2 N/mm"]
count = 2
[[vary]]
key = "tools.bal.friction"
values = [0.1, 0.2]
[[measure]]
name = "max_shear_p99"
"""
    )
    with pytest.raises(InputError, match="line 6, .*tools.bal.friction: no .* is named 'bal'"):
        conducted(read_study(path), JobSubject(job), tmp_path / "t.sqlite")


def test_a_refused_study_leaves_an_earlier_one_and_costs_no_run(tmp_path):
    class Known(FunctionSubject):
        def known_numbers(self, case):
            return {"root"}, True

    path, progress = tmp_path / "t.sqlite", Silence()
    conducted(made({"x": (0.0, 1.0)}, ["root"], counts={"x": 3}), Known(root), path)
    with RunTable(path) as table:
        before = list(table.rows())
    with pytest.raises(InputError, match="'roots': a run has no such number"):
        conducted(made({"x": (0.0, 2.0)}, ["roots"], counts={"x": 4}), Known(root), path, progress=progress)
    with RunTable(path) as table:
        assert list(table.rows()) == before and table.run_count() == 3
    assert progress.done == 0
