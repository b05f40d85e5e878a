"""Size of the elements: against the tools that they meet, and against the folds of a sheet that hangs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...tools.sampling import DOUBTFUL_ERROR, ERROR_ADVICE, error_in_words, mesh_parts
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...engine.sheet_model import SheetModel
    from ..verdict import Judged

# With fewer elements along a quarter turn of an edge, the sheet sags over it.
LEAST_ELEMENTS_PER_QUARTER_TURN = 5.0
# From here on what the sag changes is measured and small (docs/validation.md).
FEWEST_ELEMENTS_PER_QUARTER_TURN = 3.0
LEAST_ELEMENTS_PER_BENDING_LENGTH = 2.0


class ToolRadius(Guard):
    """Radii that the mesh cannot follow: told once for all tools of one radius.

    Where it is no more than a note, it is told at the end, with what it did.
    """

    name = "tool_radius"
    watches = "elements along the radii of the tools"

    def __init__(self) -> None:
        self._noted: list[Doubt] = []

    def before(self, start: Start) -> Iterable[Doubt]:
        """Tools with few elements along a quarter turn of their smallest radius; sharp edges have their own guard.

        Of several sheets that meet a tool, the one with the largest elements is named.
        """
        coarsest: dict[int, SheetModel] = {}
        for sheet, _, index in start.meetings():
            if index not in coarsest or sheet.geometry.largest_size > coarsest[index].geometry.largest_size:
                coarsest[index] = sheet
        alike: dict[tuple[float, float, float, str | None], list[str]] = {}
        for index, sheet in coarsest.items():
            tool, size = start.model.setup.tools[index], sheet.geometry.largest_size
            count = tool.elements_per_quarter_turn(size)
            if count < LEAST_ELEMENTS_PER_QUARTER_TURN:
                name = sheet.name if len(start.model.sheets) > 1 else None
                alike.setdefault((count, size, tool.fillet_radius, name), []).append(tool.name)
        self._noted = []
        for (count, size, radius, name), tools in alike.items():
            doubt = self.doubt(
                Level.NOTE if count >= FEWEST_ELEMENTS_PER_QUARTER_TURN else Level.WARNING,
                f"{', '.join(dict.fromkeys(tools))}: {count:.1f} elements of {size * 1e3:.2g} mm along 90 degrees of "
                f"{'its' if len(tools) == 1 else 'their'} {radius * 1e3:.3g} mm radius",
                "below five the sheet sags over the edge: take elements of at most "
                f"{1e3 * size * count / LEAST_ELEMENTS_PER_QUARTER_TURN:.2g} mm there",
                sheet=name,
                value=count,
                limit=LEAST_ELEMENTS_PER_QUARTER_TURN,
            )
            if doubt.level > Level.NOTE:
                yield doubt
            else:
                self._noted.append(doubt)

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The notes, with the depth that the middles of elements reached in a tool."""
        for doubt in self._noted:
            depth = run.run.penetration.at_element_centres
            measured = (
                f"; the middle of an element was {1e3 * depth:.2g} mm in a tool at most, which falls with the square "
                "of their size"
            )
            yield replace(doubt, advice=doubt.advice + (measured if depth > 0.0 else ""))


class SharpEdges(Guard):
    """Sharp edges of triangle meshes, which come through between the nodes of a sheet."""

    name = "sharp_edges"
    watches = "sharp edges of the tools that face the sheet"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Tools with convex sharp edges that the sheet may be drawn over."""
        for sheet, _, index in start.meetings():
            tool, size = start.model.setup.tools[index], sheet.geometry.largest_size
            edges = tool.sharp_edges_facing(sheet.blank.node_position)
            if len(edges):
                place = ", ".join(f"{1e3 * c:.4g}" for c in edges[0])
                yield self.doubt(
                    Level.WARNING,
                    f"{tool.name}: {len(edges)} sharp edges face the sheet, one about ({place}) mm",
                    f"the sheet meets tools at its nodes, {size * 1e3:.2g} mm apart, and a sharp edge comes "
                    "through between them: round it, or use a finer mesh",
                    sheet=sheet.name if len(start.model.sheets) > 1 else None,
                )


class ToolMeshes(Guard):
    """Leftovers in triangle meshes, and errors of their sampled distances beside the thickness of the sheet."""

    name = "tool_meshes"
    watches = "errors of the sampled distances of the tools, and parts far from the rest"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Meshes whose distance errs by more than a share of the thickness; beyond a larger one no run starts."""
        setup = start.model.setup
        thickness = min((sheet.fabric.thickness for sheet in setup.sheets), default=0.0)
        for name, surface in mesh_parts(setup.tools).items():
            for warning in surface.warnings:
                yield self.doubt(Level.WARNING, warning)
            sampled = start.model.samples[surface]
            share = sampled.usual_error / thickness
            if share > DOUBTFUL_ERROR:
                text = f"{name}: {error_in_words(sampled, thickness)}"
                yield self.doubt(Level.WARNING, text, ERROR_ADVICE, value=share, limit=DOUBTFUL_ERROR)


class BendingLength(Guard):
    """Elements that are too large for the folds of a sheet under its own weight.

    A strip bends over about (D / weight per area)^(1/3), its bending length: folds of a draping cloth are a few of it
    wide. In the cantilever test four elements on two bending lengths give 5 % less stiffness, three 9 %.
    """

    name = "bending_length"
    watches = "elements along the length over which a sheet bends under its weight"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Sheets under gravity with fewer than two elements along the shorter bending length."""
        for sheet in start.model.sheets:
            fabric, gravity = sheet.fabric, float(np.linalg.norm(sheet.dynamics.gravity))
            stiffness = min(fabric.bending.strip_stiffness(yarn, fabric.thickness) for yarn in ("warp", "weft"))
            if gravity == 0.0 or stiffness <= 0.0:  # a membrane has no such length
                continue
            length = (stiffness / (fabric.areal_density * gravity)) ** (1.0 / 3.0)
            size = sheet.geometry.largest_size
            if length < LEAST_ELEMENTS_PER_BENDING_LENGTH * size:
                yield self.doubt(
                    Level.WARNING,
                    f"elements of {1e3 * size:.3g} mm are coarse for a sheet that bends over {1e3 * length:.3g} mm "
                    "under its weight",
                    "folds and hanging parts come out too soft, or cannot form: take at least two elements along that",
                    sheet=sheet.name,
                    value=length / size,
                    limit=LEAST_ELEMENTS_PER_BENDING_LENGTH,
                )
