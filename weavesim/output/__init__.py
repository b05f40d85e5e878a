"""Results of a run, written to its folder."""

from .files import write_summary
from .film.film import Film
from .folder import ResultFolder
from .history import History
from .measured import load_measured_angles, load_measured_curves, load_measured_outline
from .paraview.series import ParaViewSeries
from .report.page import Report, write_report
from .results import Results
from .writer import Writer, chosen_writers, known_writers

__all__ = [
    "Film",
    "History",
    "ParaViewSeries",
    "Report",
    "ResultFolder",
    "Results",
    "Writer",
    "chosen_writers",
    "known_writers",
    "load_measured_angles",
    "load_measured_curves",
    "load_measured_outline",
    "write_report",
    "write_summary",
]
