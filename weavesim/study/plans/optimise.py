"""Optimisation by Optuna: it proposes points, the study computes them, and it is told what they are worth.

Points are proposed in batches of a fixed size, whatever the number of workers, from a fixed seed. A study that goes on
repeats its questions from the first one, finds the answers in its table, and arrives where it was: nothing else has to
be kept.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import InputError
from ..factors import Factor, Value
from ..schema import StudyTable
from .designs import scenarios
from .trials import Answer, Plan, Trial

# Verdicts from good to bad.
VERDICTS = ("trusted", "doubtful", "do not use")
# Random points before the first proposal, per factor, and of all points at most.
STARTS_PER_FACTOR, LARGEST_START_SHARE = 5, 0.4


@dataclass(frozen=True)
class Worth:
    """What a point is worth.

    Attributes:
        goals: what is to be small, one for each measure with a goal; None if a run of it has no result.
        violation: by how much limits are broken, relative to them; at most 0 if none is.
    """

    goals: tuple[float, ...] | None
    violation: float


def worth(answers: Sequence[Answer], table: StudyTable, names: dict[str, str]) -> Worth:
    """Worth of one point.

    Args:
        answers: its runs: one, or one for each scenario.
        table: of the study.
        names: key of each measure in the numbers, by its name in the study.
    """
    violation, goals = -1.0, []
    accepted = VERDICTS.index(table.accept)
    for answer in answers:
        if answer.verdict in VERDICTS and VERDICTS.index(answer.verdict) > accepted:
            violation = max(violation, 1.0)
    for measure in table.measure:
        found = [answer.number(names.get(measure.name, measure.name)) for answer in answers]
        values = np.array([value for value in found if value is not None and math.isfinite(value)])
        if len(values) < len(answers) or not len(values):
            return Worth(None, 1.0)
        sign = -1.0 if measure.goal == "most" else 1.0
        spread = float(values.std(ddof=1)) if len(values) > 1 else 0.0
        if measure.goal:
            goals.append(sign * float(values.mean()) + table.risk * spread)
        for limit, side in ((measure.at_most, 1.0), (measure.at_least, -1.0)):
            if limit is not None:
                bad = side * (float(values.mean()) - limit) + table.risk * spread
                violation = max(violation, bad / max(abs(limit), 1.0e-12))
    return Worth(tuple(goals), violation)


def sampler_of(table: StudyTable, factor_count: int) -> Any:
    """The optimiser.

    Raises:
        InputError: what it needs is not installed.
    """
    import optuna

    starts = max(2, min(STARTS_PER_FACTOR * factor_count, int(LARGEST_START_SHARE * (table.budget or 0))))
    common: dict[str, Any] = {"seed": table.seed, "n_startup_trials": starts}

    def limits(trial: Any) -> tuple[float]:
        return (trial.user_attrs.get("violation", 1.0),)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        if table.optimiser == "cma-es":
            _needed("cmaes", "cmaes")
            return optuna.samplers.CmaEsSampler(**common)
        if table.optimiser == "gp":
            _needed("torch", "torch")
            return optuna.samplers.GPSampler(**common, deterministic_objective=False, constraints_func=limits)
        return optuna.samplers.TPESampler(
            **common, multivariate=True, group=True, constant_liar=True, constraints_func=limits
        )


def _needed(module: str, package: str) -> None:
    from importlib.util import find_spec

    if find_spec(module) is None:
        raise InputError(f"optimiser: it needs the package {package}: pip install {package}")


def optimise(factors: Sequence[Factor], table: StudyTable, names: dict[str, str]) -> Plan:
    """A plan that looks for the best point within the budget.

    Args:
        factors: of the study; with uncontrolled ones, every point is run in so many scenarios.
        table: of the study.
        names: see ``worth``.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    controlled = [factor for factor in factors if not factor.scattered]
    others = scenarios([factor for factor in factors if factor.scattered], table.scenarios, table.seed)
    space = {factor.name: _distribution(factor) for factor in controlled}
    goal_count = sum(1 for measure in table.measure if measure.goal)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        study = optuna.create_study(sampler=sampler_of(table, len(controlled)), directions=["minimize"] * goal_count)
        done = 0
        while done < (table.budget or 0):
            asked = [study.ask(space) for _ in range(min(table.batch, (table.budget or 0) - done))]
            trials: list[Trial] = []
            for offset, trial in enumerate(asked):
                own = tuple(_value(factor, trial.params[factor.name]) for factor in controlled)
                role = "scenario" if others else "design"
                trials += [Trial((*own, *other), role, done + offset) for other in others or [()]]
            answers = yield trials
            for offset, trial in enumerate(asked):
                found = worth([a for a in answers if a.trial.point == done + offset], table, names)
                trial.set_user_attr("violation", found.violation)
                if found.goals is None:
                    study.tell(trial, state=optuna.trial.TrialState.FAIL)
                else:
                    # an optimiser without limits of its own must not be drawn to what breaks them
                    penalty = max(found.violation, 0.0) if table.optimiser == "cma-es" else 0.0
                    study.tell(trial, [goal + penalty * max(abs(goal), 1.0) for goal in found.goals])
            done += len(asked)


def _distribution(factor: Factor) -> Any:
    import optuna

    if factor.choices and not factor.is_numeric:
        return optuna.distributions.CategoricalDistribution(range(len(factor.choices)))
    if factor.level_count is not None:
        return optuna.distributions.IntDistribution(0, factor.level_count - 1)
    return optuna.distributions.FloatDistribution(0.0, 1.0)


def _value(factor: Factor, proposed: Any) -> Value:
    if factor.choices:
        return factor.choices[proposed]
    count = factor.level_count
    return factor.at(float(proposed) if count is None else (proposed + 0.5) / count)
