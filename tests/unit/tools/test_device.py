"""Tools as the kernels take them: every shape has its kind, and what has none is refused."""

import numpy as np
import pytest
import warp as wp

import weavesim.tools
from weavesim.errors import InputError
from weavesim.kernels.contact.tool_shapes import SHAPE_KINDS, ShapeKind, shape_kind, shape_number
from weavesim.tools import MeshShape, Plane, Shape, Sphere, Tool, Torus, Union, rotation_matrix
from weavesim.tools.device import build_device_tools
from weavesim.tools.sampling import sample_meshes


class Cone(Shape):
    distance_function = "cone"


class Shapeless(Shape):
    pass


class Elsewhere(Shape):
    distance_function = "weavesim.tools.shapes"


class Nowhere(Shape):
    distance_function = "no_such_package.cone"


class BallWithoutRadius(Shape):
    distance_function = "sphere"


def test_every_shape_has_a_kind_of_its_own_and_every_kind_a_shape():
    classes = [getattr(weavesim.tools, name) for name in weavesim.tools.__all__]
    shapes = [shape for shape in classes if isinstance(shape, type) and issubclass(shape, Shape)]
    names = [shape.distance_function for shape in shapes if shape not in (Shape, Union)]
    assert len(set(names)) == len(names) and set(names) >= set(SHAPE_KINDS)
    assert all(isinstance(shape_kind(name), ShapeKind) for name in names)


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        (Cone(), "Cone.distance_function: no distance function 'cone'; choose one of plane, sphere"),
        (Shapeless(), "Shapeless.distance_function: no distance function ''"),
        (
            Elsewhere(),
            "no distance function 'weavesim.tools.shapes'; .* the full name of a module with a SHAPE",
        ),
        (Nowhere(), "no distance function 'no_such_package.cone'"),
        (BallWithoutRadius(), "has the dimensions none, but the distance function 'sphere' takes radius"),
    ],
)
def test_part_that_the_kernels_do_not_know_is_refused(shape, says):
    with pytest.raises(InputError, match=says):
        build_device_tools([Tool("tool", Union([Plane(), shape]))], wp.float64, "cpu")


def test_parts_and_kinds_are_those_of_all_tools():
    turned = Torus(0.02, 0.07, rotation=rotation_matrix((1.0, 0.0, 0.0), 0.3))
    tools = [Tool("one", Union([Sphere(0.03), turned])), Tool("other", Sphere(0.04, origin=(0.0, 0.0, 0.1)))]
    device = build_device_tools(tools, wp.float64, "cpu")
    tool, part = device.tool.numpy(), device.part.numpy()
    assert tool["first_part"].tolist() == [0, 2] and tool["part_count"].tolist() == [2, 1]
    assert part["radius"].tolist() == [0.03, 0.02, 0.04] and part["major_radius"].tolist() == [0.0, 0.07, 0.0]
    assert part["kind"].tolist() == [shape_number(name) for name in ("sphere", "torus", "sphere")]
    np.testing.assert_allclose(part["rotation"][1], turned.rotation)


def test_samples_must_tell_the_faces_of_the_sheet_apart():
    ball = Sphere(0.01).display_mesh()
    tools = [Tool("ball", MeshShape.from_triangles(ball.vertices, ball.faces, spacing=1e-3, reach=4e-3))]
    samples = sample_meshes(tools, "cpu", thickness=4e-3)
    device = build_device_tools(tools, wp.float32, "cpu", samples)
    assert device.samples == tuple(samples.values())
    assert device.part.numpy()["reach"].tolist() == [np.float32(4e-3)]
    with pytest.raises(InputError, match="ball 0: .* up to a distance of 0.004 m, but the sheet is 0.0041 m thick"):
        sample_meshes(tools, "cpu", thickness=4.1e-3)
