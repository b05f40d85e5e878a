"""``weavesim fabric``: list, show and copy, in the words that a user sees."""

import re
import sys

import numpy as np
import pytest
from PIL import Image

from weavesim import glass_polypropylene, glass_polypropylene_consensus, load_fabric, resolve_fabric
from weavesim.app import command_line
from weavesim.fabric import PRESETS
from weavesim.fabric.presets.folder import VARIABLE
from weavesim.fabric.provenance import given_numbers


@pytest.fixture
def fabric_command(monkeypatch, capsys):
    """Runs ``weavesim fabric``: (exit code, stdout, stderr)."""

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["weavesim", "fabric", *map(str, arguments)])
        with pytest.raises(SystemExit) as ending:
            command_line.main()
        captured = capsys.readouterr()
        return ending.value.code or 0, captured.out, captured.err

    return call


def test_presets_and_own_fabrics_are_listed(fabric_command, tmp_path, monkeypatch):
    code, out, _ = fabric_command("list")
    assert code == 0 and all(re.search(rf"^  {name} ", out, re.MULTILINE) for name in PRESETS)
    assert "(the same as glass-polypropylene)" in out and "no fabrics" in out
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / "ours.toml").write_text('based_on = "glass-polypropylene"\nname = "woven at home"\n')
    code, out, _ = fabric_command("list")
    assert code == 0 and re.search(r"ours.toml +woven at home", out)


def test_what_cannot_be_used_is_listed_too(fabric_command, tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / "damaged.toml").write_text("thickness = ")
    (tmp_path / "assumed-twill.toml").write_text('based_on = "glass-polypropylene"\n')
    (tmp_path / "twice.toml").write_text('based_on = "glass-polypropylene"\n')
    (tmp_path / "twice.json").write_text(glass_polypropylene().to_json())
    (tmp_path / "good.toml").write_text('based_on = "glass-polypropylene"\nname = "good one"\n')
    code, out, _ = fabric_command("list")
    assert code == 2
    assert re.search(r"damaged.toml +cannot be used: fabric file .*no valid TOML", out)
    assert re.search(r"assumed-twill.toml .*\(this is the name of a preset: rename the file\)", out)
    assert len(re.findall(r"twice.(?:toml|json) .*several files of this name", out)) == 2
    assert re.search(r"good.toml +good one$", out, re.MULTILINE)


def test_a_missing_folder_is_told(fabric_command, monkeypatch, tmp_path):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "nowhere"))
    code, _, err = fabric_command("list")
    assert code == 2 and "there is no such folder" in err


def test_every_number_is_shown_with_its_source(fabric_command, monkeypatch):
    monkeypatch.setenv("COLUMNS", "170")
    code, out, _ = fabric_command("show", "glass-polypropylene-consensus")
    assert code == 0 and "assumed: crimp" not in out  # each number says it
    fabric = resolve_fabric("glass-polypropylene-consensus")
    for name in given_numbers(fabric):
        assert re.search(rf"^ *{name.rpartition('.')[2]}  .*\[\d+\]", out, re.MULTILINE), name
    limit = next(line for line in out.splitlines() if line.strip().startswith("limit "))
    assert re.search(r"8\.25347 +N/m +0\.5 to 17 +assumed +\[\d+\] +moment at which the yarns slip", limit)
    angle = next(line for line in out.splitlines() if line.startswith("  angle  "))
    assert "21 points, 0 to 0.7854 (0 to 45°)" in angle and "0 to 0.6109 (0 to 35°)" in angle
    number = re.search(r"\[(\d+)\]", limit)[1]
    assert f"[{number}] assumed: the moment that jumps up within the first degree is friction" in out
    assert "35 numbers, of which 20 are assumed" in out
    assert re.search(
        r"unloading: let go at 45° of shear it goes back to 11\.2°, and friction takes 38% of the work", out
    )
    assert max(map(len, out.splitlines())) <= 170


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_curves_are_drawn_beside_the_table(fabric_command, tmp_path, ending):
    code, out, _ = fabric_command("show", "glass-polypropylene-hkust", "--out", tmp_path / "new", "--picture", ending)
    picture, table = tmp_path / "new" / f"glass-polypropylene-hkust.{ending}", tmp_path / "new"
    assert code == 0 and f"wrote {picture}" in out
    assert "unit_cell (PlainWeave)" in (table / "glass-polypropylene-hkust.txt").read_text(encoding="utf-8")
    if ending == "svg":
        assert picture.read_text(encoding="utf-8").lstrip().startswith("<?xml")
    else:
        pixels = np.asarray(Image.open(picture).convert("RGB"))
        assert pixels.shape == (1260, 2250, 3) and len(np.unique(pixels.reshape(-1, 3), axis=0)) > 100


def test_a_copy_is_the_same_fabric_and_never_replaces_a_file(fabric_command, tmp_path):
    for ending in ("toml", "json"):
        file = tmp_path / "own" / f"ours.{ending}"
        code, out, _ = fabric_command("copy", "glass-polypropylene-consensus", file)
        assert code == 0 and f"wrote {file}" in out
        assert load_fabric(file) == glass_polypropylene_consensus()
        code, _, err = fabric_command("copy", "glass-polypropylene", file)
        assert code == 2 and "it exists; give another name" in err
    code, _, err = fabric_command("copy", "glass-polypropylene", tmp_path / "ours.txt")
    assert code == 2 and "must end in .toml or .json" in err


@pytest.mark.parametrize("verb", ["show", "copy"])
def test_an_unknown_fabric_is_refused(fabric_command, verb, tmp_path):
    code, _, err = fabric_command(verb, "silk", *([tmp_path / "x.toml"] if verb == "copy" else []))
    assert code == 2 and err.startswith("weavesim: fabric 'silk' is unknown: choose one of glass-polypropylene")


def test_help_names_the_verbs(fabric_command):
    code, out, _ = fabric_command("--help")
    assert code == 0 and all(verb in out for verb in ("list", "show", "copy"))
