"""Guards of friction laws: what is asked of them beyond what they know."""

from .tools import ToolFriction

__all__ = ["ToolFriction"]
