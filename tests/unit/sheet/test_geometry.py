"""Shape functions, area and initial strains of distorted and curved elements, on the host."""

import numpy as np
import pytest

from weavesim.sheet.blank import Blank
from weavesim.sheet.geometry import ElementGeometry


@pytest.fixture
def blank() -> Blank:
    return Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=25.0, distortion=0.35)


def nodal_gradients(geometry: ElementGeometry) -> np.ndarray:
    """Derivatives of the four shape functions along warp and weft, (4, 2, m) [1/m]."""
    b_p, b_q = geometry.gradient[:2], geometry.gradient[2:]
    return np.array([b_p, b_q, -b_p, -b_q])


def hourglass_vector(geometry: ElementGeometry) -> np.ndarray:
    """(4, m)."""
    c_p, c_q = geometry.hourglass_offset
    return np.array([1.0 - c_p, -1.0 - c_q, 1.0 + c_p, -1.0 + c_q])


def test_linear_fields_have_their_exact_gradient_along_the_yarns(blank):
    geometry = ElementGeometry.of(blank)
    slope = np.array([0.7, -1.3, 0.0])
    values = (blank.node_position @ slope + 4.0)[blank.quads]
    found = np.einsum("iae,ei->ea", nodal_gradients(geometry), values)
    assert np.allclose(found[:, 0], blank.warp_direction @ slope, rtol=1e-12, atol=1e-12)
    assert np.allclose(found[:, 1], blank.weft_direction @ slope, rtol=1e-12, atol=1e-12)


def test_hourglass_vector_sees_no_linear_field(blank):
    geometry = ElementGeometry.of(blank)
    gamma = hourglass_vector(geometry)
    for field in (np.ones(blank.node_count), blank.node_position[:, 0], blank.node_position[:, 1]):
        assert np.abs(np.einsum("ie,ei->e", gamma, field[blank.quads])).max() < 1e-12
    product = (blank.node_position[:, 0] * blank.node_position[:, 1])[blank.quads]
    assert np.abs(np.einsum("ie,ei->e", gamma, product)).min() > 1e-6
    assert np.allclose((gamma**2).sum(axis=0), geometry.squared_hourglass)


def test_areas_sum_to_that_of_the_blank(blank):
    geometry = ElementGeometry.of(blank)
    assert geometry.area.min() > 0.0
    assert geometry.area.sum() == pytest.approx(0.03 * 0.02, rel=1e-12)


def test_squared_gradients(blank):
    geometry = ElementGeometry.of(blank)
    assert np.allclose((nodal_gradients(geometry) ** 2).sum(axis=0), geometry.squared_gradients)


def test_twist_weights_of_a_square():
    """k(xi, eta) = h^2 k_12 / 4: weights 0, h^2/4 split over the two entries of the tensor, 0."""
    size = 0.004
    for angle in (0.0, 30.0):
        geometry = ElementGeometry.of(Blank.rectangle((0.0, 0.0), (size, size), size, yarn_angle=angle))
        assert geometry.squared_twist_weights == pytest.approx([2.0 * (size**2 / 8.0) ** 2])


def test_flat_sheet_has_no_initial_strain(blank):
    assert ElementGeometry.of(blank).flat


def test_cylinder_has_its_initial_curvature():
    """Normals point out of a cylinder of radius R along y: k_xx = 1/R, nothing else, seen from any yarn angle."""
    radius, angle = 0.1, 0.4
    flat = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.002)
    x, y, _ = flat.node_position.T
    position = np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)])
    curved = Blank.from_mesh(position, flat.quads, yarn_angle=np.rad2deg(angle))
    geometry = ElementGeometry.of(curved)
    assert not geometry.flat
    # nodes at the rim have a one-sided normal
    inner = np.abs(curved.element_centres()[:, 0]) < 0.015
    along = curved.warp_direction[:, :2]
    # the cosine along the circle: what is not along y
    share = 1.0 - along[:, 1] ** 2
    assert np.allclose(geometry.curvature[0][inner], (share / radius)[inner], rtol=2e-3)
    assert np.allclose(geometry.curvature[[0, 2]].sum(axis=0)[inner], 1.0 / radius, rtol=2e-3)
