"""A user's own folder of fabrics: found by name, never in the place of a preset, and never skipped in silence."""

from pathlib import Path

import pytest

from weavesim import InputError, load_fabric, resolve_fabric
from weavesim.fabric.presets.folder import VARIABLE, fabric_folder, kept_file, kept_files, shadows

OURS = 'based_on = "glass-polypropylene"\nthickness = 0.9e-3\n'


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    place = tmp_path / "our fabrics"
    place.mkdir()
    monkeypatch.setenv(VARIABLE, str(place))
    return place


def test_default_folder_need_not_exist(tmp_path, monkeypatch):
    monkeypatch.delenv(VARIABLE)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert fabric_folder() == tmp_path / ".weavesim" / "fabrics"
    assert kept_files() == {}
    fabric_folder().mkdir(parents=True)
    (fabric_folder() / "ours.toml").write_text(OURS)
    assert resolve_fabric("ours").thickness == 0.9e-3


def test_fabrics_are_found_by_name(folder):
    (folder / "ours.toml").write_text(OURS)
    (folder / "Ours 2.JSON").write_text(resolve_fabric("ours").to_json())
    (folder / "frame.csv").write_text("angle,force\n0,0\n")
    (folder / ".hidden.toml").write_text("damaged")
    (folder / "tests.toml").mkdir()
    assert list(kept_files()) == ["Ours 2", "ours"]
    assert kept_file("ours") == folder / "ours.toml" and kept_file("theirs") is None
    assert resolve_fabric("ours") == load_fabric(folder / "ours.toml") == resolve_fabric("Ours 2")
    assert resolve_fabric("ours").source == "ours.toml, based on the preset glass-polypropylene"


def test_a_table_beside_the_file_is_read(folder):
    (folder / "frame.csv").write_text("angle [deg],force [N]\n0,0\n20,5\n40,20\n")
    (folder / "ours.toml").write_text(
        OURS + '[shear]\nkind = "MomentCurve.from_picture_frame"\nframe_side = 0.2\n'
        'angle = {csv = "frame.csv", column = "angle"}\nmachine_force = {csv = "frame.csv", column = "force"}\n'
    )
    assert len(resolve_fabric("ours").shear.angle) == 3


def test_an_unknown_name_tells_what_there_is_and_where(folder):
    (folder / "jute.toml").write_text(OURS)
    with pytest.raises(
        InputError, match=r"fabric 'jude' is unknown: choose one of .*jute.* did you mean 'jute'"
    ) as told:
        resolve_fabric("jude")
    assert str(folder) in str(told.value)


@pytest.mark.parametrize("file", ["glass-polypropylene.toml", "Glass-Polypropylene.json"])
def test_the_name_of_a_preset_is_refused(folder, file):
    (folder / file).write_text(OURS)
    assert shadows() == {"glass-polypropylene": folder / file}
    with pytest.raises(InputError, match=r"'glass-polypropylene': this is a preset, and .*has the same name; rename"):
        resolve_fabric("glass-polypropylene")
    (folder.parent / "ours.toml").write_text(OURS)
    with pytest.raises(InputError, match="ours.toml, line 1: based_on: fabric .* this is a preset, and"):
        load_fabric(folder.parent / "ours.toml")
    assert resolve_fabric("glass-polypropylene-hkust").thickness == 1.2e-3


def test_two_files_of_one_name_are_refused(folder):
    (folder / "ours.toml").write_text(OURS)
    (folder / "ours.json").write_text("{}")
    with pytest.raises(InputError, match=r"ours.json and ours.toml in .* have the same name"):
        resolve_fabric("ours")


def test_a_damaged_file_is_named(folder):
    (folder / "ours.toml").write_text("thickness = ")
    with pytest.raises(InputError, match=r"ours.toml: no valid TOML"):
        resolve_fabric("ours")


def test_a_folder_that_the_environment_names_must_exist(monkeypatch, tmp_path):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "nowhere"))
    with pytest.raises(InputError, match="WEAVESIM_FABRICS = .*nowhere: there is no such folder"):
        resolve_fabric("ours")
    assert resolve_fabric("glass-polypropylene")  # which no folder is needed for
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "file"))
    with pytest.raises(InputError, match="folder of fabrics .*file: cannot be read"):
        resolve_fabric("ours")


def test_fabrics_are_based_on_each_other_but_not_on_themselves(folder):
    (folder / "ours.toml").write_text(OURS)
    (folder / "thick.toml").write_text('based_on = "ours"\nthickness = 1.1e-3\n')
    fabric = resolve_fabric("thick")
    assert fabric.thickness == 1.1e-3 and fabric.source == "thick.toml, based on the fabric ours"
    assert fabric.origin_of("areal_density").source.startswith("Cao")
    (folder / "ours.toml").write_text('based_on = "thick"\n')
    with pytest.raises(InputError, match="thick is based on ours is based on thick; no fabric can be based on itself"):
        resolve_fabric("thick")
    (folder / "ours.toml").write_text('based_on = "nothing"\n')
    with pytest.raises(
        InputError, match=r"based_on: fabric file .*ours.toml, line 1: based_on = 'nothing': a preset, or"
    ):
        resolve_fabric("thick")


def test_a_name_is_no_path(folder, tmp_path):
    (tmp_path / "outside.toml").write_text(OURS)
    (folder / "ours.toml").write_text('based_on = "../outside"\n')
    with pytest.raises(InputError, match="or the name of a file in your own folder"):
        resolve_fabric("ours")
