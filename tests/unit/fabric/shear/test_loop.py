"""Loops of known elastic moment and friction, with noise, are split into these; loading alone is not."""

import math

import numpy as np
import pytest

from tests.support.paths import ROOT
from weavesim import (
    Fabric,
    InputError,
    Origin,
    glass_polypropylene,
    glass_polypropylene_consensus,
    split_jump,
    split_loop,
)
from weavesim.fabric import LinearShear, MomentCurve, ShearFriction
from weavesim.fabric.presets import PRESETS
from weavesim.fabric.shear import unloading_doubt
from weavesim.measures.fabric_curves import unloading_of

TOP = math.radians(45.0)
CONSTANT = ShearFriction(stiffness=470.0, limit=(8.0,))
GROWING = ShearFriction(stiffness=900.0, limit=(4.0, 16.0), angle=(0.0, TOP))


def elastic(angle: np.ndarray) -> np.ndarray:
    return 20.0 * angle + 180.0 * angle**3


def loop(
    friction: ShearFriction, noise: float = 0.0, *, seed: int = 1, back: float = 0.0, cycles: int = 1, count: int = 250
) -> tuple[np.ndarray, np.ndarray]:
    """Angle and moment of a test from rest, up and down."""
    path = [np.linspace(0.0, TOP, count), np.linspace(TOP, back, count)]
    for _ in range(cycles - 1):
        path += [np.linspace(back, TOP, count), np.linspace(TOP, back, count)]
    angle = np.concatenate(path)
    moment = elastic(angle) + friction.moment_along(angle)
    return angle, moment + np.random.default_rng(seed).normal(0.0, noise, angle.shape)


def test_a_loop_without_noise_is_split_exactly():
    found = split_loop(*loop(CONSTANT))
    angle = np.linspace(0.05, TOP, 50)
    assert found.friction.limit_at(angle) == pytest.approx(8.0, abs=0.02)
    assert found.friction.stiffness == pytest.approx(470.0, rel=0.01)
    assert found.elastic.moment(angle) == pytest.approx(elastic(angle), abs=0.1)
    assert found.residual < 0.05 and found.notes == ()
    assert np.degrees(found.unloaded_between) == pytest.approx([0.0, 45.0])


def test_a_limit_that_grows_with_the_angle():
    found = split_loop(*loop(GROWING, 1.0))
    angle = np.radians([5.0, 15.0, 25.0, 35.0])
    assert found.friction.limit_at(angle) == pytest.approx(GROWING.limit_at(angle), abs=0.6)
    assert found.elastic.moment(angle) == pytest.approx(elastic(angle), abs=1.2)
    assert found.residual < 1.2 and found.noise == pytest.approx(1.0, rel=0.3)


def test_the_intervals_hold_what_they_promise():
    """95 % intervals of the limit and the stiffness over 12 loops with noise: at most two miss each."""
    inside_limit, inside_stiffness = 0, 0
    for seed in range(12):
        found = split_loop(*loop(CONSTANT, 1.5, seed=seed, count=150))
        assert found.limit_angle.shape == found.limit_error.shape
        if len(found.limit_error) == 1:
            inside_limit += abs(found.friction.limit[0] - 8.0) <= found.limit_error[0]
        else:
            inside_limit += np.all(np.abs(found.friction.limit_at(found.limit_angle) - 8.0) <= found.limit_error)
        low, high = found.stiffness_interval
        inside_stiffness += low <= 470.0 <= high
        assert found.friction.limit_at(np.array(0.4)) == pytest.approx(8.0, abs=0.6)
    assert inside_limit >= 10 and inside_stiffness >= 10


def test_noise_of_the_angle_is_no_change_of_direction():
    angle, moment = loop(CONSTANT, 0.5)
    found = split_loop(angle + np.random.default_rng(3).normal(0.0, math.radians(0.15), angle.shape), moment)
    assert found.friction.limit_at(np.array(0.4)) == pytest.approx(8.0, abs=0.3)
    assert found.elastic.moment(np.array(0.4)) == pytest.approx(elastic(np.array(0.4)), abs=0.6)


def test_a_slack_frame_ends_the_test():
    """A frame that cannot push reads zero below the angle at which the sheet stays."""
    angle, moment = loop(CONSTANT, 0.5, seed=4)
    falling = np.arange(len(angle)) > len(angle) // 2
    noise = np.random.default_rng(5).normal(0.0, 0.5, angle.shape)
    moment = np.where(falling & (elastic(angle) < 8.0), noise, moment)
    found = split_loop(angle, moment)
    assert found.friction.limit_at(np.array(0.4)) == pytest.approx(8.0, abs=0.4)
    assert "the frame is slack there" in found.notes[0]
    assert 15.0 < math.degrees(found.unloaded_between[0]) < 24.0


def test_several_cycles_that_stop_on_the_way_back():
    found = split_loop(*loop(CONSTANT, 1.0, back=math.radians(15.0), cycles=3))
    assert found.friction.limit_at(np.array(0.5)) == pytest.approx(8.0, abs=0.3)
    assert not any("slack" in note for note in found.notes)
    assert math.degrees(found.unloaded_between[0]) == pytest.approx(15.0, abs=0.2)


def test_a_specimen_that_was_sheared_before():
    """The second cycle alone starts with friction the other way round: from rest it does not fit."""
    angle, moment = loop(CONSTANT, 0.3, cycles=2, back=math.radians(5.0))
    second = slice(len(angle) // 2, None)
    found = split_loop(angle[second], moment[second], from_rest=False)
    assert found.friction.limit_at(np.array(0.4)) == pytest.approx(8.0, abs=0.3)
    assert found.residual < 0.5


def test_a_loop_without_height_is_elastic():
    angle = np.concatenate([np.linspace(0.0, TOP, 200), np.linspace(TOP, 0.0, 200)])
    moment = elastic(angle) + np.random.default_rng(2).normal(0.0, 1.0, angle.shape)
    found = split_loop(angle, moment)
    assert found.friction is None and any("all is elastic" in note for note in found.notes)
    assert found.elastic.moment(np.array(0.5)) == pytest.approx(elastic(np.array(0.5)), abs=1.0)


def test_a_loop_of_another_form_is_told():
    angle, moment = loop(CONSTANT, 0.05)
    falling = np.arange(len(angle)) >= len(angle) // 2
    found = split_loop(angle, np.where(falling, 0.6 * moment - 8.0 * np.sin(12.0 * angle), moment))
    assert any("its loop has another form" in note for note in found.notes)


def test_options_reach_both_laws():
    found = split_loop(*loop(CONSTANT), crossover_friction_length=1e-4, locking_angle=0.9)
    assert found.friction.crossover_friction_length == 1e-4 and found.elastic.locking_angle == 0.9


def wrong(name: str) -> tuple[np.ndarray, np.ndarray]:
    angle, moment = loop(CONSTANT)
    half = len(angle) // 2
    return {
        "loading only": (angle[:half], moment[:half]), "sorted by angle": (np.sort(angle), moment),
        "too few points": (angle[::40], moment[::40]), "columns of unequal length": (angle[:-1], moment),
        "unloading above loading": (angle, np.concatenate([moment[half:][::-1], moment[:half][::-1]])),
        "an offset of the angle": (angle - 0.2, moment), "texts": (np.array(["a"] * 50), np.array(["b"] * 50)),
    }[name]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("loading only", "there is no unloading in this test .*see split_jump"),
        ("sorted by angle", "there is no unloading"),
        ("too few points", "there is no unloading|20 points"),
        ("columns of unequal length", "the same number of values"),
        ("unloading above loading", "unloading lies above loading"),
        ("an offset of the angle", "angle is down to -11.5 degrees: subtract the offset"),
        ("texts", "a list of finite numbers is needed"),
    ],
)
def test_what_is_no_loop_is_refused(name, message):
    with pytest.raises(InputError, match=message):
        split_loop(*wrong(name))


def test_a_jump_is_taken_as_friction():
    angle = np.radians(np.arange(1.0, 41.0))
    moment = 6.0 + 30.0 * angle
    values, friction = split_jump(angle, moment, line=np.radians([2.0, 10.0]), onset=math.radians(1.0))
    assert friction.limit == pytest.approx((6.0,)) and friction.stiffness == pytest.approx(6.0 / math.radians(1.0))
    assert values == pytest.approx(30.0 * angle) and values + friction.moment_along(angle) == pytest.approx(moment)
    with pytest.raises(InputError, match="at least three points"):
        split_jump(angle, moment, line=np.radians([2.0, 3.0]), onset=0.02)
    with pytest.raises(InputError, match="there is no jump"):
        split_jump(angle, moment - 7.0, line=np.radians([2.0, 10.0]), onset=0.02)


def test_who_knows_what_unloading_does():
    fabric = glass_polypropylene()
    measured = MomentCurve(angle=(0.0, 0.5), moment_values=(0.0, 30.0))

    def doubt(**values) -> str:
        return unloading_doubt(Fabric.model_copy(fabric, update=values))

    for name, make in PRESETS.items():
        assert ("assumed" in unloading_doubt(make())) != name.startswith("assumed")  # these claim nothing
    assert "jumps up within the first degree" in unloading_doubt(glass_polypropylene_consensus())
    assert doubt(provenance=()).startswith("no unloading is known: all of the measured moment is taken as elastic")
    assert doubt(shear=measured, provenance=()).startswith("no unloading")
    # a law that nobody measured is what it says; friction that somebody gave is taken as known
    assert doubt(shear=LinearShear(modulus=1e5), provenance=()) == ""
    assert doubt(shear_friction=CONSTANT, provenance=()) == ""
    known = Origin(of="shear_friction", source="loop of our own frame: closed within its noise")
    assert doubt(provenance=(known,)) == ""
    guess = Origin(of="shear_friction", source="a guess", assumed=True)
    assert doubt(shear_friction=CONSTANT, provenance=(guess,)) == "a guess"


def test_the_example_of_the_documentation(capsys):
    page = (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")
    code = page.split("## Loading and unloading")[1].split("```python\n")[1].split("```")[0]
    angle, moment = loop(CONSTANT, 0.5)
    force = moment * 0.2**2 / (0.25 * np.sin(np.pi / 4 - angle / 2))
    names = {"np": np, "angle": angle, "force": force, "frame_side": 0.25, "fabric_side": 0.2}
    names["fabric"] = glass_polypropylene()
    exec(code, names)
    assert names["fabric"].shear_friction.limit_at(0.4) == pytest.approx(8.0, abs=0.3)
    assert "[" in capsys.readouterr().out


def test_what_the_documentation_says_of_the_consensus():
    """Let go at 45 degrees: 11 degrees are left, and 38 % of the work is lost."""
    found = unloading_of(glass_polypropylene_consensus(), math.radians(45.0))
    assert math.degrees(found.residual_angle) == pytest.approx(11.0, abs=0.5)
    assert found.lost_share == pytest.approx(0.38, abs=0.005)
