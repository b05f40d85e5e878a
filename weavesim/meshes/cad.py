"""Surfaces of STEP and IGES files, as triangles, by Open CASCADE (package cadquery-ocp-novtk).

The kernel reads in millimetres whatever the file's unit is, and triangulates each face within ``DEFLECTION`` of its
size. Curves, points and sketches bound no surface and are left out.
"""

from __future__ import annotations

import io
import math
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from .cad_process import NO_FACES, NO_LIBRARY, NO_MEMORY, NO_SHAPES
from .mesh_file import MeshFile, cells_of, check_finite, check_references
from .source import Source

SUFFIXES = (".step", ".stp", ".iges", ".igs")
# Distance of the triangles from the surface, over the size of the body, and largest angle between them [rad].
DEFLECTION, ANGLE = 1.0e-4, math.radians(6.0)
MILLIMETRE = 1.0e-3
# Bounds of the process that reads: memory in bytes, and per byte of the file; time in seconds.
_LEAST_MEMORY = 2**31
_MEMORY_PER_BYTE = 200
_LONGEST = 600


def read_cad(source: Source) -> MeshFile:
    """All faces of a STEP or IGES file, triangulated, in millimetres.

    Raises:
        InputError: the package is not installed, or the file cannot be read or has no faces.
    """
    if find_spec("OCP") is None:
        raise source.error(
            "STEP and IGES need the package cadquery-ocp-novtk",
            "install it with pip install 'weavesim[cad]', or export the surface as STL",
        )
    is_step = source.suffix in (".step", ".stp")
    _check_header(source, is_step)
    content = _read_apart(source, "step" if is_step else "iges")
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        vertices, triangles, (face_count, empty, deflection) = (found[k] for k in ("vertices", "triangles", "counts"))
    check_finite(source, vertices)
    notes = [f"{face_count:.0f} faces triangulated to {deflection:.3g} mm"]
    if empty:
        notes.append(f"{empty:.0f} faces left out: they cannot be triangulated")
    labels = np.arange(1, len(triangles) + 1)
    check_references(source, triangles, labels, len(vertices), "triangle")
    cells = cells_of(source, triangles, labels)
    return MeshFile(
        source.name, source.suffix[1:].upper(), vertices, (cells,), tuple(notes), "triangle",
        metres_per_unit=MILLIMETRE,
    )  # fmt: skip


def _read_apart(source: Source, kind: str) -> bytes:
    """Output of ``cad_process.py``.

    Raises:
        InputError: it could not read the file.
    """
    memory = _LEAST_MEMORY + _MEMORY_PER_BYTE * len(source.data)
    program = Path(__file__).with_name("cad_process.py")
    bounds = map(str, (DEFLECTION, ANGLE, memory, _LONGEST))
    # -P: modules beside the program must not hide those of the library
    command = [sys.executable, "-P", str(program), str(source.path.absolute()), kind, *bounds]
    otherwise = "export it again, or as STL"
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_LONGEST)
    except subprocess.TimeoutExpired:
        raise source.error(f"Open CASCADE takes longer than {_LONGEST} s for it", otherwise) from None
    except OSError as error:
        raise source.error(f"Open CASCADE cannot be started ({error.strerror})", otherwise) from None
    if done.returncode:
        reasons = {NO_MEMORY: "it needs far more memory than a file of its size should", NO_SHAPES: "it has no shapes",
                   NO_FACES: "it has no faces"}  # fmt: skip
        if done.returncode == NO_LIBRARY:
            raise source.error(
                "Open CASCADE is installed but cannot be loaded",
                "python -c 'import OCP.STEPControl' says what it lacks",
            )
        raise source.error(
            reasons.get(done.returncode, "it is damaged, or cut off: Open CASCADE fails at it"), otherwise
        )
    return done.stdout


def _check_header(source: Source, is_step: bool) -> None:
    """The kernel prints about files that are something else, and may take long."""
    start = source.data[:4096].lstrip()
    if is_step and not start.startswith(b"ISO-10303-21"):
        raise source.misnamed("STEP")
    if not is_step and (len(source.data) < 73 or source.data.split(b"\n", 1)[0].rstrip()[72:73] not in b"SCB"):
        raise source.misnamed("IGES")
