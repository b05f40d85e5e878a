"""Columns of test tables in fabric files, with the small inputs of public bug reports."""

import os

import numpy as np
import pytest

from tests.support.paths import ROOT
from weavesim.errors import InputError
from weavesim.fabric import columns
from weavesim.fabric.bending import BendingCurve
from weavesim.fabric.columns import unit_of
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.file import load_fabric
from weavesim.fabric.shear import MomentCurve, ShearFriction
from weavesim.tables import read_table

ANGLE = np.arange(0.0, 61.0, 5.0)
FORCE = np.array([0.0, 1.07, 2.32, 3.77, 5.46, 7.38, 9.55, 11.99, 14.69, 17.67, 20.93, 24.48, 28.33])
SHEAR = """
based_on = "glass-polypropylene"
[shear]
kind = "MomentCurve.from_picture_frame"
angle = {csv = "frame.csv", column = "angle", scale = 0.0174532925}
machine_force = {csv = "frame.csv", column = "force"}
frame_side = 0.25
"""


def shear_of(folder, table, toml=SHEAR):
    (folder / "frame.csv").write_bytes(table if isinstance(table, bytes) else table.encode())
    (folder / "frame.toml").write_text(toml)
    return load_fabric(folder / "frame.toml").shear


def table(separator, mark=".", header="angle{}force", end="\n"):
    lines = [header.format(separator)]
    lines += [
        f"{angle:.1f}{separator}{force:.2f}".replace(".", mark) for angle, force in zip(ANGLE, FORCE, strict=True)
    ]
    return end.join(lines) + end


@pytest.mark.parametrize(
    "text",
    [
        table(","),
        table(";", ","),
        table(";"),
        table("\t", ",", end="\r\n"),
        table(" ", ","),
        table(";", ",", "Angle [deg]{}Force [N]"),
        table(",", header="angle / deg{}force / N").encode("utf-16"),
        table("\t", header='"Angle"{0}"Force"\n"°"{0}"N"').encode("latin-1"),
        "Frame test 12\n\n" + table(";", ","),
    ],
)
def test_the_frame_test_is_read_however_it_is_written(tmp_path, text):
    """The values of the field cases, written with points."""
    moment = shear_of(tmp_path, text).moment(np.radians([10.0, 30.0, 50.0]))
    np.testing.assert_allclose(moment, [5.957, 19.108, 28.639], rtol=2e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            table(",", ","),
            "line 5: shear.angle: table .*frame.csv, line 2: 4 values under 2 names.*a point, not a comma",
        ),
        ("angle,force\n0,0\n5,1,07\n", "frame.csv, line 3: 3 values under 2 names.*a point, not a comma"),
        ("angle,force,,\n0,0,0,00\n5,0,1,07\n", "4 values under 2 names"),
        ("angle,force,remark,by\n0,0,0,00\n5,0,1,07\n", "line 2: '00' looks like the end of a number"),
        ("angle,force,angle,force\n0,0,0,0\n5,1,5,3\n", "line 1: .*column force occurs twice"),
        ("angle, Force,FORCE\n0,0,0\n5,1,3\n", "line 1: column Force occurs twice, as columns 2, 3"),
        ("angle;force [N];force [kN]\n0;0;0\n", "column force occurs twice"),
        ("angle,force\n\n\n0,0\n5,x\n", "line 5: column 'force': 'x' is not a number"),
        ("angle;force\n0;0\n5;1.234,5\n", "line 3: column 'force': '1.234,5' has separators of thousands"),
    ],
)
def test_what_cannot_be_read_right_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as raised:
        shear_of(tmp_path, text)
    assert str(raised.value).startswith(f"fabric file {tmp_path / 'frame.toml'}, line ")


def test_a_unit_in_the_header_is_converted_and_reported(tmp_path):
    toml = SHEAR.replace(", scale = 0.0174532925", "")
    text = table(";", ",", "Angle [deg]{}Force [N]")
    shear = shear_of(tmp_path, text, toml)
    np.testing.assert_allclose(shear.angle, np.radians(ANGLE), rtol=1e-15)
    source = load_fabric(tmp_path / "frame.toml").source
    assert source == (
        "frame.toml, based on the preset glass-polypropylene; frame.csv: column 'Angle [deg]' converted from deg to "
        "rad; frame.csv: decimal commas"
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"frame.csv"', '"/etc/passwd"'), "shear.angle: csv = '/etc/passwd': leads out of the folder"),
        (('"frame.csv"', '"../frame.csv"'), "leads out of the folder"),
        (('"frame.csv"', '"/dev/zero"'), "leads out of the folder"),
        (('"frame.csv"', '"link.csv"'), "leads out of the folder"),
        (('"frame.csv"', '"zero.csv"'), "leads out of the folder"),
        (('"frame.csv"', '"pipe.csv"'), "it is a pipe"),
        (('"frame.csv"', '"."'), "it is a folder"),
        (('"frame.csv"', "1"), "csv = 1: the name of a file is needed"),
        (('"frame.csv"', '"loop.csv"'), "cannot be read"),
        (('column = "angle"', "column = 3"), "column = 3: the name of a column is needed"),
        (('column = "angle"', 'column = ""'), "column = '': the name of a column is needed"),
        (('column = "angle"', 'colum = "angle"'), "colum: unknown name; did you mean 'column'"),
        (("scale = 0.0174532925", "scale = true"), "scale = True: a finite number other than 0 is needed"),
        (("scale = 0.0174532925", "scale = 0"), "scale = 0: a finite number other than 0"),
        (("scale = 0.0174532925", "scale = [1]"), r"scale = \[1\]: a finite number"),
        (('csv = "frame.csv", column = "angle"', 'column = "angle"'), "a column needs csv and column"),
    ],
)
def test_references_stay_in_the_folder_and_are_complete(tmp_path, change, message):
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "frame.csv").write_text("secret,force\n0,0\n")
    (home / "link.csv").symlink_to("../frame.csv")
    (home / "zero.csv").symlink_to("/dev/zero")
    (home / "loop.csv").symlink_to("loop.csv")
    os.mkfifo(home / "pipe.csv")
    toml = SHEAR.replace(*change, 1)
    assert toml != SHEAR
    with pytest.raises(InputError, match=message) as raised:
        shear_of(home, table(","), toml)
    assert "secret" not in str(raised.value) and "root:" not in str(raised.value)


def test_a_table_below_the_folder_is_read_once(tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(columns, "read_table", lambda *given: calls.append(given) or read_table(*given))
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "frame.csv").write_text(table(","))
    shear_of(tmp_path, "", SHEAR.replace("frame.csv", "data/frame.csv"))
    assert len(calls) == 1


@pytest.mark.parametrize(
    ("owner", "name", "unit"),
    [
        (MomentCurve, "angle", "rad"),
        (MomentCurve, "moment_values", "N/m"),
        (MomentCurve, "machine_force", "N"),
        (MomentCurve, "force_per_length", "N/m"),
        (MomentCurve, "loading", "N/m"),
        (ShearFriction, "unloading", "N/m"),
        (ShearFriction, "limit", "N/m"),
        (BendingCurve, "loading", "N"),
        (BendingCurve, "curvature", "1/m"),
        (Fabric, "name", ""),
        (None, "angle", "rad"),
        (None, "own", ""),
    ],
)
def test_the_unit_of_every_measured_quantity_is_known(owner, name, unit):
    assert unit_of(owner, name) == unit


def test_the_documented_tables_are_one_test(tmp_path):
    page = (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")
    tables = [text.split("```")[0] for text in page.split("```text\n")[1:]]
    assert len(tables) == 3
    for text in tables:
        shear = shear_of(tmp_path, text, SHEAR.replace(", scale = 0.0174532925", ""))
        np.testing.assert_allclose(shear.angle, np.radians([0.0, 20.0, 40.0]), rtol=1e-15)
        force = np.array([0.0, 5.25, 21.5])
        moment = force * 0.25 * np.sin(0.25 * np.pi - 0.5 * np.radians([0.0, 20.0, 40.0])) / 0.25**2
        np.testing.assert_allclose(shear.moment_values, moment, rtol=1e-12)


def test_a_bending_test_in_the_units_of_the_machine(tmp_path):
    """The Kawabata bending tester writes gf cm/cm over 1/cm."""
    (tmp_path / "kes.csv").write_text("K [1/cm];M [gf·cm/cm]\n0;0\n1,0;0,5\n2,5;1,25\n")
    (tmp_path / "ours.toml").write_text(
        'based_on = "glass-polypropylene"\n[bending]\nkind = "YarnBending"\nweft = 1e-3\ntwist = 1e-4\n'
        '[bending.warp]\nkind = "BendingCurve"\ncurvature = {csv = "kes.csv", column = "K"}\n'
        'moment_values = {csv = "kes.csv", column = "M"}\n'
    )
    curve = load_fabric(tmp_path / "ours.toml").bending.warp
    np.testing.assert_allclose(curve.curvature, [0.0, 100.0, 250.0])
    np.testing.assert_allclose(curve.moment_values, 9.80665e-3 * np.array([0.0, 0.5, 1.25]))
