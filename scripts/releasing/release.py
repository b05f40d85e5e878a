"""Build a release so that anybody gets the same bytes from the same commit.

    python scripts/releasing/release.py               # dist/: sdist, wheel, SHA256SUMS
    python scripts/releasing/release.py --commit v1.0 # of another commit

The files of the commit are exported twice, to folders of different names and times, and built there one after the
other; the wheel of the second is built from its sdist. The archives must agree to the byte, or the release fails.
Neither the network nor what lies about in the checkout is used. Needed: git, and setuptools of the extra ``test``.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import Annotated

import typer

ROOT = Path(__file__).resolve().parents[2]
BACKEND = "import setuptools.build_meta as b, sys; print(getattr(b, 'build_' + sys.argv[1])(sys.argv[2]))"


def run(*words: str, cwd: Path, epoch: int = 0) -> bytes:
    """Run a command and return what it printed.

    Raises:
        SystemExit: it failed.
    """
    environment = {**os.environ, "SOURCE_DATE_EPOCH": str(epoch), "PYTHONHASHSEED": "0"}
    done = subprocess.run(words, cwd=cwd, env=environment, capture_output=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(words)} ended with exit code {done.returncode}:\n{done.stderr.decode()}")
    return done.stdout


def export(commit: str, folder: Path) -> None:
    """Write the files of a commit to ``folder``, with the present as their time and the same rights for all."""
    folder.mkdir(parents=True)
    with tarfile.open(fileobj=io.BytesIO(run("git", "archive", "--format=tar", commit, cwd=ROOT))) as archive:
        archive.extractall(folder, filter="data")
    for path in folder.rglob("*"):
        path.chmod(0o755 if path.is_dir() or os.access(path, os.X_OK) else 0o644)
        os.utime(path)


def normalise(archive: Path, epoch: int) -> None:
    """Rewrite a .tar.gz without what differs from build to build: times, owners, order, the time in gzip's header."""
    entries: list[tuple[tarfile.TarInfo, bytes]] = []
    with tarfile.open(archive) as old:
        for entry in sorted(old.getmembers(), key=lambda one: one.name):
            entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = epoch, 0, 0, "", ""
            entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
            entry.pax_headers = {}
            file = old.extractfile(entry) if entry.isfile() else None
            entries.append((entry, file.read() if file else b""))
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.PAX_FORMAT) as new:
        for entry, data in entries:
            new.addfile(entry, io.BytesIO(data))
    with archive.open("wb") as target, gzip.GzipFile("", "wb", 9, target, mtime=epoch) as packed:
        packed.write(plain.getvalue())


def build(folder: Path, kind: str, epoch: int) -> Path:
    """Build ``kind``, "sdist" or "wheel", of the files in ``folder`` and return its path."""
    out = folder.parent / f"dist_of_{folder.name}"
    out.mkdir(exist_ok=True)
    said = run(sys.executable, "-c", BACKEND, kind, str(out), cwd=folder, epoch=epoch)
    made = out / said.decode().strip().splitlines()[-1]
    if kind == "sdist":
        normalise(made, epoch)
    return made


def unpacked(sdist: Path, folder: Path) -> Path:
    """The one folder inside an sdist, unpacked to ``folder``."""
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (inside,) = folder.iterdir()
    return inside


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def both_builds(commit: str, epoch: int, folder: Path) -> tuple[list[Path], list[Path]]:
    """Sdist and wheel of a commit, built twice in different places; the second wheel from the second sdist."""
    first, second = folder / "first", folder / "a_second_place"
    export(commit, first)
    one = [build(first, "sdist", epoch), build(first, "wheel", epoch)]
    export(commit, second)
    sdist = build(second, "sdist", epoch)
    return one, [sdist, build(unpacked(sdist, folder / "from_sdist"), "wheel", epoch)]


def main(
    commit: Annotated[str, typer.Option(help="what to build")] = "HEAD",
    out: Annotated[Path, typer.Option(help="folder for the archives")] = ROOT / "dist",
) -> None:
    """Build a release twice, compare, and keep it."""
    epoch = int(run("git", "log", "-1", "--format=%ct", commit, cwd=ROOT))
    with tempfile.TemporaryDirectory(prefix="weavesim-release-") as temporary:
        one, other = both_builds(commit, epoch, Path(temporary))
        different = [a.name for a, b in zip(one, other, strict=True) if a.name != b.name or digest(a) != digest(b)]
        if different:
            raise SystemExit(f"two builds of {commit} differ: {', '.join(different)}")
        out.mkdir(parents=True, exist_ok=True)
        kept = [Path(shutil.copy(path, out / path.name)) for path in one]
    lines = [f"{digest(path)}  {path.name}" for path in kept]
    (out / "SHA256SUMS").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    print(f"SOURCE_DATE_EPOCH={epoch}, built twice with the same bytes; in {out}")


if __name__ == "__main__":
    typer.run(main)
