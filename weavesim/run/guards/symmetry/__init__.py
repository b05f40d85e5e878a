"""Guards of planes of symmetry: whether the tools are their own mirror images there."""

from .tools import ToolSymmetry

__all__ = ["ToolSymmetry"]
