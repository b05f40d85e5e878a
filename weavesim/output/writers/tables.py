"""All tables, as CSV."""

from __future__ import annotations

from functools import partial

from ...run.frame import Frame, RunInfo
from ..curves import Curves
from ..pace import Pace
from ..results import Results
from ..tables import write_draw_in, write_shear_angles, write_sheets, write_table
from ..writer import Writer


class TablesWriter(Writer):
    """``history.csv``: scalars of every frame; ``draw_in.csv``, ``shear_angle.csv``; ``sheets.csv`` of several sheets;
    the curves of the scene.
    """

    name = "tables"
    title = "tables"
    rank = 1

    def start(self, info: RunInfo) -> None:
        """Prepare to save the scalars from time to time."""
        self._pace = Pace()

    def frame(self, frame: Frame) -> None:
        """Save the scalars of all frames so far, from time to time."""
        if self._pace.due():
            self.save("history.csv", lambda: self.history.write(self.folder / "history.csv"))
            self._pace.done()

    def write(self, results: Results) -> None:
        """Write all of them."""
        self.attempt("history.csv", lambda: results.history.write(self.folder / "history.csv"))
        for sheet in results.sheets if results.wanted.draw_in else ():
            name = sheet.file("draw_in.csv")
            self.attempt(name, partial(write_draw_in, self.folder / name, sheet.formed))
        for sheet in results.sheets if results.wanted.points is not None else ():
            name = sheet.file("shear_angle.csv")
            self.attempt(name, partial(write_shear_angles, self.folder / name, sheet.formed))
        if len(results.sheets) > 1:
            rows = {sheet.info.name: sheet.findings(lambda key, error: None) for sheet in results.sheets}
            self.attempt("sheets.csv", partial(write_sheets, self.folder / "sheets.csv", rows))
        for curves in results.wanted.all_curves:
            self._write_curves(curves)

    def _write_curves(self, curves: Curves) -> None:
        columns, path = curves.columns, self.folder / f"{curves.name}.csv"
        rows = zip(*(values.tolist() for values in columns.values()), strict=True)
        self.attempt(path.name, lambda: write_table(path, list(columns), rows))
