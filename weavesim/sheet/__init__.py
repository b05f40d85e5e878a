"""The sheet before it is formed: mesh, yarn directions, symmetry."""

from .blank import Blank

__all__ = [
    "Blank",
]
