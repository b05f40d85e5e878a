"""Fields and energies of one sheet, computed from the state without changing it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from ..engine.layout import lanes_view
from ..engine.loading.grips import GripperState
from ..engine.model import Model
from ..engine.sheet_model import TANGENTIAL_RATIO
from ..engine.state import SheetState, State
from ..kernels.contact.tool_distance import sample_distance_kernel
from ..kernels.contact.tool_shapes import further_kinds
from ..kernels.rows import (
    CellReportRow,
    ElementField,
    MotionRow,
    NodeWorkRow,
    ResultantRow,
    SheetEnergy,
    ThicknessRow,
)
from ..kernels.shell.energy import element_ledger_kernel
from .fields import complete
from .frame import SheetFrame

# Elastic energies of the sheet; the internal energy is their sum plus those of its unit cell.
SHEET_INTERNAL = ("compression", "shear", "in_plane_bending", "bending", "transverse_shear", "hourglass")


@dataclass(frozen=True)
class Penetration:
    """Deepest overlap of a sheet's faces with any tool [m]; negative without contact."""

    at_nodes: float
    at_element_centres: float

    def deeper(self, other: Penetration) -> Penetration:
        """The deeper of the two, at nodes and at element centres."""
        return Penetration(max(self.at_nodes, other.at_nodes), max(self.at_element_centres, other.at_element_centres))


NO_PENETRATION = Penetration(-np.inf, -np.inf)


def centred(now: wp.array, later: wp.array, started: bool) -> np.ndarray:
    """Booked values at the instant of the positions: after the first step, the mean of now and after the next step."""
    value = now.numpy().astype(np.float64)
    return 0.5 * (value + later.numpy()) if started else value


class SheetLedger:
    """Takes frames of one sheet.

    Args:
        model: of the run.
        index: of the sheet.
        state: of the run, which is read.

    Attributes:
        internal: names of the elastic energies of unit cell and sheet; their sum is the entry ``internal``.
    """

    def __init__(self, model: Model, index: int, state: State) -> None:
        self._model, self._run_model, self._index, self._state = model.sheets[index], model, index, state
        sheet = self._model
        self._kernel = element_ledger_kernel(sheet.real, sheet.cell_law, sheet.sheet_traits)
        self._device_sheet = sheet.device_sheet(1)
        self._energy_names = (*sheet.cell_law.energy_names, *SheetEnergy.names())
        self.internal = (*sheet.cell_law.energy_names, *SHEET_INTERNAL)
        count, device = sheet.element_count, sheet.device
        self._energies = wp.zeros((len(self._energy_names), count), dtype=sheet.real, device=device)
        row_count = ElementField.row_count() + ResultantRow.row_count()
        self._fields = wp.zeros((row_count, count), dtype=sheet.real, device=device)
        point_count = sheet.blank.node_count + sheet.blank.element_count if sheet.tool_count else 0
        self._points = wp.zeros(point_count, dtype=wp.vec3d, device=device)
        self._distances = wp.zeros((sheet.tool_count, point_count), dtype=sheet.real, device=device)
        # packed once: a launch from Python costs more than the work of a small sheet
        self._element_ledger: wp.Launch | None = None
        self._tool_distances = self._record_distances()
        # positions of a frame, and their distances to the tools
        self._measured: tuple[np.ndarray, np.ndarray] | None = None
        start = sheet.initial_motion()[:, : sheet.blank.node_count].astype(sheet.precision.numpy).astype(np.float64)
        velocity, spin = _rates(start)
        self.initial_kinetic = self._kinetic(velocity, velocity, spin, spin)

    @property
    def _own(self) -> SheetState:
        return self._state.sheets[self._index]

    def frame(self, ahead: State) -> SheetFrame:
        """A frame of the current state, given the state after the next step; waits for the device."""
        self._launch(ahead.sheets[self._index])
        motion = self._motion(self._own.motion)
        fields, resultants = self._read_fields(ahead.sheets[self._index])
        position = motion[MotionRow.position.vector] + motion[MotionRow.remainder.vector]
        return SheetFrame(
            name=self._model.name,
            position=position,
            director=motion[MotionRow.director.vector],
            fields=fields,
            energies=self._entries(position, motion, ahead.sheets[self._index]),
            resultants=resultants,
        )

    def _launch(self, ahead: SheetState) -> None:
        sheet = self._model
        if self._element_ledger is None:
            self._element_ledger = wp.launch(
                self._kernel,
                dim=sheet.element_count,
                inputs=[
                    self._device_sheet, self._own.motion, ahead.motion,
                    lanes_view(ahead.cell_unknowns, 1), lanes_view(ahead.cell_report, 1), lanes_view(ahead.slip, 1),
                ],
                outputs=[lanes_view(self._energies, 1), lanes_view(self._fields, 1)],
                device=sheet.device,
                record_cmd=True,
            )  # fmt: skip
        self._element_ledger.launch()

    def _read_fields(self, ahead: SheetState) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Fields and resultants by name."""
        count, fabric = self._model.blank.element_count, self._model.fabric
        values = self._fields.numpy()[:, :count].astype(np.float64)
        rows = dict(zip(ElementField.names(), values, strict=False))
        report = dict(zip(CellReportRow.names(), ahead.cell_report.numpy()[:, :count].astype(np.float64), strict=True))
        resultants = dict(zip(ResultantRow.names(), values[ElementField.row_count() :], strict=True))
        return complete(fabric, rows, report), resultants

    def _motion(self, motion: wp.array) -> np.ndarray:
        """MOTION_VECTORS without padding, in double precision, (vectors, node_count, 3)."""
        return self._model.read_motion(motion)[:, : self._model.blank.node_count].astype(np.float64)

    def _kinetic(self, before: np.ndarray, after: np.ndarray, spin_before: np.ndarray, spin_after: np.ndarray) -> float:
        """1/2 sum m v-.v+ from the velocities half a step before and after, which central differences conserve.

        For a linear sheet under constant loads, 1/2 m v-.v+ plus the energies at the positions between is constant to
        round-off; with a squared velocity the sum would oscillate by a relative omega dt.
        """
        mass, inertia = self._model.node_mass, self._model.node_inertia
        return 0.5 * float(mass @ (before * after).sum(axis=1) + inertia @ (spin_before * spin_after).sum(axis=1))

    def _entries(self, position: np.ndarray, motion: np.ndarray, ahead: SheetState) -> dict[str, float]:
        """Entries of the ledger that belong to the sheet [J].

        Work entries are the mean of their values now and after the next step: half of the next step's work brings them
        to the instant of the positions.
        """
        sheet, started = self._model, self._state.step_count > 0
        element = self._energies.numpy()[:, : sheet.blank.element_count].astype(np.float64).sum(axis=1)
        entries = dict(zip(self._energy_names, element.tolist(), strict=True))
        entries["internal"] = sum(entries[name] for name in self.internal)
        velocity, spin = _rates(motion)
        next_velocity, next_spin = _rates(self._motion(ahead.motion))
        entries["kinetic"] = (
            self._kinetic(velocity, next_velocity, spin, next_spin) if started else self.initial_kinetic
        )
        entries |= self._contact_entries(position, ahead)
        works = dict.fromkeys(NodeWorkRow.names(), 0.0)
        booked = self._own.works()
        if started:
            booked = 0.5 * (booked + ahead.works())
        works.update(zip(sheet.node_work_rows, booked.tolist(), strict=True))
        entries["friction_loss"] = works["friction_work"] - entries["friction_spring"]
        entries["damping_loss"] = works["damping_loss"]
        entries["support_work"] = works["support_work"]
        entries["thickness_work"] = works["thickness_work"]
        entries["load_work"] = works["load_work"]
        # booked up to the positions of the evaluation, so the next step has it up to these
        entries["pressure_work"] = float(ahead.pressure_work.numpy().sum())
        grippers = GripperState.of(sheet, ahead.grip)
        entries["gripper_spring"], entries["gripper_work"] = grippers.stored, grippers.work
        entries["gripper_loss"] = grippers.loss
        displacement = position - sheet.blank.node_position
        entries["gravity_work"] = float(sheet.node_mass @ (displacement @ np.array(sheet.dynamics.gravity)))
        entries["initial_kinetic"] = self.initial_kinetic
        return entries

    def _contact_entries(self, position: np.ndarray, ahead: SheetState) -> dict[str, float]:
        sheet, node_count = self._model, len(position)
        half_thickness = np.full(node_count, 0.5 * sheet.fabric.thickness)
        if sheet.follows_thickness:
            half_thickness = ahead.thickness.numpy()[ThicknessRow.half, :node_count]
        penetration = np.maximum(half_thickness - self._tool_distance(position)[:, :node_count], 0.0)
        friction = sheet.friction_layout.read(ahead.friction)[: 3 * sheet.tool_count, :node_count]
        stiffness = sheet.contact_stiffness
        return {
            "contact": 0.5 * float((stiffness * np.square(penetration)).sum()),
            "friction_spring": 0.5
            * TANGENTIAL_RATIO
            * float((stiffness * np.square(friction, dtype=np.float64)).sum()),
        }

    # --- distances to the tools --------------------------------------------------------------------------------------

    def _record_distances(self) -> list[wp.Launch]:
        sheet, tools = self._model, self._run_model.tools
        normal = wp.zeros(self._points.shape, dtype=sheet.types.vec3, device=sheet.device)
        kernel = sample_distance_kernel(sheet.real, 1, further_kinds(sheet.node_traits.shape_kinds))
        return [
            wp.launch(
                kernel,
                dim=self._points.shape[0],
                inputs=[tools.tool, tools.part, sheet.places.tools.start + k, wp.float64(0.0), self._points],
                outputs=[self._distances[k], normal],
                device=sheet.device,
                record_cmd=True,
            )
            for k in range(sheet.tool_count)
        ]

    def _tool_distance(self, position: np.ndarray) -> np.ndarray:
        """Current distance of nodes, then element centres, to each tool, (tool_count, point_count) [m]."""
        if self._measured is None or self._measured[0] is not position:
            sheet = self._model
            if not sheet.tool_count:
                return np.empty((0, len(position) + sheet.blank.element_count))
            a, b, c, d = (position[corner] for corner in sheet.blank.quads.T)
            self._points.assign(np.concatenate([position, 0.25 * (a + b + c + d)]))
            displacement = self._state.tool_displacement.numpy()[sheet.places.tools.start : sheet.places.tools.stop]
            for launch, value in zip(self._tool_distances, displacement, strict=True):
                launch.set_param_by_name("displacement", wp.float64(value))
                launch.launch()
            self._measured = position, self._distances.numpy().astype(np.float64)
        return self._measured[1]

    def penetration(self, frame: SheetFrame) -> Penetration:
        """Deepest penetration of a frame just taken."""
        sheet, quads = self._model, self._model.blank.quads
        if not sheet.tool_count:
            return NO_PENETRATION
        at_elements = np.full(len(quads), 0.5 * sheet.fabric.thickness)
        at_nodes = np.full(len(frame.position), 0.5 * sheet.fabric.thickness)
        if sheet.follows_thickness:
            at_elements = 0.5 * frame.fields["thickness"]
            sharing = np.bincount(quads.ravel())
            at_nodes = np.bincount(quads.ravel(), weights=np.repeat(at_elements, 4)) / sharing
        distance, node_count = self._tool_distance(frame.position), len(frame.position)
        return Penetration(
            at_nodes=float((at_nodes - distance[:, :node_count]).max()),
            at_element_centres=float((at_elements - distance[:, node_count:]).max()),
        )


def _rates(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and spins."""
    return motion[MotionRow.velocity.vector], motion[MotionRow.spin.vector]
