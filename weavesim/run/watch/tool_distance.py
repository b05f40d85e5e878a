"""Distances from the tools of a run at any points and displacements, and the deepest point of a sheet in a tool."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import warp as wp

from ...engine.model import Model
from ...engine.sheet_model import SheetModel
from ...kernels.contact.tool_distance import sample_distance_kernel
from ...kernels.contact.tool_shapes import further_kinds
from ...process.motions.paths import Place, Pose
from ...sheet.samples import corner_shares, surface_points

# Cells of elements that are divided further at once, the most promising first.
LARGEST_CELL_COUNT = 4000
# They are divided down to this share of the sheet's thickness.
RESOLUTION = 0.25
# A curved cell reaches this much further than a flat one of the same corners.
CURVED = 1.2


class ToolDistances:
    """Signed distances from the tools of a run, in its precision, on its device."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._kernels: dict[int, wp.Kernel] = {}
        for sheet in model.sheets:
            kernel = sample_distance_kernel(model.real, model.lane_count, further_kinds(sheet.node_traits.shape_kinds))
            self._kernels |= dict.fromkeys(range(sheet.places.tools.start, sheet.places.tools.stop), kernel)

    def __call__(self, tool: int, place: Place, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance (n,) [m] and outward normal (n, 3) of ``points`` (n, 3) [m].

        Args:
            tool: index among the tools of the run.
            place: where it is: its displacement along its axis [m], or its pose.
            points: at least one.
        """
        if isinstance(place, Pose):
            distances, normals = self(tool, 0.0, place.back(points))
            return distances, place.turned(normals)
        model, count = self._model, len(points)
        distance = wp.zeros(count, dtype=model.real, device=model.device)
        normal = wp.zeros(count, dtype=model.types.vec3, device=model.device)
        wp.launch(
            self._kernels[tool],
            dim=-(-count // model.lane_count),
            inputs=[
                model.tools.tool, model.tools.part, tool, wp.float64(place),
                wp.array(np.asarray(points, dtype=np.float64), dtype=wp.vec3d, device=model.device),
            ],
            outputs=[distance, normal],
            device=model.device,
        )  # fmt: skip
        return distance.numpy().astype(np.float64), normal.numpy().astype(np.float64)

    def deepest(
        self,
        tool: int,
        place: Place,
        position: np.ndarray,
        sheet: SheetModel,
        limit: float,
        director: np.ndarray | None = None,
    ) -> Deepest:
        """The point of a sheet that lies deepest in a tool, to a quarter of the thickness; see ``deepest_point``.

        Args:
            tool: index among the tools of the run.
            place: where it is, as above.
            position: nodes of the sheet, (node_count, 3) [m].
            sheet: it.
            limit: only points nearer than this are looked for [m].
            director: at the nodes, (node_count, 3): of the surface that they describe; None takes flat elements.
        """
        (there,), resolution = np.nonzero(sheet.kept), RESOLUTION * sheet.fabric.thickness
        quads = sheet.blank.quads[there]
        directors = None if director is None else director[quads]
        found = deepest_point(
            lambda points: self(tool, place, points)[0], position[quads], limit, resolution, directors
        )
        return found if found.element is None else found._replace(element=int(there[found.element]))


class Deepest(NamedTuple):
    """The point of a sheet's middle surface that lies deepest in a tool.

    Attributes:
        distance: from the tool's surface [m], negative inside.
        element: that contains it; None if no point is nearer than the limit.
        point: it, (3,) [m].
    """

    distance: float
    element: int | None = None
    point: np.ndarray | None = None


def deepest_point(
    distance_of: Callable[[np.ndarray], np.ndarray],
    corners: np.ndarray,
    limit: float,
    resolution: float,
    directors: np.ndarray | None = None,
) -> Deepest:
    """The point of elements that lies deepest in a body, also between their nodes.

    A distance changes by at most the way between two points: cells of elements that cannot be nearer than the best
    point so far are left out, and the others are divided in four, down to ``resolution``.

    Args:
        distance_of: signed distances (n,) of points (n, 3) [m].
        corners: of the elements, (element_count, 4, 3) [m].
        limit: only points nearer than this are looked for [m].
        resolution: size of the smallest cells [m].
        directors: at the corners, (element_count, 4, 3), which describe the surface; None takes flat elements.
    """
    middle = corners.mean(axis=1, keepdims=True)
    radius = CURVED * np.linalg.norm(corners - middle, axis=2).max(axis=1)
    element, half = np.arange(len(corners)), 1.0
    place = np.zeros((len(corners), 2))
    best = Deepest(limit)
    while len(element):
        if directors is None:
            points = np.einsum("kc,kci->ki", corner_shares(place)[0], corners[element])
        else:
            points, _ = surface_points(corners[element], directors[element], place)
        distance = distance_of(points)
        lowest = int(np.argmin(distance))
        if distance[lowest] < best.distance:
            best = Deepest(float(distance[lowest]), int(element[lowest]), points[lowest])
        reach = distance - half * radius[element]
        (kept,) = np.nonzero((reach < best.distance) & (half * radius[element] > resolution))
        if len(kept) > LARGEST_CELL_COUNT:
            kept = kept[np.argpartition(reach[kept], LARGEST_CELL_COUNT)[:LARGEST_CELL_COUNT]]
        half *= 0.5
        quarter = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        place = (place[kept][:, None] + quarter).reshape(-1, 2)
        element = np.repeat(element[kept], 4)
    return best
