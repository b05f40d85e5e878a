"""Measured values that a user gives."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output import load_measured_angles, load_measured_curves, load_measured_outline
from weavesim.output.curves import Chart, Curves, MeasuredPoints
from weavesim.output.measured import Comparable, difference


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
        ("point,angle_deg\n1,0.5\n2,-0.6\n", "the largest is 0.6 degrees: are they radians"),
    ],
)
def test_bad_measured_angles(tmp_path, text, message):
    path = tmp_path / "angles.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_measured_angles(path)
    assert str(path) in str(caught.value)


def test_small_measured_angles_may_be_accepted(tmp_path):
    path = tmp_path / "angles.csv"
    path.write_text("point,angle_deg\n1,0.5\n2,-0.6\n")
    assert load_measured_angles(path, accept_unusual=True)[1].tolist() == [0.5, -0.6]


def test_an_outline_of_another_size_than_the_blank_is_asked_about(tmp_path):
    path = tmp_path / "outline.csv"
    path.write_text("x_mm,y_mm\n0.2,0\n0.19,0.02\n")
    with pytest.raises(InputError, match=r"extends 0.0002 m from the origin, the blank 0.235 m: give the right unit"):
        load_measured_outline(path, reach=0.235)
    assert load_measured_outline(path, reach=0.235, accept_unusual=True)[0, 0] == pytest.approx(0.0002)
    path.write_text("x_m,y_m\n0.2,0\n0.19,0.02\n")
    with pytest.raises(InputError, match=r'no column x, y among .x_m., .y_m.; a column in metres is called "x \[m\]"'):
        load_measured_outline(path)


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


ABSCISSAS = (Comparable("angle", "deg", "angle_deg"), Comparable("displacement", "mm", "displacement_mm"))
ORDINATES = (Comparable("force", "N", "force_n"), Comparable("force", "N/m", "force_n_per_m"))


def loaded(tmp_path, text, names=None):
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    return load_measured_curves(path, ABSCISSAS, ORDINATES, names)


def test_a_measured_curve_is_told_by_its_names_and_units(tmp_path):
    (curve,) = loaded(tmp_path, "\ufeffAngle [rad];Force [N/mm];other\n0;0;1\n0,5;0,1;2\n")
    assert (curve.x_column, curve.y_column) == ("angle_deg", "force_n_per_m")
    assert curve.x == pytest.approx([0.0, np.degrees(0.5)]) and curve.y == pytest.approx([0.0, 100.0])
    (curve,) = loaded(tmp_path, "displacement [cm],force [kN]\n0,0\n1,2\n")
    assert (curve.x_column, curve.y_column) == ("displacement_mm", "force_n")
    assert curve.x == pytest.approx([0.0, 10.0]) and curve.y == pytest.approx([0.0, 2000.0])


def test_measured_columns_may_have_any_name(tmp_path):
    text = "travel [mm],F 20C [N],F 200C [N]\n0,0,0\n1,2,3\n"
    first, second = loaded(tmp_path, text, "travel, F 20C, F 200C")
    assert first.label == "measured, test, F 20C" and second.y == pytest.approx([0.0, 3.0])


@pytest.mark.parametrize(
    ("text", "names", "message"),
    [
        ("angle,force [N]\n0,0\n1,1\n", None, "line 1: column 'angle' does not say its unit"),
        ("angle [deg],force [kg]\n0,0\n1,1\n", None, "line 1: column 'force .kg.' is in kg, which cannot be converted"),
        ("angle [deg],force [N]\n0,0\n1,x\n", None, "line 3: .*'x'.*column 'force .N.'|line 3: column 'force"),
        ("angle [deg],torque [N]\n0,0\n1,1\n", None, 'compared are "force .N.", "force .N/m."'),
        ("angle [deg],force [N]\n0,0\n1,1\n", "angle", "two names or more are needed"),
        ("angle [deg],force [N]\n0,0\n1,1\n", "angle,,", "two names or more are needed"),
        ("angle [deg],force [N]\n1,0\n1,1\n", None, "has one value only"),
    ],
)
def test_a_measured_curve_with_mistakes_is_refused(tmp_path, text, names, message):
    with pytest.raises(InputError, match=message):
        loaded(tmp_path, text, names)


def test_a_column_that_can_be_two_things_is_refused(tmp_path):
    two = (Comparable("warp force", "N", "warp_n"), Comparable("weft force", "N", "weft_n"))
    path = tmp_path / "two.csv"
    path.write_text("angle [deg],F [N]\n0,0\n1,1\n")
    with pytest.raises(InputError, match='can be any of "warp force .N.", "weft force .N."; give it that name'):
        load_measured_curves(path, ABSCISSAS, two, "angle, F")


def test_a_difference_keeps_loading_and_unloading_apart():
    """A loop of height 2 about y = x, against itself with an offset, and against its loading alone."""
    up = np.linspace(0.0, 10.0, 21)
    x, y = np.append(up, up[::-1]), np.append(up + 1.0, up[::-1] - 1.0)
    computed = {"x": x, "y": y}
    noisy = x + 0.05 * np.where(np.arange(len(x)) % 2, 1.0, -1.0)
    found = difference(MeasuredPoints("m", "x", "y", noisy[2:40], (y + 0.5)[2:40]), computed)
    size = (y + 0.5)[2:40].max()
    assert found.largest * size == pytest.approx(0.55, abs=0.01) and found.compared_share > 0.9
    assert found.root_mean_square * size == pytest.approx(0.5, abs=0.02)
    half = difference(MeasuredPoints("m", "x", "y", x, y), {"x": up, "y": up + 1.0})
    assert half.largest == pytest.approx(0.0, abs=1e-12) and half.compared_share == pytest.approx(0.5, abs=0.03)
    assert difference(MeasuredPoints("m", "x", "y", up + 20.0, up), computed) is None


def test_a_measured_curve_that_no_chart_shows_is_refused():
    chart = Chart("c", "", "", ("x", ""), "", {"y": "computed"}, {})
    points = MeasuredPoints("measured, t", "x", "z", np.arange(2.0), np.arange(2.0))
    with pytest.raises(InputError, match="measured, t: z over x is not drawn, but y over x"):
        Curves("t", lambda frame: {}, [chart], [points])
    shown = MeasuredPoints("measured, t", "x", "y", np.arange(2.0), np.arange(2.0))
    assert Curves("t", lambda frame: {}, [chart], [shown]).charts[0].measured == (shown,)
