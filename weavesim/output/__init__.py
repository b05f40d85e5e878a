"""What a run leaves in its folder."""

from .files import write_summary
from .film import Film
from .folder import ResultFolder
from .report.page import Report, write_report
from .series import ParaViewSeries
from .tables import History, load_measured_angles, load_measured_outline

__all__ = [
    "Film",
    "History",
    "ParaViewSeries",
    "Report",
    "ResultFolder",
    "load_measured_angles",
    "load_measured_outline",
    "write_report",
    "write_summary",
]
