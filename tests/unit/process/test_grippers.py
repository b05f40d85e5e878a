"""Grippers that cannot be are refused, by name, and before a run."""

import numpy as np
import pytest

from weavesim import Setup, Sheet
from weavesim.errors import InputError
from weavesim.fabric import glass_polypropylene
from weavesim.process.grippers import Gripper
from weavesim.process.motions.paths import PathMotion, Rotation
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.sheet.blank import Blank

EDGE = np.array([0, 1, 2])
WAY = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.1))
TURN = Rotation((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.0), (0.0, 10.0))
OUT = (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Gripper("jaw", np.array([], dtype=int), OUT, 1e3), "one or more nodes"),
        (lambda: Gripper("jaw", np.array([1, 1]), OUT, 1e3), "list each node once"),
        (lambda: Gripper("jaw", EDGE, (0.0, 0.0, 0.0), 1e3), "direction"),
        (lambda: Gripper("jaw", EDGE, OUT, 0.0), "stiffness = 0.0"),
        (lambda: Gripper("jaw", EDGE, OUT, 1e3, length=0.0), "length = 0.0"),
        (lambda: Gripper("jaw", EDGE, OUT), "stiffness: is required"),
        (
            lambda: Gripper("jaw", EDGE, OUT, 1e3, pretension=5.0, largest_force=4.0),
            "5 N slips at a largest_force of 4 N",
        ),
        (lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=ForceDriven.constant(1.0, 1.0)), "a Stroke without"),
        (lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=Stroke((0.0,), (0.1,))), "must start from 0"),
        (
            lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=PathMotion((0.0,), ((0.0, 0.0, 0.1),))),
            r"0.1 m away at time zero; it must start from 0",
        ),
        (
            lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=PathMotion(rotation=TURN)),
            "a PathMotion of these without a rotation",
        ),
        (
            lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=PathMotion((0.0, 1.0), WAY, at_rest=False)),
            "at rest at its ends",
        ),
        (
            lambda: Gripper("jaw", EDGE, OUT, 1e3, motion=PathMotion(along=ForceDriven.constant(1.0, 1.0))),
            "a Stroke without",
        ),
        (lambda: Gripper("jaw", EDGE, OUT, 1e3, release_time=0.0), "release_time = 0.0"),
    ],
)
def test_bad_grippers_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def gripped(*grippers: Gripper, name: str = "sheet") -> Sheet:
    return Sheet(Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005), glass_polypropylene(), name, grippers=grippers)


def test_nodes_that_cannot_be_gripped_are_named():
    with pytest.raises(InputError, match="gripper jaw: nodes go from 0 to 25; the blank has 25 nodes"):
        gripped(Gripper("jaw", np.array([0, 25]), OUT, 1e3))
    with pytest.raises(InputError, match="gripper right: node 2 is also held by left"):
        gripped(Gripper("left", EDGE, OUT, 1e3), Gripper("right", np.array([2, 3]), OUT, 1e3))


def test_two_grippers_of_a_run_have_two_names():
    sheets = tuple(gripped(Gripper("jaw", EDGE, OUT, 1e3), name=name) for name in ("a", "b"))
    with pytest.raises(InputError, match="grippers: the name 'jaw'"):
        Setup("two", sheets=sheets, duration=1.0)


def test_a_gripper_that_holds_has_no_limit():
    assert Gripper("jaw", EDGE, OUT, 1e3).limit == np.inf
    assert Gripper("jaw", EDGE, OUT, 1e3, largest_force=2.0).limit == 2.0


def test_a_path_is_added_to_the_stroke():
    motion = PathMotion((0.0, 1.0), WAY, along=Stroke((0.0, 2.0), (0.0, 0.04)))
    gripper = Gripper("jaw", EDGE, OUT, 1e3, motion=motion)
    assert gripper.way_at(0.0).tolist() == [0.0, 0.0, 0.0] and gripper.way_at(2.0) == pytest.approx([0.04, 0.0, 0.1])
    times, values = gripper.anchor_curve()
    assert times[0] == 0.0 and times[-1] == 2.0 and (np.diff(times) > 0.0).all()
    # smooth: slow at both ends, half way in the middle
    at = [np.interp([0.1, 0.5, 0.9], times, values[:, c]) for c in range(3)]
    assert at[0] == pytest.approx([0.002, 0.01, 0.018]) and at[2] == pytest.approx([0.0028, 0.05, 0.0972], abs=1e-4)
