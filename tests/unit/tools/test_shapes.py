"""Analytic shapes: the kernels' distances and normals against closed forms, differences, and the drawn surfaces."""

import math

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.registered_shapes import OPENING, PUNCH, SHAPES
from weavesim.errors import InputError
from weavesim.kernels.contact.tool_distance import sample_distance_kernel
from weavesim.tools.device import build_device_tools
from weavesim.tools.shapes import (
    IDENTITY,
    Capsule,
    DomeCavity,
    DomeOpening,
    DomePunch,
    Plane,
    Sphere,
    Torus,
    Union,
    rotation_matrix,
)
from weavesim.tools.tool import Tool

length = st.floats(0.005, 0.1)
seeds = st.integers(0, 2**31)
cases = settings(max_examples=25, deadline=None)


def points_around(seed: int, half_size: float = 0.2, count: int = 300) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-half_size, half_size, (count, 3))


def distance(shape, points, displacement=0.0, axis=(0.0, 0.0, 1.0)):
    return Tool("tool", shape, axis=axis).distance(points, displacement)


def to_segment(points, half_length):
    """Vectors from the nearest point of the segment |x| <= half_length."""
    nearest = np.zeros_like(points)
    nearest[:, 0] = np.clip(points[:, 0], -half_length, half_length)
    return points - nearest


@cases
@given(seeds, length, length)
def test_ball_like_distances_are_the_closed_forms(seed, radius, half_length):
    points = points_around(seed)
    expected = {
        Plane(): points[:, 2],
        Sphere(radius): np.linalg.norm(points, axis=1) - radius,
        Capsule(radius, half_length): np.linalg.norm(to_segment(points, half_length), axis=1) - radius,
    }
    for shape, value in expected.items():
        np.testing.assert_allclose(distance(shape, points)[0], value, atol=1e-15)


@cases
@given(seeds, length, length)
def test_torus_is_as_far_as_the_nearest_point_of_its_circle(seed, radius, extra):
    major = radius + extra
    points = points_around(seed)
    angle = np.arctan2(points[:, 1], points[:, 0])
    centre = major * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(points))])
    value, normal = distance(Torus(radius, major), points)
    np.testing.assert_allclose(value, np.linalg.norm(points - centre, axis=1) - radius, atol=1e-14)
    np.testing.assert_allclose(points - (value + radius)[:, None] * normal, centre, atol=1e-12)


@cases
@given(seeds, length, length)
def test_punch_is_the_union_of_capsules_stacked_upwards(seed, radius, half_length):
    points = points_around(seed)
    heights = np.linspace(0.0, 0.3, 3001)[:, None]
    plan = np.linalg.norm(to_segment(points * (1.0, 1.0, 0.0), half_length), axis=1)
    stacked = np.hypot(plan, points[:, 2] - heights).min(axis=0) - radius
    # the stack is 0.1 mm apart: its distance is too large by at most half of that, and less off the axis
    value = distance(DomePunch(radius, half_length), points)[0]
    assert np.all(value <= stacked + 1e-12)
    assert np.all(value >= stacked - 0.6e-4)


@pytest.mark.slow
@cases
@given(seeds, length, length)
def test_cavity_is_as_far_as_the_nearest_point_of_its_profile(seed, radius, half_length):
    points = points_around(seed)
    out = np.linalg.norm(to_segment(points * (1.0, 1.0, 0.0), half_length), axis=1)
    angle = np.linspace(-0.5 * np.pi, 0.0, 1500)
    step = np.linspace(0.0, 0.6, 3000)
    profile = np.concatenate(
        [
            radius * np.column_stack([np.cos(angle), np.sin(angle)]),
            np.column_stack([radius + step, np.zeros_like(step)]),
        ]
    )
    nearest = np.linalg.norm(np.column_stack([out, points[:, 2]])[:, None] - profile, axis=2).min(axis=1)
    value, normal = distance(DomeCavity(radius, half_length), points)
    solid = (points[:, 2] < 0.0) & (np.hypot(out, points[:, 2]) > radius)
    assert np.array_equal(value < 0.0, solid)
    outside = ~solid
    np.testing.assert_allclose(value[outside], nearest[outside], atol=1.2e-4)
    # inside the solid the nearer of top and hollow; their common edge is nearer to no point of it
    np.testing.assert_allclose(-value[solid], nearest[solid], atol=1.2e-4)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-9)


@pytest.mark.slow
@cases
@given(seeds, length, length, st.floats(0.001, 0.03))
def test_opening_is_as_far_as_the_nearest_point_of_its_profile(seed, radius, half_length, edge):
    points = points_around(seed)
    out = np.linalg.norm(to_segment(points * (1.0, 1.0, 0.0), half_length), axis=1)
    profile_point = np.column_stack([out, points[:, 2]])
    angle = np.linspace(0.0, 0.5 * np.pi, 800)
    step = np.linspace(0.0, 0.6, 3000)
    profile = np.concatenate(
        [
            np.column_stack([np.full_like(step, radius), -edge - step]),
            np.column_stack([radius + edge - edge * np.cos(angle), edge * (np.sin(angle) - 1.0)]),
            np.column_stack([radius + edge + step, np.zeros_like(step)]),
        ]
    )
    gap = np.linalg.norm(profile_point[:, None] - profile, axis=2).min(axis=1)
    beside = (out > radius) & (points[:, 2] < 0.0)
    in_corner = (out < radius + edge) & (points[:, 2] > -edge)
    rounded_off = np.hypot(out - radius - edge, points[:, 2] + edge) > edge
    solid = beside & ~(in_corner & rounded_off)
    value = distance(DomeOpening(radius, half_length, edge), points)[0]
    np.testing.assert_allclose(np.abs(value), gap, atol=1.1e-4)
    clear = gap > 2e-4
    np.testing.assert_array_equal(value[clear] < 0.0, solid[clear])


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_normal_is_the_gradient_of_the_distance_and_has_length_one(shape):
    shape = shape.placed((0.01, -0.02, 0.03), rotation_matrix((1.0, 2.0, -1.0), 0.8))
    points = points_around(7, count=2000)
    step = 1e-6
    value, normal = distance(shape, points)
    gradient = np.column_stack(
        [
            (distance(shape, points + step * e)[0] - distance(shape, points - step * e)[0]) / (2 * step)
            for e in np.eye(3)
        ]
    )
    # on a ridge of the distance (as far from wall and top, the axis of a ball) the gradient jumps
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1.0) < 1e-6
    assert smooth.mean() > 0.99
    np.testing.assert_allclose(normal[smooth], gradient[smooth], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-12)
    assert (value < 0.0).any() and (value > 0.0).any()


@cases
@given(seeds, st.floats(-3.0, 3.0), st.floats(-0.1, 0.1), st.sampled_from(SHAPES))
def test_a_placed_and_displaced_shape_is_the_same_shape_elsewhere(seed, angle, displacement, shape):
    random = np.random.default_rng(seed)
    axis, origin, direction = random.normal(size=(3, 3))
    turn = rotation_matrix(axis, angle)
    points = points_around(seed)
    value, normal = distance(shape, points)
    unit = direction / np.linalg.norm(direction)
    moved = points @ np.array(turn).T + origin + displacement * unit
    moved_value, moved_normal = distance(shape.placed(origin, turn), moved, displacement, direction)
    np.testing.assert_allclose(moved_value, value, atol=1e-14)
    # where two faces are equally near, round-off decides between their normals
    same = np.einsum("ij,ij->i", moved_normal @ np.array(turn), normal)
    assert np.mean(same > 1.0 - 1e-9) > 0.99


def test_union_is_the_nearest_shape_in_the_frame_of_the_union():
    capsule = Capsule(0.02, 0.05, origin=(0.0, 0.0, -0.1), rotation=rotation_matrix((0, 0, 1), 0.5))
    parts = (Sphere(0.04, origin=(0.0, 0.2, 0.0)), capsule, DomePunch(0.03, 0.05))
    turn = rotation_matrix((0.3, 1.0, 0.2), 1.1)
    union = Union((Union(parts[:2], origin=(0.0, 0.01, 0.0)), parts[2]), origin=(0.1, 0.2, 0.3), rotation=turn)
    alone = [part.placed((0.0, 0.01, 0.0)).placed((0.1, 0.2, 0.3), turn) for part in parts[:2]]
    alone.append(parts[2].placed((0.1, 0.2, 0.3), turn))
    points = points_around(3) + (0.1, 0.2, 0.3)
    values, normals = zip(*(distance(part, points) for part in alone), strict=True)
    value, normal = distance(union, points)
    np.testing.assert_allclose(value, np.min(values, axis=0), atol=1e-15)
    nearest = np.argmin(values, axis=0)
    np.testing.assert_allclose(normal, np.array(normals)[nearest, np.arange(len(points))], atol=1e-11)
    assert set(nearest) == {0, 1, 2}
    assert union.smallest_radius == 0.02
    assert len(union.display_mesh().faces) == sum(len(part.display_mesh().faces) for part in parts)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_drawn_vertices_lie_on_the_surface_and_triangles_face_outwards(shape):
    shape = shape.placed((0.01, 0.02, 0.3), rotation_matrix((1.0, 2.0, 3.0), 0.7))
    mesh = shape.display_mesh()
    assert np.abs(distance(shape, mesh.vertices)[0]).max() < 1e-12
    assert mesh.area_faces.min() > 0.0
    value, normal = distance(shape, mesh.triangles_center)
    on_surface = np.abs(value) < 1e-4  # not so on the lid of a punch
    assert on_surface.mean() > 0.9
    # at a sharp edge, or at the rim of a punch's lid, a flat triangle is nearest to the other face
    facing = np.einsum("ij,ij->i", mesh.face_normals, normal)[on_surface]
    assert facing.min() > (0.99 if shape.smallest_radius > 0.0 and not isinstance(shape, DomePunch) else -1e-9)
    assert np.median(facing) > 0.99


def test_drawn_extent_is_what_was_asked_for():
    plate = OPENING.model_copy(update={"display_size": (0.6, 0.4), "display_depth": 0.05}).display_mesh()
    np.testing.assert_allclose(plate.bounds, [[-0.3, -0.2, -0.05], [0.3, 0.2, 0.0]], atol=1e-12)
    punch = PUNCH.model_copy(update={"display_height": 0.1}).display_mesh()
    np.testing.assert_allclose(punch.bounds, [[-0.145, -0.06, -0.06], [0.145, 0.06, 0.1]], atol=1e-12)
    plane = Plane(display_size=(0.2, 0.1)).display_mesh()
    np.testing.assert_allclose(plane.bounds, [[-0.1, -0.05, 0.0], [0.1, 0.05, 0.0]], atol=1e-15)


def test_drawn_ball_and_capsule_have_nearly_the_exact_area():
    sphere, capsule = Sphere(0.05).display_mesh(), Capsule(0.03, 0.08).display_mesh()
    assert sphere.area == pytest.approx(4 * math.pi * 0.05**2, rel=2e-3)
    assert capsule.area == pytest.approx(4 * math.pi * 0.03**2 + 2 * math.pi * 0.03 * 0.16, rel=2e-3)


@pytest.mark.parametrize("real", [wp.float32, wp.float64], ids=["float32", "float64"])
def test_sixteen_lanes_give_what_one_lane_gives(real):
    union = Union([shape.placed((0.1 * k, 0.0, 0.05 * k)) for k, shape in enumerate([Torus(0.02, 0.07), PUNCH])])
    turned = OPENING.placed((0.0, 0.0, -0.05), rotation_matrix((1.0, 0.0, 0.0), 0.4))
    points = points_around(5, count=1003)  # not a multiple of sixteen
    vec3 = wp.types.vector(3, real)
    for shape in (union, turned):
        tools = build_device_tools([Tool("tool", shape)], real, "cpu")
        results = []
        for lane_count in (1, 16):
            value = wp.zeros(len(points), dtype=real, device="cpu")
            normal = wp.zeros(len(points), dtype=vec3, device="cpu")
            wp.launch(
                sample_distance_kernel(real, lane_count, ()),
                dim=-(-len(points) // lane_count),
                inputs=[tools.tool, tools.part, 0, wp.float64(0.03), wp.array(points, dtype=wp.vec3d, device="cpu")],
                outputs=[value, normal],
                device="cpu",
            )
            results.append(np.column_stack([value.numpy(), normal.numpy()]))
        epsilon = 1.2e-7 if real is wp.float32 else 2.3e-16
        np.testing.assert_allclose(results[1][:, 0], results[0][:, 0], atol=4 * epsilon)
        np.testing.assert_allclose(results[1][:, 1:], results[0][:, 1:], atol=200 * epsilon)
        exact = Tool("tool", shape).distance(points, 0.03)[0]
        np.testing.assert_allclose(results[0][:, 0], exact, atol=4 * epsilon)


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Sphere(0.0), "Sphere: radius = 0.0: a number above 0 is needed"),
        (lambda: Sphere(math.nan), "finite"),
        (lambda: Sphere("wide"), "Sphere: radius = 'wide': a number is needed"),
        (lambda: Capsule(0.1, -0.1), "Capsule: half_length"),
        (lambda: Torus(0.2, 0.1), "below major_radius"),
        (lambda: DomePunch(0.1, -1e-3), "half_length = -0.001: at least 0 is needed"),
        (lambda: DomeOpening(0.1, 0.1, -1e-3), "edge_radius"),
        (lambda: DomeOpening(0.1, 0.1, 0.01, display_size=(0.1, 0.1)).display_mesh(), "display_size"),
        (lambda: Sphere(0.1, origin=(0.0, math.inf, 0.0)), "origin"),
        (lambda: Sphere(0.1, rotation=2.0 * np.eye(3)), "rotation matrix"),
        (lambda: Sphere(0.1, rotation=5), "Sphere: rotation = 5: a 3 x 3 rotation matrix is needed"),
        (lambda: Sphere(0.1, rotation=((1, 0, 0), (0, 1, 0), 5)), "row 2 = 5: three finite numbers are needed"),
        (lambda: Sphere(0.1).placed((0, 0, 0), 5), "3 x 3 rotation matrix"),
        (lambda: Sphere(0.1, rotation=np.diag([1.0, 1.0, -1.0])), "right-handed"),
        (lambda: rotation_matrix((0.0, 0.0, 0.0), 1.0), "axis of the rotation"),
        (lambda: Union([]), "Union: shapes = .*: it takes one or more shapes"),
        (lambda: Union([Sphere(0.1), "box"]), "shapes.1 = 'box': one of Plane, Sphere"),
    ],
)
def test_bad_dimensions_are_refused(build, says):
    with pytest.raises(InputError, match=says):
        build()


def test_rotation_matrix_turns_the_right_way():
    np.testing.assert_allclose(
        rotation_matrix((0, 0, 2.0), math.pi / 2), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15
    )
    assert Sphere(0.1).rotation == IDENTITY


@pytest.mark.parametrize(
    ("angle", "right"), [(90.0, "1.571 for 90"), (-45, "at most 6.283 rad"), (180.0, "3.142 for 180")]
)
def test_a_rotation_in_degrees_is_refused(angle, right):
    with pytest.raises(InputError, match=f"angle = .*{right}"):
        rotation_matrix((0.0, 0.0, 1.0), angle)
