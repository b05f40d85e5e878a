"""Make the pictures of docs/gallery.md anew, by the commands that the page names. Takes some minutes.

python scripts/documentation/make_gallery.py                 all of them
python scripts/documentation/make_gallery.py --only stack    one of them, and those whose run it needs
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from PIL import Image
from PIL.PngImagePlugin import PngInfo

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from scripts.documentation.gallery import EXHIBITS, FOLDER, Exhibit  # noqa: E402
from weavesim.app.ending import ExitCode  # noqa: E402

WIDTH = 1400  # pixels
COLOURS = 256
# Of the pixels: thin lines have less than 1 %, a grey part has none.
LEAST_COLOURED = 0.002
COMMAND = "from weavesim.app.command_line import main; main()"
# A doubtful result is a picture all the same: the page says what is seen, not that it is to be trusted.
ACCEPTED = (ExitCode.FINISHED, ExitCode.DO_NOT_USE, ExitCode.BEYOND_LIMITS)


def run(command: str, folder: Path) -> None:
    """Run a command of the page in ``folder``.

    Raises:
        SystemExit: it failed.
    """
    program, *words = shlex.split(command)
    words = [str(ROOT / word) if word.startswith(("docs/", "scripts/")) else word for word in words]
    start = ["-c", COMMAND] if program == "weavesim" else []
    done = subprocess.run(
        [sys.executable, *start, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    if done.returncode not in [int(code) for code in ACCEPTED]:
        raise SystemExit(f"{command} ended with exit code {done.returncode}:\n{done.stdout}\n{done.stderr}")


def joined(paths: list[Path]) -> Image.Image:
    """Pictures one below the other on white, at most ``WIDTH`` pixels wide."""
    parts = [Image.open(path).convert("RGBA") for path in paths]
    grounds = [Image.alpha_composite(Image.new("RGBA", one.size, "white"), one).convert("RGB") for one in parts]
    width, height = max(one.width for one in grounds), sum(one.height for one in grounds)
    whole = Image.new("RGB", (width, height), "white")
    top = 0
    for one in grounds:
        whole.paste(one, (0, top))
        top += one.height
    if width > WIDTH:
        whole = whole.resize((WIDTH, round(height * WIDTH / width)), Image.Resampling.LANCZOS)
    return whole


def coloured_share(picture: Image.Image) -> float:
    """Share of the pixels that are neither white nor grey."""
    saturation = np.asarray(picture.convert("HSV"))[..., 1]
    return float(np.mean(saturation > 50))


def told_of(files: Sequence[Path]) -> PngInfo:
    """What the pictures say of themselves: the texts of them all."""
    about = PngInfo()
    for file in files:
        with Image.open(file) as picture:
            for name, text in getattr(picture, "text", {}).items():
                about.add_text(name, text)
    return about


def write(exhibit: Exhibit, folder: Path) -> Path:
    """Write the picture of an exhibit from what its commands left in ``folder``.

    Raises:
        SystemExit: a picture is missing or blank, or what its text says is not true of it.
    """
    found = [path for source in exhibit.sources for path in sorted(folder.glob(source))]
    if len(found) < len(exhibit.sources):
        raise SystemExit(f"{exhibit.name}: {', '.join(exhibit.sources)} is missing in {folder}")
    if exhibit.holds is not None and not exhibit.holds(folder):
        raise SystemExit(f"{exhibit.name}: its text is not true of what its commands left in {folder}")
    whole = joined(found)
    if coloured_share(whole) < LEAST_COLOURED:
        raise SystemExit(f"{exhibit.name}: {', '.join(exhibit.sources)} shows next to nothing")
    path = FOLDER / f"{exhibit.name}.png"
    few = whole.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.save(path, optimize=True, pnginfo=told_of(found))
    return path


def main(
    only: Annotated[list[str] | None, typer.Option(help="name of a picture; may be repeated")] = None,
    keep: Annotated[Path | None, typer.Option(help="folder for the runs [default: a temporary one]")] = None,
) -> None:
    """Make the pictures."""
    names = [one.name for one in EXHIBITS]
    if unknown := set(only or ()) - set(names):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: choose from {', '.join(names)}")
    with tempfile.TemporaryDirectory(prefix="weavesim-gallery-") as temporary:
        folder = keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for exhibit in with_those_before(only or names):
            started = time.monotonic()
            for command in exhibit.commands:
                run(command, folder)
            path = write(exhibit, folder)
            print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1e3:.0f} kB, {time.monotonic() - started:.0f} s")


def with_those_before(names: list[str]) -> list[Exhibit]:
    """The exhibits of these names, each after the one whose run it needs."""
    by_name = {one.name: one for one in EXHIBITS}
    needed: set[str] = set()
    for name in names:
        while name:
            needed.add(name)
            name = by_name[name].after
    return [one for one in EXHIBITS if one.name in needed]


if __name__ == "__main__":
    typer.run(main)
