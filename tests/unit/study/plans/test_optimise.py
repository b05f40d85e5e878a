"""What a point is worth, and what an optimiser proposes."""

import pytest

from tests.support.studies import made
from weavesim.errors import InputError
from weavesim.study.plans.optimise import optimise, sampler_of, worth
from weavesim.study.plans.trials import Answer, Trial
from weavesim.study.schema import MeasureTable, VaryTable

NAMES = {"a": "a_mm", "b": "b"}


def answers(*values, verdict="trusted"):
    return [Answer(Trial((0.0,)), "k", verdict=verdict, numbers={"a_mm": value, "b": 1.0}) for value in values]


def table(measures=None, **given):
    measures = measures or [MeasureTable(name="a", goal="least")]
    return made({"x": (0.0, 1.0)}, measures, method="optimise", budget=10, **given).table


def test_worth_is_the_mean_and_the_risk():
    scattered = table(risk=2.0, scatter=(VaryTable(key="s", range=(0, 1)),))
    assert worth(answers(1.0, 3.0), scattered, NAMES).goals == (pytest.approx(2.0 + 2.0 * 2.0**0.5),)
    assert worth(answers(1.5), table(), NAMES).goals == (1.5,)
    most = table((MeasureTable(name="a", goal="most"),))
    assert worth(answers(1.5), most, NAMES).goals == (-1.5,)


def test_limits_and_verdicts_are_violations():
    limited = table((MeasureTable(name="a", goal="least", at_most=1.0), MeasureTable(name="b", at_least=2.0)))
    assert worth(answers(1.5), limited, NAMES).violation == pytest.approx(0.5)
    assert worth(answers(1.5, verdict="do not use"), table(), NAMES).violation == 1.0
    assert worth(answers(1.5, verdict="do not use"), table(accept="do not use"), NAMES).violation < 0.0
    assert worth(answers(1.5), table(), NAMES).violation < 0.0


def test_a_run_without_a_result_is_worth_nothing():
    lost = [*answers(1.0), Answer(Trial((0.0,)), "k", "failed")]
    assert worth(lost, table(), NAMES).goals is None


@pytest.mark.parametrize("optimiser", ["tpe", "cma-es"])
def test_questions_depend_on_the_answers_alone(optimiser):
    study = made({"x": (0.0, 1.0), "y": (0.0, 1.0)}, [MeasureTable(name="a", goal="least")],
                 method="optimise", budget=40, optimiser=optimiser)  # fmt: skip

    def asked():
        plan, found = optimise(study.factors, study.table, NAMES), []
        trials = next(plan)
        while trials is not None:
            found += trials
            told = [Answer(t, "k", numbers={"a_mm": (t.values[0] - 0.3) ** 2, "b": 1.0}) for t in trials]
            try:
                trials = plan.send(told)
            except StopIteration:
                trials = None
        return found

    first = asked()
    assert first == asked() and [trial.point for trial in first] == list(range(40))
    late = [abs(trial.values[0] - 0.3) for trial in first[30:]]
    assert sum(late) / len(late) < 0.2


def test_an_optimiser_that_is_not_installed_is_told(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install torch"):
        sampler_of(table(optimiser="gp"), 1)
