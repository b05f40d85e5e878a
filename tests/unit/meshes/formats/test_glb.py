"""Binary glTF: scenes with several bodies in their places."""

import json
import struct

import numpy as np
import pytest
import trimesh

from tests.support.mesh_files import die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.tools import MeshShape

NODES, QUADS = die()
DIE = trimesh.Trimesh(NODES, split(QUADS), process=False)
MOVE = trimesh.transformations.translation_matrix((300.0, 0.0, 10.0)) @ trimesh.transformations.rotation_matrix(
    0.5, (0, 0, 1)
)
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])


def exported(*places) -> bytes:
    scene = trimesh.Scene()
    for k, place in enumerate(places):
        scene.add_geometry(DIE, node_name=f"n{k}", geom_name="die", transform=place)
    return scene.export(file_type="glb")


def changed(content: bytes, change) -> bytes:
    """The same file with its description changed."""
    size = struct.unpack_from("<I", content, 12)[0]
    description = json.loads(content[20 : 20 + size])
    change(description)
    text = json.dumps(description).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + size :]
    return struct.pack("<4s2I2I", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


@pytest.mark.parametrize("places", [[np.eye(4)], [MOVE], [np.eye(4), MOVE], [MOVE, MIRROR, np.eye(4)]])
def test_all_bodies_are_in_their_places(tmp_path, places):
    mesh = read_mesh(written(tmp_path, "die.glb", exported(*places)))
    triangles, notes = mesh.triangles()
    found = mesh.vertices[triangles].mean(axis=1)
    expected = np.concatenate([trimesh.transform_points(NODES[split(QUADS)].mean(axis=1), place) for place in places])
    assert found[np.lexsort(found.round(2).T)] == pytest.approx(expected[np.lexsort(expected.round(2).T)], abs=1e-3)
    normal = np.cross(*(mesh.vertices[triangles[:, k]] - mesh.vertices[triangles[:, 0]] for k in (1, 2)))
    assert np.all(normal[:, 2] > 0.0)
    assert len(notes) == (len(places) > 1)


def test_a_tool_from_it(tmp_path):
    path = written(tmp_path, "die.glb", exported(np.eye(4)))
    assert len(MeshShape.from_file(path, unit_scale=0.001, side=(0, 0, 1)).surface.faces) == 128


def lines_only(description):
    description["meshes"][0]["primitives"][0]["mode"] = 1


GOOD = exported(np.eye(4))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (changed(GOOD, lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"])), "an extension of glTF"),
        (changed(GOOD, lambda d: d["buffers"][0].update(uri="../../etc/passwd")), "in another file"),
        (changed(GOOD, lambda d: d["accessors"][0].update(count=3 * 10**9)), "cannot be read"),
        (
            changed(GOOD, lambda d: [a.update(count=3) for a in d["accessors"]]),
            "cannot be read|no triangles|1 triangles",
        ),
        (changed(GOOD, lambda d: d["nodes"][0].update(children=[0])), "more parts|damaged"),
        (changed(GOOD, lambda d: [n.update(skin=0) for n in d["nodes"]]), "posed by bones"),
        (changed(GOOD, lambda d: d["meshes"][0].update(weights=[0.0, 0.5])), "a mixture of others"),
        (changed(GOOD, lambda d: d.update(scenes=[])), "no scene"),
        (changed(GOOD, lambda d: d.update(nodes=5)), "damaged"),
        (changed(GOOD, lambda d: d.update(meshes=[])), "damaged"),
        (changed(GOOD, lines_only), "no triangles|could be read"),
        (GOOD[:-10], "does not fit glTF 2.0 or the length"),
        (GOOD[:18], "ends within its header"),
        (GOOD + b"\0", "does not fit"),
        (GOOD.replace(b"glTF", b"glXX", 1), "not like binary glTF"),
        (GOOD[:20] + b"\xff" * (len(GOOD) - 20), "no JSON"),
    ],
)
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "die.glb", content)).triangles()


def test_numbers_that_are_not_finite_are_refused(tmp_path):
    broken = DIE.copy()
    broken.vertices[5] = np.nan
    with pytest.raises(InputError, match="not finite|cannot be read"):
        read_mesh(written(tmp_path, "die.glb", broken.export(file_type="glb")))
