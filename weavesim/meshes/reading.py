"""Read a mesh file by the reader of its format."""

from __future__ import annotations

import os

import numpy as np

from .cad import SUFFIXES, read_cad
from .formats.abaqus import read_abaqus
from .formats.by_meshio import FORMATS, read_by_meshio
from .formats.glb import read_glb
from .formats.nastran import read_nastran
from .formats.obj import read_obj
from .formats.off import read_off
from .formats.ply import read_ply
from .formats.stl import read_stl
from .formats.threemf import read_threemf
from .kinds import looks_like
from .mesh_file import MeshFile
from .source import opened

READERS = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".ply": read_ply,
    ".off": read_off,
    ".inp": read_abaqus,
    **dict.fromkeys((".bdf", ".nas", ".fem"), read_nastran),
    ".3mf": read_threemf,
    ".glb": read_glb,
    **dict.fromkeys(FORMATS, read_by_meshio),
    **dict.fromkeys(SUFFIXES, read_cad),
}

# No unit makes a tool of this; beyond it, areas and volumes overflow at last.
FARTHEST = 1e15


def read_mesh(path: str | os.PathLike[str], what: str = "mesh") -> MeshFile:
    """All surface cells of a mesh file, in its own unit.

    Args:
        path: of the file; its ending, in any case, names the format.
        what: name of such a file in messages, such as "tool mesh".

    Raises:
        InputError: a file that is missing, too large, damaged, of an unknown format, or holds something that cannot be
            taken: curved surfaces, volumes, references to other files.
    """
    source = opened(path, what, (".stl", ".ply", ".glb"))
    reader = READERS.get(source.suffix)
    if reader is None:
        kind = looks_like(source.data)
        known = ", ".join(READERS)
        ending = f"its name ends in {source.suffix!r}" if source.suffix else "its name has no ending"
        raise source.error(
            f"{ending}, which is no format that is known" + (f"; it looks like {kind}" if kind else ""),
            f"convert it to one of {known}",
        )
    try:
        mesh = reader(source)
    except MemoryError:
        raise source.error("there is not enough memory for it", "export a coarser mesh") from None
    far = np.any(np.abs(mesh.vertices) > FARTHEST, axis=1)
    if np.any(far):
        raise source.error(f"{int(far.sum())} vertices lie farther than {FARTHEST:g} from the origin, in any unit")
    return mesh
