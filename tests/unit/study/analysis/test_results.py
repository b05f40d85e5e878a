"""Points, fronts and remarks from answers that a test chooses."""

import pytest

from tests.support.studies import made
from weavesim.study.analysis.results import StudyResults, spread_points
from weavesim.study.plans.trials import Answer, Trial
from weavesim.study.schema import MeasureTable

MEASURES = (MeasureTable(name="a", goal="least"), MeasureTable(name="b", goal="least"))


def results(values, verdicts=(), repeats=(), measures=MEASURES):
    study = made({"x": (0.0, 1.0)}, measures, counts={"x": max(len(values), 2)})
    answers = [
        Answer(Trial((float(k),), point=k), f"k{k}", verdict=verdicts[k] if verdicts else "trusted",
               numbers={"a_mm": a, "b": b})
        for k, (a, b) in enumerate(values)
    ]  # fmt: skip
    answers += [
        Answer(Trial((0.0,), "noise", 0, k + 1), f"r{k}", numbers={"a_mm": a, "b": 0.0}) for k, a in enumerate(repeats)
    ]
    return StudyResults(study.table, study.factors, tuple(answers), {"a": "a_mm", "b": "b"})


def test_the_front_has_what_nothing_beats():
    found = results([(1.0, 5.0), (2.0, 2.0), (3.0, 3.0), (5.0, 1.0)])
    assert [point.number for point in found.front] == [0, 1, 3]
    assert found.best.number == 0


def test_runs_that_must_not_be_used_are_never_best():
    found = results([(1.0, 1.0), (2.0, 2.0)], ["do not use", "doubtful"])
    assert found.best.number == 1
    assert any("1 of 2 runs have the verdict" in text for text in found.remarks())
    none = results([(1.0, 1.0)], ["do not use"])
    assert none.best is None and any("there is no best one" in text for text in none.remarks())


def test_noise_is_that_of_the_point_and_its_repeats():
    found = results([(1.0, 0.0), (9.0, 0.0)], repeats=(2.0, 3.0))
    assert found.noise(MEASURES[0]).deviation == pytest.approx(1.0)
    assert found.points[0].measure("a_mm") == 1.0  # repeats are no results
    assert found.chance(MEASURES[0]) < 0.05


def test_everything_is_in_the_dictionary():
    told = results([(1.0, 5.0), (2.0, 2.0), (3.0, 3.0)], repeats=(2.0, 3.0)).as_dict()
    assert told["best"]["inputs"] == {"x": 0.0} and len(told["front"]) == 2
    assert told["measures"]["a"]["noise"]["degrees"] == 2 and told["measures"]["a"]["effects"]


def test_points_for_the_noise_are_the_best_and_then_spread():
    found = results([(float(k), 0.0) for k in range(9)])
    assert [point.number for point in spread_points(found.points, 3, found.front)] == [0, 3, 7]
    assert len(spread_points(found.points, 99, ())) == 9
