"""Repeats of a test in one table: read right, or refused with line and column."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.tables import Role, read_repeats, read_table

ROLES = (
    Role("angle", ("shear angle", "scherwinkel"), ("rad",)),
    Role("force", ("kraft", "normalised force"), ("N", "N/m")),
    Role("unloading", ("force unloading",), ("N", "N/m"), is_required=False),
)
# All hold the forces 0, 2, 3 N at 0, 10, 20 degrees, and 0, 3, 4 N in a second specimen, which may be shorter.
READ = {
    "shared angle": "angle [deg],force 1 [N],force 2 [N]\n0,0,0\n10,2,3\n20,3,4\n",
    "pairs, numbered": "angle 1 [deg];force 1 [N];angle 2 [deg];force 2 [N]\n0;0;0;0\n10;2;10;3\n20;3;20;4\n",
    "pairs, equal names": "angle;force;angle;force\n°;N;°;N\n0;0;0;0\n10;2;10;3\n20;3;20;4\n",
    "German, decimal commas": "Scherwinkel [Grad];Kraft 1 [kN];Kraft 2 [kN]\n"
    "0,0;0,000;0,000\n10,0;0,002;0,003\n20,0;0,003;0,004\n",
    "number behind the unit": "angle [deg],force [N] 1,force [N] 2\n0,0,0\n10,2,3\n20,3,4\n",
    "specimen first": "specimen 1 angle [deg]\tspecimen 1 force [N]\tspecimen 2 angle [deg]\tspecimen 2 force [N]\n"
    "0\t0\t0\t0\n10\t2\t10\t3\n20\t3\t20\t4\n",
    "other columns": "time [s],angle [deg],force #1 [N],force #2 [N],force (filtered) [N],remark\n"
    "0,0,0,0,9,a\n1,10,2,3,9,b\n2,20,3,4,9,c\n",
    "byte order mark": "\ufeffangle [deg],force 1 [N],force 2 [N]\n0,0,0\n10,2,3\n20,3,4\n",
    "preamble": 'Laboratory;"A 12"\nPreload;2;N\n\nangle;force 1;force 2\ndeg;N;N\n0;0;0\n10;2;3\n20;3;4\n',
}


def repeats(folder, text):
    path = folder / "frame.csv"
    path.write_text(text, encoding="utf-8")
    return read_repeats(read_table(path, "picture frame"), ROLES)


@pytest.mark.parametrize("text", READ.values(), ids=READ)
def test_every_way_to_write_repeats_is_read(tmp_path, text):
    found = repeats(tmp_path, text).tests
    assert len(found) == 2
    for test, newtons in zip(found, ([0, 2, 3], [0, 3, 4]), strict=True):
        np.testing.assert_allclose(np.degrees(test.columns["angle"]), [0, 10, 20])
        np.testing.assert_allclose(test.columns["force"], newtons)
        assert test.units == {"angle": "rad", "force": "N"}


def test_a_shorter_specimen_ends_with_empty_cells(tmp_path):
    found = repeats(tmp_path, "angle [deg],force 1 [N],force 2 [N]\n0,0,0\n10,2,3\n20,3,\n30,4,\n")
    assert [len(test.lines) for test in found.tests] == [4, 2]
    assert found.tests[1].lines.tolist() == [2, 3]


def test_a_wanted_test_may_be_shorter_than_others_in_the_table(tmp_path):
    text = "angle [deg],force [N],force at 200 C [N]\n0,0,0\n10,2,1\n20,,2\n30,,3\n"
    (test,) = repeats(tmp_path, text).tests
    assert test.lines.tolist() == [2, 3]
    with pytest.raises(InputError, match="line 4: no value in column.*a gap"):
        repeats(tmp_path, text + "40,7,8\n")
    with pytest.raises(InputError, match="line 4: no value in column 'force"):
        repeats(tmp_path, "angle [deg],force [N]\n0,0\n10,2\n20,\n")


def test_one_test_alone_and_what_was_converted(tmp_path):
    found = repeats(tmp_path, "angle_deg,normalised_force_n_per_mm\n0,0\n10,0.01\n")
    (test,) = found.tests
    assert test.label == "" and test.units["force"] == "N/m"
    np.testing.assert_allclose(test.columns["force"], [0, 10])
    assert any("converted from N/mm to N/m" in note for note in found.notes)


def test_unloading_in_its_own_column(tmp_path):
    (test,) = repeats(tmp_path, "angle [deg],force [N],force unloading [N]\n0,0,-1\n10,2,1\n").tests
    np.testing.assert_allclose(test.columns["unloading"], [-1, 1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("angle,force\n0,0\n1,2\n", r"line 1: column 'angle' does not say its unit.*\[deg\]"),
        ("winkl [deg],force [N]\n0,0\n1,2\n", "line 1: no column angle among 'winkl"),
        ("angle [deg],force [mm]\n0,0\n1,2\n", "line 1: column 'force .mm.' is in mm"),
        ("angle [deg],force [bananas]\n0,0\n1,2\n", "line 1: column 'force .bananas.*unit is not known"),
        ("angle [deg],force 1 [N],force 2 [N]\n0,0,0\n1,2,x\n", "line 3: column 'force 2 .N.': 'x' is not a number"),
        (
            "angle [deg],force 1 [N],force 2 [N]\n0,0,0\n5,,1\n6,1,1\n",
            "line 3: no value in column 'force 1 .N.': a gap",
        ),
        ("angle 1 [deg],force 1 [N],angle 2 [deg],force 2 [N]\n0,0,0,0\n5,1,,1\n", "line 3: no value in.*'angle 2"),
        ("angle 1 [deg],force 1 [N],angle 2 [deg],force 3 [N]\n0,0,0,0\n", "line 1: .*same specimen"),
        ("angle 1 [deg],force 1 [N],force 1 [N],force 2 [N]\n0,0,0,0\n", "line 1: column force 1 occurs twice"),
        ("angle [deg],force 1 [N],force 2 [N]\n0,0,0\n1,2,3,4\n", "line 3: 4 values under 3 names"),
        ("x,y\n0,0\n", "no table with"),
        ("", "it is empty"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, text, message):
    with pytest.raises(InputError, match=f"picture frame .*frame.csv.*{message}"):
        repeats(tmp_path, text)
