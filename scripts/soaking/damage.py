"""Damaged inputs of every reader: refused in words, or read without a number that is not finite; never slowly."""

from __future__ import annotations

import json
import resource
import signal
import time
import traceback
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.support.every_kind import every_kind
from tests.support.jobs import TRAY, write_tray
from tests.support.made_run import made_stack
from tests.unit.meshes.test_damaged_files import damaged, good_files
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.file import load_fabric
from weavesim.job.blanks.outlines import read_drawing
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.meshes import read_mesh
from weavesim.output.comparison.points import read_points
from weavesim.output.comparison.runs import compare_scan
from weavesim.output.export.lamina import ASSUMED, Lamina
from weavesim.output.flat.part_edge import read_part_edge
from weavesim.output.measured import load_measured_angles, load_measured_outline
from weavesim.output.stored.file import read_results, write_results
from weavesim.output.stored.judged import read_limits
from weavesim.run.checkpoint.container import DamageError, packed, unpacked
from weavesim.run.checkpoint.journal import FrameJournal
from weavesim.study.read import read_study

ROOT = Path(__file__).resolve().parents[2]
# Of one file [s], and of all of them together [bytes].
LONGEST, LARGEST_GROWTH = 30.0, 2**29
KINDS = (InputError, DamageError)


class Reader(NamedTuple):
    """A reader and a good file for it.

    Attributes:
        name: of the file.
        content: of the file.
        read: reads the file, and returns all numbers of it that have to be finite.
        share: of so many damaged files only one is tried: a process of its own takes a second for each.
    """

    name: str
    content: bytes
    read: Callable[[Path], Any]
    share: int = 1


def readers(folder: Path) -> Iterator[Reader]:
    """Every reader of weavesim."""
    for name, content in good_files().items():
        yield Reader(name, content, lambda path: read_mesh(path).vertices)
    yield Reader("angles.csv", b"point,angle_deg\n1,10.5\n2,-20\n3,30\n", lambda path: load_measured_angles(path)[1])
    yield Reader("outline.csv", b"x_mm;y_mm\n0,5;1,25\n2;3\n4;5,5\n", load_measured_outline)
    page = (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")
    (folder / "frame.csv").write_text("angle,force\n0,0\n0.35,5\n0.7,20\n")
    fabric = page.split("```toml\n")[1].split("```")[0]
    yield Reader("fabric.toml", fabric.encode(), lambda path: load_fabric(path).areal_density)
    write_tray(folder, TRAY)
    yield Reader("job.toml", TRAY.encode(), lambda path: setup_of(read_job(path)).duration)
    setup = every_kind()["supports and loads"].to_json().encode()
    yield Reader("setup.json", setup, lambda path: Setup.from_json(path.read_bytes()).duration)
    arrays = {"a": np.arange(100.0), "b": np.eye(9, dtype=np.float32)}
    whole = b"".join(packed({"numbers": list(range(100))}, arrays))
    yield Reader("checkpoint.bin", whole, lambda path: unpacked(path.read_bytes()).arrays["a"])
    journal = FrameJournal(folder / "frames.bin")
    journal.begin()
    for frame in made_stack(2)[1]:
        journal.append(frame)
    count, size = journal.count, journal.size
    kept = journal.path.read_bytes()
    yield Reader("frames.bin", kept, lambda path: [f.time for f in FrameJournal(path).frames(count, size)])
    yield from _readers_of_drawings(folder)
    yield from _readers_of_results(folder)


def _readers_of_drawings(folder: Path) -> Iterator[Reader]:
    """What CAD writes: drawings, and surfaces if the package that reads them is there."""
    drawing = _drawing(folder / "good.dxf")
    yield Reader("blank.dxf", drawing, lambda path: read_drawing(path).outline)
    yield Reader("edge.dxf", drawing, lambda path: read_part_edge(path).outline)
    edge = b"x [mm],y [mm],z [mm]\n-50,-30,0\n50,-30,1\n50,30,0\n-50,30,1\n"
    yield Reader("edge.csv", edge, lambda path: read_part_edge(path).outline)
    border = good_files()["binary.stl"]
    yield Reader("edge.stl", border, lambda path: read_part_edge(path, metres_per_unit=1e-3).outline)
    if find_spec("OCP") is None:
        print("STEP and IGES: not tried, since cadquery-ocp-novtk is not installed", flush=True)
        return
    from tests.unit.meshes.test_cad import box, write

    for name in ("a.step", "a.igs"):
        whole = write(folder / f"good{Path(name).suffix}", box(8.0)).read_bytes()
        yield Reader(name, whole, lambda path: read_mesh(path).vertices, share=10)


def _drawing(path: Path) -> bytes:
    """A blank with an arc in its outline, a hole in a block, a slit, and a curve."""
    import ezdxf

    drawing = ezdxf.new("R2010", units=4)
    space = drawing.modelspace()
    space.add_lwpolyline([(0, 0), (200, 0), (200, 100, 0.3), (0, 100)], format="xyb", close=True)
    drawing.blocks.new("hole").add_circle((0, 0), 10)
    space.add_blockref("hole", (50, 50))
    space.add_line((120, 20), (120, 60))
    space.add_spline([(150, 30), (160, 50), (150, 70), (140, 50), (150, 30)])
    drawing.saveas(path)
    return path.read_bytes()


def _readers_of_results(folder: Path) -> Iterator[Reader]:
    """What is read beside the end of a run, and that end itself."""
    info, frames = made_stack(2)
    write_results(folder / "results.h5", info, frames[-1], "finished")
    whole = (folder / "results.h5").read_bytes()
    sheet = read_results(folder).sheets[0]

    def numbers(path: Path) -> list[float]:
        found = read_results(path.parent).sheets
        return [float(values.sum()) for each in found for values in (each.position, each.director)]

    yield Reader("results.h5", whole, numbers)
    limits = b"wrinkle_amplitude = 1e-3\nlocking_angle = 50.0\nbridging_gap = 0.5e-3\n"
    yield Reader("limits.toml", limits, lambda path: read_limits(path).longest_wavelength)
    lamina = ASSUMED.to_json().encode()
    yield Reader(
        "lamina.json", lamina, lambda path: list(Lamina.from_file(path).model_dump(exclude={"source"}).values())
    )
    page = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    study = next(part for part in page.split("```toml\n")[1:] if part.startswith("job")).split("```")[0]
    (folder / "job.toml").write_bytes(TRAY.encode())
    yield Reader("study.toml", study.encode(), lambda path: len(read_study(path).factors))
    points = b"x [mm],y [mm],z [mm],shear_angle [deg]\n0,0,0,10.5\n10,5,-1,20\n20,30,-2,3e1\n"
    yield Reader("points.csv", points, lambda path: read_points(path).space)
    scan = good_files()["text.stl"]
    size = np.linalg.norm(np.ptp(sheet.position, axis=0)) / np.linalg.norm(np.ptp(_vertices(folder, scan), axis=0))
    yield Reader("scan.stl", scan, lambda path: compare_scan(sheet, path, float(size)).distance)


def _vertices(folder: Path, content: bytes) -> np.ndarray:
    (folder / "good.stl").write_bytes(content)
    return read_mesh(folder / "good.stl").vertices


def one(reader: Reader, path: Path, random: np.random.Generator) -> str:
    """Read one damaged file: "read", "refused", or what is wrong."""
    data = damaged(reader.content, random)
    path.write_bytes(data)
    started = time.process_time()
    try:
        numbers = reader.read(path)
    except KINDS as error:
        if "\nTraceback" in str(error) or len(str(error)) > 4000:
            return f"an unreadable message: {str(error)[:200]}"
        answer = "refused"
    except TimeoutError:
        return "a hang"
    except BaseException:
        return traceback.format_exc(limit=-3)
    else:
        if not np.all(np.isfinite(np.asarray(numbers, dtype=float))):
            return "a number that is not finite"
        answer = "read"
    passed = time.process_time() - started
    return answer if passed < LONGEST else f"{passed:.0f} s"


def damage(folder: Path, count: int, seed: int) -> bool:
    """``count`` damaged files for each reader; those that are not answered well are kept in ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)

    def late(number: int, stack: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    well = True
    for reader in readers(folder):
        random = np.random.default_rng([seed, *reader.name.encode()])
        path, before = folder / reader.name, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        answers: dict[str, int] = {}
        path.write_bytes(reader.content)
        reader.read(path)  # else nothing would be tested
        for number in range(max(1, count // reader.share)):
            signal.alarm(int(2 * LONGEST))
            answer = one(reader, path, random)
            signal.alarm(0)
            if answer not in ("read", "refused"):
                kept = folder / f"{number}-{reader.name}"
                kept.write_bytes(path.read_bytes())
                print(f"FAILED: {kept}: {answer}", flush=True)
                answer = "failed"
            answers[answer] = answers.get(answer, 0) + 1
        growth = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
        well = well and "failed" not in answers and growth < LARGEST_GROWTH
        print(f"{reader.name}: {json.dumps(answers)}, {growth / 1e6:.0f} MB more memory", flush=True)
    return well
