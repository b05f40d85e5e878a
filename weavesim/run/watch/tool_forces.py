"""Forces of the tools at every point of a sheet, by the contact law of the steps, computed when a frame wants them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp

from ...engine.layout import lanes_view, put
from ...engine.model import Model
from ...engine.sheet_model import SheetModel
from ...engine.state import State
from ...engine.surface.friction import argument_rows, contact_areas
from ...kernels.contact.penalty import touch_struct
from ...kernels.contact.tool_distance import tool_set_struct
from ...kernels.rows import ClockEntry, ToolPoseRow
from ...kernels.stepping.tool_contact import tool_push_kernel, touching_struct
from ...sheet.samples import at_places, corner_shares
from .tool_gaps import ToolGaps


class PointForces(NamedTuple):
    """Forces of the tools at points of a sheet.

    Attributes:
        push: along the outward normal of each tool, (tool_count, point_count) [N].
        normal: these normals, (tool_count, point_count, 3).
        drag: of friction, (tool_count, point_count, 3) [N].
    """

    push: np.ndarray
    normal: np.ndarray
    drag: np.ndarray


class ToolForces:
    """Forces of the tools of one sheet at its nodes, and at its samples where it meets tools between them.

    They are those of the step to come, which starts from the state. The step itself keeps only their sums.

    Args:
        model: of the run.
        index: of the sheet.
        state: of the run, which is read.
        gaps: distances and normals at these points, nodes first.
        acting: whether each tool of the run acts, (tool_count,) bool.

    Attributes:
        launches: that compute them; none without tools.
    """

    def __init__(self, model: Model, index: int, state: State, gaps: ToolGaps, acting: np.ndarray) -> None:
        sheet = self._sheet = model.sheets[index]
        self._own, self._gaps = state.sheets[index], gaps
        self._tools = model.setup.tools[sheet.places.tools.start : sheet.places.tools.stop]
        self._acts = acting[sheet.places.tools.start : sheet.places.tools.stop]
        self._node_count, self._element_count = sheet.blank.node_count, sheet.blank.element_count
        real, count = sheet.real, self._node_count + len(sheet.samples.places) * self._element_count
        self._shares = corner_shares(sheet.samples.places)[0]
        self._half_thickness = wp.zeros(count, dtype=real, device=sheet.device)
        self._state = state
        self._velocity = wp.zeros((sheet.tool_count, count), dtype=sheet.types.vec3, device=sheet.device)
        self._friction = wp.zeros((3 * sheet.tool_count, count), dtype=real, device=sheet.device)
        self._push = wp.zeros((sheet.tool_count, count), dtype=real, device=sheet.device)
        self._drag = wp.zeros(self._push.shape, dtype=sheet.types.vec3, device=sheet.device)
        self.launches = [self._record(model, state)] if sheet.tool_count else []

    def __call__(self, half_thickness: np.ndarray, velocity: np.ndarray) -> PointForces:
        """Forces at the points whose distances ``gaps`` has just taken; waits for the device.

        Args:
            half_thickness: at the points, (point_count,) [m].
            velocity: of the nodes, (node_count, 3) [m/s].
        """
        sheet = self._sheet
        if not self.launches:
            empty = np.zeros((0, len(half_thickness)))
            return PointForces(empty, empty[..., None], empty[..., None])
        put(self._half_thickness, half_thickness)
        of_points = np.concatenate([velocity, *at_places(self._shares, velocity, sheet.blank.quads)])
        put(self._velocity, of_points if not sheet.node_traits.carried else of_points - self._surface_velocity())
        put(self._friction, self._springs())
        for launch in self.launches:
            launch.launch()
        push, drag = (array.numpy().astype(np.float64) for array in (self._push, self._drag))
        push[~self._acts], drag[~self._acts] = 0.0, 0.0
        return PointForces(push, self._gaps.normals(), drag)

    def _poses(self) -> np.ndarray:
        """Entries of the poses of its tools, if they are carried."""
        places = self._sheet.places.tools
        return self._state.tool_pose.numpy()[places.start : places.stop]

    def _surface_velocity(self) -> np.ndarray:
        """Of carried tools at the points, (tool_count, point_count, 3) [m/s]; of others the kernel knows it."""
        places = self._sheet.places.tools
        poses, along = self._poses(), self._state.tool_velocity.numpy()[places.start : places.stop]
        axes = np.array([tool.axis for tool in self._tools])
        arms = self._gaps.points - poses[:, None, ToolPoseRow.pivot.span]
        turning = np.cross(poses[:, None, ToolPoseRow.spin.span], arms)
        velocity: np.ndarray = (poses[:, ToolPoseRow.velocity.span] + along[:, None] * axes)[:, None] + turning
        return velocity

    def _springs(self) -> np.ndarray:
        """Friction springs at the points, turned with carried tools, (3 tool_count, point_count) [m]."""
        springs = self._kept_springs()
        if not self._sheet.node_traits.carried:
            return springs
        vectors = springs.reshape(self._sheet.tool_count, 3, -1).astype(np.float64)
        step = float(self._state.clock.numpy()[ClockEntry.mean_step])
        turned = vectors + step * np.cross(self._poses()[:, ToolPoseRow.spin.span, None], vectors, axis=1)
        return turned.reshape(springs.shape)

    def _kept_springs(self) -> np.ndarray:
        """Friction springs as the steps keep them."""
        sheet, rows = self._sheet, 3 * self._sheet.tool_count
        parts = [sheet.friction_layout.read(self._own.friction)[:rows, : self._node_count]]
        if places := len(sheet.samples.places):
            between = sheet.samples.layout.read(self._own.sample_friction)[:rows]
            between = between.reshape(rows, places, sheet.element_count).take(sheet.samples.slot, axis=2)
            parts.append(between.reshape(rows, -1))
        return np.concatenate(parts, axis=1)

    def _record(self, model: Model, state: State) -> wp.Launch:
        sheet, tools = self._sheet, model.tools
        of_tools = tool_set_struct(sheet.real)()
        of_tools.part, of_tools.argument, of_tools.coefficient = tools.part, tools.argument, tools.coefficient
        own = sheet.places.tools.of
        of_tools.tool, of_tools.law = own(tools.tool), own(tools.law)
        of_tools.displacement, of_tools.velocity = own(state.tool_displacement), own(state.tool_velocity)
        if sheet.node_traits.carried:  # velocities are relative to their surfaces
            of_tools.velocity = wp.zeros(sheet.tool_count, dtype=wp.float64, device=sheet.device)
        return wp.launch(
            tool_push_kernel(sheet.real, sheet.node_traits.friction_laws),
            dim=self._push.shape,
            inputs=[sheet.node_laws(), of_tools, self._points(state), self._touch()],
            outputs=[self._push, self._drag],
            device=sheet.device,
            record_cmd=True,
        )

    def _points(self, state: State) -> Any:
        sheet, points = self._sheet, touching_struct(self._sheet.real)()
        mass = [sheet.node_mass, np.tile(sheet.samples.mass, len(sheet.samples.places))]
        points.clock = state.clock
        points.mass = wp.array(np.concatenate(mass), dtype=sheet.real, device=sheet.device)
        points.half_thickness, points.velocity = self._half_thickness, self._velocity
        points.distance, points.normal = self._gaps.distances, self._gaps.normal
        return points

    def _touch(self) -> Any:
        """Friction of the points, with room for what laws note of their arguments, which nobody reads."""
        sheet, touch = self._sheet, touch_struct(self._sheet.real, 1)()
        touch.friction = lanes_view(self._friction, 1)
        if sheet.node_traits.friction_laws:
            count = self._push.shape[1]
            area = [contact_areas(sheet, samples=False)[: self._node_count]]
            if places := len(sheet.samples.places):
                between = contact_areas(sheet, samples=True).reshape(places, -1)[:, sheet.samples.slot]
                area.append(between.ravel())
            arguments: wp.array = wp.array(argument_rows(sheet, count), dtype=sheet.real, device=sheet.device)
            areas: wp.array = wp.array(np.concatenate(area), dtype=sheet.real, device=sheet.device)
            touch.argument, touch.area = lanes_view(arguments, 1), lanes_view(areas, 1)
        return touch


class ToolFields:
    """Pressure and friction of the tools on either face of a sheet.

    Forces at a node are shared by its elements as their areas on the flat sheet share it; those at a sample belong to
    its element. Their sum over the current area of the element is its pressure: summed over the elements, pressure
    times area is the force of the tools.

    Args:
        sheet: of the run.
    """

    def __init__(self, sheet: SheetModel) -> None:
        self._area, self._node_count = sheet.geometry.area, sheet.blank.node_count
        self._corners = np.ascontiguousarray(sheet.blank.quads.T)
        there = self._area * sheet.kept
        around = np.bincount(self._corners.T.ravel(), np.repeat(0.25 * there, 4), self._node_count)
        self._share = 0.25 * there / np.where(sheet.waste, 1.0, around)[self._corners]
        self._of_samples = corner_shares(sheet.samples.places)[0]

    def __call__(self, forces: PointForces, director: np.ndarray, area_ratio: np.ndarray) -> dict[str, np.ndarray]:
        """Fields of every element by name, (element_count,) [Pa]; none without tools.

        Args:
            forces: of the tools of the sheet.
            director: at the nodes, (node_count, 3).
            area_ratio: current over initial area of the elements, (element_count,).
        """
        names = [f"tool_{name}_{face}" for name in ("pressure", "friction") for face in ("below", "above")]
        if not len(forces.push):
            return {}
        (touched,) = np.nonzero(forces.push.any(axis=0))
        if not len(touched):
            return {name: 0.0 * area_ratio for name in names}  # of waste not a number
        # most points touch nothing
        push, normal, drag = (each[:, touched] for each in forces)
        # a tool below pushes up, along the director
        below = np.einsum("tpi,pi->tp", normal, self._directors(touched, director)) > 0.0
        rubbed = np.sqrt(np.einsum("tpi,tpi->tp", drag, drag))
        total = np.zeros((len(names), forces.push.shape[1]))
        total[:, touched] = [(values * here).sum(axis=0) for values in (push, rubbed) for here in (below, ~below)]
        nodes, samples = np.split(total, [self._node_count], axis=1)
        at_corners = nodes.take(self._corners, axis=1)
        at_corners *= self._share
        force = at_corners[:, 0] + at_corners[:, 1] + at_corners[:, 2] + at_corners[:, 3]
        force += samples.reshape(len(names), -1, len(self._area)).sum(axis=1)
        return dict(zip(names, force / (area_ratio * self._area), strict=True))

    def _directors(self, points: np.ndarray, director: np.ndarray) -> np.ndarray:
        """At some points, (len(points), 3), of directors at the nodes (node_count, 3); nodes first, ascending."""
        nodes, samples = np.split(points, [np.searchsorted(points, self._node_count)])
        place, element = np.divmod(samples - self._node_count, len(self._area))
        total = np.zeros((len(samples), 3))
        for share, corner in zip(self._of_samples.T, self._corners, strict=True):
            total += share[place, None] * director[corner[element]]
        return np.concatenate([director[nodes], total])
