"""Slits: both sides apart, tips closed, area kept."""

import numpy as np
import pytest

from weavesim import Blank, InputError
from weavesim.sheet.fitted_mesh import corner_sines, fitted_mesh
from weavesim.sheet.slits import cut_open

SQUARE = 0.1 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def cut(slits, mesh_angle=0.0, size=0.01):
    node, quads = fitted_mesh(SQUARE, size, mesh_angle=mesh_angle)
    return len(node), *cut_open(node, quads, [np.array(slit) for slit in slits], size)


@pytest.mark.parametrize("mesh_angle", [0.0, 30.0, 45.0])
def test_an_inner_slit_is_a_hole_without_area(mesh_angle):
    count, node, quads, off = cut([[[-0.05, 0.02], [0.05, 0.02]]], mesh_angle)
    blank = Blank.from_mesh(np.column_stack([node, 0 * node[:, 0]]), quads, merge_nodes=0.0)
    corner = node[quads]
    diagonal = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    area = 0.5 * np.abs(diagonal[0][:, 0] * diagonal[1][:, 1] - diagonal[0][:, 1] * diagonal[1][:, 0])
    assert np.isclose(area.sum(), 0.04)
    doubled = node[count:]
    # all but the tips; elements that are not along the slit make a zigzag of it
    assert len(doubled) >= 7
    assert (np.abs(doubled[:, 1] - 0.02) <= off + 1e-12).all() and (np.abs(doubled[:, 0]) < 0.0499).all()
    assert off < (1e-9 if mesh_angle == 0.0 else 0.4 * 0.01)
    assert corner_sines(node, quads).min() > 0.3
    assert len(blank.boundary_loop()) > 60


def test_a_slit_from_the_edge_opens_it():
    count, node, quads, _ = cut([[[0.0, -0.1], [0.0, -0.04]]])
    doubled = node[count:]
    assert np.isclose(doubled[:, 1].min(), -0.1) and doubled[:, 1].max() < -0.04
    blank = Blank.from_mesh(np.column_stack([node, 0 * node[:, 0]]), quads, merge_nodes=0.0)
    # the way around the outline leads along both sides of it
    assert len(blank.boundary_loop()) == 4 * 20 + 2 * 6


@pytest.mark.parametrize(
    ("slit", "message"),
    [
        ([[0.0, 0.0], [0.004, 0.0]], "slit 0 is shorter than an element"),
        ([[0.0, 0.0], [0.3, 0.0]], r"slit 0: its point \(0.3, 0\) m lies outside the sheet"),
    ],
)
def test_what_is_no_slit_is_refused(slit, message):
    with pytest.raises(InputError, match=message):
        cut([slit])
