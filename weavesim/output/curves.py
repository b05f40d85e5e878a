"""Curves of a test: a scene's own numbers for every frame, as a CSV and as charts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from ..run.frame import Frame, Outcome, RunInfo


@dataclass(frozen=True)
class MeasuredPoints:
    """A measured curve that is drawn beside computed ones.

    Attributes:
        label: in the legend.
        x_column, y_column: the computed columns that it belongs to.
        x, y: its points, in the order measured and in the units of these columns, (k,) each.
    """

    label: str
    x_column: str
    y_column: str
    x: np.ndarray
    y: np.ndarray


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
        measured: measured curves, drawn as points.
        equal_scales: whether both axes have one scale, as for the shape of a body.
        downwards: whether the ordinate grows downwards.
    """

    name: str
    title: str
    caption: str
    x: tuple[str, str]
    y_label: str
    computed: Mapping[str, str]
    expected: Mapping[str, str]
    measured: tuple[MeasuredPoints, ...] = ()
    equal_scales: bool = False
    downwards: bool = False


class Curves:
    """Observer that records the same numbers from every frame.

    Args:
        name: of the CSV, without extension.
        measure: returns the numbers of a frame by name; names are the CSV header, so they end in their unit.
        charts: to draw from them.
        measured: measured curves; each is added to the charts that show its columns.

    Attributes:
        failed: whether ``measure`` has raised something; then no more frames are recorded.

    Raises:
        InputError: a measured curve whose columns no chart shows together.
    """

    def __init__(
        self,
        name: str,
        measure: Callable[[Frame], Mapping[str, float]],
        charts: Sequence[Chart],
        measured: Sequence[MeasuredPoints] = (),
    ) -> None:
        self.name, self.measured = name, tuple(measured)
        self.charts = tuple(_with_measured(chart, self.measured) for chart in charts)
        drawn = {id(curve) for chart in self.charts for curve in chart.measured}
        for curve in self.measured:
            if id(curve) not in drawn:
                pairs = "; ".join(f"{', '.join(chart.computed)} over {chart.x[0]}" for chart in charts)
                raise InputError(f"{curve.label}: {curve.y_column} over {curve.x_column} is not drawn, but {pairs}")
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


class LastCurve(Curves):
    """Observer that keeps a whole curve of the last frame, such as the profile of a strip.

    Args:
        name, charts, measured: as of ``Curves``.
        measure: returns the columns of a frame by name, (k,) each.
    """

    def __init__(
        self,
        name: str,
        measure: Callable[[Frame], Mapping[str, np.ndarray]],
        charts: Sequence[Chart],
        measured: Sequence[MeasuredPoints] = (),
    ) -> None:
        super().__init__(name, lambda frame: {}, charts, measured)
        self._measure_all = measure
        self._last: dict[str, np.ndarray] = {}

    def start(self, info: RunInfo) -> None:
        super().start(info)
        self._last = {}

    def frame(self, frame: Frame) -> None:
        self._last = {name: np.asarray(values, dtype=float) for name, values in self._measure_all(frame).items()}

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Values by name, (k,) each."""
        return dict(self._last)


def _with_measured(chart: Chart, measured: Sequence[MeasuredPoints]) -> Chart:
    """The chart with those curves that belong to its columns."""
    shown = {*chart.computed, *chart.expected}
    own = tuple(curve for curve in measured if curve.x_column == chart.x[0] and curve.y_column in shown)
    return replace(chart, measured=(*chart.measured, *own)) if own else chart
