"""What a study found: its points with their measures, the noise, what matters, the best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..factors import Factor, Value
from ..measures import unit_of
from ..plans.optimise import VERDICTS, Worth, worth
from ..plans.trials import Answer
from ..schema import MeasureTable, StudyTable
from .noise import Noise, chance_of, noise_of
from .sensitivity import Effect, level_effects, rank_effects, sobol_effects, without_effect

# A measure whose differences chance alone explains this often says nothing.
LARGEST_CHANCE = 0.05


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a study.

    Attributes:
        number: from 0.
        values: of the controlled factors.
        answers: its runs: one, or one for each scenario.
        repeats: runs that differ from the first in nothing that is meant.
        worth: of the point.
    """

    number: int
    values: tuple[Value, ...]
    answers: tuple[Answer, ...]
    repeats: tuple[Answer, ...]
    worth: Worth

    @property
    def verdict(self) -> str:
        """The worst of its runs; how they ended, if one did not finish."""
        bad = [answer.status for answer in self.answers if answer.status != "finished"]
        known = [answer.verdict for answer in self.answers if answer.verdict in VERDICTS]
        return bad[0] if bad else max(known, key=VERDICTS.index, default="")

    def measure(self, key: str) -> float | None:
        """Of the point: the mean over its scenarios; None if a run does not have it."""
        found = [answer.number(key) for answer in self.answers]
        values = [value for value in found if value is not None]
        return float(np.mean(values)) if len(values) == len(found) and values else None

    def spread(self, key: str) -> float | None:
        """Standard deviation over its scenarios; None with one run."""
        values = [value for value in (answer.number(key) for answer in self.answers) if value is not None]
        return float(np.std(values, ddof=1)) if len(values) > 1 else None


@dataclass(frozen=True, eq=False)
class StudyResults:
    """What a study found.

    Attributes:
        table: of the study.
        factors: all of them.
        answers: of all runs, in order.
        names: key of each measure in the numbers, by its name.
        warnings: what its reader must know.
        seconds: of all runs, one after the other.
        run_count: different runs.
        reused: how many of them were known before.
    """

    table: StudyTable
    factors: tuple[Factor, ...]
    answers: tuple[Answer, ...]
    names: dict[str, str]
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0
    run_count: int = 0
    reused: int = 0
    _effects: dict[str, list[Effect]] = field(default_factory=dict)

    @property
    def controlled(self) -> tuple[Factor, ...]:
        """Factors that somebody chooses."""
        return tuple(factor for factor in self.factors if not factor.scattered)

    @property
    def measures(self) -> tuple[MeasureTable, ...]:
        """As the study names them."""
        return self.table.measure

    @property
    def goals(self) -> tuple[MeasureTable, ...]:
        """Measures with a goal."""
        return tuple(measure for measure in self.measures if measure.goal)

    def key(self, measure: MeasureTable) -> str:
        """Of a measure in the numbers; as it was named where no run has finished that tells more."""
        return self.names.get(measure.name, measure.name)

    def label(self, measure: MeasureTable) -> str:
        """Name of a measure with its unit."""
        unit = unit_of(self.key(measure))
        return f"{measure.name} [{unit}]" if unit else measure.name

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """In order."""
        count = len(self.controlled)
        grouped: dict[int, list[Answer]] = {}
        for answer in self.answers:
            grouped.setdefault(answer.trial.point, []).append(answer)
        found = []
        for number, answers in sorted(grouped.items()):
            own = tuple(answer for answer in answers if answer.trial.role != "noise")
            repeats = tuple(answer for answer in answers if answer.trial.role == "noise")
            found.append(Point(number, own[0].trial.values[:count], own, repeats, worth(own, self.table, self.names)))
        return tuple(found)

    @cached_property
    def good(self) -> tuple[Point, ...]:
        """Points with a result that keep all limits and have an acceptable verdict."""
        return tuple(point for point in self.points if point.worth.goals is not None and point.worth.violation <= 0.0)

    @cached_property
    def front(self) -> tuple[Point, ...]:
        """Good points of which no other is at least as good in all goals and better in one."""
        if not self.goals:
            return ()
        return tuple(point for point in self.good if not any(_dominates(other, point) for other in self.good))

    @cached_property
    def best(self) -> Point | None:
        """The best point; of several on the front, the one that is best by the first goal."""
        return min(self.front, key=lambda point: (point.worth.goals or (math.inf,))[0], default=None)

    def noise(self, measure: MeasureTable) -> Noise | None:
        """Numerical noise of a measure; None if it was not estimated."""
        key, groups = self.key(measure), []
        for point in self.points:
            if point.repeats:
                values = [answer.number(key) for answer in (point.answers[0], *point.repeats)]
                groups.append([value for value in values if value is not None])
        return noise_of(groups)

    def measured(self, measure: MeasureTable) -> tuple[list[Point], list[float]]:
        """Points that have a measure, and its values."""
        key = self.key(measure)
        found = [(point, value) for point in self.points if (value := point.measure(key)) is not None]
        return [point for point, _ in found], [value for _, value in found]

    def chance(self, measure: MeasureTable) -> float | None:
        """Probability that noise alone explains the differences of a measure; None without an estimate of noise."""
        noise = self.noise(measure)
        return None if noise is None else chance_of(self.measured(measure)[1], noise)

    def effects(self, measure: MeasureTable) -> list[Effect]:
        """What each factor does to a measure; nothing where runs are missing that it needs."""
        if measure.name not in self._effects:
            self._effects[measure.name] = self._effects_of(measure)
        return self._effects[measure.name]

    def _effects_of(self, measure: MeasureTable) -> list[Effect]:
        points, values = self.measured(measure)
        if len(points) < 3:
            return []
        places = [point.values for point in points]
        if self.table.method == "sobol":
            if len(points) < len(self.points):
                return []
            return sobol_effects(self.factors, values, self.table.samples or 0, self.table.seed)
        if self.table.method == "factorial" and len(self.controlled) > 1:
            return level_effects(self.controlled, places, values)
        return rank_effects(self.controlled, places, values)

    def remarks(self) -> Iterator[str]:
        """What a reader must know before trusting the rest."""
        yield from self.warnings
        for status, what in (
            ("failed", "stopped"), ("refused", "were refused"), ("lost", "were lost with their workers"),
        ):  # fmt: skip
            bad = [answer for answer in self.answers if answer.status == status]
            if bad:
                yield f"{len(bad)} of {len(self.answers)} runs {what}, the first one: {bad[0].error}"
        doubtful = [answer for answer in self.answers if answer.verdict == "do not use"]
        if doubtful:
            yield (
                f'{len(doubtful)} of {len(self.answers)} runs have the verdict "do not use": their numbers may be '
                "wrong; form one of them to see why"
            )
        complete = [
            (point, [point.measure(self.key(m)) for m in self.measures])
            for point in self.points
            if all(point.measure(self.key(m)) is not None for m in self.measures)
        ]
        idle = without_effect(
            self.controlled, [point.values for point, _ in complete],
            [tuple(value for value in values if value is not None) for _, values in complete],
        )  # fmt: skip
        for name, pairs in idle.items():
            where = "the pair" if pairs == 1 else f"{pairs} pairs"
            yield f"{name} does nothing: in {where} of runs that differ in it alone, every measure is the same"
        for measure in self.measures:
            chance, noise = self.chance(measure), self.noise(measure)
            if noise is None or chance is None or chance <= LARGEST_CHANCE:
                continue
            yield (
                f"{self.label(measure)}: its differences are no larger than its noise ({noise.deviation:.3g} for one "
                "run); they say nothing about the parameters"
            )
        if self.table.method == "sobol":
            missing = [m.name for m in self.measures if len(self.measured(m)[0]) < len(self.points)]
            if missing:
                yield f"no indices of {', '.join(missing)}: they need every run of the design"
        if self.goals and self.best is None:
            yield f"no point keeps all limits with a verdict of {self.table.accept!r} or better: there is no best one"

    def as_dict(self) -> dict[str, Any]:
        """For study.json."""
        measures = {}
        for measure in self.measures:
            noise = self.noise(measure)
            measures[measure.name] = {
                "key": self.key(measure),
                "goal": measure.goal,
                "noise": None if noise is None else {**vars(noise), "least_difference": noise.least_difference},
                "chance": self.chance(measure),
                "effects": [vars(effect) for effect in self.effects(measure)],
            }
        return {
            "name": self.table.name,
            "method": self.table.method,
            "run_count": self.run_count,
            "reused": self.reused,
            "seconds": self.seconds,
            "measures": measures,
            "best": None if self.best is None else self.point_dict(self.best),
            "front": [self.point_dict(point) for point in self.front],
            "remarks": list(self.remarks()),
        }

    def point_dict(self, point: Point) -> dict[str, Any]:
        """One point by names."""
        return {
            "point": point.number,
            "inputs": dict(zip((factor.name for factor in self.controlled), point.values, strict=True)),
            "verdict": point.verdict,
            "measures": {measure.name: point.measure(self.key(measure)) for measure in self.measures},
        }


def _dominates(one: Point, other: Point) -> bool:
    a, b = one.worth.goals or (), other.worth.goals or ()
    return all(x <= y for x, y in zip(a, b, strict=True)) and any(x < y for x, y in zip(a, b, strict=True))


def spread_points(points: Sequence[Point], count: int, best: Sequence[Point]) -> list[Point]:
    """Points that are repeated for the noise: the best first, the others evenly along the study's order."""
    usable = [point for point in points if all(answer.status == "finished" for answer in point.answers)]
    chosen = [point for point in best if point in usable][:count]
    rest = [point for point in usable if point not in chosen]
    wanted = min(count - len(chosen), len(rest))
    for k in range(wanted):
        chosen.append(rest[math.floor((k + 0.5) * len(rest) / wanted)])
    return chosen
