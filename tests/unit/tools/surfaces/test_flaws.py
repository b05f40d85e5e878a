"""Holes, turned triangles and sharp radii of a tool's mesh, where they are and how large."""

import numpy as np
import pytest

from tests.support.jobs import tray_surface
from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.surfaces.flaws import holes_of, sharper_than

UP = (0.0, 0.0, 1.0)


def tray(drop=None, turn=None, **given) -> MeshSurface:
    """The tray [m], without the triangles ``drop``, and with the triangles ``turn`` the other way round."""
    vertices, faces = tray_surface(**given)
    faces = faces.copy()
    if turn is not None:
        faces[turn] = faces[turn][:, ::-1]
    if drop is not None:
        faces = np.delete(faces, drop, axis=0)
    return MeshSurface(1e-3 * vertices, faces, name="die", side=UP)


def about(x: float, y: float, radius: float) -> np.ndarray:
    """Rows of the triangles of the tray whose middles are near a place [mm]."""
    vertices, faces = tray_surface()
    return np.flatnonzero(np.linalg.norm(vertices[faces].mean(axis=1)[:, :2] - (x, y), axis=1) < radius)


def test_a_whole_surface_has_none():
    surface = tray()
    assert holes_of(surface) == [] and len(surface.turned) == 0
    assert not any("turned" in note for note in surface.notes())


def test_holes_are_found_with_their_places_the_smallest_first():
    small, large = about(70.0, 50.0, 2.0), about(-69.0, 49.0, 6.0)
    assert len(small) and len(large) and not set(small) & set(large)
    surface = tray(drop=np.concatenate([small, large]))
    holes = holes_of(surface)
    assert len(holes) == 2 and not any(hole.is_opening for hole in holes)
    vertices, faces = tray_surface()
    for hole, rows in zip(holes, (small, large), strict=True):
        gone = 1e-3 * vertices[faces[rows]].reshape(-1, 3)
        assert hole.width == pytest.approx(np.linalg.norm(np.ptp(gone, axis=0)), rel=1e-6)
        assert hole.place == pytest.approx(0.5 * (gone.min(axis=0) + gone.max(axis=0)), abs=1e-9)
        assert len(hole.edges) >= 3


def test_an_opening_that_is_meant_is_none():
    vertices, faces = tray_surface()
    ring = faces[(vertices[faces][:, :, 2] > -1e-9).all(axis=1)]
    (opening,) = holes_of(MeshSurface(1e-3 * vertices, ring, name="ring", side=UP))
    assert opening.is_opening and opening.width == pytest.approx(np.hypot(0.16, 0.12), rel=0.01)


def test_closed_bodies_have_none():
    import trimesh

    box = trimesh.creation.box((0.2, 0.1, 0.05))
    assert holes_of(MeshSurface(box.vertices, box.faces, name="box")) == []


def test_triangles_that_faced_the_other_way_are_told_with_their_place():
    rows = about(-69.0, -49.0, 12.0)
    surface = tray(turn=rows)
    vertices, faces = tray_surface()
    given = np.sort(1e-3 * vertices[faces[rows]].mean(axis=1), axis=0)
    assert np.allclose(np.sort(surface.turned.mean(axis=1), axis=0), given, atol=1e-9)
    (note,) = [note for note in surface.notes() if "turned" in note]
    assert note.startswith(f"die: {len(rows)} of {len(faces)} triangles faced the other way, one about (")
    # they are as the others now
    assert np.allclose(surface.vertices[surface.faces].mean(axis=1), tray().vertices[tray().faces].mean(axis=1))


def test_a_surface_that_was_given_upside_down_is_told():
    surface = tray(turn=slice(None))
    assert len(surface.turned) == len(surface.faces)
    assert "die: all triangles faced away from the side of the sheet: turned" in surface.notes()


def test_of_a_body_the_fewer_are_the_wrong_ones():
    import trimesh

    box = trimesh.creation.box((0.2, 0.1, 0.05)).subdivide()
    faces = np.array(box.faces)
    faces[:3] = faces[:3, ::-1]
    for given in (faces, faces[:, ::-1]):
        surface = MeshSurface(box.vertices, given, name="box")
        assert len(surface.turned) == 3
        assert any(f"3 of {len(faces)} triangles" in note for note in surface.notes())


def test_sharp_parts_have_their_share_and_place():
    surface = tray()
    assert sharper_than(surface, 0.004) is None
    sharp = sharper_than(surface, 0.009)  # the entry has 8 mm, the corners in plan more
    assert 0.005 < sharp.share < 0.2
    assert -0.008 < sharp.place[2] < 0.001
