"""Tools across a plane of symmetry that are not their own mirror images are refused, or warned of."""

import numpy as np
import pytest
import trimesh

from tests.support.runs import small_run
from weavesim import ForceDriven, InputError, PathMotion, Stroke, Tool
from weavesim.process.motions.paths import Rotation
from weavesim.run.guards import Level
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Sphere, Union

AWAY = -0.012 - 0.0006  # the middle of a ball that touches a sheet of 1.2 mm from below


def ball(x=0.0, y=0.0, motion=None, axis=(0.0, 0.0, 1.0)):
    return Tool("ball", Sphere(0.012, origin=(x, y, AWAY)), motion or Stroke((0.0, 1e-5), (0.0, 1e-4)), axis=axis)


def found(tool, symmetry=("x",), **given):
    run = small_run(tools=[tool], symmetry=symmetry, **given)
    return [doubt for doubt in run.doubts() if doubt.guard == "tool_symmetry"]


@pytest.mark.parametrize("symmetry", [("x",), ("y",), ("x", "y")])
def test_a_ball_on_the_planes_is_silent(symmetry):
    assert not found(ball(), symmetry)


def test_a_ball_beside_the_plane_is_none_of_its_business():
    assert not found(Tool("ball", Sphere(0.004, origin=(0.01, 0.01, -0.0046)), Stroke((0.0, 1e-5), (0.0, 1e-4))))


def test_a_tool_off_the_plane_is_refused_with_its_place_and_can_be_accepted():
    # on a slope of one half the surface is off by half of twice the shift
    with pytest.raises(InputError, match=r"ball: at \(.*\) mm it is .* mm off its mirror image at the plane .* x = 0"):
        found(ball(x=0.003))
    (doubt,) = found(ball(x=0.003), accept_unusual=True)
    assert doubt.level == Level.WARNING and doubt.value > 5 * doubt.limit
    assert not found(ball(y=0.003))  # another plane


def test_what_lies_deep_in_another_part_of_the_tool_is_silent():
    """As the lower pole of the dome of the scene diaphragm: its table is all below its middle."""
    dome = Union((Sphere(0.012, origin=(0.0, 0.0, AWAY)), Plane(origin=(0.0, 0.0, AWAY))))
    assert not found(Tool("dome", dome), ("x", "y"))


def test_a_small_shift_is_within_the_tolerance():
    assert not found(ball(x=1e-4))


@pytest.mark.parametrize(
    "motion",
    [
        PathMotion((0.0, 1e-5), ((0.0, 0.0, 0.0), (0.004, 0.0, 0.0))),
        Stroke((0.0, 1e-5), (0.0, 6e-3)),
    ],
    ids=["path", "leaning axis"],
)
def test_a_tool_that_moves_off_the_plane_is_refused(motion):
    leaning = isinstance(motion, Stroke)
    with pytest.raises(InputError, match="off its mirror image"):
        found(ball(motion=motion, axis=(0.6, 0.0, 0.8) if leaning else (0.0, 0.0, 1.0)))


def test_what_ends_a_little_beyond_the_plane_is_silent():
    corners = np.array([[-0.003, -0.01, 0.0], [0.03, -0.01, 0.0], [0.03, 0.03, 0.0], [-0.003, 0.03, 0.0]])
    plate = MeshShape.from_triangles(
        corners, np.array([[0, 1, 2], [0, 2, 3]]), spacing=1e-3, reach=4e-3, origin=(0.0, 0.0, -0.0006)
    )
    assert not found(Tool("plate", plate))


def test_turning_about_the_normal_of_the_plane_is_symmetric():
    def turning(axis):
        roll = Rotation(axis, (0.0, 0.0, AWAY), (0.0, 1e-5), (0.0, 20.0))
        corners = np.array([[-0.02, -0.02, 0.0], [0.02, -0.02, 0.0], [0.02, 0.02, 0.0], [-0.02, 0.02, 0.0]])
        plate = MeshShape.from_triangles(
            corners, np.array([[0, 1, 2], [0, 2, 3]]), spacing=1e-3, reach=4e-3, origin=(0.0, 0.0, -0.009)
        )
        return Tool("plate", plate, PathMotion(rotation=roll))

    assert not found(turning((1.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="off its mirror image"):
        found(turning((0.0, 1.0, 0.0)))


def test_the_back_of_a_punch_may_be_uneven_however_far_it_is_drawn():
    block = trimesh.creation.box(extents=(0.06, 0.06, 0.01))
    step = trimesh.creation.box(extents=(0.02, 0.06, 0.005))
    step.apply_translation((-0.02, 0.0, 0.0074))
    both = trimesh.boolean.union([block, step])
    punch = MeshShape.from_triangles(
        np.asarray(both.vertices), np.asarray(both.faces), spacing=1e-3, reach=4e-3, origin=(0.0, 0.0, 0.0056)
    )
    down = (0.0, 0.0, -1.0)
    for stroke in (1e-4, 0.02):
        assert not found(Tool("punch", punch, Stroke((0.0, 1e-5), (0.0, stroke)), axis=down), accept_unusual=True)
    turned = MeshShape.from_triangles(
        np.asarray(both.vertices) * (1, 1, -1), np.asarray(both.faces)[:, ::-1], spacing=1e-3, reach=4e-3,
        origin=(0.0, 0.0, 0.0106),
    )  # fmt: skip
    with pytest.raises(InputError, match="off its mirror image"):
        found(Tool("punch", turned, Stroke((0.0, 1e-5), (0.0, 0.02)), axis=down))


def test_a_pair_of_tools_is_its_own_mirror_image():
    def clamp(name, x):
        return Tool(name, Sphere(0.004, origin=(x, 0.01, -0.0046)), Stroke((0.0, 1e-5), (0.0, 1e-4)))

    def doubts(*tools):
        run = small_run(tools=tools, symmetry=("x",))
        return [doubt for doubt in run.doubts() if doubt.guard == "tool_symmetry"]

    assert not doubts(clamp("right", 0.01), clamp("left", -0.01))
    with pytest.raises(InputError, match="left: at .* off its mirror image"):
        doubts(clamp("right", 0.01), clamp("left", -0.007))
    with pytest.raises(InputError, match="left: at .* off its mirror image"):
        doubts(clamp("left", -0.01))


def test_a_tool_that_comes_from_beside_or_goes_there_is_looked_at_over_the_sheet():
    def carried(begin, end):
        path = PathMotion((0.0, 1e-5), ((begin, 0.0, 0.0), (end, 0.0, 0.0)))
        return Tool("ball", Sphere(0.004, origin=(0.0, 0.01, -0.0046)), path)

    with pytest.raises(InputError, match="off its mirror image"):
        found(carried(0.1, -0.005))
    assert not found(carried(0.02, 0.12))


def test_a_force_along_a_leaning_axis_moves_off_the_plane():
    force = ForceDriven.constant(1.0, 1e-3)
    assert not found(ball(motion=force))
    with pytest.raises(InputError, match="off its mirror image"):
        found(ball(motion=force, axis=(0.6, 0.0, 0.8)))
