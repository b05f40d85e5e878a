"""The side of a die that a sheet meets, and its flat rim."""

import numpy as np
import pytest
import trimesh

from tests.support.jobs import tray_surface
from weavesim import InputError
from weavesim.tools.mesh_features import face_normals
from weavesim.tools.surfaces.rim import facing_up, rim_faces, ring_over_rim


def closed_die():
    """A block of 100 x 80 x 30 mm with a pocket of 60 x 40 x 20 mm, all walls vertical."""
    block = trimesh.creation.box((0.1, 0.08, 0.03))
    pocket = trimesh.creation.box((0.06, 0.04, 0.02))
    pocket.apply_translation((0, 0, 0.005 + 1e-9))
    return trimesh.boolean.difference([block, pocket], engine="manifold")


def test_of_a_block_the_pocket_and_the_top_face_up_and_the_outside_does_not():
    die = closed_die()
    part = facing_up(die.vertices, die.faces)
    normal, area = face_normals(part.vertices, part.faces)
    assert normal[:, 2].min() > -0.01
    wall = np.abs(normal[:, 2]) < 0.01
    assert np.isclose(area[wall].sum(), 2 * (0.06 + 0.04) * 0.02, rtol=1e-3)
    assert np.isclose(area[~wall].sum(), 0.1 * 0.08, rtol=1e-3)


def test_the_rim_of_a_block_is_its_top():
    die = closed_die()
    part = facing_up(die.vertices, die.faces)
    rim = rim_faces(part.vertices, part.faces)
    area = face_normals(part.vertices, part.faces)[1]
    assert np.isclose(area[rim].sum(), 0.1 * 0.08 - 0.06 * 0.04, rtol=1e-3)


def test_a_ring_over_the_rim_of_a_tray_faces_down():
    vertices, faces = tray_surface()
    ring = ring_over_rim("tray", 1e-3 * vertices, faces, 0.002)
    assert np.allclose(ring.vertices[:, 2], 0.002)
    assert face_normals(ring.vertices, ring.faces)[0][:, 2].max() < -0.99
    inner = np.abs(ring.vertices[:, :2]).min(axis=0)
    assert (inner < [0.08, 0.06]).all()


def test_a_male_tool_has_its_rim_below():
    vertices, faces = tray_surface()
    bump = 1e-3 * vertices * [1.0, 1.0, -1.0]
    rim = rim_faces(bump, faces)
    assert np.any(rim)
    assert np.allclose(bump[faces[rim]][:, :, 2], 0.0)


def test_a_tool_without_a_flat_rim_is_refused():
    ball = trimesh.creation.icosphere(3, 0.05)
    part = facing_up(ball.vertices, ball.faces)
    with pytest.raises(InputError, match="no flat rim"):
        ring_over_rim("ball", part.vertices, part.faces, 0.001)


def test_what_others_cover_does_not_face_up():
    """Seen from a side of the block, the far wall of its pocket lies behind the near one."""
    die = closed_die()
    part = facing_up(die.vertices[:, [2, 0, 1]], die.faces)  # y of the block is up
    area = face_normals(part.vertices, part.faces)[1]
    assert np.isclose(area.sum(), 0.1 * 0.03, rtol=1e-3)
    assert np.allclose(part.vertices[:, 2], 0.04)
