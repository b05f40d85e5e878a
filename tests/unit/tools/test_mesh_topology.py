"""Edges of triangle meshes: neighbours, orientation, and borders that merely touch."""

import numpy as np
import pytest

from weavesim.tools.mesh_topology import border_in_words, directed_edges, neighbours, oriented, seam_contacts

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def test_neighbours_share_an_edge_and_three_faces_are_none():
    np.testing.assert_array_equal(np.sort(neighbours(SQUARE) // 3, axis=1), [[0, 1]])
    assert len(neighbours(np.concatenate([SQUARE, [[0, 2, 4]]]))) == 0


@pytest.mark.parametrize("turned", [(), (1,), (0,), (0, 1)])
def test_a_component_is_oriented_as_its_first_face(turned):
    faces = SQUARE.copy()
    faces[list(turned)] = faces[list(turned), ::-1]
    pairs = neighbours(faces)
    edges = directed_edges(faces)
    result, component, one_sided = oriented(faces, pairs // 3, edges[pairs[:, 0], 0] != edges[pairs[:, 1], 0])
    np.testing.assert_array_equal(result[0], faces[0])
    edges = directed_edges(result)
    (a, b), *_ = neighbours(result)
    np.testing.assert_array_equal(edges[a], edges[b][::-1])
    assert not np.any(one_sided) and len(np.unique(component)) == 1


def test_an_item_linked_to_its_own_reverse_is_one_sided():
    ring = np.array([[0, 1], [1, 2], [2, 0]])
    faces = np.tile(np.arange(3), (3, 1))
    assert not np.any(oriented(faces, ring, np.array([True, False, False]))[2])
    assert np.all(oriented(faces, ring, np.array([True, True, False]))[2])


@pytest.mark.parametrize("ratio", [1, 3, 300])
def test_seams_are_found_whatever_the_division(ratio):
    """One long edge beside many short ones, 1 um apart, and one short edge far from all."""
    x = np.linspace(0.0, 0.3, ratio + 1)
    line = np.column_stack([x, np.full_like(x, 1e-6), np.zeros_like(x)])
    vertices = np.concatenate([[(0.0, 0.0, 0.0), (0.3, 0.0, 0.0)], line, [(0.0, 0.2, 0.0), (1e-3, 0.2, 0.0)]])
    k = np.arange(2, ratio + 2)
    border = np.concatenate([[[0, 1]], np.column_stack([k + 1, k]), [[ratio + 3, ratio + 4]]])
    contacts = seam_contacts(vertices, border, 1e-5)
    assert set(contacts.edge.tolist()) == set(range(ratio + 1))
    assert not np.any(contacts.along)
    assert len(seam_contacts(vertices, border, 1e-7).edge) == 0


def test_a_border_says_how_long_it_is_and_where():
    vertices = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [5, 5, 0], [5.1, 5, 0], [5, 5.1, 0]]) * 1e-2
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 4]])
    text = border_in_words(vertices, edges)
    assert text == "7 open edges in 2 loops, the smallest of 3 edges, 1.41 mm across, at (50, 50, 0) mm"
    assert border_in_words(vertices, edges[:4]).startswith("4 open edges in one loop of 4 edges, 28.3 mm across")
