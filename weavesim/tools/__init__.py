"""Rigid tools and their shapes."""

from .mesh_tool import MeshShape
from .segments.opening import DomeOpeningSector
from .shapes import Capsule, DomeCavity, DomeOpening, DomePunch, Plane, Shape, Sphere, Torus, Union, rotation_matrix
from .tool import Tool

__all__ = [
    "Capsule",
    "DomeCavity",
    "DomeOpening",
    "DomeOpeningSector",
    "DomePunch",
    "MeshShape",
    "Plane",
    "Shape",
    "Sphere",
    "Tool",
    "Torus",
    "Union",
    "rotation_matrix",
]
