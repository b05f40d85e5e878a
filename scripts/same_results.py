"""Whether this checkout computes the same bits as another commit: proof that a change of the code changes no result.

    python scripts/same_results.py --commit 4add259                      both versions, all cases
    python scripts/same_results.py --reference ../reference [--quick]    results of the commit are kept there, and used
    python scripts/same_results.py --reference ../reference --record     only run what is missing there
    python scripts/same_results.py --reference ../reference --case cantilever --extra=--damping=101

Every case is one call of the command line, in a process of its own. Compared are, bit for bit: every number of every
frame (ledger, stroke, tools, supports, steps, time) and hashes of its positions, directors and fields; these arrays of
the last frame; all CSV tables; the final state for ParaView; and the summary but for what depends on the clock. Bytes
of film, ParaView series and pictures are told in a column of their own and change nothing in the verdict. Ends with
exit code 1 if anything differs or a run fails. Bits belong to a processor and a version of Warp: keep no reference
from another machine.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
import platform
import re
import shutil
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from shared.checkouts import checked_out, environment, full_name  # noqa: E402

REFERENCE_COMMIT = "4add259"


# --- cases ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """One call of the command line.

    Attributes:
        words: ``{inputs}`` in them is the folder of ``write_inputs``.
        quick: whether it is one of the few that ``--quick`` runs.
        changed: what was changed on purpose; differences are then shown and not counted.
    """

    words: str
    quick: bool = False
    changed: str = ""

    def arguments(self, inputs: Path) -> list[str]:
        return [word.format(inputs=inputs) for word in self.words.split()]


COARSE_DOME = "double-dome --mesh-size 0.01 "
RUBBING_DOME = COARSE_DOME + "--fabric {inputs}/rubbing.toml "
RUBBING_FRAME = "picture-frame --mesh-size 0.025 --cycle --fabric {inputs}/rubbing.toml --precision float64 "
# With a step of their own choice runs show that no more than the choice was changed.
FIXED_STEP = "--time-step 2e-6"
YARN_STEP = "the stable step of bending per yarn family (docs/decisions/0021-bounds-of-coupled-terms.md)"
MESH_TOOLS = "--punch {inputs}/punch.stl --die {inputs}/die.stl --binder {inputs}/binder.stl --unit-scale 0.001"

CASES = {
    "double-dome-quarter": Case("double-dome", quick=True),
    "double-dome-quarter-float64": Case("double-dome --precision float64"),
    "double-dome-full": Case("double-dome --part full"),
    "double-dome-full-float64": Case("double-dome --part full --precision float64"),
    "hemisphere-low-bending": Case("hemisphere --case low-bending"),
    "hemisphere-high-bending": Case("hemisphere --case high-bending"),
    "hemisphere-float64": Case("hemisphere --case low-bending --mesh-size 0.01 --precision float64"),
    "picture-frame": Case("picture-frame --mesh-size 0.02"),
    "picture-frame-cycle": Case("picture-frame --cycle"),
    "picture-frame-arms": Case("picture-frame --mesh-size 0.02 --arm-length 0.04 --misalignment 3 --shear-law linear"),
    "picture-frame-friction-float64": Case(RUBBING_FRAME, changed=YARN_STEP),
    "picture-frame-friction-float64-fixed-step": Case(RUBBING_FRAME + FIXED_STEP),
    "bias-extension": Case("bias-extension"),
    "bias-extension-float64": Case("bias-extension --mesh-size 0.0125 --precision float64"),
    "cantilever": Case("cantilever", quick=True),
    "cantilever-weft-float32": Case("cantilever --yarn weft --precision float32"),
    "dome-rubbing-fabric": Case(RUBBING_DOME, changed=YARN_STEP),
    "dome-rubbing-fabric-float64": Case(RUBBING_DOME + "--precision float64", changed=YARN_STEP),
    "dome-rubbing-fabric-fixed-step": Case(RUBBING_DOME + FIXED_STEP, quick=True),
    "dome-rubbing-fabric-float64-fixed-step": Case(RUBBING_DOME + FIXED_STEP + " --precision float64"),
    "dome-twill": Case(COARSE_DOME + "--fabric assumed-twill"),
    "dome-satin-half": Case(COARSE_DOME + "--fabric assumed-satin-5 --part half --blank-holder-gap 0.0001"),
    "dome-stitched-tape": Case(COARSE_DOME + "--fabric assumed-stitched-tape"),
    "dome-membrane-turned": Case(COARSE_DOME + "--fabric assumed-linear-membrane --part full --yarn-angle 30"),
    "dome-current-thickness": Case(COARSE_DOME + "--contact-thickness current"),
    "dome-mesh-tools": Case(COARSE_DOME + MESH_TOOLS, quick=True),
    "dome-mass-scaling": Case(COARSE_DOME + "--target-step 4e-6"),
}

# Other spellings of an option of the cases, in versions before or after this one: the first that a version knows is
# taken. {"--binder": ("--binder", "--holder")}
SPELLINGS: dict[str, tuple[str, ...]] = {"--binder": ("--blank-holder", "--binder")}
# Names of entries that were changed on purpose, old to new.
RENAMED: dict[str, str] = {}

RUBBING_FABRIC = """\
# plain weave with friction of the crossovers, and yarns whose bending is a curve with a loop
based_on = "glass-polypropylene"
name = "rubbing fabric"

[shear_friction]
stiffness = 60.0
limit = [0.5, 0.8]
angle = [0.0, 0.6]
crossover_friction_length = 1e-4

[bending]
kind = "YarnBending"
twist = 1.4e-3
warp = {kind = "BendingCurve.from_kawabata", rigidity = 2.9e-3, hysteresis = 2.0e-2}

[bending.weft]
kind = "BendingCurve"
curvature = [0.0, 10.0, 50.0]
moment_values = [0.0, 0.023, 0.072]
friction_limit = 0.008
friction_stiffness = 0.0008
"""


def write_inputs(folder: Path) -> None:
    """What the cases read: a fabric, and the tools of a double dome as open meshes in millimetres.

    Files that are there stay, so that both versions read the same.
    """
    turn = np.linspace(0.0, 0.5 * np.pi, 25)
    punch = np.column_stack([60.0 * np.sin(turn), 60.0 * (1.0 - np.cos(turn))])
    wall = [(61.2, -30.0), (61.2, -20.0)]
    edge = np.column_stack([71.2 - 10.0 * np.cos(turn), -10.0 + 10.0 * np.sin(turn)])
    die = np.vstack([wall, edge, [(130.0, 0.0), (200.0, 0.0)]])
    files = {
        "rubbing.toml": RUBBING_FABRIC.encode(),
        "punch.stl": stl(punch),
        "die.stl": stl(die),
        "binder.stl": stl(die * (1.0, -1.0)),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        path = folder / name
        if path.exists() and path.read_bytes() != content:
            raise SystemExit(f"{path} is not what the cases are made with now: record the reference anew")
        path.write_bytes(content)


def stl(profile: np.ndarray, half_length: float = 85.0, corner_count: int = 24) -> bytes:
    """A profile (k, 2) of radius and height, swept around a segment along x, as binary STL."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, corner_count + 1)
    angle = np.concatenate([angle, angle + np.pi])
    centre = np.repeat([half_length, -half_length], corner_count + 1)
    radius, height = profile[:, 0, None], profile[:, 1, None] + 0.0 * angle
    ring = np.stack([centre + radius * np.cos(angle), radius * np.sin(angle), height], axis=2)
    a, b = ring, np.roll(ring, -1, axis=1)
    corners = np.stack([a[:-1], b[:-1], b[1:], a[:-1], b[1:], a[1:]], axis=2).reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    corners = corners[area > 1e-6].astype("<f4")
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets["corners"] = corners
    return bytes(80) + struct.pack("<I", len(facets)) + facets.tobytes()


# --- running ----------------------------------------------------------------------------------------------------------


def run_case(case: Case, checkout: Path, inputs: Path, folder: Path, threads: int, extra: Sequence[str] = ()) -> float:
    """Run a case in ``checkout`` and leave its results in ``folder``; returns the seconds that it took.

    Raises:
        RuntimeError: the run did not finish; what it said last.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    arguments = spelled([*case.arguments(inputs), *extra], checkout)
    arguments += ["--threads", str(threads), "--out", str(folder / "out")]
    command = [
        sys.executable,
        "-P",
        str(ROOT / "scripts" / "shared" / "recorded_run.py"),
        str(folder / "frames.npz"),
        *arguments,
    ]
    started = time.perf_counter()
    with open(folder / "output.txt", "w", encoding="utf-8") as output:
        result = subprocess.run(
            command, cwd=checkout, env=environment(checkout), stdout=output, stderr=subprocess.STDOUT, check=False
        )
    if result.returncode:
        lines = (folder / "output.txt").read_text(encoding="utf-8").strip().splitlines()
        raise RuntimeError(lines[-1] if lines else f"exit code {result.returncode}")
    return time.perf_counter() - started


def spelled(arguments: list[str], checkout: Path) -> list[str]:
    """``arguments`` with the names that the options have in ``checkout``."""
    if not set(arguments) & set(SPELLINGS):
        return arguments
    command = [sys.executable, "-m", "weavesim", arguments[0], "--help"]
    told = subprocess.run(command, cwd=checkout, env=environment(checkout), capture_output=True, text=True, check=True)
    known = set(told.stdout.split())
    return [next((name for name in SPELLINGS.get(word, ()) if name in known), word) for word in arguments]


def machine() -> dict[str, str]:
    """What bits depend on beside the code."""
    processor = platform.processor() or platform.machine()
    if (cpu_info := Path("/proc/cpuinfo")).exists():
        lines = cpu_info.read_text(encoding="utf-8").splitlines()
        processor = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), processor)
    return {"processor": processor, "warp": version("warp-lang"), "numpy": np.__version__}


# --- reading ----------------------------------------------------------------------------------------------------------

# Entries of the summary that differ from run to run.
OF_THE_CLOCK = {
    "wall_time_s", "stepping_time_s", "output_time_s", "element_steps_per_second", "threads", "weavesim_version",
}  # fmt: skip

# Files that are compared byte by byte, and only told.
BYTES_ONLY = (".usdc", ".png", ".vtu", ".pvd")


def read_results(folder: Path) -> dict[str, np.ndarray]:
    """Every entry of a run by its name, numbers with all their bits and tables as they are written."""
    entries: dict[str, np.ndarray] = {}
    with np.load(folder / "frames.npz") as record:
        entries |= {name: record[name] for name in record.files}
    out = folder / "out"
    for path in sorted(out.rglob("*.csv")):
        entries |= {f"{path.name}/{name}": column for name, column in read_table(path).items()}
    for path in sorted(out.rglob("final_state.vtu")):
        entries |= {f"{path.name}/{name}": values for name, values in read_final_state(path)}
    for path in sorted(out.rglob("summary.json")):
        # notes name the tool meshes with their folder
        summary = json.loads(re.sub(r"[^\s\"]*/inputs/", "inputs/", path.read_text(encoding="utf-8")))
        entries |= {f"{path.name}/{name}": values for name, values in leaves(summary) if name not in OF_THE_CLOCK}
    return {RENAMED.get(name, name): values for name, values in entries.items()}


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV as text, by their header."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: np.array([row[k] for row in rows], dtype=str) for k, name in enumerate(header)}


def read_final_state(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    import meshio

    mesh = meshio.read(path)
    yield "points", mesh.points
    yield "quads", mesh.cells[0].data
    yield from mesh.point_data.items()
    for name, blocks in mesh.cell_data.items():
        yield name, blocks[0]


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Entries of nested JSON; a list is one entry if it is of numbers or of texts."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from leaves(item, f"{name}.{key}" if name else key)
    elif isinstance(value, list) and any(isinstance(item, Mapping | list) for item in value):
        for index, item in enumerate(value):
            yield from leaves(item, f"{name}.{index}")
    else:
        yield name, np.asarray("null" if value is None else value)


def other_files(folder: Path) -> dict[str, str]:
    """SHA-256 of what is compared as bytes, by path."""
    out = folder / "out"
    return {
        str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.suffix in BYTES_ONLY and path.name != "final_state.vtu"
    }


def sha256(values: np.ndarray) -> str:
    """Of kind, shape and bits."""
    head = f"{values.dtype.str} {values.shape} ".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()


# --- comparing --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Difference:
    """An entry that is not the same.

    Attributes:
        name: of the entry.
        text: what happened to it.
        frame: the first at which it differs, None if it is not of frames.
        size: largest difference over the largest magnitude; None if it is not of numbers.
    """

    name: str
    text: str
    frame: int | None = None
    size: float | None = None

    def __str__(self) -> str:
        return f"{self.name}: {self.text}"


def difference(name: str, before: np.ndarray, after: np.ndarray) -> Difference | None:
    """How ``after`` differs from ``before`` in kind, shape or any bit; None if it does not."""
    if _kind(before) != _kind(after):
        return Difference(name, f"{_kind(before)} became {_kind(after)}")
    of_frames = name.startswith("frames/") and before.ndim > 0
    if of_frames and before.shape[1:] == after.shape[1:] and len(before) != len(after):
        # a run that ends earlier or later: where it parts ways says more than its length
        count = min(len(before), len(after))
        text = f"{len(before)} frames became {len(after)}"
        if one := difference(name, before[:count], after[:count]):
            return replace(one, text=f"{one.text}; {text}")
        return Difference(name, text, frame=count)
    if before.shape != after.shape:
        return Difference(name, f"shape {before.shape} became {after.shape}")
    differs = _bits(before) != _bits(after) if before.dtype.kind not in "US" else before != after
    if not differs.any():
        return None
    first = tuple(int(index) for index in np.argwhere(differs)[0])
    frame = first[0] if of_frames else None
    size = relative_size(before, after)
    text = f"{before[first]} became {after[first]}"
    if len(text) > 80:
        text = "differs"
    place = f"frame {frame}, " if frame is not None else ""
    text = f"{place}{text}, {int(differs.sum())} of {differs.size} values"
    return Difference(name, text if size is None else f"{text}, relative difference {size:.2g}", frame, size)


def _kind(values: np.ndarray) -> str:
    return {"U": "text", "S": "hash"}.get(values.dtype.kind, values.dtype.name)


def _bits(values: np.ndarray) -> np.ndarray:
    """Values as whole numbers: 0.0 is not -0.0, and a NaN is itself."""
    return np.ascontiguousarray(values).reshape(values.shape).view(f"u{values.dtype.itemsize}")


def relative_size(before: np.ndarray, after: np.ndarray) -> float | None:
    """Largest difference over the largest magnitude; None if these are no numbers."""
    if before.dtype.kind == "S":
        return None
    try:
        a, b = (np.asarray(values).astype(np.float64) for values in (before, after))
    except ValueError:
        return None
    same_nan = np.isnan(a) & np.isnan(b)
    with np.errstate(invalid="ignore"):
        gap = np.where(same_nan | (a == b), 0.0, np.abs(a - b))
    if not np.isfinite(gap).all():
        return math.inf
    scale = max((float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) for values in (a, b)), default=0.0)
    return float(gap.max(initial=0.0)) / scale if scale > 0.0 else 0.0


def differences(before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray]) -> list[Difference]:
    """All entries that differ: those of the earliest frame first, there the largest, then the others in their order."""
    found = [Difference(name, "is missing") for name in before if name not in after]
    found += [Difference(name, "is new") for name in after if name not in before]
    for name in before:
        if name in after and (one := difference(name, before[name], after[name])):
            found.append(one)
    return sorted(found, key=lambda one: (math.inf if one.frame is None else one.frame, -(one.size or 0.0)))


@dataclass
class Verdict:
    """What is said of a case."""

    case: str
    entry_count: int = 0
    seconds: float = math.nan
    found: list[Difference] = field(default_factory=list)
    changed_files: list[str] = field(default_factory=list)
    file_count: int = 0
    failure: str | None = None

    @property
    def same(self) -> bool:
        return not self.found and self.failure is None

    @property
    def wrong(self) -> bool:
        """Whether something differs that was not changed on purpose."""
        return self.failure is not None or bool(self.found and not self.changed)

    @property
    def changed(self) -> str:
        """What was changed on purpose; nothing for a case that is not in ``CASES``."""
        return CASES[self.case].changed if self.case in CASES else ""

    def row(self) -> list[str]:
        if self.failure is not None:
            result = f"FAILED: {self.failure}"
        else:
            result = "same" if self.same else f"DIFFERENT ({len(self.found)} entries)"
            if self.changed and not self.same:
                result = f"changed on purpose ({len(self.found)} entries): {self.changed}"
        files = f"{len(self.changed_files)} of {self.file_count} differ: {self.changed_files[0]}" if (
            self.changed_files
        ) else "same"  # fmt: skip
        first = str(self.found[0]) if self.found else ""
        return [self.case, str(self.entry_count), f"{self.seconds:.0f}", result, first, files]


def compare(case: str, reference: Path, here: Path) -> Verdict:
    """The results in two folders."""
    before, after = read_results(reference), read_results(here)
    files, files_after = other_files(reference), other_files(here)
    changed = [name for name in files | files_after if files.get(name) != files_after.get(name)]
    return Verdict(
        case, len(before), found=differences(before, after), changed_files=changed, file_count=len(files | files_after)
    )


def table(verdicts: Sequence[Verdict]) -> str:
    """A markdown table."""
    lines = ["| case | entries | seconds | results | first difference | film, series, pictures |", "|" + "---|" * 6]
    return "\n".join(lines + ["| " + " | ".join(verdict.row()) + " |" for verdict in verdicts])


# --- the command ------------------------------------------------------------------------------------------------------


class Reference:
    """Results of a commit in a folder; what is missing there, or was made otherwise, is run and added."""

    def __init__(self, folder: Path, commit: str, threads: int, stack: ExitStack) -> None:
        self.folder, self.commit, self._threads, self._stack = folder, full_name(commit), threads, stack
        self.inputs = folder / "inputs"
        self._checkout: Path | None = None
        write_inputs(self.inputs)

    def result(self, name: str, say: Callable[[str], None]) -> Path:
        """The folder of a case's results."""
        folder, about = self.folder / name, {"commit": self.commit, "words": CASES[name].words}
        file = folder / "case.json"
        if file.exists():
            known = json.loads(file.read_text(encoding="utf-8"))
            if {key: known.get(key) for key in about} == about:
                if known["machine"] != machine():
                    say(f"{name}: the reference was made with {known['machine']}, this is {machine()}: bits may differ")
                return folder
            if known.get("commit") != self.commit:
                raise SystemExit(f"{folder} has results of {known.get('commit')}, not of {self.commit}")
        if self._checkout is None:
            self._checkout = self._stack.enter_context(checked_out(self.commit))
        seconds = run_case(CASES[name], self._checkout, self.inputs, folder, self._threads)
        say(f"{name}: {self.commit[:7]} took {seconds:.0f} s")
        file.write_text(json.dumps(about | {"machine": machine(), "seconds": seconds}, indent=2) + "\n")
        return folder


def main(
    commit: Annotated[str, typer.Option(help="the version to compare with")] = REFERENCE_COMMIT,
    case: Annotated[list[str] | None, typer.Option(help="one of --list; may be repeated [default: all]")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="only a few cases, less than a minute each version")] = False,
    reference: Annotated[
        Path | None, typer.Option(help="results of the commit: taken from here, or run once and kept here")
    ] = None,
    record: Annotated[bool, typer.Option("--record", help="only run what --reference lacks")] = False,
    keep: Annotated[Path | None, typer.Option(help="keep the results of this checkout here")] = None,
    hashes: Annotated[Path | None, typer.Option(help="write a JSON of the SHA-256 of every entry here")] = None,
    extra: Annotated[
        list[str] | None, typer.Option(help="argument for this checkout's runs only, to see a difference found")
    ] = None,
    threads: Annotated[int, typer.Option(min=1, help="CPU threads; the bits do not depend on them")] = 2,
    every: Annotated[bool, typer.Option("--all-differences", help="list every entry that differs")] = False,
    listing: Annotated[bool, typer.Option("--list", help="list the cases and do nothing")] = False,
) -> None:
    """Compare every bit that this checkout computes with another commit."""
    if listing:
        for name, one in CASES.items():
            typer.echo(f"{name}{' (quick)' if one.quick else ''}: weavesim {one.words}")
        return
    if record and reference is None:
        raise typer.BadParameter("say where with --reference", param_hint="--record")
    names = case or [name for name, one in CASES.items() if one.quick or not quick]
    if unknown := [name for name in names if name not in CASES]:
        raise typer.BadParameter(f"{', '.join(unknown)}: choose from {', '.join(CASES)}", param_hint="--case")

    def say(text: str) -> None:
        typer.echo(text, err=True)

    verdicts: list[Verdict] = []
    digests: dict[str, dict[str, dict[str, str]]] = {}
    with ExitStack() as stack:
        temporary = Path(stack.enter_context(TemporaryDirectory(prefix="weavesim-same-")))
        known = Reference((reference or temporary / "reference").resolve(), commit, threads, stack)
        for name in names:
            here = (keep or temporary / "here").resolve() / name
            verdict = Verdict(name)
            verdicts.append(verdict)
            try:
                there = known.result(name, say)
                if record:
                    continue
                seconds = run_case(CASES[name], ROOT, known.inputs, here, threads, extra or ())
                verdicts[-1] = verdict = compare(name, there, here)
                verdict.seconds = seconds
            except (RuntimeError, OSError) as error:
                verdict.failure = str(error)
            if not (record and verdict.same):
                say(f"{name}: {verdict.row()[3]}")
            if hashes is not None and verdict.failure is None:
                digests[name] = {
                    label: {entry: sha256(values) for entry, values in read_results(folder).items()}
                    for label, folder in (("reference", there), ("here", here))
                }
            if reference is None:
                shutil.rmtree(known.folder / name, ignore_errors=True)
            if keep is None:
                shutil.rmtree(here, ignore_errors=True)
    if record:
        failed = [verdict.case for verdict in verdicts if verdict.failure is not None]
        typer.echo(f"{known.folder} has {len(names) - len(failed)} of {len(names)} cases of {known.commit[:7]}")
        raise typer.Exit(1 if failed else 0)
    if hashes is not None:
        about = {"commit": known.commit, "machine": machine(), "cases": digests}
        hashes.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
    typer.echo(f"this checkout beside {known.commit[:7]}; {', '.join(machine().values())}\n")
    typer.echo(table(verdicts))
    if every:
        for verdict in verdicts:
            for one in verdict.found:
                typer.echo(f"{verdict.case}: {one}")
    same = [verdict for verdict in verdicts if verdict.same]
    changed = [verdict for verdict in verdicts if not verdict.same and not verdict.wrong]
    typer.echo(f"\n{len(same)} of {len(verdicts)} cases are the same to the last bit")
    if changed:
        typer.echo(f"{len(changed)} were changed on purpose: {', '.join(verdict.case for verdict in changed)}")
    if any(verdict.wrong for verdict in verdicts):
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)
