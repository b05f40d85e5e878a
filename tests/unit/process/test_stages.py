"""Stages as values: what they take, and what they refuse."""

import pytest

from weavesim import AtForce, AtRest, AtStroke, Fixed, Move, Stage, Stroke
from weavesim.errors import InputError


def test_a_mapping_gives_moves():
    stroke = Stroke((0.0, 1.0), (0.0, 0.1))
    stage = Stage("close", 1.0, moves={"punch": stroke, "die": Fixed()})
    assert stage.moves == (Move("punch", stroke), Move("die", Fixed()))
    assert stage == Stage.from_json(stage.to_json()) and stage.changes == {}


def test_what_a_stage_says_is_told():
    stage = Stage("hold", 1.0, tools=(), damping=0.0, gravity=(0.0, 0.0, -9.81))
    assert stage.changes == {"tools": (), "damping": 0.0, "gravity": (0.0, 0.0, -9.81)}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Stage("a", 0.0), "duration = 0.0: a number above 0"),
        (lambda: Stage("a", 1.0, end="rest"), "one of AtStroke, AtForce, AtRest is needed"),
        (lambda: Stage("a", 1.0, tools="punch"), "give a list"),
        (lambda: Stage("a", 1.0, frame_count=0), "at least 1"),
        (lambda: Stage("a", 1.0, moves=(Move("b", Fixed()), Move("b", Fixed()))), "b is moved twice"),
        (lambda: AtStroke("punch", 0.0), "other than 0"),
        (lambda: AtForce("punch", 0.0), "above 0"),
        (lambda: AtRest(0.0), "above 0"),
        (lambda: Stage("a", 1.0, stage="b"), "unknown name"),
    ],
)
def test_bad_stages_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_ends_are_reached_on_their_side():
    assert AtStroke("a", 0.01).reached(0.01) and not AtStroke("a", 0.01).reached(-0.02)
    assert AtStroke("a", -0.01).reached(-0.01) and not AtStroke("a", -0.01).reached(0.02)
    assert AtForce("a", 5.0).reached(-5.0) and AtForce("a", 5.0).reached(6.0) and not AtForce("a", 5.0).reached(4.9)
    rest = AtRest(1e-3, 0.1)
    # half of m v^2 is 5e-3 J
    assert rest.reached(0.9e-3, 1.0, 1.0) and not rest.reached(1.1e-3, 1.0, 1.0) and not rest.reached(6e-3, 100.0, 1.0)
