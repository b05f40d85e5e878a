"""Damaged inputs of every reader: refused in words, or read without a number that is not finite; never slowly."""

from __future__ import annotations

import json
import resource
import signal
import time
import traceback
from collections.abc import Callable, Iterator
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
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.meshes import read_mesh
from weavesim.output.measured import load_measured_angles, load_measured_outline
from weavesim.run.checkpoint.container import DamageError, packed, unpacked
from weavesim.run.checkpoint.journal import FrameJournal

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
    """

    name: str
    content: bytes
    read: Callable[[Path], Any]


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
        for number in range(count):
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
