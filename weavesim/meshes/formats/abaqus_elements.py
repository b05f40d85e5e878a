"""What the element types of Abaqus and CalculiX are to a surface."""

from __future__ import annotations

import re

from ..mesh_file import QUAD, TRIANGLE

# Kinds of cells with their number of nodes, and the types that are so: shells, membranes, surfaces, rigid and plane
# elements. A suffix (reduced integration, temperature, ...) does not change the nodes.
_SURFACES = (
    (TRIANGLE, 3, r"R3D3|STRI3|S3\w*|M3D3|SFM3D3|DS3|CP[SE]3\w*|CPEG3\w*|DC2D3\w*|AC2D3\w*|F[23]D3|WARPF2D3|CAX3\w*"),
    (QUAD, 4, r"R3D4|S4\w*|M3D4R?|SFM3D4R?|DS4|CP[SE]4\w*|CPEG4\w*|DC2D4\w*|DCC2D4D?|AC2D4\w*|F3D4|WARPF2D4|CAX4\w*"),
    ("triangle6", 6, r"STRI65|S6|M3D6|SFM3D6|DS6|CP[SE]6\w*|CPEG6\w*|DC2D6\w*|AC2D6\w*"),
    ("quad8", 8, r"S8\w*|M3D8R?|SFM3D8R?|DS8|CP[SE]8\w*|CPEG8\w*|DC2D8\w*|AC2D8\w*"),
    ("quad9", 9, r"S9R5|M3D9R?"),
)
_LINES = (
    r"B[23][123]\w*|T[23]D[23]\w*|R2D2|RAX2|RB[23]D2|PIPE\w+|ELBOW\w+|CONN[23]D2|SPRING\w+|DASHPOT\w+|GAP\w+|ITS\w+|"
    r"ITT\w+|FRAME[23]D|DC1D\w+|DCC1D\w+|AC1D\w+|JOINT\w+|F2D2|D|U1|DRAG[23]D|TUBE\w+"
)
_POINTS = r"MASS|ROTARYI|HEATCAP|DCOUP[23]D|DMASSFAST"
_VOLUMES = (
    r"C3D\d+\w*|SC[68]\w*|CSS8|COH3D\w*|AC3D\w*|ACIN3D\w*|DC3D\w*|DCC3D\w*|EC3D\w*|CCL\w*|Q3D\w*|GK3D\w*|PC3D|PD3D|"
    r"EMC3D\w*|CIN3D\w*|F3D8"
)


# Sections of bodies of revolution; meshio writes all quadrilaterals as one of these.
AXISYMMETRIC = ("CAX",)


def kind_of(name: str) -> tuple[str, int] | None:
    """Kind of cell of an element type and its number of nodes, for types that bound or fill something.

    "line" and "point" are left out of a surface, "volume" cannot be one. None: a type that is not known.
    """
    for kind, count, pattern in _SURFACES:
        if re.fullmatch(pattern, name):
            return kind, count
    for kind, pattern in (("volume", _VOLUMES), ("line", _LINES), ("point", _POINTS)):
        if re.fullmatch(pattern, name):
            return kind, 0
    return None
