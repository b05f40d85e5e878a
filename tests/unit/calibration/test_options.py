"""Options of a calibration that contradict each other are refused before anything is read."""

import pytest

from weavesim.calibration import CalibrationOptions, calibrate
from weavesim.errors import InputError


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "nothing to calibrate with: give at least one of biaxial, picture_frame"),
        ({"bias_extension": "b.csv"}, "bias_extension needs the strip: give bias_length and bias_width"),
        ({"bias_extension": "b.csv", "bias_length": 0.2, "bias_width": 0.15}, "at least twice the width"),
        ({"picture_frame": "p.csv", "frame_side": 0.1, "fabric_side": 0.2}, "must not exceed frame_side"),
        ({"picture_frame": "p.csv", "frame_side": 250.0}, "at most 2 m is allowed"),
        ({"bending_length_weft": 0.04}, "needs bending_length"),
        ({"bending_length": 45.0}, "at most 2 m"),
        ({"picture_frame": "p.csv", "knots": 1}, "knots"),
        ({"picture_frame": "p.csv", "noise": 2.0}, "noise"),
        ({"picture_frame": "p.csv", "frame_sid": 0.2}, "did you mean 'frame_side'"),
        ({"picture_frame": "p.csv", "friction": "some"}, "one of 'auto' or 'none' is needed"),
    ],
)
def test_what_cannot_be_meant_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        CalibrationOptions(fabric="glass-polypropylene", **given)


def test_one_file_or_several():
    one = CalibrationOptions(fabric="glass-polypropylene", picture_frame="a.csv")
    assert [path.name for path in one.picture_frame] == ["a.csv"]
    assert len(CalibrationOptions(fabric="x", picture_frame=("a.csv", "b.csv")).picture_frame) == 2


def test_unknown_fabrics_and_missing_files():
    with pytest.raises(InputError, match="fabric 'nope' is unknown"):
        calibrate("nope", picture_frame="nope.csv")
    with pytest.raises(InputError, match="picture frame nope.csv: cannot be read"):
        calibrate("glass-polypropylene", picture_frame="nope.csv")
    with pytest.raises(InputError, match="fit names parameters of the unit cell"):
        calibrate("glass-polypropylene", bending_length=0.04, fit=("yarn_stiffness",))
