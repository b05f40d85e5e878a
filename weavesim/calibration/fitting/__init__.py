"""Bounded least squares with intervals, and what data cannot tell apart; knows nothing of fabrics."""

from .fit import Fit, Problem, Unknown, solve
from .reduction import Direction, Reduced, fit_reduced

__all__ = ["Direction", "Fit", "Problem", "Reduced", "Unknown", "fit_reduced", "solve"]
