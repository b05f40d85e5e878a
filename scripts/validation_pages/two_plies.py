"""The page of the public two-ply deck: plies at 0 and 45 degrees over a ball, without friction and with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from PIL import Image

from scripts.shared.report import table
from weavesim import __version__
from weavesim.measures.angles import shear_angle_at
from weavesim.measures.defects.judgement import Judgement, Limits
from weavesim.measures.findings import FormedSheet
from weavesim.output.pictures.style import new_axes, new_figure, styled, write_picture
from weavesim.output.stored.judged import distance_to
from weavesim.run.simulation import Simulation
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.scenes.stack import StackParameters, slips, stack
from weavesim.tools.surfaces.distance import ToolDistance

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"
SIZES = (0.015, 0.010, 0.0075)
FRICTIONS = (0.0, 0.5)
# Twice the default speed: the kinetic energy in the last quarter is told on the page.
SPEED = 0.5
# Of the picture's colours [degrees]; where angles are read along the plies' own diagonals [m].
LARGEST_ANGLE, DISTANCES = 25.0, (0.04, 0.06, 0.08, 0.10)


@dataclass(frozen=True)
class Formed:
    """A deck at its end: the run, what crossed in any frame, and both plies, from the bottom."""

    simulation: Simulation
    crossings: int
    plies: tuple[FormedSheet, ...]


def formed(size: float, friction: float, lay_up: str = "0/45") -> Formed:
    """The deck of one mesh size [m], with friction between the plies."""
    parameters = StackParameters(
        lay_up=lay_up, part="full", mesh_size=size, ply_friction=friction, punch_speed=SPEED, threads=1
    )  # fmt: skip
    simulation, record = Simulation(stack(parameters)), CrossingRecord()
    simulation.run([record])
    plies = tuple(
        FormedSheet(info.blank, frame.position, frame.fields, info.fabric.thickness, info.symmetry)
        for info, frame in zip(simulation.info.sheets, simulation.frame.sheets, strict=True)
    )
    return Formed(simulation, record.total, plies)


def largest_wave(run: Formed, ply: FormedSheet) -> float:
    """Largest amplitude of waves over the tools [mm]; see docs/outputs.md."""
    tools = run.simulation.model.setup.tools
    distance = distance_to([(ToolDistance(tool), run.simulation.frame.place(k)) for k, tool in enumerate(tools)])
    return 1.0e3 * float(Judgement(ply, Limits(), distance).fields["wrinkle_amplitude"].max())


def angles_along(ply: FormedSheet, turn: float) -> np.ndarray:
    """Shear angles on the diagonals between the yarns of a ply at ``turn``, mean of the four arms [degrees]."""
    arms = np.radians(turn + 45.0 + 90.0 * np.arange(4))
    points = np.array([[d * np.cos(a), d * np.sin(a)] for a in arms for d in DISTANCES])
    angles = shear_angle_at(ply.blank, ply.fields["shear_angle"], points)
    return angles.reshape(4, -1).mean(axis=0)


def maps(runs: Sequence[Formed]) -> None:
    """Angles of both plies on every mesh, seen from above: a picture for each friction."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize

    scale = Normalize(0.0, LARGEST_ANGLE)
    with styled():
        for friction, own in zip(FRICTIONS, np.array_split(np.arange(len(runs)), len(FRICTIONS)), strict=True):
            figure = new_figure(10.0, 7.6)
            grid = figure.add_gridspec(2, len(own))
            every = []
            for column, (k, size) in enumerate(zip(own, SIZES, strict=True)):
                for row, level in enumerate((1, 0)):
                    ply = runs[k].plies[level]
                    axes = new_axes(figure, grid[row, column], title=f"ply at {45 * level}°, {1e3 * size:g} mm")
                    corners = 1.0e3 * ply.position[ply.blank.quads][:, :, :2]
                    patches = PolyCollection(list(corners), array=ply.shear_angle_deg, norm=scale, edgecolors="face",
                                             linewidths=0.2)  # fmt: skip
                    axes.add_collection(patches)
                    axes.set(aspect="equal", xlim=(-160, 160), ylim=(-160, 160), xticks=(-100, 0, 100),
                             yticks=(-100, 0, 100))  # fmt: skip
                    axes.set(xlabel="x [mm]" if row == 1 else "", ylabel="y [mm]" if column == 0 else "")
                    every.append(axes)
            figure.colorbar(ScalarMappable(scale), ax=every, location="bottom", shrink=0.5, aspect=45,
                            label=f"shear angle [degrees], friction {friction:g} between the plies")  # fmt: skip
            path = IMAGES / f"two_plies_{10 * friction:02.0f}.png"
            write_picture(figure, path)
            # a palette takes a quarter of the room
            with Image.open(path) as picture:
                small = picture.convert("RGB").quantize(128)
            small.save(path, optimize=True)


def row_of(size: float, friction: float, run: Formed) -> list[str]:
    """Numbers of one run."""
    summary, slip = run.simulation.summary(), slips(run.simulation)
    angle = [f"{ply.shear_angle_deg.max():.1f}" for ply in run.plies]
    wave = [f"{largest_wave(run, ply):.1f}" for ply in run.plies]
    (mean,), (largest,) = slip["mean_slip_mm"].values(), slip["largest_slip_mm"].values()
    return [
        f"{friction:g}", f"{1e3 * size:g}", f"{summary['element_count']}", " / ".join(angle),
        " / ".join(wave), f"{mean:.1f} / {largest:.1f}", f"{summary['peak_tool_force_n']['punch']:.1f}",
        f"{100.0 * summary['kinetic_energy_ratio']:.1f}", f"{100.0 * summary['energy_balance_error']:.2f}",
        f"{run.crossings}",
    ]  # fmt: skip


def two_plies_page() -> tuple[str, list[str]]:
    """The page of the two-ply deck, and the requirements that are not met."""
    cases = [(friction, size) for friction in FRICTIONS for size in SIZES]
    runs = []
    for friction, size in cases:
        runs.append(formed(size, friction))
        print(*row_of(size, friction, runs[-1]), flush=True)
    alone = formed(SIZES[0], 0.0, "0")
    rows = [row_of(size, friction, run) for (friction, size), run in zip(cases, runs, strict=True)]
    along = [
        [f"{friction:g}", f"{1e3 * size:g}", f"{45 * level}",
         *(f"{a:.1f}" for a in angles_along(run.plies[level], 45.0 * level))]
        for (friction, size), run in zip(cases, runs, strict=True) for level in (0, 1)
    ]  # fmt: skip
    apart = float(np.abs(alone.plies[0].shear_angle_deg - runs[0].plies[0].shear_angle_deg).mean())
    maps(runs)
    errors = [run.simulation.summary()["energy_balance_error"] for run in runs]
    gates = [
        ("no triangles of the plies cross in any frame", not any(run.crossings for run in runs)),
        ("the ledger closes within 1 % of the work", max(errors) < 0.01),
        ("without friction the ply at 0° forms as if alone: angles within 0.5° on average (15 mm)", apart < 0.5),
    ]
    head = [
        "friction", "mesh [mm]", "elements", "largest angle, 0° / 45° [°]", "largest wave, 0° / 45° [mm]",
        "slip, mean / largest [mm]", "largest punch force [N]", "kinetic [%]", "balance [%]", "crossings",
    ]  # fmt: skip
    paragraphs = [
        "# Validation: two plies over a ball",
        f"Written by `python scripts/validation.py two-plies` on {date.today().isoformat()} with weavesim "
        f"{__version__}. The public two-ply deck ([stacks](stacks.md#the-two-ply-deck)): a punch of 75 mm radius, a "
        "die with an opening of 80 mm radius and an edge of 7.5 mm, squares of 300 mm of the preset "
        f"glass/polypropylene at 0 and 45 degrees, 50 mm of stroke at {SPEED:g} m/s, no holder, no friction on the "
        "tools. The deck was not compared by numbers.",
        table(["requirement", "holds"], [[what, "yes" if holds else "**no**"] for what, holds in gates]),
        f"Alone, the ply at 0 degrees has angles that differ by {apart:.2f}° on the mean.",
        table(head, rows),
        "Slip is between points that lay on each other at the start. Waves are of the height over the nearest tool, "
        "with a wavelength of up to 60 mm ([formed parts](outputs.md)). Kinetic energy is over internal energy, in the "
        "last quarter; crossings are pairs of triangles of all frames, by a test of all pairs. With friction the plies "
        "wrinkle each other no more than without: nothing holds the blanks, and the waves are those of their rims.",
        "![Angles without friction](images/two_plies_00.png)",
        "![Angles with friction 0.5 between the plies](images/two_plies_05.png)",
        "Angles on the diagonals between the yarns of each ply, by the distance from the middle on the flat blank, "
        "mean of the four arms:",
        table(["friction", "mesh [mm]", "ply [°]", *(f"{1e3 * d:g} mm [°]" for d in DISTANCES)], along),
    ]
    text = "\n\n".join(paragraphs) + "\n"
    return text, [what for what, holds in gates if not holds]
