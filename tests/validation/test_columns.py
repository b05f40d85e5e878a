"""docs/outputs.md lists every column and entry of the files of a run, and none that is not there."""

import csv
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.support.paths import ROOT
from weavesim.app.command_line import application
from weavesim.measures.units import PURE, split_unit, with_unit
from weavesim.output import History
from weavesim.output.comparison.fields import FIELDS, keyed
from weavesim.run import ledger
from weavesim.run.interface_ledger import ENTRIES
from weavesim.scenes.scene import known_scenes

pytestmark = pytest.mark.slow
PAGE = ROOT / "docs" / "outputs.md"
# Symbols of units as the page has them.
SYMBOLS = {"°": "degrees"}


def listed() -> dict[str, list[tuple[str, str]]]:
    """By the file: names of columns or entries, and their units."""
    part = PAGE.read_text(encoding="utf-8").split("\n## Columns and entries\n")[1].split("\n## ")[0]
    found: dict[str, list[tuple[str, str]]] = {}
    for section in part.split("\n### ")[1:]:
        head, _, body = section.partition("\n")
        names = found.setdefault(head.strip("`"), [])
        for row in re.findall(r"^\| (`.*?) \| ?(.*?) ?\| .* \|$", body, flags=re.MULTILINE):
            spans = re.findall(r"`([^`]+)`", row[0])
            units = row[1].split(", ") if ", " in row[1] and len(row[1].split(", ")) == len(spans) else [row[1]]
            names += zip(spans, units * len(spans) if len(units) == 1 else units, strict=True)
    return found


LISTED = listed()


def of_table(heading: str) -> dict[str, str]:
    """First two columns of a table of docs/results.md: names with their units."""
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    section = text.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return dict(re.findall(r"^\| `(\w+)` \| ([^|]*) \|", section, flags=re.MULTILINE))


# What a name in angle brackets stands for, by the file; anything where nothing is said.
STANDS_FOR = {
    "comparison.csv": {"<field>": [keyed(name) for name in FIELDS]},
    "NAME.csv": {
        "<field>": [with_unit(name, unit) for name, unit in of_table("Fields per element").items()],
        "<stress>": list(of_table("Stresses per element")),
    },
}


def pattern(file: str, name: str) -> re.Pattern:
    """What a name of the page stands for in a file."""
    known = STANDS_FOR.get(file, {})
    parts = [
        (f"({'|'.join(known[part])})" if part in known else ".+") if part.startswith("<") else re.escape(part)
        for part in re.split(r"(<\w+>)", name)
    ]
    return re.compile("".join(parts))


def check(file: str, found: set[str], more: tuple[str, ...] = ()) -> None:
    """Every name that was found is listed, and every one that is listed was found.

    Args:
        file: heading of the page.
        found: in files.
        more: patterns of the page that are of another kind of file than these.
    """
    assert found
    names = [name for name, _ in LISTED[file]]
    unknown = [name for name in sorted(found) if not any(pattern(file, each).fullmatch(name) for each in names)]
    assert not unknown, f"{file}: not in docs/outputs.md"
    dead = [
        each for each in names if each not in more and not any(pattern(file, each).fullmatch(name) for name in found)
    ]
    assert not dead, f"{file}: in docs/outputs.md, but in no file"


def header(path: Path) -> set[str]:
    with open(path, encoding="utf-8", newline="") as file:
        return set(next(csv.reader(file)))


def content(path: Path) -> dict:
    return json.loads(path.read_text(encoding="utf-8"))


def call(*words: object) -> None:
    done = CliRunner().invoke(application, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code in (0, 5), done.output


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """The double dome, coarse and short, after every command that leaves tables."""
    folder = tmp_path_factory.mktemp("columns")
    scene, out = known_scenes()["double-dome"].load(), folder / "out"
    given = {"mesh_size": 0.02, "stroke": 0.008, "punch_speed": 2.0, "frame_count": 2}
    scene.run(scene.parameters(**given, out=out, write="summary,tables,results,report"))
    (folder / "limits.toml").write_text("gap = 1e-9\nlocking_angle = 1.7\n")
    (folder / "edge.csv").write_text("x [mm],y [mm]\n30,30\n90,30\n90,70\n30,70\n")
    (folder / "points.csv").write_text("x [mm],y [mm],z [mm],shear_angle [deg]\n50,50,0,1\n100,60,0,2\n")
    call("verdict", out, "--limits", folder / "limits.toml")
    call("kinematic", out, "--tool", "punch", "--out", out)
    call("compare", out, out, "--out", folder / "runs")
    call("compare", out, folder / "points.csv", "--out", folder / "points")
    call("export", out, "--to", "csv", "--out", folder / "part")
    call("export", out, "--to", "csv", "--unit", "mm", "--out", folder / "part_mm")
    call("export", out, "--flat", folder / "flat.dxf", "--part-edge", folder / "edge.csv")
    return out


def of_everything() -> History:
    """A history of all that a run may have: supports, grippers, carried tools, several sheets."""
    tool, support = SimpleNamespace(name="die"), SimpleNamespace(name="clamp", drives=(1,))
    info = SimpleNamespace(tool_names=["die"], tools=(tool,), supports=(support,),
                           grippers=(SimpleNamespace(name="corner_1"),))  # fmt: skip
    names = {*ledger.STORED, *ledger.LOST, *ledger.SUPPLIED, *ledger.STAGE_SUPPLIED, *ledger.TRIM_LOST, *ledger.SUMS}
    names |= {*ENTRIES, "unit_cell"}
    sheets = [
        SimpleNamespace(name=name, fields={"shear_angle": np.zeros(1)}, energies=dict.fromkeys(names, 0.0))
        for name in ("ply_1", "ply_2")
    ]
    frame = SimpleNamespace(
        index=0, step_count=0, time=0.0, stroke=0.0, sheets=sheets, tool_displacement=np.zeros(1),
        tool_reaction=np.zeros((1, 3)), tool_wanted=np.ones(1), tool_pose=np.append(np.eye(3), np.zeros(3))[None],
        tool_moment=np.zeros((1, 3)), support_force=np.zeros((1, 3)), drive_displacement=np.zeros(1),
        drive_force=np.zeros(1), gripper_force=np.zeros(1), gripper_slip=np.zeros(1),
        energies=dict.fromkeys(names, 0.0),
    )  # fmt: skip
    history = History()
    history.start(info)
    history.frame(frame)
    return history


def test_units_are_those_of_the_names():
    for names in LISTED.values():
        for name, unit in names:
            own = split_unit(name.split("[].")[-1])[1]
            if own != PURE:
                assert unit == SYMBOLS.get(own.symbol, own.symbol), name


def test_the_columns_of_the_history(run, tmp_path):
    of_everything().write(tmp_path / "history.csv")
    check("history.csv", header(run / "history.csv") | header(tmp_path / "history.csv"))


def test_the_columns_of_the_other_tables(run):
    # a mesh of one's own has its numbers too (tests/unit/run/test_numbering.py)
    check("draw_in.csv", header(run / "draw_in.csv") | {"node_number"})
    for name in ("shear_angle.csv", "verdict.csv", "kinematic.csv"):
        check(name, header(run / name))
    compared = header(run.parent / "runs" / "comparison.csv") | header(run.parent / "points" / "comparison.csv")
    check("comparison.csv", compared)
    part, millimetres = (
        header(run.parent / "part" / "double_dome.csv"),
        header(next((run.parent / "part_mm").iterdir())),
    )
    further = {re.sub("_[yz](_n_per_m)?$", r"_x\1", name) for name in part if not name.startswith("centre")}
    # a mapped part has the distance too (tests/unit/output/export/test_formed.py)
    check("NAME.csv", further | {name for name in part if name.startswith("centre")} | {"distance_m"})
    assert {f"centre_{axis}_mm" for axis in "xyz"} <= millimetres


def test_the_entries_of_the_records(run):
    check("run.json", set(content(run / "run.json")))
    progress = set(content(run / "progress.json"))
    check("progress.json", progress, more=("stage",))
    for name in ("verdict.json", "kinematic.json", "flat.json"):
        file = (run.parent if name == "flat.json" else run) / name
        check(name, set(nested(content(file))), more=("ends[].reason", "ends[].nearest_mm"))
    for folder in ("runs", "points"):
        numbers = content(run.parent / folder / "comparison.json")
        statistics = {key for value in numbers.values() if isinstance(value, dict) for key in value}
        check("comparison.json", statistics)
        assert {key for key, value in numbers.items() if not isinstance(value, dict)} <= {
            "sheet", "other", "point_count"
        }  # fmt: skip


def nested(entries: dict, start: str = ""):
    """Names of entries; of lists of tables, which are not looked into further, as "sheets[].name"."""
    for key, value in entries.items():
        if isinstance(value, list) and value and isinstance(value[0], dict) and not start:
            yield from nested(value[0], f"{key}[].")
        elif not (isinstance(value, list) and not value and key == "ends"):
            yield f"{start}{key}"


def test_every_file_of_a_run_has_its_list(run):
    """Tables and records beside those that results.md lists."""
    files = {path.name for path in run.rglob("*") if path.suffix in (".csv", ".json")}
    others = {"summary.json", "setup.json"}
    assert files - others <= set(LISTED)


def test_fields_of_the_page_are_those_that_are_compared():
    part = PAGE.read_text(encoding="utf-8").split("### `comparison.csv`")[1].split("###")[0]
    assert {keyed(name) for name in FIELDS} <= set(re.findall(r"`(\w+)`", part))


def test_sections_have_the_columns_that_the_page_saves():
    script = (ROOT / "weavesim" / "output" / "run_page" / "viewer" / "section.js").read_text(encoding="utf-8")
    (saved,) = re.findall(r'"section\.csv", `([^\\]+)\\n', script)
    check("section.csv", set(saved.replace("${", "").replace("}", "").split(",")))
