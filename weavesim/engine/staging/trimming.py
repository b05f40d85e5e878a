"""Which elements a trim leaves of a sheet, and how far their new border lies from its curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...errors import did_you_mean
from ...process.stages import Stage
from ...process.trims import Trim
from ...sheet.blank import Blank
from ...sheet.mesh_checks import border_edges
from ...sheet.outline import Outline, checked_outline
from ...sheet.sheet import Sheet
from ...sheet.topology import flat_areas, part_of_nodes
from .acting import Acting

# Pieces beside the largest one are waste up to this share of the area inside the curves.
LARGEST_SCRAP = 0.02
# Distances of points from sides of a curve that are computed at once.
LARGEST_TABLE = 2_000_000


class Cut(NamedTuple):
    """What a trim does to a sheet.

    Attributes:
        kept: elements that stay, (element_count,) bool.
        off: furthest that a node of the new border lies from the curves [m]; 0 without a new border.
    """

    kept: np.ndarray
    off: float


class TrimmedSheet(NamedTuple):
    """A trim and the place of its sheet in the run."""

    trim: Trim
    sheet: int


def trims_of(stage: Stage, sheets: Sequence[Sheet]) -> list[TrimmedSheet]:
    """The trims of a stage with the places of their sheets; names must be known."""
    names = [sheet.name for sheet in sheets]
    return [TrimmedSheet(trim, 0 if trim.sheet is None else names.index(trim.sheet)) for trim in stage.trims]


def depth_inside(trim: Trim, points: np.ndarray) -> np.ndarray:
    """Distance of points (n, 2) from the curves, positive where a sheet stays, (n,) [m].

    Raises:
        ValueError: a curve that crosses itself.
    """
    try:
        found = [_depth(Outline(checked_outline(curve)), points) for curve in trim.curves]
    except ValueError as error:
        raise ValueError(str(error).replace("outline", "curve")) from None
    odd = np.sum([depth > 0.0 for depth in found], axis=0) % 2 == 1
    nearest = np.min(np.abs(found), axis=0)
    return np.where(odd == (trim.keeps == "inside"), nearest, -nearest)


def _depth(outline: Outline, points: np.ndarray) -> np.ndarray:
    """Signed distance, in parts that take little memory."""
    part_count = 1 + len(points) * len(outline.vertex) // LARGEST_TABLE
    return np.concatenate([outline.nearest(part)[0] for part in np.array_split(points, part_count)])


def cut(trim: Trim, blank: Blank, plan: np.ndarray, kept: np.ndarray) -> Cut:
    """Cut a sheet whose nodes are at ``plan`` (node_count, 2) [m], of which ``kept`` elements are there.

    An element stays if its centre does. Small pieces beside the largest one, and elements that would hang on it by a
    corner only, are waste.

    Raises:
        ValueError: nothing stays, or pieces that are too large to be waste.
    """
    depth = depth_inside(trim, plan[blank.quads].mean(axis=1))
    result = kept & (depth > 0.0)
    if not result.any():
        raise ValueError("nothing of the sheet would stay: look at the unit and the place of the curves")
    area = flat_areas(blank)
    wanted = area[result].sum()
    while True:
        _drop_hinges(blank, depth, result)
        pieces = _pieces(blank, result)
        if len(pieces) < 2:
            break
        sizes = [float(area[piece].sum()) for piece in pieces]
        largest = int(np.argmax(sizes))
        for size, piece in zip(sizes, pieces, strict=True):
            if piece is pieces[largest]:
                continue
            if size > LARGEST_SCRAP * wanted:
                x, y = 1e3 * plan[blank.quads[piece]].mean(axis=(0, 1))
                raise ValueError(
                    f"{len(pieces)} pieces would stay, one of {1e6 * size:.4g} mm^2 about ({x:.4g}, {y:.4g}) mm beside "
                    "the largest: a sheet stays in one piece; trim to one of them"
                )
            result[piece] = False
    return Cut(result, _off(trim, blank, plan, kept, result))


def _drop_hinges(blank: Blank, depth: np.ndarray, kept: np.ndarray) -> None:
    """Take away elements that meet others only in a corner, those nearest to the curves first."""
    while True:
        edges = border_edges(blank.quads[kept], blank.node_count)
        hinge = np.bincount(edges.ravel(), minlength=blank.node_count) > 2
        if not hinge.any():
            return
        around = kept & hinge[blank.quads].any(axis=1)
        rows = np.flatnonzero(around)
        kept[rows[np.argmin(depth[rows])]] = False


def _pieces(blank: Blank, kept: np.ndarray) -> list[np.ndarray]:
    rows = np.flatnonzero(kept)
    part = part_of_nodes(blank.quads[rows], blank.node_count)[blank.quads[rows, 0]]
    return [rows[part == number] for number in np.unique(part)]


def _off(trim: Trim, blank: Blank, plan: np.ndarray, before: np.ndarray, kept: np.ndarray) -> float:
    gone = before & ~kept
    both = np.intersect1d(blank.quads[kept], blank.quads[gone])
    return float(np.abs(depth_inside(trim, plan[both])).max()) if len(both) else 0.0


def waste_nodes(blank: Blank, kept: np.ndarray) -> np.ndarray:
    """Nodes of no element that is kept, (node_count,) bool."""
    return np.bincount(blank.quads[kept].ravel(), minlength=blank.node_count) == 0


def check_trims(acts: Sequence[Acting], sheets: Sequence[Sheet], touching: frozenset[str]) -> None:
    """Check the trims of all stages as far as that is possible before a run.

    Args:
        acts: what acts in the stages of the run.
        sheets: of the run.
        touching: names of sheets that meet others.

    Raises:
        ValueError: a sheet that is not there or cannot be trimmed, curves that cross themselves, that leave nothing of
            a flat blank, or all of it, or that cut away what a gripper holds.
    """
    kept: list[np.ndarray | None] = [np.ones(sheet.blank.element_count, dtype=bool) for sheet in sheets]
    for now in acts:
        for trim in now.stage.trims:
            try:
                place = _place_of(trim, sheets, touching)
                depth_inside(trim, np.zeros((1, 2)))
                before = kept[place]
                if trim.view == "formed" or before is None:
                    kept[place] = None
                    continue
                blank = sheets[place].blank
                kept[place] = found = cut(trim, blank, blank.material_coordinates, before).kept
                if found.sum() == before.sum():
                    raise ValueError("all of the blank would stay; the curves must cut it")
                refuse_gripped(sheets[place], found, now.grippers)
            except ValueError as error:
                raise ValueError(f"stage {now.stage.name}: trim: {error}") from None


def _place_of(trim: Trim, sheets: Sequence[Sheet], touching: frozenset[str]) -> int:
    names = [sheet.name for sheet in sheets]
    if trim.sheet is None and len(names) > 1:
        raise ValueError(f"sheet is required, one of {', '.join(names)}")
    if trim.sheet is not None and trim.sheet not in names:
        raise ValueError(
            f"there is no sheet {trim.sheet!r}; there are {', '.join(names)}{did_you_mean(trim.sheet, names)}"
        )
    place = 0 if trim.sheet is None else names.index(trim.sheet)
    sheet = sheets[place]
    if sheet.name in touching or sheet.self_contact is not None:
        what = "may touch itself" if sheet.self_contact is not None else "touches another sheet"
        raise ValueError(
            f"sheet {sheet.name} {what}, which is looked for on whole sheets, and only a sheet that meets tools alone "
            "is trimmed; form it untrimmed, and take the blank of weavesim export --trim"
        )
    return place


def refuse_gripped(sheet: Sheet, kept: np.ndarray, grippers: frozenset[str]) -> None:
    """Refuse to cut away what a gripper holds.

    Args:
        sheet: that is trimmed.
        kept: elements that stay, (element_count,) bool.
        grippers: names of those that pull.

    Raises:
        ValueError: it does.
    """
    waste = waste_nodes(sheet.blank, kept)
    for gripper in sheet.grippers:
        if gripper.name in grippers and waste[gripper.nodes].any():
            raise ValueError(
                f"gripper {gripper.name} holds what is cut away of sheet {sheet.name}; release it in this stage or "
                "before: leave it out of its grippers"
            )
