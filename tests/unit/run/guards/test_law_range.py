"""Guard of laws that are used beyond their data: with the share of elements and the largest excess."""

import math

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.fabric import BendingCurve, MomentCurve, Origin, ShearFriction, YarnBending, glass_polypropylene
from weavesim.kernels.rows import ExtremeRow
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.run.guards import Level
from weavesim.run.guards.law_range import beyond_data
from weavesim.sheet.blank import Blank


def fabric(**values):
    return glass_polypropylene().model_copy(update=values)


CURVE = MomentCurve(angle=(0.0, 0.1, 0.2), moment_values=(0.0, 2.0, 6.0))
BENT = BendingCurve(curvature=(0.0, 10.0, 20.0), moment_values=(0.0, 0.02, 0.03))


def rows(**values):
    result = np.zeros((ExtremeRow.row_count(), 4))
    for name, value in values.items():
        result[ExtremeRow[name]] = value
    return result


@pytest.mark.parametrize(
    ("values", "extremes", "found"),
    [
        ({"shear": CURVE}, {"angle": [0.1, 0.25, 0.3, 0.0]}, [("the shear law", 0.5, 0.3, 2)]),
        ({"shear": CURVE}, {"angle": [0.1, 0.2, 0.1, 0.0]}, []),
        ({"shear": CURVE.model_copy(update={"extrapolation": "trusted"})}, {"angle": 1.0}, []),
        ({}, {"angle": math.radians(54.9)}, []),
        ({}, {"angle": math.radians(56.0)}, [("the shear law", 1.0, math.radians(56.0), 0)]),
        (
            {"shear_friction": ShearFriction(stiffness=40.0, limit=(0.1, 0.5), angle=(0.0, 0.2))},
            {"angle": [0.0, 0.0, 0.0, 0.3]},
            [("the shear friction", 0.25, 0.3, 3)],
        ),
        ({"shear_friction": ShearFriction(stiffness=40.0, limit=(0.1,))}, {"angle": 0.3}, []),
        (
            {"bending": YarnBending(warp=BENT, weft=1e-3, twist=0.0)},
            {"warp_curvature": [0.0, 30.0, 0.0, 0.0], "weft_curvature": 100.0},
            [("the bending curve of the warp", 0.25, 30.0, 1)],
        ),
        (
            {"bending": YarnBending(warp=1e-3, weft=BENT, twist=0.0)},
            {"weft_curvature": 25.0},
            [("the bending curve of the weft", 1.0, 25.0, 0)],
        ),
    ],
)
def test_share_and_largest_value_are_those_of_the_elements(values, extremes, found):
    laws = beyond_data(fabric(**values), rows(**extremes))
    assert [(law.what, law.share, law.largest, law.element) for law in laws] == found


def sheared(angle: float, frame_count: int = 1, back: bool = False, **values):
    """A square that is sheared as a whole, and back."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    y = blank.node_position[:, 1]
    stroke = SmoothStroke.ramped(0.02 * math.tan(angle), 5.0, 1e-3)
    drive = Drive(stroke.and_back(1e-4) if back else stroke, np.column_stack([y / 0.02, 0.0 * y, 0.0 * y]))
    everywhere = Support("frame", np.arange(blank.node_count), (drive,))
    simulation = small_run(
        blank=blank, fabric=fabric(**values), supports=(everywhere,), duration=drive.motion.duration,
        frame_count=frame_count,
    )  # fmt: skip
    simulation.run()
    return simulation


@pytest.mark.parametrize(
    ("angle", "level"), [(0.15, None), (0.25, Level.WARNING), (0.5, Level.DO_NOT_USE), (0.9, Level.DO_NOT_USE)]
)
def test_a_sheet_sheared_beyond_the_data_says_so(angle, level):
    run = sheared(angle, shear=CURVE)
    doubts = [doubt for doubt in run.doubts() if doubt.guard == "law_range"]
    if level is None:
        assert doubts == [] and run.summary()["share_beyond_data"] == 0.0
        return
    (doubt,) = doubts
    assert doubt.level == level
    assert doubt.value == pytest.approx(angle, rel=1e-3) and doubt.limit == 0.2
    assert f"measured up to 11.46° and used up to {math.degrees(angle):.4g}°" in doubt.text
    assert "100.00% of the elements" in doubt.text
    assert run.summary()["share_beyond_data"] == 1.0


def test_it_does_not_depend_on_the_frames():
    few, many = (sheared(0.4, frame_count, back=True, shear=CURVE) for frame_count in (1, 20))
    for run in (few, many):
        (doubt,) = (doubt for doubt in run.doubts() if doubt.guard == "law_range")
        assert doubt.value == pytest.approx(0.4, rel=1e-3)


def test_a_sheet_bent_beyond_the_data_says_so():
    """A strip that is rolled up by its supports to a radius of 25 mm: 40 1/m."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.005), 0.001)
    x = blank.node_position[:, 0]
    radius = 0.025
    place = np.column_stack([radius * np.sin(x / radius) - x, 0.0 * x, radius * (1.0 - np.cos(x / radius))])
    drive = Drive(SmoothStroke.ramped(1.0, 200.0, 1e-3), place)
    bending = YarnBending(warp=BENT, weft=BENT, twist=1e-4)
    simulation = small_run(
        blank=blank, fabric=fabric(bending=bending), duration=8e-3, accept_unusual=True,
        supports=(Support("roll", np.arange(blank.node_count), (drive,), rotations=""),),
    )  # fmt: skip
    simulation.run()
    (doubt,) = (doubt for doubt in simulation.doubts() if doubt.guard == "law_range")
    assert "the bending curve of the warp was measured up to 20 1/m" in doubt.text
    assert doubt.value == pytest.approx(40.0, rel=0.3)


KNOWN = Origin(of="shear_friction", source="a loop of our own frame")


@pytest.mark.parametrize(
    ("back", "values", "said"),
    [
        (True, {}, "assumed: no unloading was published; all of the moment is taken as elastic"),
        (True, {"shear": CURVE, "provenance": ()}, "no unloading is known: all of the measured moment"),
        (True, {"provenance": (KNOWN,)}, None),
        (False, {}, None),
    ],
)
def test_shear_that_goes_back_on_an_assumption_is_noted(back, values, said):
    run = sheared(0.15, back=back, **values)
    doubts = [doubt for doubt in run.doubts() if doubt.guard == "unloading"]
    if said is None:
        assert doubts == []
        return
    (doubt,) = doubts
    assert doubt.level == Level.NOTE and doubt.value == 1.0
    assert (
        said in doubt.text and "100% of the elements went back in shear by more than 2°, by up to 8.59°" in doubt.text
    )
