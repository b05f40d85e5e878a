"""The largest mass scaling that keeps a stated error."""

import pytest

from weavesim.engine.model import Model
from weavesim.engine.setup import Setup, Solver
from weavesim.errors import InputError
from weavesim.fabric import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import Stroke
from weavesim.run.scaling.mass import COARSENING, choose_mass_scaling
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

SIZE = 0.008


def pressed(mesh_size: float, target_step: float | None) -> Setup:
    """A quarter of a small free sheet that a ball pushes."""
    fabric = glass_polypropylene()
    half = 0.5 * fabric.thickness
    ball = Tool("ball", Sphere(0.02, origin=(0.0, 0.0, 0.02 + half)), Stroke.smooth(0.006, 0.5, 4e-3),
                axis=(0.0, 0.0, -1.0))  # fmt: skip
    return Setup(
        "pressed", sheets=(Sheet(Blank.rectangle((0.0, 0.0), (0.036, 0.036), mesh_size), fabric),),
        tools=(ball,), symmetry=("x", "y"), duration=0.02, frame_count=1,
        dynamics=Dynamics(damping=100.0),
        solver=Solver(precision="float64", lane_count=1, threads=1, target_step=target_step),
    )  # fmt: skip


def test_the_largest_factor_within_both_tolerances_is_chosen():
    found = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.05, factors=(1.5, 2.0))
    assert [each.accepted for each in found.tries] == [True, True] and found.factor == 2.0
    assert found.coarse_size == pytest.approx(COARSENING * SIZE)
    assert found.tries[1].speed_up == pytest.approx(2.0, rel=0.1)
    # the step of the run itself, not that of the coarse mesh
    assert found.target_step == pytest.approx(2.0 * Model(pressed(SIZE, None)).reference_step)
    text = found.report()
    assert "chosen: step x 2" in text and "step x 1.5 (mass x 2.25)" in text


def test_the_search_ends_where_a_tolerance_is_lost():
    errors = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.05, factors=(2.0, 6.0)).tries
    assert errors[1].angle_error > errors[0].angle_error > 0.0 < errors[0].draw_in_error
    between = 0.5 * (errors[0].angle_error + errors[1].angle_error)
    found = choose_mass_scaling(
        pressed, SIZE, angle_tolerance=between, draw_in_tolerance=0.05, factors=(2.0, 6.0, 9.0)
    )  # fmt: skip
    assert [each.accepted for each in found.tries] == [True, False] and found.factor == 2.0
    assert "too much" in found.report()
    found = choose_mass_scaling(pressed, SIZE, draw_in_tolerance=1e-12, factors=(2.0, 6.0))
    assert found.target_step is None and found.factor == 1.0 and "no scaling keeps" in found.report()


@pytest.mark.parametrize("given", [{"factors": ()}, {"factors": (1.0, 2.0)}, {"factors": (3.0, 2.0)}])
def test_factors_that_cannot_be_are_refused(given):
    with pytest.raises(InputError, match="increasing numbers above 1"):
        choose_mass_scaling(pressed, SIZE, **given)
    with pytest.raises(InputError, match="angle_tolerance"):
        choose_mass_scaling(pressed, SIZE, angle_tolerance=0.0)
