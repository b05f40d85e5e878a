"""Measured values that a user gives."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output import load_measured_angles, load_measured_outline


def test_measured_angles_are_read(tmp_path):
    path = tmp_path / "angles.csv"
    path.write_text("\ufeffpoint, angle_deg, source\n3, 21.5, a\n1, 0\n\n", encoding="utf-8")
    numbers, angles = load_measured_angles(path)
    assert numbers.tolist() == [3, 1] and angles.tolist() == [21.5, 0.0]


def test_measured_outline_is_read_in_metres(tmp_path):
    path = tmp_path / "outline.csv"
    path.write_text("x_mm,y_mm\n200,0\n190.5,20\n")
    assert load_measured_outline(path) == pytest.approx(np.array([[0.2, 0.0], [0.1905, 0.02]]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no column point, angle_deg"),
        ("point,angle\n1,2\n", "no column angle_deg"),
        ("point,angle_deg\n", "no rows"),
        ("point,angle_deg\n1,ten\n", "line 2"),
        ("point,angle_deg\n1,2\n2\n", "line 3"),
        ("point,angle_deg\n1,nan\n", "not finite"),
        ("point,angle_deg\n1.5,3\n", "must be integers"),
        ("point,angle_deg\n1,3\n1,4\n", "each once"),
        ("point,angle_deg\n1,120\n", "below 90"),
    ],
)
def test_bad_measured_angles(tmp_path, text, message):
    path = tmp_path / "angles.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_measured_angles(path)
    assert str(path) in str(caught.value)


def test_unreadable_measured_files(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x80" * 20)
    (tmp_path / "single.csv").write_text("x_mm,y_mm\n1,2\n")
    (tmp_path / "metres.csv").write_text("x_mm,y_mm\n1e6,2\n1,3\n")
    for name, message in (
        ("missing.csv", "No such file"),
        ("binary.csv", "cannot be read"),
        ("single.csv", "only one point"),
        ("metres.csv", "give millimetres"),
        ("", "cannot be read"),
    ):
        with pytest.raises(InputError, match=message):
            load_measured_outline(tmp_path / name)
