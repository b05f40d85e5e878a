"""Distances from the tools of a run, and the deepest point of elements in a body."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.process.strokes import Stroke
from weavesim.run.watch.tool_distance import ToolDistances, deepest_point
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, Sphere, Union
from weavesim.tools.tool import Tool

BLANK = Blank.rectangle((0.0, 0.0), (0.05, 0.05), 0.01)
CORNERS = BLANK.node_position[BLANK.quads]


def ball(x: float, y: float, z: float, radius: float):
    return lambda points: np.linalg.norm(points - (x, y, z), axis=1) - radius


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_distances_are_those_of_each_tool_where_it_is(precision):
    tools = [
        Tool("table", Plane(origin=(0.0, 0.0, -0.002)), Stroke((0.0, 1.0), (0.0, 0.01))),
        Tool("balls", Union([Sphere(0.01, origin=(0.0, 0.0, -0.1)), Sphere(0.02, origin=(0.1, 0.0, -0.1))])),
    ]
    distances = ToolDistances(small_run(tools=tools, precision=precision).model)
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (37, 3))
    for index, displacement in ((0, 0.0), (0, 0.003), (1, -0.01)):
        found, normal = distances(index, displacement, points)
        wanted, outward = tools[index].distance(points, displacement)
        assert found == pytest.approx(wanted, abs=1e-7) and normal == pytest.approx(outward, abs=1e-4)


@pytest.mark.parametrize(
    ("place", "radius"), [((0.023, 0.017), 0.0015), ((0.0301, 0.0299), 0.0004), ((0.049, 0.001), 0.001)]
)
def test_a_small_body_between_the_nodes_is_found_with_its_depth(place, radius):
    """A ball through the plane of the sheet, far smaller than its elements."""
    x, y = place
    body = ball(x, y, 0.2 * radius, radius)
    found = deepest_point(body, CORNERS, 0.0, 1e-4)
    assert found.distance == pytest.approx(-0.8 * radius, abs=1e-4)
    centre = BLANK.element_centres()[found.element]
    assert np.abs(centre[:2] - place).max() <= 0.005


def test_a_body_that_is_not_near_is_not_found():
    assert deepest_point(ball(0.02, 0.02, 0.011, 0.01), CORNERS, 0.0, 1e-4).element is None
    assert deepest_point(ball(0.02, 0.02, 0.011, 0.01), CORNERS, 0.002, 1e-4).distance == pytest.approx(0.001, abs=1e-5)


def test_it_is_that_of_a_dense_search_on_a_bent_sheet():
    random = np.random.default_rng(1)
    position = BLANK.node_position + random.uniform(-1.0, 1.0, BLANK.node_position.shape) * 0.003
    corners = position[BLANK.quads]
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 81), np.linspace(-1.0, 1.0, 81))
    weight = 0.25 * np.stack([(1 - u) * (1 - v), (1 + u) * (1 - v), (1 + u) * (1 + v), (1 - u) * (1 + v)], axis=-1)
    dense = np.einsum("ijc,eck->eijk", weight, corners).reshape(-1, 3)
    for _ in range(20):
        body = ball(*random.uniform(0.0, 0.05, 2), 0.0, random.uniform(0.001, 0.004))
        wanted, found = body(dense).min(), deepest_point(body, corners, 0.0, 5e-5)
        assert found.distance == pytest.approx(min(wanted, 0.0), abs=1e-4)
