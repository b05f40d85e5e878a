"""Pictures of parts on their own; those of a whole calibration are in ``test_record.py``."""

from weavesim.calibration import calibrate
from weavesim.calibration.pictures import bending_figure, interval_figure, pictures


def test_bending_alone_has_its_specimens_and_its_ratio():
    found = calibrate("glass-polypropylene", bending_length=(0.044, 0.046), bending_length_weft=(0.04, 0.041, 0.042))
    assert [name for name, _, _ in pictures(found)] == ["bending", "intervals"]
    (chart,) = bending_figure(found).axes
    points = [line for line in chart.lines if line.get_marker() == "o"]
    assert [len(line.get_xdata()) for line in points] == [2, 3]
    (chart,) = interval_figure(found).axes
    assert [label.get_text() for label in chart.get_yticklabels()] == [
        "warp bending stiffness",
        "weft bending stiffness",
    ]
