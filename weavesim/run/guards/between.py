"""Tools that come through the sheet between its nodes, where the sheet does not meet them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...errors import InputError
from ...sheet.samples import MOST_PER_SIDE
from ..watch.remembered import geometry_key, remembered
from ..watch.tool_distance import RESOLUTION, Deepest, ToolDistances
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...engine.sheet_model import SheetModel
    from ...process.motions.paths import Place
    from ..frame import Frame
    from ..ledger import Ledger
    from ..verdict import Judged

# Of the thickness, before the run: overlap of the sheet's face with a tool that is not doubted, and that is refused.
LARGEST_OVERLAP = 0.05
REFUSED_OVERLAP = 0.25
# Of the thickness, in the run: depth of the sheet's middle in a tool that is not doubted, and from which on a tool more
# slender than the elements has come through.
LARGEST_DEPTH = 0.05
USELESS_DEPTH = 0.25
# Of the thickness: how far a tool of any width may stand out of the sheet before it has come through.
USELESS_PROTRUSION = 2.0
# Of the thickness: how far it is followed.
LONGEST_PROTRUSION = 10.0


class NarrowTool(Guard):
    """Tools more slender than the elements, which may pass between nodes."""

    name = "narrow_tool"
    watches = "tools that are more slender than the elements"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Tools of which a part is narrower than an element."""
        for sheet, _, index in start.meetings():
            tool, size = start.model.setup.tools[index], sheet.geometry.largest_size
            text, advice = f"the elements are {1e3 * size:.3g} mm", "take elements of at most half its width"
            if sheet.samples.count:
                size /= MOST_PER_SIDE
                text = f"the sheet meets tools every {1e3 * size:.3g} mm at best"
            else:
                advice += ', or meet tools between nodes too (contact_samples = "surface")'
            if tool.smallest_width < size:
                yield self.doubt(
                    Level.WARNING,
                    f"{tool.name}: it is {1e3 * tool.smallest_width:.3g} mm wide, {text}",
                    f"it may pass between these places: {advice}",
                    value=tool.smallest_width,
                    limit=size,
                )


class StartOverlap(Guard):
    """Tools that overlap the sheet before the run, at nodes or between them."""

    name = "start_overlap"
    watches = "tools that overlap the sheet before the run"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Overlaps that are small.

        Raises:
            InputError: a tool that overlaps the sheet by more than a quarter of its thickness.
        """
        distances = ToolDistances(start.model)
        for sheet, position, index in start.meetings():
            thickness, name = sheet.fabric.thickness, start.model.setup.tools[index].name
            if name not in start.phases[0].tools:
                continue
            limit = (0.5 - LARGEST_OVERLAP) * thickness - _sampling_error(start, index)
            place_of_tool = start.frame.place(index)
            key = geometry_key(start.model, (start.model.setup.tools[index],))
            if key is not None:
                key = ("overlap", sheet.name, place_of_tool, *key)
            found = remembered(key, partial(distances.deepest, index, place_of_tool, position, sheet, limit))
            overlap = 0.5 * thickness - found.distance
            if found.element is None:
                continue
            text = (
                f"{name} overlaps the blank by {1e3 * overlap:.3g} mm before the run starts; the sheet is "
                f"{1e3 * thickness:.3g} mm thick"
            )
            advice = "move the tool half a thickness off the mid-surface"
            if overlap > REFUSED_OVERLAP * thickness:
                raise InputError(f"{text}: {advice}")
            place = _place(sheet, found)
            yield self.doubt(Level.WARNING, text, advice, sheet=sheet.name, place=place, value=overlap)


class Seen(NamedTuple):
    """The deepest that one tool has been in one sheet: the distance of the sheet's middle [m], how far the tool stood
    out of the sheet [m], place and time."""

    distance: float
    protrusion: float
    place: tuple[float, float]
    time: float


class BetweenNodes(Guard):
    """Tools that come through the sheet between its nodes while it forms.

    Tools with radii and widths well above the elements are left out: there, nodes and centres of elements tell.
    """

    lasting = True
    name = "between_nodes"
    watches = "tools with sharp edges or small radii that come through between nodes"

    def __init__(self) -> None:
        self._distances: ToolDistances | None = None
        self._watched: list[tuple[int, int]] = []  # index of a sheet, and of a tool
        self._sheets: tuple[SheetModel, ...] = ()
        self._deepest: dict[tuple[int, int], Seen] = {}

    def before(self, start: Start) -> Iterable[Doubt]:
        """Nothing; remembers what there is to watch."""
        self._distances, self._sheets = ToolDistances(start.model), start.model.sheets
        for sheet, _, index in start.meetings():
            tool, size = start.model.setup.tools[index], sheet.geometry.largest_size
            if tool.smallest_radius < size or tool.smallest_width < 2.0 * size:
                self._watched.append((self._sheets.index(sheet), index))
        return ()

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Search the elements near these tools."""
        for pair in self._watched:
            assert self._distances is not None
            if not ledger.acting[pair[1]]:
                continue
            sheet, where = self._sheets[pair[0]], frame.place(pair[1])
            limit = self._deepest[pair].distance if pair in self._deepest else -LARGEST_DEPTH * sheet.fabric.thickness
            position, director = frame.sheets[pair[0]].position, frame.sheets[pair[0]].director
            found = self._distances.deepest(pair[1], where, position, sheet, limit, director)
            if found.element is not None:
                out = _protrusion(self._distances, pair[1], where, position, sheet, found)
                self._deepest[pair] = Seen(found.distance, out, _place(sheet, found), frame.time)

    def memory(self) -> Mapping[str, Any]:
        """The deepest of each tool in each sheet."""
        return {"deepest": [[*pair, *seen] for pair, seen in self._deepest.items()]}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._deepest = {
            (sheet, tool): Seen(distance, protrusion, (place[0], place[1]), time)
            for sheet, tool, distance, protrusion, place, time in memory["deepest"]
        }

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The deepest of each tool in each sheet."""
        info = run.run.info
        for (place, index), seen in self._deepest.items():
            thickness, tool = info.sheets[place].fabric.thickness, info.tools[index]
            slender = tool.smallest_width < self._sheets[place].geometry.largest_size
            useless = slender and -seen.distance > USELESS_DEPTH * thickness
            useless |= seen.protrusion > USELESS_PROTRUSION * thickness
            least = "at least " if seen.protrusion >= LONGEST_PROTRUSION * thickness else ""
            yield self.doubt(
                Level.DO_NOT_USE if useless else Level.WARNING,
                f"{info.tool_names[index]} came through the sheet between its nodes: the middle of the sheet was "
                f"{-1e3 * seen.distance:.3g} mm inside it, and it stood out by {least}{1e3 * seen.protrusion:.3g} mm",
                "take a finer mesh, round the tool's edges, or a wider tool; tools can be met between nodes "
                '(contact_samples = "surface")',
                sheet=info.sheets[place].name,
                place=seen.place,
                time=seen.time,
                value=-seen.distance,
                limit=LARGEST_DEPTH * thickness,
            )


def _sampling_error(start: Start, index: int) -> float:
    """Error of the distances from a tool that 99 % of all points have at most [m]; 0 for formulas."""
    surfaces = [part.surface for part in start.model.setup.tools[index].shape.parts()]
    return max((start.model.samples[surface].usual_error for surface in surfaces if surface is not None), default=0.0)


def _protrusion(
    distances: ToolDistances, tool: int, where: Place, position: np.ndarray, sheet: SheetModel, found: Deepest
) -> float:
    """How far a tool reaches from the deepest point to the nearer side of the sheet, along its normal [m]."""
    assert found.element is not None and found.point is not None
    a, b, c, d = position[sheet.blank.quads[found.element]]
    normal = np.cross(c - a, d - b)
    normal /= max(float(np.linalg.norm(normal)), 1e-300)
    steps = sheet.fabric.thickness * np.arange(RESOLUTION, LONGEST_PROTRUSION + RESOLUTION, RESOLUTION)
    way = steps[:, None] * normal
    outside = distances(tool, where, np.concatenate([found.point + way, found.point - way]))[0] >= 0.0
    sides = outside.reshape(2, -1)
    return min(float(steps[side.argmax()]) if side.any() else float(steps[-1]) for side in sides)


def _place(sheet: SheetModel, found: Deepest) -> tuple[float, float]:
    x, y = sheet.blank.material_coordinates[sheet.blank.quads[found.element or 0]].mean(axis=0)
    return float(x), float(y)
