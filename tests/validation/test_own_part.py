"""The newcomer's hour: tools that are not ours, from their surfaces to fibre angles in a structural model, in CalculiX.

Every step is a command as a user types it; nothing is edited but the fabric's name. ``make hour`` does it for both
tools as ``weavesim new`` writes the jobs, each command in a process of its own; the suite does it for one of them in
short, with coarse elements and a fast punch.
"""

import json
import os
import re
import resource
import shutil
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import meshio
import numpy as np
import pytest
from typer.testing import CliRunner

from tests.support import processes
from tests.support.jobs import tray_surface, two_valleys, write_stl
from weavesim.app.command_line import application

FABRIC = "glass-polypropylene-polynomial"
# The whole of both tools takes at most this on two idle cores [s].
WHOLE_HOUR = 600.0


@dataclass(frozen=True)
class Tool:
    """A tool of a newcomer, and what should come of it.

    Attributes:
        name: of the job.
        surface: vertices [mm] and triangles.
        opening: as ``weavesim new`` says it [mm].
        radius: the smallest convex one [mm].
        depth: of the die [mm].
        angles: between which the largest shear angle lies [degrees].
        hourglass: energy of the modes that elements have beside, over the internal one, at most.
        turned: share of the elements that are turned over at an edge, at most.
        shortened: smallest stretch of a yarn, at least.
        doubt: words of a warning that tells what the elements cannot follow.
    """

    name: str
    surface: Callable[[], tuple[np.ndarray, np.ndarray]]
    opening: str
    radius: float
    depth: float
    angles: tuple[float, float]
    hourglass: float = 0.01
    turned: float = 0.0
    shortened: float = 0.97
    doubt: str = "the shear law was measured up to"


TRAY = Tool("tray", tray_surface, "160 x 120", 8.0, 25.0, (52.0, 66.0))
# its radius has two of its elements on a quarter turn: the run says what that does
VALLEYS = Tool(
    "valleys",
    two_valleys,
    "144 x 84",
    3.0,
    12.0,
    (29.0, 41.0),
    0.12,
    0.015,
    0.95,
    "die: 1.8 elements of 2.5 mm along 90",
)


@dataclass
class Hour:
    """What the commands said and left.

    Attributes:
        folder: of the job.
        said: output of each command by its name, with single spaces.
        seconds: wall time of each.
        is_short: whether it is coarse and fast, in this process.
    """

    folder: Path
    is_short: bool = False
    said: dict[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    def call(self, *words: object, codes: tuple[int, ...] = (0,)) -> None:
        """Run a command in the folder above, as its user would; it ends with one of some exit ``codes``."""
        begin = time.monotonic()
        if self.is_short:
            result = CliRunner().invoke(application, [str(word) for word in words], catch_exceptions=False)
            code, said = result.exit_code, result.output
        else:
            done = processes.run(*words, cwd=self.folder.parent, timeout=900)
            code, said = done.returncode, done.stdout + done.stderr
        assert code in codes, (words, said[-3000:])
        self.said[str(words[0])] = " ".join(said.split())
        self.seconds[str(words[0])] = time.monotonic() - begin

    @property
    def out(self) -> Path:
        return self.folder / "out"


def the_hour(folder: Path, tool: Tool, new: tuple[str, ...] = (), form: tuple[str, ...] = ()) -> Hour:
    """new, check, form, view, export; in short with further words for two of them, in the present folder."""
    hour, name = Hour(folder / tool.name, is_short=bool(form)), tool.name
    write_stl(folder / "die.stl", *tool.surface())
    hour.call("new", name, "--die", "die.stl", "--thickness", "1.2", *new)
    job = hour.folder / "job.toml"
    text = job.read_text(encoding="utf-8")
    assert text.count('"glass-polypropylene"') == 1
    job.write_text(text.replace('"glass-polypropylene"', f'"{FABRIC}"'), encoding="utf-8")
    hour.call("check", f"{name}/job.toml")
    # a run that is coarse and fast on purpose should not be used, and says so by its exit code
    hour.call("form", f"{name}/job.toml", *form, codes=(0, 3) if hour.is_short else (0,))
    hour.call("view", f"{name}/out", "--no-open")
    hour.call("export", f"{name}/out", "--to", "calculix,csv")
    return hour


def check_words(hour: Hour, tool: Tool) -> None:
    """What is said is true of the tool, in words of its user."""
    new, check = hour.said["new"], hour.said["check"]
    for text in ("Unit: mm, guessed from the size of", "Up: +z", f"an opening of {tool.opening} mm with a flat rim"):
        assert text in new, new
    radius = float(re.search(r"smallest convex radius is about ([\d.]+) mm", new)[1])
    assert radius == pytest.approx(tool.radius, rel=0.15)
    # between the facets of both surfaces
    assert float(re.search(r"ok die - punch ([\d.]+) mm at", check)[1]) == pytest.approx(1.2, abs=0.07)
    for text in ("ring in touch at the start", "suggested:", "steps", "about", "smallest radius"):
        assert text in check, check
    assert (hour.folder / "job_check.png").stat().st_size > 20_000
    assert "verdict: " in hour.said["view"] and "max shear angle deg" in hour.said["view"]


def check_answer(hour: Hour, tool: Tool) -> dict:
    """Verdict, angles, shape and ledger of the run; returns its summary."""
    summary = processes.summary(hour.out)
    assert summary["outcome"] == "finished" and f"verdict: {summary['verdict']}" in hour.said["view"]
    low, high = tool.angles
    assert summary["fabric"] and low - (12.0 if hour.is_short else 0.0) < summary["max_shear_angle_deg"] < high
    assert abs(summary["energy_balance_error"]) < 0.01
    if not hour.is_short:
        assert summary["verdict"] != "do not use", summary["warnings"]
        assert summary["kinetic_energy_ratio"] < 0.05 and summary["hourglass_energy_ratio"] < tool.hourglass
        assert summary["inverted_elements"] <= tool.turned * summary["element_count"]
        assert summary["self_intersections"] == 0
        assert any(tool.doubt in warning for warning in summary["warnings"]), summary["warnings"]
    # the press has closed: the sheet lies at the bottom of the die, and its yarns are neither torn nor crumpled
    rows = np.genfromtxt(hour.out / "export" / f"{tool.name}.csv", delimiter=",", names=True)
    near = 1.5e-3 if hour.is_short else 0.4e-3
    assert rows["centre_z_m"].min() == pytest.approx(-1e-3 * tool.depth + 0.6e-3, abs=near)
    assert rows["centre_z_m"].max() == pytest.approx(0.6e-3, abs=near)
    assert tool.shortened < summary["min_stretch"] <= summary["max_stretch"] < 1.03
    assert np.abs(rows["shear_angle_deg"]).max() == pytest.approx(summary["max_shear_angle_deg"], abs=0.01)
    return summary


@dataclass(frozen=True)
class Deck:
    """An exported deck, read back.

    Attributes:
        text: of it.
        points: (n, 3) [m].
        quads: corners of the elements, (m, 4).
        axes: direction of material axis 1 of both layers, (m, 2, 3).
    """

    path: Path
    text: str
    points: np.ndarray
    quads: np.ndarray
    axes: np.ndarray


def deck_of(hour: Hour, tool: Tool) -> Deck:
    path = hour.out / "export" / f"{tool.name}_calculix.inp"
    mesh, text = meshio.read(path), path.read_text(encoding="utf-8")
    quads = mesh.cells_dict["quad8"][:, :4]
    axes = np.full((len(quads), 2, 3), np.nan)
    for label, layer, numbers in re.findall(r"\*ORIENTATION, NAME=O(\d+)_(\d), .*\n(.*)\n", text):
        axes[int(label) - 1, int(layer) - 1] = [float(number) for number in numbers.split(",")[:3]]
    return Deck(path, text, mesh.points, quads, axes)


def check_orientations(deck: Deck, hour: Hour, tool: Tool) -> None:
    """Both fibre directions of every element are those of its sides, which lay along the yarns of the flat blank."""
    corner = deck.points[deck.quads]
    sides = np.stack(
        [corner[:, a] - corner[:, 0] + corner[:, 2] - corner[:, b] for a, b in ((1, 3), (3, 1))], axis=1
    )  # fmt: skip
    sides /= np.linalg.norm(sides, axis=2, keepdims=True)
    assert np.isfinite(deck.axes).all()
    along = np.abs(np.einsum("eli,eli->el", deck.axes, sides))
    assert along.min() > np.cos(np.radians(0.5)), np.degrees(np.arccos(along.min()))
    # and they cross under the angle that the table of the same export says
    rows = np.genfromtxt(hour.out / "export" / f"{tool.name}.csv", delimiter=",", names=True)
    crossing = np.degrees(np.arcsin(np.clip(np.einsum("ei,ei->e", *deck.axes.transpose(1, 0, 2)), -1.0, 1.0)))
    assert np.abs(crossing) == pytest.approx(np.abs(rows["shear_angle_deg"]), abs=0.05)


def bent(deck: Deck, name: str, text: str) -> np.ndarray:
    """Displacements under ten times its weight of the part, held at its flange, in CalculiX, (n, 3) [m]."""
    flange = np.flatnonzero(deck.points[:, 2] > deck.points[:, 2].max() - 0.3e-3) + 1
    elements = re.search(r"\*ELEMENT, TYPE=\w+, ELSET=(\w+)", text)[1]
    lines = ["*NSET, NSET=FLANGE", *(f"{label}," for label in flange)]
    lines += ["*NSET, NSET=ALLNODES, GENERATE", f"1, {len(deck.points)}, 1", "*BOUNDARY", "FLANGE, 1, 6"]
    lines += ["*STEP", "*STATIC", "*DLOAD", f"{elements}, GRAV, 98.1, 0., 0., -1."]
    lines += ["*NODE PRINT, NSET=ALLNODES", "U", "*END STEP", ""]
    folder = deck.path.parent
    (folder / f"{name}.inp").write_text(text + "\n".join(lines), encoding="utf-8")
    done = subprocess.run(["ccx", name], cwd=folder, capture_output=True, text=True, timeout=600)
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    rows = [line.split() for line in (folder / f"{name}.dat").read_text().splitlines()]
    moved = np.array([[float(value) for value in row[1:]] for row in rows if len(row) == 4])
    assert moved.shape == deck.points.shape and np.isfinite(moved).all()
    assert -0.01 < moved[:, 2].min() < -1e-7 and np.abs(moved).max() < 0.01
    return moved


def askew(deck: Deck) -> str:
    """The deck with all fibres turned by 45 degrees in the surface."""
    corner = deck.points[deck.quads]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)

    def turned(match: re.Match) -> str:
        element, layer = int(match[2]) - 1, int(match[3]) - 1
        along = deck.axes[element, layer]
        first = np.sqrt(0.5) * (along + np.cross(normal[element], along))
        return match[1] + ", ".join(f"{x:.7f}" for x in (*first, *np.cross(normal[element], first))) + "\n"

    return re.sub(r"(\*ORIENTATION, NAME=O(\d+)_(\d), .*\n)(.*)\n", turned, deck.text)


def check_structure(deck: Deck, is_short: bool) -> tuple[float, float | None]:
    """CalculiX runs the part, and its fibre directions matter.

    Returns:
        how far it goes down [m]; and the change of all displacements if it is askew, over their size.
    """
    formed = bent(deck, "formed", deck.text)
    down = float(-formed[:, 2].min())
    if is_short:
        return down, None
    change = float(np.linalg.norm(bent(deck, "askew", askew(deck)) - formed) / np.linalg.norm(formed))
    assert change > 0.05
    return down, change


def record(hour: Hour, summary: dict, structure: tuple[float, float | None] | None) -> str:
    """The hour in a few lines."""
    times = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in hour.seconds.items())
    lines = [
        f"{hour.folder.name}: {times}",
        f"  {summary['element_count']} elements, {summary['step_count']} steps; verdict {summary['verdict']}; largest "
        f"angle {summary['max_shear_angle_deg']:.1f} degrees; balance {summary['energy_balance_error']:.1e}, kinetic "
        f"{summary['kinetic_energy_ratio']:.1e}; stretch {summary['min_stretch']:.4f} to {summary['max_stretch']:.4f}",
    ]
    if structure is not None:
        change = "" if structure[1] is None else f"; {100 * structure[1]:.1f} % otherwise with fibres at 45 degrees"
        lines.append(f"  CalculiX: it goes down by {1e3 * structure[0]:.4f} mm{change}")
    return "\n".join([*lines, *(f"  {warning}" for warning in summary["warnings"])])


def whole(folder: Path, tool: Tool, **words: tuple[str, ...]) -> Hour:
    """All of it for one tool, with all checks."""
    hour = the_hour(folder, tool, **words)
    check_words(hour, tool)
    summary = check_answer(hour, tool)
    deck, structure = deck_of(hour, tool), None
    check_orientations(deck, hour, tool)
    if shutil.which("ccx") is not None:
        begin = time.monotonic()
        structure = check_structure(deck, hour.is_short)
        hour.seconds["ccx"] = time.monotonic() - begin
    print("\n" + record(hour, summary, structure))
    return hour


@pytest.mark.slow
def test_the_hour_in_short(tmp_path, monkeypatch):
    """Coarse, and so fast that inertia has a say: the same steps and checks in seconds."""
    monkeypatch.chdir(tmp_path)
    quick = ("--set", "tools.punch.speed=2 m/s", "--set", "output.frame_count=4")
    some = ("--set", 'output.write=["summary", "results", "pictures"]')
    whole(tmp_path, TRAY, new=("--mesh-size", "10"), form=(*quick, *some))


@pytest.mark.hour
@pytest.mark.slow
def test_the_hour_of_a_newcomer(tmp_path):
    """Both tools with the jobs as they are written, in less than ten minutes where nothing else runs."""
    busy = os.getloadavg()[0]
    hours = [whole(tmp_path, tool) for tool in (TRAY, VALLEYS)]
    for hour in hours:
        page = (hour.out / "report.html").read_text(encoding="utf-8")
        assert len(page) > 100_000
        assert json.loads((hour.out / "run.json").read_text(encoding="utf-8"))["outcome"] == "finished"
    seconds = sum(sum(hour.seconds.values()) for hour in hours)
    used = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    print(f"\nboth: {seconds:.0f} s, {used:.0f} s of processors; load {busy:.1f} at the start")
    assert used < 2.0 * WHOLE_HOUR
    if busy < 0.5:
        assert seconds < WHOLE_HOUR
