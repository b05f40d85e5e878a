"""Curves of a test: a scene's own numbers for every frame, as a CSV and as charts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..run.frame import Frame, Outcome, RunInfo


@dataclass(frozen=True)
class Chart:
    """One chart of columns over a column.

    Attributes:
        name: of the picture, without extension.
        title, caption: in the picture, and below it in the report.
        x: column along the abscissa, with its label.
        y_label: of the ordinate.
        computed: columns drawn as lines, with their labels.
        expected: columns drawn dashed, with their labels.
    """

    name: str
    title: str
    caption: str
    x: tuple[str, str]
    y_label: str
    computed: Mapping[str, str]
    expected: Mapping[str, str]


class Curves:
    """Observer that records the same numbers from every frame.

    Args:
        name: of the CSV, without extension.
        measure: returns the numbers of a frame by name; names are the CSV header, so they end in their unit.
        charts: to draw from them.

    Attributes:
        failed: whether ``measure`` has raised something; then no more frames are recorded.
    """

    def __init__(self, name: str, measure: Callable[[Frame], Mapping[str, float]], charts: Sequence[Chart]) -> None:
        self.name, self.charts = name, tuple(charts)
        self.failed = False
        self._measure = measure
        self._rows: list[dict[str, float]] = []

    def start(self, info: RunInfo) -> None:
        self._rows.clear()
        self.failed = False

    def frame(self, frame: Frame) -> None:
        self._rows.append({name: float(value) for name, value in self._measure(frame).items()})

    def finish(self, outcome: Outcome) -> None:
        """Nothing to close; the result folder writes the files."""

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Values by name, (frame_count,) each."""
        names = self._rows[0] if self._rows else {}
        return {name: np.array([row[name] for row in self._rows]) for name in names}
