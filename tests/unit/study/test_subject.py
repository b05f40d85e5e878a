"""Functions as subjects, and what becomes of a run that cannot be."""

import logging

import pytest

from tests.support.studies import bowl
from weavesim.errors import InputError, RunError
from weavesim.study.factors import Factor
from weavesim.study.plans.trials import Trial
from weavesim.study.subject import FunctionSubject, FunctionTask, compute, digest

FACTORS = (Factor("x", ("x",)), Factor("y", ("y",)))


def test_the_key_of_a_call_is_that_of_its_values():
    subject = FunctionSubject(bowl)
    one, same, other = (subject.case(FACTORS, Trial(v, point=p)) for v, p in (((1, 2), 0), ((1, 2), 5), ((2, 1), 0)))
    assert one.key == same.key != other.key
    assert compute(one.task).numbers["depth"] == bowl(1, 2)["depth"]


def test_repeats_of_a_function_that_has_none_are_the_same_run():
    plain, repeated = FunctionSubject(bowl), FunctionSubject(bowl, repeats=True)
    assert len({plain.case(FACTORS, Trial((1, 2), repeat=k)).key for k in range(3)}) == 1
    assert len({repeated.case(FACTORS, Trial((1, 2), repeat=k)).key for k in range(3)}) == 3


def raising(kind):
    logging.getLogger("weavesim.study").warning("a run says this")
    raise {"input": InputError, "run": RunError, "other": OSError}[kind](kind)


@pytest.mark.parametrize(("kind", "status"), [("input", "refused"), ("run", "failed")])
def test_what_would_happen_again_is_a_result(kind, status, caplog):
    found = compute(FunctionTask(raising, {"kind": kind}))
    assert (found.status, found.error) == (status, kind) and found.worker
    assert not caplog.records


def test_what_may_go_well_another_time_is_raised():
    with pytest.raises(OSError, match="other"):
        compute(FunctionTask(raising, {"kind": "other"}))


def test_a_digest_is_that_of_all_parts():
    assert digest("a", {"b": 1.0, "c": 2}) == digest("a", {"c": 2, "b": 1.0}) != digest("a", {"b": 1.0})
