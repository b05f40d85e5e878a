"""What a file looks like, whatever its name says."""

from __future__ import annotations

import re
import struct

# Starts of files, in the order in which they are tried. Text is compared without spaces before it, in lower case.
_BINARY_STARTS = (
    (b"PK\x03\x04", "a ZIP archive"),
    (b"PK\x05\x06", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ\0", "an xz archive"),
    (b"glTF", "a binary glTF file (.glb)"),
    (b"\x89HDF\r\n", "an HDF5 file"),
    (b"CDF\x01", "a netCDF file"),
    (b"CDF\x02", "a netCDF file"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"MZ\x90", "a program"),
    (b"\xd0\xcf\x11\xe0", "a document of a CAD or Office program"),
    (b"V5_CFV2", "a CATIA model"),
    (b"AC10", "a DWG drawing"),
    (b"Kaydara FBX", "an FBX scene"),
    (b"PXR-USDC", "a USD scene"),
    (b"\xff\xfe", "text in UTF-16: save it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16: save it as UTF-8"),
)
_TEXT_STARTS = (
    (b"<!doctype html", "a web page"),
    (b"<html", "a web page"),
    (b"version https://git-lfs", "a pointer of git-lfs in place of the file: fetch the file itself"),
    (b"iso-10303-21", "a STEP model of curved surfaces"),
    (b"# vtk datafile", "a legacy VTK file (.vtk)"),
    (b"$meshformat", "a Gmsh mesh (.msh)"),
    (b"ply\n", "a PLY file (.ply)"),
    (b"ply\r", "a PLY file (.ply)"),
    (b"off\n", "an OFF file (.off)"),
    (b"off\r", "an OFF file (.off)"),
    (b"off ", "an OFF file (.off)"),
    (b"#usda", "a USD scene"),
    (b"#vrml", "a VRML scene"),
    (b"*heading", "an Abaqus or CalculiX deck (.inp)"),
    (b"*keyword", "an LS-DYNA deck"),
    (b"solid", "an ASCII STL file (.stl)"),
)


def looks_like(data: bytes) -> str | None:
    """What a file's content is by its first bytes, in words; None if nothing is recognised."""
    for start, kind in _BINARY_STARTS:
        if data.startswith(start):
            return kind
    if is_binary_stl(data):
        return "a binary STL file (.stl)"
    head = data[:4096].lstrip().lower()
    for start, kind in _TEXT_STARTS:
        if head.startswith(start):
            return kind
    if head.startswith(b"<"):
        for mark, kind in (
            (b"<html", "a web page"), (b"<vtkfile", "a VTK file in XML (.vtu)"), (b"<xdmf", "an XDMF file"),
            (b"<collada", "a COLLADA scene"), (b"<svg", "an SVG drawing"), (b"<x3d", "an X3D scene"),
        ):  # fmt: skip
            if mark in head:
                return kind
        return "XML"
    if re.search(rb"(?m)^\*(node|part)\b", head):
        return "an Abaqus or CalculiX deck (.inp)"
    if re.search(rb"(?m)^(begin bulk|grid\*? )", head):
        return "a Nastran deck (.bdf)"
    if re.match(rb"0\s+section\b", head) or re.match(rb"999\s", head):
        return "a DXF drawing"
    if len(data) > 80 and data[72:73] == b"S" and data[73:80].strip() == b"1":
        return "an IGES model of curved surfaces"
    if head.startswith((b"{", b"[")):
        return "JSON"
    if re.search(rb"(?m)^v[ \t]+[-+.0-9]", head):
        return "an OBJ file (.obj)"
    return None


def is_binary_stl(data: bytes) -> bool:
    """Whether the number of triangles after the header of 80 bytes fits the length of the file."""
    return len(data) >= 84 and len(data) == 84 + 50 * struct.unpack_from("<I", data, 80)[0]


def is_text(data: bytes) -> bool:
    """Whether the first bytes are text in some encoding of bytes."""
    return b"\0" not in data[:65536]
