"""Rigid tools and their shapes."""

from .mesh_tool import MeshShape
from .shapes import Capsule, DomeCavity, DomeOpening, DomePunch, Plane, Shape, Sphere, Torus, Union, rotation_matrix
from .tool import Tool

__all__ = [
    "Capsule",
    "DomeCavity",
    "DomeOpening",
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
