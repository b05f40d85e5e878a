"""Draw docs/images/architecture.png: the rooms with their imports, and the paths of a step and of a result.

    python scripts/architecture.py [--out docs/images/architecture.png]

Rooms, modules and imports are counted in this checkout; the contents of each room and the two walks are written here. A
test fails when a room is missing, when an import points up, or when a walk names something that does not exist.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.support.imports import Sources  # noqa: E402
from tests.support.rooms import ORDER, room_of  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, GREY, PALE = "#23262d", "#6b7280", "#b4bac4"
FEW_IMPORTS = 2
EVERYWHERE = "base"  # imported by all above it, so its arrows are not informative
RESOLUTION = 130
WIDTH, HEIGHT = 12.0, 12.0  # [inches], which are the coordinates of the drawing
FONT = 12.0

# What each room holds, and its colour.
ROOMS = {
    "kernels": ("device code", "#4a5568"),
    "base": ("errors, checks, device: all use it", "#7a7f8a"),
    "tables": ("tables of measured values", "#2f6fb0"),
    "meshes": ("mesh files, cell by cell", "#2f6fb0"),
    "fabric": ("laws, cells, presets, files", "#2f6fb0"),
    "process": ("strokes, supports, loads, dynamics", "#2f6fb0"),
    "sheet": ("blank, symmetry, geometry", "#2f6fb0"),
    "tools": ("shapes, meshes", "#2f6fb0"),
    "measures": ("numbers of a formed sheet", "#1f8a70"),
    "engine": ("Setup, Model, State, Stepper", "#c2571a"),
    "run": ("Simulation, ledger, frames, verdict", "#c2571a"),
    "output": ("writers, pictures, report", "#1f8a70"),
    "calibration": ("fabrics from tests", "#1f8a70"),
    "job": ("runs as files", "#5b3fb5"),
    "study": ("many runs of a job", "#5b3fb5"),
    "app": ("command line, progress", "#5b3fb5"),
    "scenes": ("problems as values", "#5b3fb5"),
    "scripts": ("what a person runs", "#5b3fb5"),
}
# The rooms of kernels, row by row from the top; "" stands for the modules outside its folders.
KERNEL_ROWS = (
    ("worlds", "carried", "creases"),
    ("loads", "plies"),
    ("stepping", "shell"),
    ("contact", "laws", "cell"),
    ("formula",),
    ("",),
)


@dataclass(frozen=True)
class Stop:
    """One stop of a walk.

    Attributes:
        room: determines its colour.
        name: module, optionally followed by a dot and a name in it.
        text: what happens there.
    """

    room: str
    name: str
    text: str


A_STEP = (
    Stop("engine", "engine.setup.Setup", "all that a run is given, checked and frozen"),
    Stop("run", "run.simulation.Simulation", "from one output to the next"),
    Stop("engine", "engine.stepper.Stepper", "blocks of 20 steps, on threads"),
    Stop("engine", "engine.launches.Launches", "kernels with their arguments"),
    Stop("kernels", "kernels.shell.force", "elements write the forces of their corners"),
    Stop("kernels", "kernels.stepping.node", "nodes gather, meet the tools, move"),
    Stop("kernels", "kernels.stepping.tools", "tools move, the clock advances"),
    Stop("kernels", "kernels.shell.frequency", "after 20 steps: the stable step"),
)
# These run in every step, the one below them after some steps.
IN_EVERY_STEP = ("kernels.shell.force", "kernels.stepping.tools")
A_RESULT = (
    Stop("engine", "engine.state.State", "everything that a step writes"),
    Stop("run", "run.ledger.Ledger", "energies and fields of the state"),
    Stop("run", "run.frame.Frame", "what an observer gets"),
    Stop("measures", "measures.findings.Finding", "each number once, with its unit"),
    Stop("output", "output.writer.Writer", "film, pictures, tables, summary, report"),
)


@dataclass(frozen=True)
class House:
    """Data for drawing the rooms.

    Attributes:
        modules: of each room, from bottom to top; an __init__.py does not count.
        arrows: imports of modules of one room by those of another, by (importer, imported).
        kernel_modules, kernel_arrows: the same for the folders of kernels, "" for the modules outside them.
    """

    modules: dict[str, int]
    arrows: dict[tuple[str, str], int]
    kernel_modules: dict[str, int]
    kernel_arrows: dict[tuple[str, str], int]

    @classmethod
    def of(cls, sources: Sources) -> House:
        """Count the rooms of a checkout."""
        room = {module: room_of(module) or "" for module in sources.file_of}
        inner = {module: _kernel_room(sources, module) for module in room if room[module] == "kernels"}
        counted = [module for module in room if not sources.is_package(module)]
        pairs = [(a, b) for a, found in sources.imports().items() for b in found]
        between = Counter((room[a], room[b]) for a, b in pairs if room[a] != room[b])
        inside = Counter((inner[a], inner[b]) for a, b in pairs if {a, b} <= set(inner) and inner[a] != inner[b])
        count = Counter(room[module] for module in counted)
        return cls(
            modules={name: count[name] for name in sorted(set(count) - {"door"}, key=_level)},
            arrows={pair: number for pair, number in between.items() if "door" not in pair},
            kernel_modules=dict(Counter(inner[module] for module in counted if module in inner)),
            kernel_arrows=dict(inside),
        )


def _level(room: str) -> int:
    return ORDER.index(room)


def _kernel_room(sources: Sources, module: str) -> str:
    folder = sources.file_of[module].parent.relative_to(sources.root / "kernels")
    return "" if folder == Path() else folder.parts[0]


# --- the left half: rooms and their imports ---------------------------------------------------------------------------

LEFT, BOX_WIDTH, BOX_HEIGHT, TOP = 0.15, 4.75, 0.44, 11.42
KERNEL_HEIGHT, KERNEL_GAP = 0.32, 0.15
KERNELS_BOTTOM = 0.45
KERNELS_HEIGHT = BOX_HEIGHT + len(KERNEL_ROWS) * (KERNEL_HEIGHT + KERNEL_GAP)
# Rooms above the kernels fill what is left.
PITCH = (TOP - BOX_HEIGHT - KERNELS_BOTTOM - KERNELS_HEIGHT - 0.15) / (len(ORDER) - 2)
LARGEST_BULGE = 2.15


def _bottom(room: str) -> float:
    index = _level(room)
    return KERNELS_BOTTOM if index == 0 else KERNELS_BOTTOM + KERNELS_HEIGHT + 0.15 + (index - 1) * PITCH


def _box(axes: Axes, x: float, y: float, width: float, height: float, colour: str, alpha: float = 0.14) -> None:
    from matplotlib.colors import to_rgba
    from matplotlib.patches import FancyBboxPatch

    style = f"round,pad=0,rounding_size={min(0.09, 0.3 * height)}"
    face = to_rgba(colour, alpha) if alpha < 1.0 else "white"
    axes.add_patch(
        FancyBboxPatch((x, y), width, height, boxstyle=style, facecolor=face, edgecolor=colour, linewidth=1.2)
    )


def _draw_room(axes: Axes, room: str, module_count: int) -> None:
    text, colour = ROOMS[room]
    height = KERNELS_HEIGHT if room == "kernels" else BOX_HEIGHT
    bottom = _bottom(room)
    line = bottom + height - 0.5 * BOX_HEIGHT
    _box(axes, LEFT, bottom, BOX_WIDTH, height, colour)
    axes.text(LEFT + 0.12, line, room, weight="bold", color=colour, va="center", size=FONT)
    axes.text(LEFT + 1.34, line, text, color=INK, va="center", size=FONT)
    axes.text(LEFT + BOX_WIDTH - 0.12, line, f"{module_count}", color=GREY, va="center", ha="right", size=FONT)


def _draw_kernels(axes: Axes, house: House) -> None:
    """The rooms of kernels with the imports from row to row."""
    height, gap, inset = KERNEL_HEIGHT, KERNEL_GAP, 0.14
    place: dict[str, tuple[float, float, float]] = {}
    for row, names in enumerate(KERNEL_ROWS):
        y = KERNELS_BOTTOM + KERNELS_HEIGHT - BOX_HEIGHT - height - row * (height + gap)
        width = (BOX_WIDTH - 2 * inset - (len(names) - 1) * gap) / len(names)
        for column, name in enumerate(names):
            place[name] = (LEFT + inset + column * (width + gap), y, width)
    colour = ROOMS["kernels"][1]
    for (importer, imported), count in house.kernel_arrows.items():
        (x, y, width), (x_below, y_below, width_below) = place[importer], place[imported]
        if not 0.0 < y - y_below < 1.5 * (height + gap):
            continue  # all rows depend on the bottom row
        middle = 0.5 * (max(x, x_below) + min(x + width, x_below + width_below))
        _arrow(axes, [(middle, y), (middle, y_below + height)], count, colour)
    for name, (x, y, width) in place.items():
        _box(axes, x, y, width, height, colour, alpha=1.0)
        text = name or "lanes, operators, rows, curve"
        axes.text(x + 0.5 * width, y + 0.5 * height, text, color=INK, va="center", ha="center", size=FONT - 1)


def _arrow(axes: Axes, points: Sequence[tuple[float, float]], count: int, colour: str) -> None:
    """Straight or as a Bézier curve, as wide as the number of imports asks."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.path import Path as Curve

    few = count <= FEW_IMPORTS
    head = "head_length=3.5,head_width=1.6" if few else "head_length=5,head_width=2.6"
    codes = [Curve.MOVETO, *([Curve.LINETO] if len(points) == 2 else [Curve.CURVE4] * 3)]
    axes.add_patch(
        FancyArrowPatch(
            path=Curve(points, codes), arrowstyle=f"-|>,{head}",
            linewidth=0.7 if few else 0.8 + 0.11 * count, color=PALE if few else colour, shrinkA=0, shrinkB=0,
            mutation_scale=1.0, alpha=1.0 if few else 0.75, capstyle="butt", joinstyle="miter",
        )
    )  # fmt: skip


def _draw_imports(axes: Axes, arrows: dict[tuple[str, str], int]) -> None:
    """Arcs to the right of the boxes: outgoing ones start in the lower half of a box, incoming ones end above."""
    right = LEFT + BOX_WIDTH
    port: dict[tuple[str, tuple[str, str]], float] = {}
    for room in ROOMS:
        down = sorted((pair for pair in arrows if pair[0] == room), key=lambda pair: _level(pair[1]))
        up = sorted((pair for pair in arrows if pair[1] == room), key=lambda pair: _level(pair[0]))
        height = KERNELS_HEIGHT if room == "kernels" else BOX_HEIGHT
        ports = [*reversed(down), *reversed(up)]  # from the lowest: nested, the farthest nearest to the middle
        for index, pair in enumerate(ports):
            share = (index + 0.5) / len(ports)
            port[room, pair] = _bottom(room) + height * (0.06 + 0.88 * share)
    for pair, count in sorted(arrows.items(), key=lambda item: item[1]):
        start, end = port[pair[0], pair], port[pair[1], pair]
        reach = abs(_level(pair[0]) - _level(pair[1])) / (len(ORDER) - 1)
        bulge = (0.25 + LARGEST_BULGE * reach**0.8) * 4.0 / 3.0
        curve = [(right, start), (right + bulge, start), (right + bulge, end), (right, end)]
        _arrow(axes, curve, count, ROOMS[pair[0]][1])


# --- the right half: the walks ----------------------------------------------------------------------------------------

WALK_LEFT, WALK_WIDTH, STOP_HEIGHT, STOP_PITCH = 7.72, 3.85, 0.58, 0.735


def _draw_walk(axes: Axes, title: str, stops: Sequence[Stop], top: float) -> float:
    """Draw a walk from ``top`` down; returns where its last stop ends."""
    axes.text(WALK_LEFT, top, title, weight="bold", color=INK, va="center", size=FONT + 2)
    y = top - 0.22
    place: dict[str, float] = {}
    for index, stop in enumerate(stops):
        y -= STOP_HEIGHT if index == 0 else STOP_PITCH
        place[stop.name] = y + 0.5 * STOP_HEIGHT
        colour = ROOMS[stop.room][1]
        if index:
            middle = WALK_LEFT + 0.35
            _arrow(axes, [(middle, y + STOP_PITCH), (middle, y + STOP_HEIGHT)], 8, GREY)
        _box(axes, WALK_LEFT, y, WALK_WIDTH, STOP_HEIGHT, colour)
        axes.text(WALK_LEFT + 0.12, y + 0.41, stop.name, weight="bold", color=colour, va="center", size=FONT)
        axes.text(WALK_LEFT + 0.12, y + 0.165, stop.text, color=INK, va="center", size=FONT)
    if set(IN_EVERY_STEP) <= set(place):
        first, last = (place[name] for name in IN_EVERY_STEP)
        right, far = WALK_LEFT + WALK_WIDTH, WALK_LEFT + WALK_WIDTH + 0.42
        _arrow(axes, [(right, last), (far, last), (far, first), (right, first)], 8, GREY)
    return y


def draw(house: House, path: Path) -> None:
    """Write the picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=RESOLUTION)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, WIDTH), ylim=(0.0, HEIGHT))
    axes.axis("off")
    axes.text(LEFT, HEIGHT - 0.35, "Rooms and their imports", weight="bold", color=INK, va="center", size=FONT + 2)
    axes.text(LEFT + BOX_WIDTH - 0.12, HEIGHT - 0.35, "modules", color=GREY, va="center", ha="right", size=FONT)
    _draw_imports(axes, {pair: count for pair, count in house.arrows.items() if pair[1] != EVERYWHERE})
    for room, count in house.modules.items():
        _draw_room(axes, room, count)
    _draw_kernels(axes, house)
    note = "An arrow goes from a room to one it imports; it is as wide as there are imports, and grey for one or two."
    axes.text(LEFT, 0.2, note, color=GREY, va="center", size=FONT - 1)
    end = _draw_walk(axes, "A step", A_STEP, HEIGHT - 0.35)
    _draw_walk(axes, "A result", A_RESULT, end - 0.42)
    canvas.draw()
    about = PngInfo()
    about.add_text("Description", " ".join(house.modules))
    # few colours: a third of the file size
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").quantize(128).save(
        path, pnginfo=about, optimize=True
    )


def main(
    out: Annotated[Path, typer.Option(help="the picture")] = ROOT / "docs" / "images" / "architecture.png",
) -> None:
    """Draw the rooms of this checkout with their imports, and the paths of a step and of a result."""
    draw(House.of(Sources(ROOT)), out)


if __name__ == "__main__":
    typer.run(main)
