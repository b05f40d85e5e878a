"""3MF: all bodies of the build, where it places them. The file says its unit."""

from __future__ import annotations

import io
import zipfile
import zlib
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ...errors import InputError
from ..mesh_file import TRIANGLE, Cells, MeshFile, check_references
from ..source import LARGEST_COUNT, LARGEST_TEXT, Source, number, whole

_METRES = {
    "micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0
}  # fmt: skip
# Extensions that add no shape: materials, and parts in several files.
_HARMLESS = ("/material/", "/production/")
_MOST_PLACES = 20_000
_MOST_LEVELS = 50


class _Reference(NamedTuple):
    """Where an object stands, and its place: 4 x 3, as it multiplies rows (x, y, z, 1)."""

    model: str
    number: str
    place: np.ndarray


class _Object(NamedTuple):
    """A body, or a group of others with their places."""

    vertices: np.ndarray
    triangles: np.ndarray
    components: list[_Reference]


class _Model(NamedTuple):
    """Objects by number, what the build places, and the unit."""

    objects: dict[str, _Object]
    build: list[_Reference]
    unit: str


@dataclass
class _Bodies:
    """Vertices (n, 3) and triangles (m, 3) of each body that was placed."""

    vertices: list[np.ndarray] = field(default_factory=list)
    triangles: list[np.ndarray] = field(default_factory=list)
    vertex_count: int = 0
    reference_count: int = 0


@dataclass
class _Archive:
    """Models of the archive: objects by file and number, read when they are first needed."""

    source: Source
    zip: zipfile.ZipFile
    models: dict[str, _Model] = field(default_factory=dict)

    def model(self, name: str) -> _Model:
        name = name.lstrip("/")
        if name not in self.models:
            self.models[name] = _model(self.source, _content(self.source, self.zip, name), name)
        return self.models[name]


def read_threemf(source: Source) -> MeshFile:
    """Vertices and surface cells of a 3MF file, with its unit.

    Raises:
        InputError: damaged, or an extension that adds shapes, or no 3MF.
    """
    try:
        archive = _Archive(source, zipfile.ZipFile(io.BytesIO(source.data)))
    except (zipfile.BadZipFile, ValueError, OSError, NotImplementedError):
        raise source.misnamed("3MF", "no archive") from None
    entries = archive.zip.infolist()
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST_TEXT:
        raise source.error(f"it unpacks to {size / 2**20:.4g} MiB; at most {LARGEST_TEXT / 2**20:g} MiB are read")
    root = next((e.filename for e in entries if e.filename.lower().endswith("3d/3dmodel.model")), None)
    if root is None:
        raise source.error("it is an archive without 3D/3dmodel.model")
    _, build, unit = archive.model(root)
    if unit not in _METRES:
        raise source.error("its unit is none of 3MF")
    bodies = _Bodies()
    _place(archive, build, np.eye(4, 3), bodies, 0)
    if not bodies.triangles:
        raise source.error("its build places no bodies")
    points, faces = np.concatenate(bodies.vertices), np.concatenate(bodies.triangles)
    count = len(bodies.vertices)
    notes = [f"{count} bodies taken where the build places them"] if count > 1 else []
    cells = Cells(TRIANGLE, "triangles", faces, np.arange(1, len(faces) + 1))
    return MeshFile(source.name, "3MF", points, (cells,), tuple(notes), "triangle", metres_per_unit=_METRES[unit])


def _content(source: Source, archive: zipfile.ZipFile, name: str) -> bytes:
    try:
        entry = archive.getinfo(name)
        with archive.open(entry) as file:
            return file.read(entry.file_size + 1)
    except (KeyError, zipfile.BadZipFile, zlib.error, RuntimeError, OSError, NotImplementedError, EOFError, ValueError):
        raise source.error("one of its parts is missing, damaged or encrypted", "copy or export it again") from None


def _model(source: Source, content: bytes, name: str) -> _Model:
    objects: dict[str, _Object] = {}
    build: list[_Reference] = []
    unit = "millimeter"
    spaces: dict[str, str] = {}
    try:
        for event, item in ElementTree.iterparse(io.BytesIO(content), ("start", "end", "start-ns")):
            if event == "start-ns":
                spaces[item[0]] = item[1]
                continue
            tag = item.tag.rpartition("}")[2]
            if event == "start":
                if tag == "model":
                    unit = item.get("unit", unit)
                    needed = [spaces.get(prefix, prefix) for prefix in item.get("requiredextensions", "").split()]
                    if any(not any(part in space for part in _HARMLESS) for space in needed):
                        raise source.error(
                            "it needs an extension of 3MF that is not read here", "export plain 3MF or STL"
                        )
                elif tag in ("beamlattice", "displacementmesh", "volumetricstack", "slicestack", "booleans"):
                    raise source.error(f"it contains a {tag}, which is no triangle mesh", "export plain 3MF or STL")
                continue
            if tag == "object":
                objects[item.get("id", "")] = _object(source, item, name)
                item.clear()
            elif tag == "item":
                build.append(_reference(item, name))
    except InputError:
        raise
    except (ElementTree.ParseError, ValueError, LookupError):
        raise source.error("its model is damaged, or has numbers that are not finite", "export it again") from None
    return _Model(objects, build, unit)


def _object(source: Source, item: ElementTree.Element, name: str) -> _Object:
    vertices: list[list[float]] = []
    triangles: list[list[int]] = []
    components = []
    for part in item.iter():
        tag = part.tag.rpartition("}")[2]
        if tag == "vertex":
            vertices.append([number(part.get(axis, "").encode()) for axis in "xyz"])
        elif tag == "triangle":
            triangles.append([whole(part.get(corner, "").encode()) for corner in ("v1", "v2", "v3")])
        elif tag == "component":
            components.append(_reference(part, name))
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    check_references(source, faces, np.arange(1, len(faces) + 1), len(points), "triangle")
    return _Object(points, faces, components)


def _reference(item: ElementTree.Element, name: str) -> _Reference:
    """What ``item`` refers to, in the model ``name`` unless it says another."""
    path = next((value for key, value in item.attrib.items() if key.rpartition("}")[2] == "path"), name)
    place = np.eye(4, 3)
    if (text := item.get("transform")) is not None:
        place = np.array([number(word.encode()) for word in text.split()]).reshape(4, 3)
    return _Reference(path, item.get("objectid", ""), place)


def _place(archive: _Archive, references: list[_Reference], outer: np.ndarray, bodies: _Bodies, level: int) -> None:
    """Add what is referred to from ``level`` groups down, which stand at ``outer`` (4, 3)."""
    if level > _MOST_LEVELS:
        raise archive.source.error("its bodies contain each other")
    for path, object_id, place in references:
        objects = archive.model(path).objects
        if object_id not in objects:
            raise archive.source.error("it places an object that is not there")
        found = objects[object_id]
        place = np.vstack([place[:3] @ outer[:3], place[3] @ outer[:3] + outer[3]])
        if len(found.triangles):
            faces = found.triangles + bodies.vertex_count
            # a mirrored body is turned inside out
            bodies.triangles.append(faces if np.linalg.det(place[:3]) >= 0.0 else faces[:, ::-1])
            bodies.vertices.append(found.vertices @ place[:3] + place[3])
            bodies.vertex_count += len(found.vertices)
        bodies.reference_count += 1
        if bodies.vertex_count > LARGEST_COUNT or bodies.reference_count > _MOST_PLACES:
            raise archive.source.error("it places more bodies than a tool can have")
        _place(archive, found.components, place, bodies, level + 1)
