"""Studies for tests: functions in place of jobs, and a small job."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from weavesim.study.analysis.results import StudyResults
from weavesim.study.conduct import Conductor
from weavesim.study.execution.executor import Executor, HereExecutor
from weavesim.study.factors import factor_of
from weavesim.study.read import Study
from weavesim.study.schema import MeasureTable, StudyTable, VaryTable
from weavesim.study.subject import Subject
from weavesim.study.table import RunTable

SMALL = """\
name = "small"

[[ply]]
fabric = "glass-polypropylene"
rectangle = ["60 mm", "60 mm"]
mesh_size = "10 mm"
height = "20.6 mm"

[[tool]]
name = "ball"
shape = {kind = "Sphere", radius = "20 mm"}
faces = "up"
stroke = "4 mm"
speed = "1 m/s"

[[spring]]
name = "corner"
corners = true
stiffness = "1 N/mm"
pretension = "2 N"
"""


def write_small_job(folder: Path, text: str = SMALL) -> Path:
    """A sheet of 36 elements on a ball, held by springs; returns the path of the job."""
    path = folder / "small.toml"
    path.write_text(text, encoding="utf-8")
    return path


def ishigami(x: float, y: float, z: float) -> dict[str, float]:
    """sin x + 7 sin^2 y + 0.1 z^4 sin x; Ishigami and Homma 1990. All within -pi and pi."""
    return {"f": math.sin(x) + 7.0 * math.sin(y) ** 2 + 0.1 * z**4 * math.sin(x)}


def ishigami_indices() -> tuple[list[float], list[float]]:
    """First and total indices of it, in closed form."""
    a, b = 7.0, 0.1
    first = [0.5 * (1.0 + 0.2 * b * math.pi**4) ** 2, a**2 / 8.0, 0.0]
    joint = b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = sum(first) + joint
    return [v / whole for v in first], [(first[0] + joint) / whole, first[1] / whole, joint / whole]


def bowl(x: float, y: float) -> dict[str, float]:
    """A valley that is turned against its axes: least at (3, 7), where it is 1."""
    u, v = x - 3.0, y - 7.0
    return {"depth": 1.0 + u * u + 2.0 * v * v + 1.5 * u * v, "across": abs(x - 6.0)}


def noisy(x: float, repeat: int = 0) -> dict[str, float]:
    """A line with a scatter of 0.5 that is the same in every process, and a number that says nothing but scatter."""
    scatter = math.sin(12.9898 * x + 78.233 * repeat) * 43758.5453 % 1.0 - 0.5
    deviation = 0.5 * math.sqrt(12.0)
    return {"line": 2.0 * x + deviation * scatter, "chance": deviation * scatter, "constant": 1.0}


def root_of(x: float) -> dict[str, float]:
    """A number with all digits."""
    return {"root": math.sqrt(x)}


def slow(x: float) -> dict[str, float]:
    """A number with all digits, after a fifth of a second."""
    time.sleep(0.2)
    return {"root": math.sqrt(x) / 3.0}


def made(subject_keys: dict[str, tuple[float, float]], measures: Iterable[Any], **given: Any) -> Study:
    """A study of a function: ranges by name, names of measures or ``MeasureTable``, and fields of ``StudyTable``."""
    counts = given.pop("counts", {})
    vary = tuple(
        VaryTable(key=name, range=ends, **({"count": counts[name]} if name in counts else {}))
        for name, ends in subject_keys.items()
    )
    tables = tuple(m if isinstance(m, MeasureTable) else MeasureTable(name=m) for m in measures)
    scattered = given.get("scatter", ())
    table = StudyTable(job="function", vary=vary, measure=tables, **given)
    factors = [factor_of(each) for each in vary] + [factor_of(each, scattered=True) for each in scattered]
    return Study(table, tuple(factors), Path("function"), tuple(f"{factor.name}: " for factor in factors))


class Silence:
    """Progress that only counts."""

    def __init__(self) -> None:
        self.total = self.done = self.found = 0
        self.texts: list[str] = []

    def planned(self, total: int, width: int) -> None:
        self.total = total

    def known(self, count: int) -> None:
        self.done += count
        self.found += count

    def ended(self, status: str, seconds: float) -> None:
        self.done += 1

    def said(self, text: str) -> None:
        self.texts.append(text)


def conducted(
    study: Study, subject: Subject, path: Path, executor: Executor | None = None, progress: Silence | None = None
) -> StudyResults:
    """The results of a study, with its table at ``path``."""
    executor = executor or HereExecutor()
    with RunTable(path) as table:
        try:
            return Conductor(study, subject, table, executor, progress or Silence()).run()
        finally:
            executor.close()
