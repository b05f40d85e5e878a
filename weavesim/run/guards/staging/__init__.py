"""Guards of stages: whether each comes to its end, and what it trims."""

from .ends import StageEnds
from .trims import Trims

__all__ = ["StageEnds", "Trims"]
