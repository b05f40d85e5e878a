"""Where the tools of a job stand when a stage begins, as far as the job alone decides it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...process.stages import AtStroke, Stage
from ...process.strokes import Fixed, Motion
from ...tools.tool import Tool


class Course(NamedTuple):
    """A motion under way.

    Attributes:
        motion: of a tool.
        begin: displacement from which it counts [m]; None if the run decides it.
        least, most: time since it began [s], at least and at most.
        there: displacement at which it ended a stage [m]; None if it ended none.
    """

    motion: Motion
    begin: float | None = 0.0
    least: float = 0.0
    most: float = 0.0
    there: float | None = None

    def at(self) -> float | None:
        """Displacement along the axis [m]; None if the run decides it."""
        if self.there is not None:
            return self.there
        if self.begin is None or self.motion.by_force or self.motion.is_carried:
            return None
        times, values = self.motion.curve()
        passed = np.interp([self.least, self.most], times, values)
        between = values[(times >= self.least) & (times <= self.most)]
        waits = self.motion.limiting_force > 0.0 and np.ptp([self.motion.displacement_at(0.0), *passed]) > 0.0
        if waits or np.ptp([*passed, *between]) > 0.0:
            return None
        return self.begin + float(passed[1])


class Places:
    """Displacements of the tools of a job along their axes, one stage after the other.

    Args:
        tools: by name.
    """

    def __init__(self, tools: Mapping[str, Tool]) -> None:
        self._courses = {name: Course(tool.motion) for name, tool in tools.items()}
        self._acted: set[str] = set()

    def at(self, name: str) -> float | None:
        """Displacement of a tool when the next stage begins [m]; None if the run decides it."""
        return self._courses[name].at()

    def go_through(self, stage: Stage, acting: frozenset[str]) -> None:
        """Let the next stage pass, in which the tools of these names act."""
        moved = {move.name: move.motion for move in stage.moves}
        for name, course in self._courses.items():
            if name in moved:
                course = Course(moved[name], course.at())
            if name not in acting:
                if name in self._acted:
                    course = Course(Fixed(), course.at())
                self._courses[name] = course
                continue
            begin, passed = course.at(), stage.duration
            there = None
            if isinstance(stage.end, AtStroke) and stage.end.tool == name and begin is not None:
                there = begin + stage.end.displacement
            least = course.least + (passed if stage.end is None else 0.0)
            self._courses[name] = course._replace(least=least, most=course.most + passed, there=there)
        self._acted |= acting
