"""Binary glTF (.glb) by trimesh: all bodies of the scene, where it places them."""

from __future__ import annotations

import contextlib
import io
import json
import struct
from typing import Any

import numpy as np

from ...errors import InputError
from ..mesh_file import TRIANGLE, Cells, MeshFile, check_finite, check_references
from ..source import LARGEST_COUNT, Source

# Extensions without an effect on shape.
_HARMLESS = ("KHR_materials", "KHR_texture", "KHR_lights", "KHR_xmp")
_MOST_NODES = 100_000


def read_glb(source: Source) -> MeshFile:
    """Vertices and surface cells of a binary glTF file.

    Raises:
        InputError: damaged, or an extension, a posed or mixed shape, numbers in other files, or no binary glTF.
    """
    description = _description(source)
    try:
        expected, left_out, bodies = _promised(source, description)
    except InputError:
        raise
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OverflowError):
        raise source.error("its description is damaged") from None
    if expected > LARGEST_COUNT:
        raise source.error(f"it promises {expected} triangles, more than a file of this size can have")
    vertices, triangles = _taken(source)
    if len(triangles) != expected:
        raise source.error(f"{expected} triangles are in its scene, but {len(triangles)} could be read")
    check_finite(source, vertices)
    labels = np.arange(1, len(triangles) + 1)
    check_references(source, triangles, labels, len(vertices), "triangle")
    notes = [f"{left_out} sets of lines or points left out: they bound no surface"] if left_out else []
    if bodies > 1:
        notes.append(f"{bodies} bodies taken where the scene places them")
    cells = Cells(TRIANGLE, "triangles", triangles, labels)
    return MeshFile(source.name, "binary glTF", vertices, (cells,), tuple(notes), "triangle")


def _description(source: Source) -> dict[str, Any]:
    """The JSON that describes the scene."""
    data = source.data
    if not data.startswith(b"glTF"):
        raise source.misnamed("binary glTF")
    if len(data) < 20:
        raise source.error("it ends within its header", "copy or export it again")
    version, length, size, kind = struct.unpack_from("<4xIIII", data)
    if version != 2 or kind != 0x4E4F534A or length != len(data) or size > len(data) - 20:
        raise source.error("its header does not fit glTF 2.0 or the length of the file", "copy or export it again")
    try:
        description = json.loads(data[20 : 20 + size])
    except (ValueError, RecursionError):
        raise source.error("its description is no JSON") from None
    if not isinstance(description, dict):
        raise source.error("its description is no JSON object")
    return description


def _promised(source: Source, description: dict[str, Any]) -> tuple[int, int, int]:
    """Numbers of triangles, of primitives without any, and of bodies in the scene."""
    needed = [name for name in description.get("extensionsRequired", []) if not str(name).startswith(_HARMLESS)]
    if needed:
        raise source.error(
            "it needs an extension of glTF, such as compression, that is not read here", "export it plain"
        )
    if any("uri" in buffer for buffer in description.get("buffers", [])):
        raise source.error("its numbers are in another file or in text", "export one binary file")
    nodes, meshes, accessors = (description.get(key, []) for key in ("nodes", "meshes", "accessors"))
    if any(int(accessor["count"]) > len(source.data) for accessor in accessors):
        raise source.error("it promises more numbers than a file of its size can have")
    scenes = description.get("scenes", [])
    if not scenes:
        raise source.error("it has no scene")
    waiting = list(scenes[description.get("scene", 0)].get("nodes", []))
    triangles = left_out = bodies = visited = 0
    while waiting:
        node = nodes[waiting.pop()]
        waiting += node.get("children", [])
        visited += 1
        if visited > _MOST_NODES:
            raise source.error("its scene has more parts than a tool can have, or parts that contain each other")
        if "skin" in node:
            raise source.error("it is a figure that is posed by bones", "export the posed shape")
        if "mesh" not in node:
            continue
        mesh = meshes[node["mesh"]]
        if any(node.get("weights", mesh.get("weights", []))):
            raise source.error("its shape is a mixture of others", "export the mixed shape")
        for primitive in mesh["primitives"]:
            accessor = primitive.get("indices", primitive["attributes"].get("POSITION"))
            count = int(accessors[accessor]["count"])
            mode = primitive.get("mode", 4)
            if mode in (4, 5, 6):
                triangles += count // 3 if mode == 4 else max(count - 2, 0)
                bodies += 1
            else:
                left_out += 1
    return triangles, left_out, bodies


def _taken(source: Source) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    silent = io.StringIO()
    try:
        with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent):
            scene = trimesh.load_scene(
                io.BytesIO(source.data), file_type="glb", process=False, skip_materials=True, resolver=None
            )
        vertices, triangles, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
        for node in scene.graph.nodes_geometry:
            place, name = scene.graph[node]
            mesh = scene.geometry[name]
            if not isinstance(mesh, trimesh.Trimesh):
                continue
            faces = np.asarray(mesh.faces, dtype=np.int64) + count
            triangles.append(faces if np.linalg.det(place[:3, :3]) >= 0.0 else faces[:, ::-1])
            vertices.append(np.asarray(mesh.vertices, dtype=np.float64) @ place[:3, :3].T + place[:3, 3])
            count += len(mesh.vertices)
    except Exception:  # whatever a damaged file makes of it
        raise source.error("it is damaged, or uses something that trimesh does not know") from None
    return np.concatenate(vertices), np.concatenate(triangles)
