"""The energy ledger and the fields of a frame, taken from the state without changing it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from ..engine.layout import lanes_view
from ..engine.model import TANGENTIAL_RATIO
from ..engine.state import Ahead
from ..engine.stepper import Stepper
from ..kernels.contact.tool_distance import sample_distance_kernel
from ..kernels.rows import CellReportRow, ElementField, MotionRow, NodeReportRow, SheetEnergy, ToolWorkRow
from ..kernels.shell.energy import element_ledger_kernel
from ..process.device import support_outputs
from ..process.strokes import ForceDriven
from ..process.supports import Support
from ..tools.tool import Tool
from .frame import Frame, SheetFrame

# A cell whose residual ever exceeds this share of the forces that it balances has failed.
UNIT_CELL_FAILURE = 1.0e-3
# Elastic energies of the sheet; their sum with those of its unit cell is the internal energy.
SHEET_INTERNAL = ("compression", "shear", "in_plane_bending", "bending", "transverse_shear", "hourglass")
STORED = ("kinetic", "tool_kinetic", "internal", "contact", "friction_spring")
LOST = ("friction_loss", "damping_loss", "snap_loss", "shear_friction_loss", "bending_friction_loss")
SUPPLIED = (
    "tool_work", "driving_force_work", "support_work", "load_work", "thickness_work", "gravity_work", "initial_kinetic",
)  # fmt: skip
# What is made of the other entries.
SUMS = ("internal", "supplied", "used", "balance_error")


@dataclass(frozen=True)
class Penetration:
    """Deepest overlap of the sheet's faces with any tool [m]; negative where nothing touches."""

    at_nodes: float
    at_element_centres: float


class Ledger:
    """Takes frames of a run.

    Args:
        stepper: its state is read.
        tools: in the order of the device tools.
        leading_tool: whose displacement is the stroke.
        supports: in the order of the device supports.

    Attributes:
        internal: names of the elastic energies of unit cell and sheet; their sum is the entry ``internal``.
    """

    def __init__(
        self, stepper: Stepper, tools: tuple[Tool, ...], leading_tool: int, supports: tuple[Support, ...] = ()
    ) -> None:
        self._stepper, self._tools, self._leading_tool, self._supports = stepper, tools, leading_tool, supports
        model = stepper.model
        self._kernel = element_ledger_kernel(model.real, model.cell_law, model.sheet_traits)
        shape = model.element_count
        self._energy_names = (*model.cell_law.energy_names, *SheetEnergy.names())
        self.internal = (*model.cell_law.energy_names, *SHEET_INTERNAL)
        self._energies = wp.zeros((len(self._energy_names), shape), dtype=model.real, device=model.device)
        self._fields = wp.zeros((ElementField.row_count(), shape), dtype=model.real, device=model.device)
        point_count = model.blank.node_count + model.blank.element_count if tools else 0
        self._points = wp.zeros(point_count, dtype=model.types.vec3, device=model.device)
        self._distances = wp.zeros((len(tools), point_count), dtype=model.real, device=model.device)
        # packed once: from Python a launch costs more than the work of a small sheet
        self._element_ledger: wp.Launch | None = None
        self._tool_distances = self._record_distances()
        # positions of a frame, and their distances to the tools
        self._measured: tuple[np.ndarray, np.ndarray] | None = None
        self._driven = np.array([isinstance(tool.motion, ForceDriven) for tool in tools], dtype=bool)
        self._tool_mass = np.array(
            [tool.motion.mass if isinstance(tool.motion, ForceDriven) else 0.0 for tool in tools]
        )
        velocity, spin = self._rates(self._motion(stepper.state.motion))
        self._initial_kinetic = self._kinetic(velocity, velocity, spin, spin)

    def frame(self, index: int) -> Frame:
        """The present state; waits for the device."""
        stepper, model, state = self._stepper, self._stepper.model, self._stepper.state
        ahead = stepper.look_ahead()
        if self._element_ledger is None:
            self._element_ledger = wp.launch(
                self._kernel,
                dim=model.element_count,
                inputs=[
                    model.elements_single, model.cell, model.laws, state.motion, ahead.motion,
                    lanes_view(ahead.cell_unknowns, 1), lanes_view(ahead.cell_report, 1), lanes_view(ahead.slip, 1),
                ],
                outputs=[lanes_view(self._energies, 1), lanes_view(self._fields, 1)],
                device=model.device,
                record_cmd=True,
            )  # fmt: skip
        self._element_ledger.launch()
        count = model.blank.element_count
        fields = dict(zip(ElementField.names(), self._fields.numpy()[:, :count].astype(np.float64), strict=True))
        report = dict(zip(CellReportRow.names(), ahead.cell_report.numpy()[:, :count].astype(np.float64), strict=True))
        compaction, cell = model.fabric.compaction, model.fabric.unit_cell
        fields["thickness"] = model.fabric.thickness * compaction.thickness_ratio(
            cell, fields["area_ratio"], fields["crossover_pressure"]
        )
        fraction = compaction.fibre_volume_fraction(fields["thickness"], fields["area_ratio"])
        if fraction is not None:
            fields["fibre_volume_fraction"] = fraction
        if cell.crossover_area > 0.0:
            fields["crossover_force"] = fields["crossover_pressure"] * cell.crossover_area
        fields["unit_cell_residual"] = report["worst_residual"]
        fields["unit_cell_iterations"] = report["iterations"]
        fields["unit_cell_failed"] = (~(report["worst_residual"] < UNIT_CELL_FAILURE)).astype(np.float64)
        motion = self._motion(state.motion)
        position = motion[MotionRow.position.vector] + motion[MotionRow.remainder.vector]
        displacement = stepper.tools.displacement.numpy().copy()
        support_force, drive_displacement, drive_force = support_outputs(self._supports, stepper.supports)
        leading = displacement[self._leading_tool :] if len(displacement) else drive_displacement
        return Frame(
            index=index,
            step_count=stepper.step_count,
            time=state.time,
            stroke=float(leading[0]) if len(leading) else 0.0,
            sheets=(SheetFrame("sheet", position, motion[MotionRow.director.vector], fields, {}),),
            tool_displacement=displacement,
            tool_reaction=stepper.tools.total_reaction.numpy().copy(),
            energies=self._balance(position, motion, ahead),
            support_force=support_force,
            drive_displacement=drive_displacement,
            drive_force=drive_force,
        )

    def _motion(self, motion: wp.array) -> np.ndarray:
        """MOTION_VECTORS without the padding, in double precision, (vectors, node_count, 3)."""
        return self._stepper.model.read_motion(motion)[:, : self._stepper.model.blank.node_count].astype(np.float64)

    @staticmethod
    def _rates(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and spins."""
        return motion[MotionRow.velocity.vector], motion[MotionRow.spin.vector]

    def _kinetic(self, before: np.ndarray, after: np.ndarray, spin_before: np.ndarray, spin_after: np.ndarray) -> float:
        """1/2 sum m v.v from the velocities of half a step before and after, whose product central differences keep.

        Of a linear sheet under constant loads, 1/2 m v-.v+ plus the energies at the positions between them is constant
        to round-off; a squared velocity would swing against them by a share omega dt.
        """
        model = self._stepper.model
        return 0.5 * float(
            model.node_mass @ (before * after).sum(axis=1) + model.node_inertia @ (spin_before * spin_after).sum(axis=1)
        )

    def _balance(self, position: np.ndarray, motion: np.ndarray, ahead: Ahead) -> dict[str, float]:
        """Every entry of the ledger [J], the supplied and used sums, and their difference.

        Works are the mean of what is booked and what will be after the next step: that of half the next step is
        needed to bring them to the instant of the positions.
        """
        stepper, model, state = self._stepper, self._stepper.model, self._stepper.state
        element = self._energies.numpy()[:, : model.blank.element_count].astype(np.float64).sum(axis=1)
        entries = dict(zip(self._energy_names, element.tolist(), strict=True))
        entries["internal"] = sum(entries[name] for name in self.internal)
        started = stepper.step_count > 0
        velocity, spin = self._rates(motion)
        next_velocity, next_spin = self._rates(self._motion(ahead.motion))
        entries["kinetic"] = (
            self._kinetic(velocity, next_velocity, spin, next_spin) if started else self._initial_kinetic
        )

        def centred(now: wp.array, later: wp.array) -> np.ndarray:
            return 0.5 * (now.numpy().astype(np.float64) + later.numpy()) if started else now.numpy().astype(np.float64)

        work = centred(stepper.tools.work, ahead.tool_work)
        entries["tool_kinetic"] = 0.5 * float(
            self._tool_mass @ (stepper.tools.velocity.numpy() * ahead.tool_velocity.numpy())
        )
        half_thickness = np.full(len(position), 0.5 * model.fabric.thickness)
        if model.follows_thickness:
            half_thickness = ahead.node_report.numpy()[NodeReportRow.half_thickness, : len(position)]
        penetration = np.maximum(half_thickness - self._tool_distance(position)[:, : len(position)], 0.0)
        entries["contact"] = 0.5 * float((model.contact_stiffness * np.square(penetration)).sum())
        friction = model.friction_layout.read(ahead.friction)[: 3 * len(self._tools), : model.blank.node_count]
        entries["friction_spring"] = (
            0.5 * TANGENTIAL_RATIO * float((model.contact_stiffness * np.square(friction, dtype=np.float64)).sum())
        )
        report = dict.fromkeys(NodeReportRow.names(), 0.0)
        report.update(
            zip(model.node_report_rows, centred(state.node_report, ahead.node_report).sum(axis=1), strict=True)
        )
        entries["friction_loss"] = float(report["friction_work"]) - entries["friction_spring"]
        entries["damping_loss"] = float(report["damping_loss"])
        entries["support_work"] = float(report["support_work"])
        entries["thickness_work"] = float(report["thickness_work"])
        entries["load_work"] = float(report["load_work"])
        entries["tool_work"] = float(work[ToolWorkRow.on_sheet][~self._driven].sum())
        entries["driving_force_work"] = float(work[ToolWorkRow.driving][self._driven].sum())
        displacement = position - model.blank.node_position
        entries["gravity_work"] = float(model.node_mass @ (displacement @ np.array(model.motion.gravity)))
        entries["initial_kinetic"] = self._initial_kinetic
        entries["supplied"] = sum(entries[name] for name in SUPPLIED)
        entries["used"] = sum(entries[name] for name in STORED + LOST)
        entries["balance_error"] = entries["supplied"] - entries["used"]
        return entries

    def _record_distances(self) -> list[wp.Launch]:
        model, tools = self._stepper.model, self._stepper.tools
        normal = wp.zeros_like(self._points)
        return [
            wp.launch(
                sample_distance_kernel(model.real, 1),
                dim=self._points.shape[0],
                inputs=[tools.tool, tools.part, k, model.real(0.0), self._points],
                outputs=[self._distances[k], normal],
                device=model.device,
                record_cmd=True,
            )
            for k in range(len(self._tools))
        ]

    def _tool_distance(self, position: np.ndarray) -> np.ndarray:
        """Distance of nodes and then element centres to each tool as it stands, (tool_count, point_count) [m]."""
        if self._measured is None or self._measured[0] is not position:
            model = self._stepper.model
            if not self._tools:
                return np.empty((0, len(position) + model.blank.element_count))
            a, b, c, d = (position[corner] for corner in model.blank.quads.T)
            points = np.concatenate(
                [position, 0.25 * (a + b + c + d)], dtype=model.precision.numpy, casting="same_kind"
            )
            self._points.assign(points)
            displacement = self._stepper.tools.displacement.numpy()
            for launch, value in zip(self._tool_distances, displacement, strict=True):
                launch.set_param_by_name("displacement", model.real(value))
                launch.launch()
            self._measured = position, self._distances.numpy().astype(np.float64)
        return self._measured[1]

    def penetration(self, frame: Frame) -> Penetration:
        """Deepest penetration of a frame just taken."""
        model, quads = self._stepper.model, self._stepper.model.blank.quads
        if not self._tools:
            return Penetration(-np.inf, -np.inf)
        at_elements = np.full(len(quads), 0.5 * model.fabric.thickness)
        at_nodes = np.full(len(frame.position), 0.5 * model.fabric.thickness)
        if model.follows_thickness:
            at_elements = 0.5 * frame.fields["thickness"]
            sharing = np.bincount(quads.ravel())
            at_nodes = np.bincount(quads.ravel(), weights=np.repeat(at_elements, 4)) / sharing
        distance, node_count = self._tool_distance(frame.position), len(frame.position)
        return Penetration(
            at_nodes=float((at_nodes - distance[:, :node_count]).max()),
            at_element_centres=float((at_elements - distance[:, node_count:]).max()),
        )
