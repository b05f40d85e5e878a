"""Tools that overlap the sheet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from .guard import Doubt, Guard, Level
from .limit import LimitGuard

if TYPE_CHECKING:
    from ..verdict import Judged

# Of the thickness: depth of a node that is not doubted, and from which on the tool is past the middle of the sheet.
LARGEST_DEPTH = 0.05
USELESS_DEPTH = 0.5


class PenetrationAtNodes(Guard):
    """Nodes deep in a tool, in any step."""

    lasting = True
    name = "penetration_at_nodes"
    watches = "the depth of the nodes in the tools, in every step"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The deepest node of each sheet."""
        for info, sheet in zip(run.run.info.sheets, run.extremes.sheets, strict=True):
            share = sheet.depth.value / info.fabric.thickness
            if not share <= LARGEST_DEPTH:
                tool = run.run.info.tool_names[sheet.depth.tool] if sheet.depth.tool is not None else "a tool"
                yield self.doubt(
                    Level.WARNING if share <= USELESS_DEPTH else Level.DO_NOT_USE,
                    f"the deepest node was {1e3 * sheet.depth.value:.3g} mm in {tool}, {share:.0%} of the thickness",
                    "tools move too fast, or meet through the sheet: slow them down, or leave them room for the sheet",
                    sheet=info.name,
                    place=sheet.depth.place,
                    time=sheet.depth.time,
                    value=sheet.depth.value,
                    limit=LARGEST_DEPTH * info.fabric.thickness,
                )


class PenetrationOfSurface(LimitGuard):
    """Sheets whose surface lies deep in a tool, at nodes or between; the chord of flat elements does not count."""

    lasting = True
    name = "penetration_of_surface"
    watches = "the depth of the sheet's surface, as its directors describe it, in the tools"
    key = "penetration_of_surface_mm"
    text = "the deepest point of the sheet's surface in a tool [mm]"
    advice = (
        "the elements are too large for the tools' edges: refine the mesh, or meet tools between nodes too "
        '(contact_samples = "surface")'
    )

    def where(self, run: Judged) -> Mapping[str, Any]:
        """Of that point."""
        deepest = run.run.penetration
        return {"sheet": deepest.sheet, "place": deepest.place, "time": deepest.time} if deepest.sheet else {}

    def limit(self, run: Judged) -> float:
        """Half the thinnest sheet [mm]: the tool's surface is at the middle of the sheet."""
        return 0.5 * (1e3 * run.thickness)

    def useless_beyond(self, run: Judged) -> float | None:
        """Twice the thickness [mm]."""
        return 2.0 * (1e3 * run.thickness)
