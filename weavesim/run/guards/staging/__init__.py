"""Guards of stages: whether each comes to its end and all in it, what it trims, what its tools do to each other."""

from .crossing import ToolsCross
from .cut_short import CutShort
from .ends import StageEnds
from .trims import Trims

__all__ = ["CutShort", "StageEnds", "ToolsCross", "Trims"]
