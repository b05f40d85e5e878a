"""The report, one HTML page with everything in it."""

from __future__ import annotations

from contextlib import ExitStack

from ...run.frame import Frame, Outcome, RunInfo
from ..results import Results
from ..run_page.content import ConstantParts, begun_page, page_so_far
from ..run_page.progress import PROGRESS_NAME, PagePace, ProgressRecord
from ..run_page.recorder import FrameRecorder
from ..run_page.writing import load, numbers_of, write_page
from ..writer import Writer

PAGE_NAME = "report.html"


class ReportWriter(Writer):
    """``report.html``: one page with a view of all frames, charts, all numbers, pictures and warnings; during the run
    ``progress.json``, how far it is (``weavesim view --live``)."""

    name = "report"
    title = PAGE_NAME
    rank = 8
    packages = ("jinja2",)

    @classmethod
    def load(cls) -> None:
        """Import what renders pages, and prepare what all of them have."""
        load()

    def start(self, info: RunInfo) -> None:
        """Begin to keep frames."""
        self._info, self._recorder, self._pace = info, FrameRecorder(), PagePace()
        self._recorder.start(info)
        self._constant = ConstantParts(info)
        self._progress = ProgressRecord(self.folder, info)
        self.save(PROGRESS_NAME, self._progress.start)

    def frame(self, frame: Frame) -> None:
        """Keep a frame; from time to time write the page so far, which ``weavesim view --live`` shows."""
        self._recorder.frame(frame)
        self.save(PROGRESS_NAME, lambda: self._progress.frame(frame))
        if self._pace.due(self._progress.left):
            self._constant.prepare()
            self._pace.begin()
            self.save(self.title, self._write_so_far)
            self._pace.done()

    def _write_so_far(self) -> None:
        content = page_so_far(self._info, self.history, self._recorder, self.folder, self._constant)
        write_page(self.folder / PAGE_NAME, content)

    def finish(self, outcome: Outcome) -> None:
        """Say how the run ended."""
        self.save(PROGRESS_NAME, lambda: self._progress.finish(outcome))

    def begin(self, results: Results, meanwhile: ExitStack) -> None:
        """Make what needs no pictures, while a copy of this process draws them."""
        self._begun = begun_page(results, self._recorder, self.folder, self._constant)
        self._numbers = numbers_of(self._begun.content)

    def write(self, results: Results) -> None:
        """Write the page."""
        write_page(self.folder / PAGE_NAME, self._begun.finished(results), self._numbers)
