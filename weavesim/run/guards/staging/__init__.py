"""Guards of stages: whether each comes to its end, what it trims, and what its tools do to each other."""

from .crossing import ToolsCross
from .ends import StageEnds
from .trims import Trims

__all__ = ["StageEnds", "ToolsCross", "Trims"]
