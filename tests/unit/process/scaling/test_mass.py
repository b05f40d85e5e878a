"""What a search for a mass scaling says of itself."""

import pytest

from weavesim.errors import InputError
from weavesim.process.scaling.mass import MassScaling, ScalingTry


def tried(factor: float, accepted: bool, angle: float | None = 0.2) -> ScalingTry:
    return ScalingTry(
        factor=factor, angle_error=angle, draw_in_error=None if angle is None else 1e-4, kinetic_ratio=0.3,
        speed_up=factor, accepted=accepted,
    )  # fmt: skip


def found(*tries: ScalingTry, factor: float = 1.0, step: float | None = None) -> MassScaling:
    return MassScaling(
        factor=factor, target_step=step, mesh_size=0.004, coarse_size=0.006, angle_tolerance=0.5,
        draw_in_tolerance=5e-4, tries=tries,
    )  # fmt: skip


def test_it_tells_what_was_tried_and_chosen():
    scaling = found(tried(2.0, True), tried(3.0, False), factor=2.0, step=4e-6)
    text = scaling.report()
    assert "0.5 degrees at 95% of the elements and 0.5 mm of draw-in, tried on elements of 6 mm" in text
    assert "step x 2 (mass x 4): 0.2 degrees, 0.1 mm, 2.0 times fewer steps" in text and "0.3: kept" in text
    assert "step x 3 (mass x 9)" in text and text.endswith("chosen: step x 2, target_step = 4e-06 s")
    assert MassScaling.from_json(scaling.to_json()) == scaling


def test_without_a_scaling_that_is_kept_it_says_so():
    text = found(tried(2.0, False, angle=None)).report()
    assert "step x 2 (mass x 4): the run stopped: too much" in text and text.endswith("run without")


def test_the_summary_has_units_in_its_names():
    told = found(tried(2.0, True), factor=2.0, step=4e-6).as_told()
    assert set(told) == {
        "factor", "target_step_s", "mesh_size_m", "coarse_mesh_size_m", "angle_tolerance_deg", "draw_in_tolerance_m",
        "kept_share", "tries",
    }  # fmt: skip
    (entry,) = told["tries"]
    assert entry["angle_error_deg"] == 0.2 and entry["draw_in_error_m"] == 1e-4 and entry["accepted"] is True


def test_errors_that_look_like_radians_are_taken():
    """They were measured, not typed."""
    assert tried(2.0, True, angle=0.3490658503988659).angle_error == 0.3490658503988659


def test_a_factor_below_one_is_refused():
    with pytest.raises(InputError, match="factor"):
        found(factor=0.5)
