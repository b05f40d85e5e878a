"""The kinematic drape of a sheet on one of its tools, beside the formed sheet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...measures.angles import locate, yarn_vectors
from ...measures.findings import FormedSheet
from ...measures.kinematic.net import CLOSED, NO_SURFACE, THERE, Net, Surface, check_count, lay_net
from ...process.motions.paths import Place
from ...sheet.blank import Blank
from ...sheet.topology import flat_areas
from ...tools.surfaces.exact import ExactSurface
from ...tools.tool import Tool
from ..files import write_summary
from ..paraview.files import Grid
from ..stored.file import StoredRun, StoredSheet
from ..tables import write_table

# Yarns of the blank are straight if their directions differ by less.
_STRAIGHT = 1.0e-6
# An element lies on a tool if its gap is below this share of the thickness.
TOUCHING = 0.5
# From a flat blank the tool is looked for along its axis in at most so many steps.
_MOST_STEPS = 200


# Why a net ends, in the words of files and of the terminal.
REASONS = {CLOSED: "its yarns cross below 20 degrees", NO_SURFACE: "there is no more surface"}


@dataclass(frozen=True)
class NetEnd:
    """Where a net ends within a blank.

    Attributes:
        reason: a row of ``REASONS``.
        nearest: to the seed, material point (x, y) [m].
    """

    reason: int
    nearest: tuple[float, float]

    def text(self) -> str:
        """In words."""
        x, y = (1.0e3 * value for value in self.nearest)
        return f"{REASONS[self.reason]}, first at x = {x:.4g}, y = {y:.4g} mm of the flat blank"


@dataclass(frozen=True, eq=False)
class KinematicDrape:
    """A net on a tool, and the formed sheet beside it.

    Attributes:
        net: on the surface of the tool, half a thickness above it.
        tool: name of the tool.
        seed: material point where the net begins (x, y) [m].
        angle_deg: absolute shear angle of the net at each element of the sheet; NaN where the net does not reach.
        ends: where the net ends within the blank; empty if it covers the blank.
        sheet: the formed sheet; None for a drape alone.
        touching: elements of the formed sheet that lie on the tool; None for a drape alone.
    """

    net: Net
    tool: str
    seed: tuple[float, float]
    angle_deg: np.ndarray
    ends: tuple[NetEnd, ...] = ()
    sheet: FormedSheet | None = None
    touching: np.ndarray | None = None

    @property
    def difference_deg(self) -> np.ndarray | None:
        """Angle of the formed sheet less that of the net; NaN where the net does not reach."""
        return None if self.sheet is None else self.sheet.shear_angle_deg - self.angle_deg

    @property
    def covered_share(self) -> float:
        """Share of the elements that have a whole cell of the net."""
        return float(np.isfinite(self.angle_deg).mean())

    def numbers(self) -> dict[str, Any]:
        """As ``kinematic.json`` has them."""
        known = np.isfinite(self.angle_deg)
        out: dict[str, Any] = {
            "tool": self.tool,
            "seed_mm": [1.0e3 * x for x in self.seed],
            "side_mm": 1.0e3 * self.net.side,
            "covered_share": self.covered_share,
            "ends": [
                {"reason": REASONS[end.reason], "nearest_mm": [1.0e3 * x for x in end.nearest]} for end in self.ends
            ],
            "largest_net_angle_deg": float(np.nanmax(self.angle_deg)) if known.any() else None,
        }
        if self.sheet is not None and self.touching is not None and (difference := self.difference_deg) is not None:
            both = known & self.touching
            out |= {
                "touching_share": float(self.touching.mean()),
                "largest_formed_angle_deg": float(self.sheet.shear_angle_deg.max()),
                "mean_difference_deg": float(difference[both].mean()) if both.any() else None,
                "mean_absolute_difference_deg": float(np.abs(difference[both]).mean()) if both.any() else None,
                "largest_difference_deg": float(np.abs(difference[both]).max()) if both.any() else None,
            }
        return out


def beside_run(
    run: StoredRun,
    sheet: StoredSheet,
    *,
    tool: str | None = None,
    seed: Sequence[float] | None = None,
    side: float | None = None,
) -> KinematicDrape:
    """The net for one sheet of a run, on a tool where it is at the end.

    Args:
        run: that has ended.
        sheet: one of its sheets.
        tool: name of the tool; by default the one that is nearest at the seed.
        seed: material point (x, y) [m]; by default the origin, or the middle of a blank that does not contain it.
        side: of the net's cells [m]; by default the size of an element.

    Raises:
        InputError: no such tool, a seed outside the blank, yarns that are not straight.
    """
    if not sheet.tools:
        raise InputError(f"kinematic drape: sheet {sheet.name} has no tool to lie on")
    tools = {run.tools[place].name: place for place in run.acting_tools(sheet)}
    if not tools:
        raise InputError(
            f"kinematic drape: no tool of sheet {sheet.name} acts at the end of the run, which has released it; take a "
            "run that ends in its tools"
        )
    if tool is not None and tool not in tools:
        raise InputError(f"kinematic drape: tool {tool!r}: choose from {', '.join(tools)}")
    half, start = 0.5 * sheet.thickness, seed_of(sheet.blank, seed)
    element, weight = locate(sheet.blank, np.array([start]))
    position = weight[0] @ sheet.position[sheet.blank.quads[element[0]]]
    surfaces = {
        name: surface_of(run.tools[place], run.place(place)) for name, place in tools.items() if tool in (None, name)
    }
    name = min(surfaces, key=lambda key: abs(float(surfaces[key](position[None])[0][0]) - half))
    surface = surfaces[name]
    centre = sheet.position[sheet.blank.quads].mean(axis=1)
    touching = np.abs(surface(centre)[0] - half) < TOUCHING * sheet.thickness
    warp = yarn_vectors(sheet.blank, sheet.position)[0][element[0]]
    net, angle, ends = lay(sheet.blank, surface, start, position, warp, half, side)
    return KinematicDrape(net, name, start, angle, ends, sheet.formed, touching)


def of_flat_blank(
    blank: Blank,
    tool: Tool,
    thickness: float,
    *,
    seed: Sequence[float] | None = None,
    side: float | None = None,
) -> KinematicDrape:
    """The net alone, from a flat blank above or below a tool: the seed goes to the tool along its axis.

    Raises:
        InputError: the tool is not met; a seed outside the blank; yarns that are not straight.
    """
    start, surface, half = seed_of(blank, seed), surface_of(tool, 0.0), 0.5 * thickness
    element, weight = locate(blank, np.array([start]))
    point = weight[0] @ blank.node_position[blank.quads[element[0]]]
    met = _along_axis(surface, point, np.array(tool.axis), half, tool.name)
    net, angle, ends = lay(blank, surface, start, met, blank.warp_direction[element[0]], half, side)
    return KinematicDrape(net, tool.name, start, angle, ends)


def _along_axis(surface: Surface, point: np.ndarray, axis: np.ndarray, height: float, name: str) -> np.ndarray:
    """Where a line through ``point`` meets the surface first, in either direction."""
    met = []
    for direction in (axis, -axis):
        here = point.copy()
        for _ in range(_MOST_STEPS):
            left = float(surface(here[None])[0][0]) - height
            if abs(left) < 1.0e-7:
                met.append(here)
                break
            here = here + left * direction
            if np.linalg.norm(here - point) > 10.0:
                break
    if not met:
        raise InputError(
            f"kinematic drape: from the seed, the tool {name} is not met along its axis; give another seed or tool"
        )
    return min(met, key=lambda place: float(np.linalg.norm(place - point)))


def surface_of(tool: Tool, place: Place) -> ExactSurface:
    """The surface of a tool in its place."""
    return ExactSurface(tool, place)


def seed_of(blank: Blank, seed: Sequence[float] | None) -> tuple[float, float]:
    """The seed as given; else the origin, or the middle of a blank that does not contain it (x, y) [m]."""
    if seed is not None:
        return float(seed[0]), float(seed[1])
    lower, upper = blank.material_coordinates.min(axis=0), blank.material_coordinates.max(axis=0)
    if np.all(lower <= 0.0) and np.all(upper >= 0.0):
        return 0.0, 0.0
    x, y = (0.5 * (lower + upper)).tolist()
    return x, y


def lay(
    blank: Blank,
    surface: ExactSurface,
    seed: tuple[float, float],
    position: np.ndarray,
    warp: np.ndarray,
    height: float,
    side: float | None,
) -> tuple[Net, np.ndarray, tuple[NetEnd, ...]]:
    """A net as large as a blank, its absolute angle at each element [degrees], and where it ends within the blank.

    Raises:
        InputError: yarns that are not straight or not at right angles on the flat blank; a side of no use.
    """
    yarns = np.stack([blank.warp_direction[:, :2], blank.weft_direction[:, :2]], axis=1)
    if np.ptp(yarns, axis=0).max() > _STRAIGHT or abs(float(yarns[0, 0] @ yarns[0, 1])) > _STRAIGHT:
        raise InputError("kinematic drape: straight yarns at right angles are needed on the flat blank")
    largest = 0.5 * float(np.ptp(blank.material_coordinates, axis=0).min())
    size = min(float(np.sqrt(flat_areas(blank).mean())), largest) if side is None else side
    if not 0.0 < size < np.inf:
        raise InputError(f"kinematic drape: side = {side} m: a positive length is needed")
    if size > largest:
        raise InputError(
            f"kinematic drape: side = {size:g} m: at most {largest:.4g} m, half the width of the blank, shows "
            "anything; it is in metres"
        )
    # half a cell aside, so that borders and planes of symmetry lie on yarns
    lengths = (blank.material_coordinates - np.array(seed)) @ yarns[0].T
    with np.errstate(over="ignore"):
        first, last = np.floor(lengths.min(axis=0) / size - 1e-6), np.ceil(lengths.max(axis=0) / size + 1e-6)
    check_count(size, float(np.prod(np.maximum(last, 0.0) - np.minimum(first, 0.0) + 1.0)))
    reach = tuple((min(int(a), 0), max(int(b), 0)) for a, b in zip(first, last, strict=True))
    net = lay_net(
        surface, position, warp, size, (reach[0], reach[1]), height=height, beyond=surface.beyond, error=surface.error
    )
    centre = (blank.material_coordinates[blank.quads].mean(axis=1) - np.array(seed)) @ yarns[0].T
    return net, np.abs(np.rad2deg(net.angle_at(centre))), _ends(net, centre, np.array(seed), yarns[0])


def _ends(net: Net, lengths: np.ndarray, seed: np.ndarray, yarns: np.ndarray) -> tuple[NetEnd, ...]:
    """Where crossings are missing around the cells of elements, whose ``lengths`` (k, 2) along the yarns are given."""
    cell = np.floor(lengths / net.side).astype(int) - np.array(net.first)
    cell = cell[np.all((cell >= 0) & (cell < np.array(net.state.shape) - 1), axis=1)]
    within = np.zeros(net.state.shape, dtype=bool)
    for corner in ((0, 0), (1, 0), (1, 1), (0, 1)):
        within[tuple((cell + corner).T)] = True
    missing = within & (net.state != THERE)
    if missing.any() and not np.isin(net.state[missing], list(REASONS)).any():
        within[:] = True  # it has ended beside the blank
    ends = []
    for reason in REASONS:
        place = np.argwhere(within & (net.state == reason)) + np.array(net.first)
        if len(place):
            x, y = (seed + net.side * place[np.linalg.norm(place, axis=1).argmin()] @ yarns).tolist()
            ends.append(NetEnd(reason, (x, y)))
    return tuple(ends)


def write_kinematic(folder: Path, drape: KinematicDrape, run_id: str = "", ending: str = "") -> list[Path]:
    """Write ``kinematic.json``, ``.csv`` (beside a run), ``.vtu`` and ``.png``; returns the files."""
    from ..pictures.net import net_picture
    from ..pictures.style import write_picture

    files = [folder / f"kinematic{ending}.{kind}" for kind in ("json", "vtu", "png")]
    write_summary(files[0], drape.numbers())
    points, quads, angles = _as_mesh(drape.net)
    Grid(quads).write(files[1], points, cell_data={"shear_angle_deg": np.abs(np.rad2deg(angles))}, run_id=run_id)
    write_picture(net_picture(drape), files[2], run_id)
    if drape.sheet is not None and drape.touching is not None and (difference := drape.difference_deg) is not None:
        flat = drape.sheet.blank.material_coordinates[drape.sheet.blank.quads].mean(axis=1)
        rows = zip(
            *(1.0e3 * flat).T.tolist(), drape.sheet.shear_angle_deg.tolist(), drape.angle_deg.tolist(),
            difference.tolist(), drape.touching.astype(int).tolist(), strict=True,
        )  # fmt: skip
        files.append(folder / f"kinematic{ending}.csv")
        header = ["flat_x_mm", "flat_y_mm", "formed_angle_deg", "net_angle_deg", "difference_deg", "on_tool"]
        write_table(files[-1], header, rows)
    return files


def _as_mesh(net: Net) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, quads and angles of the cells that are there."""
    rows, columns = net.position.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = net.position.reshape(-1, 3)
    whole = np.isfinite(points[quads]).all(axis=(1, 2))
    used, quads = np.unique(quads[whole], return_inverse=True)
    return points[used], quads.reshape(-1, 4), net.shear_angle.ravel()[whole]
