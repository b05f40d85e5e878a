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
    ("text", "angle"),
    [
        ("Point;Angle [°]\n1;21,5\n", 21.5),
        ("point\tAngle (deg)\n1\t21.5\n", 21.5),
        ("point;angle\n;deg\n1;21,5\n", 21.5),
        ("point,angle / rad\n1,0.5\n", np.degrees(0.5)),
        ("# measured by hand\npoint angle_deg\n1 21.5\n", 21.5),
    ],
)
def test_measured_angles_are_in_degrees_however_they_are_written(tmp_path, text, angle):
    path = tmp_path / "angles.csv"
    path.write_text(text, encoding="utf-8")
    numbers, angles = load_measured_angles(path)
    assert numbers.tolist() == [1] and angles == pytest.approx([angle], rel=1e-14)


@pytest.mark.parametrize(
    "text",
    ["x_mm;y_mm\n200,5;0\n190;20\n", "x [m],y [m]\n0.2005,0\n0.19,0.02\n", "x (cm)\ty (cm)\n20.05\t0\n19\t2\n"],
)
def test_measured_outline_is_converted_from_its_unit(tmp_path, text):
    path = tmp_path / "outline.csv"
    path.write_text(text)
    assert load_measured_outline(path) == pytest.approx(np.array([[0.2005, 0.0], [0.19, 0.02]]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "it is empty; needed is the columns point, angle"),
        ("point,angle\n1,2\n", "line 1: column 'angle' does not say its unit.*angle \\[deg\\]"),
        ("point;angle [mm]\n1;2\n", "is in mm, which cannot be converted to deg"),
        ("point,angel_deg\n1,2\n", "no column angle among 'point', 'angel_deg'; did you mean"),
        ("point,angle_deg\n", "no rows"),
        ("point,angle_deg\n1,ten\n", "line 2"),
        ("point,angle_deg\n1,2\n2\n", "line 3"),
        ("point,angle_deg\n1,nan\n", "line 2.*'nan' is not a finite number"),
        ("point,angle_deg\n1.5,3\n", "must be integers"),
        ("point,angle_deg\n1,3\n\n1,4\n", "line 4: point 1; .*each once"),
        ("point,angle_deg\n1e300,3\n", "line 2: point 1e\\+300"),
        ("point,angle_deg\n1,1,5\n", "line 2: 3 values under 2 names"),
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
        ("binary.csv", "no table with the columns x, y"),
        ("single.csv", "only one point"),
        ("metres.csv", "give the right unit"),
        ("", "cannot be read"),
    ):
        with pytest.raises(InputError, match=message):
            load_measured_outline(tmp_path / name)
