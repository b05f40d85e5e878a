"""Guards of stages: whether each comes to its end."""

from .ends import StageEnds

__all__ = ["StageEnds"]
