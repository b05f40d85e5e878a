"""All numbers of a run, as JSON."""

from __future__ import annotations

from ..files import write_summary
from ..results import Results
from ..writer import Writer


class SummaryWriter(Writer):
    """``summary.json``: all numbers of the run, and the warnings of the other writers."""

    name = "summary"
    title = "summary.json"
    rank = 9

    def write(self, results: Results) -> None:
        """Write the file."""
        write_summary(self.folder / "summary.json", results.whole_summary)
