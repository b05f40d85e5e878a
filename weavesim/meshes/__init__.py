"""Mesh files: one reader per format, and every cell of a file accounted for."""

from .mesh_file import Cells, MeshFile
from .reading import READERS, read_mesh

__all__ = ["READERS", "Cells", "MeshFile", "read_mesh"]
