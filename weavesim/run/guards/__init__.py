"""Named guards of a run, and what they say: ``Guard``, ``Doubt``, ``Level``."""

from .guard import Doubt, Guard, Guards, Level, Start, known_guards, report_new, verdict_of

__all__ = ["Doubt", "Guard", "Guards", "Level", "Start", "known_guards", "report_new", "verdict_of"]
