"""What the kernels of a set-up are made for."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_setup
from weavesim.engine.traits import node_traits, sheet_traits, waiting
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads
from weavesim.process.stages import Move, Stage
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Support
from weavesim.sheet.blank import Blank
from weavesim.sheet.geometry import ElementGeometry
from weavesim.tools.shapes import Sphere, Torus, Union, rotation_matrix
from weavesim.tools.tool import Tool

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)


def of_nodes(**given):
    setup = one_sheet_setup(
        name="t", blank=BLANK, fabric=glass_polypropylene(), duration=1.0, accept_unusual=True, **given
    )
    return node_traits(setup.sheet, setup.worlds[0])


def test_kinds_are_those_of_all_parts_of_all_tools():
    turned = Torus(0.02, 0.07, rotation=rotation_matrix((1.0, 0.0, 0.0), 0.3))
    tools = (Tool("one", Union([Sphere(0.03), turned])), Tool("other", Sphere(0.04, origin=(0.0, 0.0, 0.1))))
    assert of_nodes(tools=tools).shape_kinds == ("sphere", "torus")
    assert of_nodes(tools=tools).rotated and not of_nodes(tools=tools[1:]).rotated
    assert of_nodes().shape_kinds == ()


def test_traits_state_what_acts_on_the_nodes():
    assert not of_nodes().loaded and not of_nodes().supported and not of_nodes().follows_thickness
    assert of_nodes(loads=NodalLoads(force=np.zeros((9, 3)))).loaded
    assert of_nodes(supports=(Support("edge", [0]),)).supported
    assert of_nodes(dynamics=Dynamics(contact_thickness="current")).follows_thickness


@pytest.mark.parametrize(("distortion", "skewed"), [(0.0, False), (0.2, True)])
def test_traits_state_the_shape_of_the_mesh(distortion, skewed):
    flat = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005, distortion=distortion)
    bent = Blank.from_mesh(flat.node_position + np.outer(flat.node_position[:, 0] ** 2, (0.0, 0.0, 3.0)), flat.quads)
    for blank, is_flat in ((flat, True), (bent, False)):
        traits = sheet_traits(glass_polypropylene(), ElementGeometry.of(blank), Dynamics())
        assert traits.flat == is_flat and traits.skewed == skewed


@pytest.mark.parametrize(
    ("own", "later", "expected"),
    [(None, (), (False,)), (5.0, (), (True,)), (None, (None,), (False,)), (None, (5.0,), (False, True)),
     (5.0, (None,), (False, True))],
)  # fmt: skip
def test_strokes_with_a_largest_force_take_a_kernel_of_their_own(own, later, expected):
    """Of any stage: each has the kernel of its own strokes."""

    def stroke(force: float | None) -> Stroke:
        return Stroke((0.0, 0.1), (0.0, 0.01), largest_force=force)

    tools = (Tool("ball", Sphere(0.03, origin=(0.0, 0.0, 0.05)), stroke(own), axis=(0.0, 0.0, -1.0)),)
    setup = one_sheet_setup(
        name="t", blank=BLANK, fabric=glass_polypropylene(), duration=0.1, accept_unusual=True, tools=tools
    )
    stages = tuple(Stage(f"{k}", 0.1, moves=(Move("ball", stroke(force)),)) for k, force in enumerate(later))
    assert waiting(setup.model_copy(update={"stages": stages})) == expected
