"""The sheet before forming: mesh, yarn directions, symmetry."""

from .blank import Blank
from .sheet import Sheet
from .symmetry import Symmetry

__all__ = [
    "Blank",
    "Sheet",
    "Symmetry",
]
