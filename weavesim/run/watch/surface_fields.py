"""Gap to the tools and height of wrinkles of a sheet at one instant, for the frames that are written."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ...engine.model import Model
from ...engine.state import State
from ...measures.defects.contact import half_thickness
from ...measures.defects.regions import with_neighbours
from ...measures.defects.waves import WAVELENGTH_OF_FRAMES, WRINKLE_COMPRESSION, WaveFilter
from ...sheet.blank import Blank
from .tool_gaps import ToolGaps

# A larger sheet has no heights of wrinkles in its frames: the equations of the waves would take gigabytes.
LARGEST_NODE_COUNT = 200_000
# Share of the reach of sampled distances up to which they are distances, not bounds.
_KNOWN_SHARE = 1.0 - 1.0e-5


class SurfaceFields:
    """Takes both fields of one sheet.

    Args:
        model: of the run.
        index: of the sheet.
        state: of the run, which is read.
        acting: whether each tool of the run acts, (tool_count,) bool.
    """

    def __init__(self, model: Model, index: int, state: State, acting: np.ndarray) -> None:
        sheet = self._sheet = model.sheets[index]
        self._gaps = ToolGaps(model, index, state, sheet.blank.element_count, acting)
        tools = model.setup.tools[sheet.places.tools.start : sheet.places.tools.stop]
        surfaces = [[part.surface for part in tool.shape.parts() if part.surface is not None] for tool in tools]
        # beyond the reach of its samples, the distance to a mesh is only a lower bound
        self._reach = np.array(
            [min((model.samples[surface].reach for surface in own), default=np.inf) for own in surfaces]
        )

    @property
    def launches(self) -> list:
        """Of the distances to the tools."""
        return self._gaps.launches

    @cached_property
    def _part(self) -> tuple[Blank, np.ndarray | slice]:
        """What no stage has trimmed away, and its nodes."""
        blank, kept = self._sheet.blank, self._sheet.kept
        return (blank, slice(None)) if kept.all() else blank.part(kept)

    @cached_property
    def _filter(self) -> WaveFilter:
        return WaveFilter(self._part[0], WAVELENGTH_OF_FRAMES)

    def __call__(
        self,
        position: np.ndarray,
        fields: Mapping[str, np.ndarray],
        node_distance: np.ndarray,
        middle_distance: np.ndarray | None = None,
    ) -> dict[str, np.ndarray]:
        """The fields by name, (element_count,) each [m]; waits for the device.

        A gap is not a number where no tool acts, or where the nearest one is a mesh out of the reach of its samples.

        Args:
            position: of the nodes, (node_count, 3) [m].
            fields: of the elements, by name.
            node_distance: of the nodes from each tool, infinite where it does not act, (tool_count, node_count) [m].
            middle_distance: the same of the middles of flat elements, (tool_count, element_count) [m]; None if it is
                not known.
        """
        found, quads = {}, self._sheet.blank.quads
        if self._sheet.tool_count:
            if middle_distance is None:
                middle_distance = self._gaps(position[quads].mean(axis=1))
            middle = self._nearest(middle_distance)
            sheet = self._sheet
            found["tool_gap"] = middle - half_thickness(
                sheet.fabric.thickness, fields["thickness"], sheet.follows_thickness
            )
        if self._sheet.blank.node_count <= LARGEST_NODE_COUNT:
            (part, nodes), kept, height = self._part, self._sheet.kept, np.full(len(quads), np.nan)
            stretches = (fields[f"{yarn}_stretch"][kept] for yarn in ("warp", "weft"))
            short = [1.0 - each > WRINKLE_COMPRESSION for each in stretches]
            height[kept] = 0.0
            if np.any(short):
                # a crease is an element or two wide: the yarns beside it count too
                counted = np.array([with_neighbours(part.quads, each) for each in short])
                deviation = self._deviation(position[nodes], node_distance[:, nodes])
                height[kept] = 2.0 * self._filter.along_yarns(deviation, counted)
            found["wrinkle_height"] = height
        return found

    def _nearest(self, distance: np.ndarray) -> np.ndarray:
        """Distance from the nearest tool, (n,), not a number where it is unknown, of (tool_count, n) [m]."""
        nearest = distance.min(axis=0)
        known = np.isfinite(nearest)
        if np.isfinite(self._reach).any():
            known &= nearest < _KNOWN_SHARE * self._reach[distance.argmin(axis=0)]
        return np.where(known, nearest, np.nan)

    def _deviation(self, position: np.ndarray, node_distance: np.ndarray) -> np.ndarray:
        """Of every node, what may be a wave, (node_count,) [m].

        What the sheet deviates from its smoothed self contains the shape of the part; what its distance to the nearest
        tool deviates contains creases where another tool becomes the nearest. A wrinkle is in both: at every node the
        smaller one counts, and the first alone where that distance is unknown.
        """
        waves = self._filter
        deviation = waves.of_surface(position)
        if len(node_distance):
            height = self._nearest(node_distance)
            known = np.isfinite(height)
            if known.any():
                over_tools = waves.of_height(np.where(known, height, height.max(where=known, initial=-np.inf)))
                deviation = np.where(known & (abs(over_tools) < abs(deviation)), over_tools, deviation)
        return deviation
