"""The sheet before forming: mesh, yarn directions, symmetry, lay-ups of several."""

from .blank import Blank
from .sheet import Sheet
from .stack import LayUp, Ply
from .symmetry import Symmetry

__all__ = [
    "Blank",
    "LayUp",
    "Ply",
    "Sheet",
    "Symmetry",
]
