"""Arrays that are given stay their owner's: writable, and free to change without a value changing with them."""

import numpy as np
import pytest
import trimesh

from tests.support.sheet import plain_fabric
from weavesim import Drive, NodalLoads, Sheet, Support
from weavesim.arrays import frozen
from weavesim.process import Stroke
from weavesim.sheet.blank import Blank
from weavesim.tools import MeshShape
from weavesim.tools.mesh_tool import MeshSurface, TriangleMesh

MOTION = Stroke(times=(0.0, 1.0), displacements=(0.0, 0.01))
FLAT = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.05)


def blank_arrays() -> dict[str, np.ndarray]:
    names = ("node_position", "material_coordinates", "quads", "warp_direction", "weft_direction", "initial_director")
    return {name: np.array(getattr(FLAT, name)) for name in names}


def sheet_of(free, initial_velocity):
    return Sheet(FLAT, plain_fabric(), free=free, initial_velocity=initial_velocity)


MESH = {"vertices": np.array(BALL.vertices), "faces": np.array(BALL.faces)}
NODES = {"node_position": np.array(FLAT.node_position), "quads": np.array(FLAT.quads)}
KINDS = {
    "from_mesh": (Blank.from_mesh, NODES),
    "from_mesh merged": (lambda **a: Blank.from_mesh(**a, merge_nodes=1e-6), NODES),
    "from_mesh int64": (Blank.from_mesh, {**NODES, "quads": NODES["quads"].astype(np.int64)}),
    "from_mesh int32": (Blank.from_mesh, {**NODES, "quads": NODES["quads"].astype(np.int32)}),
    "from_mesh directions": (
        Blank.from_mesh,
        {**NODES, "warp_direction": np.array([1.0, 0, 0]), "material_coordinates": np.array(FLAT.material_coordinates)},
    ),
    "Blank": (Blank, blank_arrays()),
    "from_triangles": (MeshShape.from_triangles, MESH),
    "from_triangles placed": (MeshShape.from_triangles, {**MESH, "origin": np.zeros(3), "rotation": np.eye(3)}),
    "TriangleMesh": (TriangleMesh, MESH),
    "MeshSurface": (MeshSurface, MESH),
    "Sheet": (sheet_of, {"free": np.ones((9, 6), dtype=bool), "initial_velocity": np.zeros((9, 3))}),
    "NodalLoads": (NodalLoads, {"force": np.zeros((9, 3)), "couple": np.zeros((9, 3)), "times": np.array([0.0, 1.0]),
                                "shares": np.array([0.0, 1.0])}),
    "Support": (lambda nodes: Support("s", nodes), {"nodes": np.arange(3)}),
    "Drive": (lambda direction: Drive(MOTION, direction), {"direction": np.array([1.0, 0.0, 0.0])}),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_stay_their_owners(kind):
    make, arrays = KINDS[kind]
    given = {name: array.copy() for name, array in arrays.items()}
    value = make(**given)
    before = value.to_json() if hasattr(value, "to_json") else value.vertices.copy()
    for name, array in given.items():
        assert array.flags.writeable, name
        assert np.array_equal(array, arrays[name]), name
        array[...] = 0
    after = value.to_json() if hasattr(value, "to_json") else value.vertices
    assert np.array_equal(before, after)


def test_a_frozen_array_cannot_be_made_writable():
    array = frozen(np.arange(3.0))
    with pytest.raises(ValueError):
        array.flags.writeable = True
