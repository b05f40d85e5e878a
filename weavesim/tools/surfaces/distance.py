"""The distance to a tool at many points, again and again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...process.motions.paths import Place, Pose
from ..shapes import shape_kinds

if TYPE_CHECKING:
    from ..tool import Tool


class ToolDistance:
    """Signed distance and normal of one tool; a mesh is sampled once, when this is made.

    Args:
        tool: of any shape.
        device: name in Warp.
    """

    def __init__(self, tool: Tool, device: str = "cpu") -> None:
        import warp as wp

        from ...device import initialise
        from ...kernels.contact.tool_distance import sample_distance_kernel
        from ...kernels.contact.tool_shapes import further_kinds
        from ..device import build_device_tools
        from ..sampling import sample_meshes

        initialise()
        self._device = device
        self._tools = build_device_tools([tool], wp.float64, device, sample_meshes([tool], device))
        self._kernel = sample_distance_kernel(wp.float64, 1, further_kinds(shape_kinds([tool.shape])))

    def __call__(self, points: np.ndarray, place: Place = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Distance of ``points`` (n, 3) [m], (n,), and outward normals (n, 3).

        Args:
            points: (n, 3) [m].
            place: where the tool is: its displacement along its axis [m], or its pose.
        """
        import warp as wp

        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if isinstance(place, Pose):
            distances, normals = self(place.back(points))
            return distances, place.turned(normals)
        distance = wp.zeros(len(points), dtype=wp.float64, device=self._device)
        normal = wp.zeros(len(points), dtype=wp.vec3d, device=self._device)
        wp.launch(
            self._kernel,
            dim=len(points),
            inputs=[
                self._tools.tool, self._tools.part, 0, wp.float64(place),
                wp.array(points, dtype=wp.vec3d, device=self._device),
            ],
            outputs=[distance, normal],
            device=self._device,
        )  # fmt: skip
        return distance.numpy(), normal.numpy()
