"""Distances of points of a sheet from its tools where they are now, recorded once."""

from __future__ import annotations

import numpy as np
import warp as wp

from ...engine.layout import put
from ...engine.model import Model
from ...engine.state import State
from ...kernels.contact.tool_distance import sample_distance_kernel
from ...kernels.contact.tool_shapes import further_kinds
from ...tools.carried.device import pose_of


class ToolGaps:
    """Signed distances of a fixed number of points from the tools of one sheet.

    Args:
        model: of the run.
        index: of the sheet.
        state: of the run, which is read.
        point_count: number of points.
        acting: whether each tool of the run acts, (tool_count,) bool; others are infinitely far away.
        keep_normals: whether ``normals`` are wanted.

    Attributes:
        launches: of every tool.
        points: called last, (point_count, 3) [m].
        distances, normal: of the points called last, of all tools, also of those that do not act, [tool, point];
            ``normal`` has a row for all tools together without ``keep_normals``.
    """

    def __init__(
        self, model: Model, index: int, state: State, point_count: int, acting: np.ndarray, keep_normals: bool = False
    ) -> None:
        self._sheet, self._tools, self._state = model.sheets[index], model.tools, state
        count, places = self._sheet.tool_count, self._sheet.places.tools
        self._away = ~acting[places.start : places.stop]
        self._points = wp.zeros(point_count if count else 0, dtype=wp.vec3d, device=model.device)
        self.distances = wp.zeros((count, len(self._points)), dtype=model.real, device=model.device)
        self.normal = wp.zeros((count if keep_normals else min(count, 1), len(self._points)), dtype=model.types.vec3,
                               device=model.device)  # fmt: skip
        # packed once: a launch from Python costs more than the work of a small sheet
        self.launches = self._record() if len(self._points) else []
        self.points = np.zeros((0, 3))

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Distances of ``points`` (point_count, 3) [m], (tool_count, point_count) [m]; waits for the device."""
        if not len(self._points):
            return np.empty((self._sheet.tool_count, len(points)))
        self.points, places = points, self._sheet.places.tools
        if self._sheet.node_traits.carried:
            self._take_carried(points)
        else:
            put(self._points, points)
            displacement = self._state.tool_displacement.numpy()[places.start : places.stop]
            for launch, value in zip(self.launches, displacement, strict=True):
                launch.set_param_by_name("displacement", wp.float64(value))
                launch.launch()
        result = self.distances.numpy().astype(np.float64)
        result[self._away] = np.inf
        return result

    def _take_carried(self, points: np.ndarray) -> None:
        """From the poses of the tools: points are taken into their frames, and normals back."""
        places = self._sheet.places.tools
        poses = [pose_of(entries) for entries in self._state.tool_pose.numpy()[places.start : places.stop]]
        for launch, pose in zip(self.launches, poses, strict=True):
            put(self._points, pose.back(points))
            launch.launch()
        if len(self.normal) == len(poses):
            self.normal.assign(np.stack([pose.turned(own) for pose, own in zip(poses, self.normals(), strict=True)]))

    def normals(self) -> np.ndarray:
        """Outward normals of the tools at the points called last, (tool_count, point_count, 3)."""
        return self.normal.numpy().astype(np.float64)

    def _record(self) -> list[wp.Launch]:
        sheet, tools = self._sheet, self._tools
        kernel = sample_distance_kernel(sheet.real, sheet.lane_count, further_kinds(sheet.node_traits.shape_kinds))
        return [
            wp.launch(
                kernel,
                dim=-(-len(self._points) // sheet.lane_count),
                inputs=[tools.tool, tools.part, sheet.places.tools.start + k, wp.float64(0.0), self._points],
                outputs=[self.distances[k], self.normal[min(k, len(self.normal) - 1)]],
                device=sheet.device,
                record_cmd=True,
            )
            for k in range(sheet.tool_count)
        ]
