"""Conduct a study: ask its plan what to run, look into the table, have the rest computed, and say what was found."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from typing import Protocol

from ..errors import InputError
from .analysis.results import StudyResults, spread_points
from .execution.executor import Executor
from .factors import Factor
from .measures import resolved
from .plans.designs import design, factorial, latin_hypercube, sobol_design
from .plans.optimise import optimise
from .plans.trials import Answer, Plan, Trial
from .read import Study
from .subject import Case, Subject, Task
from .table import RunTable

logger = logging.getLogger(__name__)

# Set-ups of so many runs are kept between the look at the table and the run; those of more are made again.
LARGEST_BATCH_IN_MEMORY = 64


class Progress(Protocol):
    """Is told how far a study is."""

    def planned(self, total: int, width: int) -> None:
        """How many runs there are in all, and how many are computed at a time."""
        ...

    def known(self, count: int) -> None:
        """So many more are in the table already."""
        ...

    def ended(self, status: str, seconds: float) -> None:
        """One more has ended."""
        ...

    def said(self, text: str) -> None:
        """Something that a user should know at once."""
        ...


class Conductor:
    """Conducts one study.

    Args:
        study: as read.
        subject: what it runs.
        table: of its runs.
        executor: computes them.
        progress: is told how far it is.
        fields: keep fields at material points.
    """

    def __init__(
        self, study: Study, subject: Subject, table: RunTable, executor: Executor, progress: Progress, *,
        fields: bool = False, rehearses: bool = True,
    ) -> None:  # fmt: skip
        self.study, self.subject, self.table = study, subject, table
        self._executor, self._progress, self._fields, self._rehearses = executor, progress, fields, rehearses
        self.names: dict[str, str] = {}
        self._accepted = False
        self._warnings: list[str] = []
        self._answers: list[Answer] = []
        self._seconds, self._reused, self._seen = 0.0, 0, set[str]()

    # ------------------------------------------------------------------------------------------------ before runs

    def check(self) -> Case:
        """Check all that can be known before the first run; returns the run in the middle of all ranges.

        Raises:
            InputError: a key that the job does not have, a value that it does not allow, a parameter that does nothing.
        """
        factors = self.study.factors
        middle = tuple(factor.base for factor in factors)
        base: Case | None = None
        for k, (factor, place) in enumerate(zip(factors, self.study.places, strict=True)):
            cases = []
            for end in factor.ends:
                values = (*middle[:k], end, *middle[k + 1 :])
                try:
                    cases.append(self.subject.case(factors, Trial(values)))
                except InputError as error:
                    self._check_alone()
                    raise InputError(f"{place}{_without_settings(str(error), factor)}") from None
            if len({case.key for case in cases}) == 1:
                raise InputError(
                    f"{place}it does nothing: from {factor.shown(factor.ends[0])} to "
                    f"{factor.shown(factor.ends[-1])} the set-up of the run is the same to the bit; leave it out, or "
                    "look for what makes it work"
                )
        base = self.subject.case(factors, Trial(middle))
        return base

    def _check_alone(self) -> None:
        """Name the parameter that the job does not have or allow whatever the others are, if there is one.

        Raises:
            InputError: see ``check``.
        """
        for factor, place in zip(self.study.factors, self.study.places, strict=True):
            for end in factor.ends:
                try:
                    self.subject.case((factor,), Trial((end,)))
                except InputError as error:
                    raise InputError(f"{place}{_without_settings(str(error), factor)}") from None

    def check_measures(self, base: Case) -> None:
        """Check the names of the measures against what a run will find, if that can be known.

        Raises:
            InputError: a measure that no run has.
        """
        known, complete = self.subject.known_numbers(base)
        self._resolve(known, final=complete)

    def _resolve(self, known: set[str], *, final: bool) -> None:
        for measure in self.study.table.measure:
            if measure.name in self.names:
                continue
            try:
                self.names[measure.name] = resolved(measure.name, known)
            except InputError as error:
                if final:
                    raise InputError(f"measure {error}") from None

    # ------------------------------------------------------------------------------------------------------- runs

    def accept(self) -> None:
        """Check all that can be known before the first run; then forget which runs were those of an earlier study.

        Raises:
            InputError: see ``check``; a measure that the runs do not have.
        """
        base = self.check()
        self._resolve(self.table.any_numbers(), final=False)
        if self._rehearses and len(self.names) < len({measure.name for measure in self.study.table.measure}):
            self.check_measures(base)
        self.table.clear_points()
        self._accepted = True

    def run(self) -> StudyResults:
        """Accept the study, if that is not done, and run what is not known yet.

        Raises:
            InputError: see ``accept``.
            RunError: a cluster is gone for good.
        """
        if not self._accepted:
            self.accept()
        plan = self._plan()
        trials = next(plan, None)
        assert trials is not None
        table = self.study.table
        self._progress.planned(self._total(len(trials)), self._executor.width)
        while trials is not None:
            answers = self._evaluate(trials)
            try:
                trials = plan.send(answers)
            except StopIteration:
                trials = None
        if table.noise is not None and not self.study.uncontrolled:
            results = self.results()
            repeats = table.noise.repeats
            count = len(results.points) if table.noise.points == "all" else table.noise.points
            chosen = spread_points(results.points, count, results.front[:1])
            self._evaluate(
                [
                    Trial(point.answers[0].trial.values, "noise", point.number, repeat)
                    for point in chosen
                    for repeat in range(1, repeats + 1)
                ]
            )
        return self.results()

    def results(self) -> StudyResults:
        """What is known so far."""
        return StudyResults(
            self.study.table, self.study.factors, tuple(self._answers), dict(self.names), tuple(self._warnings),
            self._seconds, len(self._seen), self._reused,
        )  # fmt: skip

    def _plan(self) -> Plan:
        table, factors = self.study.table, self.study.factors
        if table.method == "optimise":
            return optimise(factors, table, self.names)
        if table.method == "factorial":
            return design(factorial(factors))
        points = latin_hypercube if table.method == "latin-hypercube" else sobol_design
        return design(points(factors, table.samples or 0, table.seed))

    def _total(self, first: int) -> int:
        table = self.study.table
        points = table.budget or first
        total = points * (table.scenarios if self.study.uncontrolled else 1)
        if table.noise is not None and not self.study.uncontrolled:
            repeated = points if table.noise.points == "all" else min(table.noise.points, points)
            total += repeated * table.noise.repeats
        return total

    def _evaluate(self, trials: Sequence[Trial]) -> list[Answer]:
        """Answers to some trials, from the table or computed now."""
        factors = self.study.factors
        keys: list[str] = []
        refused: dict[int, str] = {}
        missing: dict[str, tuple[Trial, str]] = {}
        kept: dict[str, Task] = {}
        for place, trial in enumerate(trials):
            try:
                case = self.subject.case(factors, trial)
            except InputError as error:
                refused[place] = str(error)
                keys.append("")
                self._progress.ended("refused", 0.0)
                continue
            keys.append(case.key)
            if self.table.has(case.key, fields=self._fields) or case.key in missing:
                self._progress.known(1)
                self._reused += case.key not in missing and case.key not in self._seen
            else:
                missing[case.key] = trial, case.setup_hash
                if len(trials) <= LARGEST_BATCH_IN_MEMORY:
                    kept[case.key] = case.task
            self._seen.add(case.key)
        self.table.add_points(factors, zip(trials, keys, strict=True))
        self._compute(missing, kept, factors)
        answers = [
            Answer(trial, "", "refused", error=refused[place]) if place in refused else self.table.answer(trial, key)
            for place, (trial, key) in enumerate(zip(trials, keys, strict=True))
        ]
        for answer in answers:
            if answer.status == "finished":
                self._resolve(set(answer.numbers), final=True)
        self._answers += answers
        return answers

    def _compute(self, missing: dict[str, tuple[Trial, str]], kept: dict[str, Task], factors: Sequence[Factor]) -> None:
        def tasks() -> Iterator[tuple[str, Task]]:
            for key, (trial, _) in missing.items():
                yield key, kept.pop(key) if key in kept else self.subject.case(factors, trial).task

        results = self._executor.run(tasks()) if missing else iter(())
        for result in results:
            if result.found is None:
                self.table.attempt(result.key, result.worker, None, "lost" if result.final else "again")
                text = f"run {result.key[:12]}: {result.error}"
                logger.warning("%s", text)
                self._progress.said(f"{text}; {'it is given up' if result.final else 'it is tried again'}")
                if result.final:
                    self._progress.ended("lost", 0.0)
                continue
            warning = self.table.store(result.key, missing[result.key][1], result.found)
            if warning and warning not in self._warnings:
                self._warnings.append(warning)
                self._progress.said(warning)
            self._seconds += result.found.seconds
            self._progress.ended(result.found.status, result.found.seconds)
            if result.found.status == "finished":
                self._resolve(set(result.found.numbers), final=True)


def _without_settings(text: str, factor: Factor) -> str:
    """A message about a job without the settings that the study made for it."""
    for key in factor.keys:
        for end in factor.ends:
            text = text.replace(f"--set {key}={factor.text(end)}: ", "").replace(
                f"--set {key}={factor.text(end)}, ", ""
            )
    return text
