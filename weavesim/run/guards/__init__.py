"""Named guards of a run, and what they say: ``Guard``, ``Doubt``, ``Level``."""

from .guard import Doubt, Guard, Guards, Level, Start, known_guards, verdict_of

__all__ = ["Doubt", "Guard", "Guards", "Level", "Start", "known_guards", "verdict_of"]
