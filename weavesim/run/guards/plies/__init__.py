"""Guards of the contact between plies."""

from .interfaces import Interfaces

__all__ = ["Interfaces"]
