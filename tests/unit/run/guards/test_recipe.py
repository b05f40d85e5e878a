"""The recipe of CONTRIBUTING for a guard, verbatim: it speaks of a fast sheet, and is silent about a slow one."""

import numpy as np
import pytest

from tests.support.kinds import imported
from tests.support.recipes import written_recipe
from tests.support.runs import small_run
from weavesim.run.guards import Level, known_guards
from weavesim.run.guards import guard as guard_module


@pytest.fixture
def speed(tmp_path):
    before = dict(known_guards())
    imported(written_recipe("speed.py", tmp_path), pytest.MonkeyPatch())
    yield
    guard_module._known.clear()
    guard_module._known.update(before)


def thrown(speed: float) -> list:
    velocity = np.zeros((25, 3))
    velocity[:, 2] = speed
    simulation = small_run(initial_velocity=velocity, duration=1e-4)
    simulation.run()
    return [doubt for doubt in simulation.doubts() if doubt.guard == "fast_sheet"]


def test_the_recipe_of_a_guard(speed):
    (doubt,) = thrown(20.0)
    assert doubt.level == Level.WARNING and doubt.value == pytest.approx(20.0, rel=0.01)
    assert 0.0 < doubt.time <= 2e-4 and doubt.sheet == "sheet"
    assert thrown(1.0) == []
