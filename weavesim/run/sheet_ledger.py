"""Fields and energies of one sheet, computed from the state without changing it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from ..engine.layout import lanes_view
from ..engine.loading.grips import GripperState
from ..engine.model import Model
from ..engine.sheet_model import TANGENTIAL_RATIO
from ..engine.state import SheetState, State
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
from ..measures.defects.contact import half_thickness
from ..measures.folding import directors_apart
from ..sheet.samples import Surfaces
from ..sheet.topology import at_corners
from .fields import complete
from .frame import SheetFrame
from .watch.surface_fields import SurfaceFields
from .watch.tool_forces import PointForces, ToolFields, ToolForces
from .watch.tool_gaps import ToolGaps

# Elastic energies of the sheet; the internal energy is their sum plus those of its unit cell.
SHEET_INTERNAL = ("compression", "shear", "in_plane_bending", "bending", "transverse_shear", "hourglass")


# Places of an element, from -1 to 1, at which its surface is judged: the middles of it, its edges and its quarters.
JUDGED_PLACES = np.array([
    (0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5),
])  # fmt: skip


@dataclass(frozen=True)
class Penetration:
    """Deepest overlap of a sheet's faces with any tool [m]; negative without contact.

    Attributes:
        at_nodes: at the nodes.
        at_surface: anywhere on the surface that the directors describe, at nodes and between them.
        at_element_centres: at the middles of flat elements, most of which is the chord over a curved tool.
        sheet, place, time: of the deepest point of the surface: its sheet, place on the flat blank [m], and when [s].
    """

    at_nodes: float
    at_surface: float
    at_element_centres: float
    sheet: str = ""
    place: tuple[float, float] = (0.0, 0.0)
    time: float = 0.0

    def deeper(self, other: Penetration) -> Penetration:
        """The deeper of the two, each for itself."""
        worst = other if other.at_surface > self.at_surface else self
        return replace(
            worst,
            at_nodes=max(self.at_nodes, other.at_nodes),
            at_element_centres=max(self.at_element_centres, other.at_element_centres),
        )


NO_PENETRATION = Penetration(-np.inf, -np.inf, -np.inf)


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
        acting: whether each tool of the run acts, (tool_count,) bool.

    Attributes:
        internal: names of the elastic energies of unit cell and sheet; their sum is the entry ``internal``.
        name: of the sheet.
        tools: that it may touch.
    """

    def __init__(self, model: Model, index: int, state: State, acting: np.ndarray) -> None:
        self._model, self._index, self._state = model.sheets[index], index, state
        sheet = self._model
        self.name = sheet.name
        self.first_tool = sheet.places.tools.start
        self.tools = model.setup.tools[self.first_tool : sheet.places.tools.stop]
        self._kernel = element_ledger_kernel(sheet.real, sheet.cell_law, sheet.sheet_traits)
        self._device_sheet = sheet.device_sheet(1)
        self._energy_names = (*sheet.cell_law.energy_names, *SheetEnergy.names())
        self.internal = (*sheet.cell_law.energy_names, *SHEET_INTERNAL)
        count, device = sheet.element_count, sheet.device
        self._energies = wp.zeros((len(self._energy_names), count), dtype=sheet.real, device=device)
        row_count = ElementField.row_count() + ResultantRow.row_count()
        self._fields = wp.zeros((row_count, count), dtype=sheet.real, device=device)
        # packed once: a launch from Python costs more than the work of a small sheet
        self._element_ledger: wp.Launch | None = None
        elements, nodes = sheet.blank.element_count, sheet.blank.node_count
        points = nodes + len(sheet.samples.places) * elements
        # of nodes and samples; the former change with the sheet where contact follows them
        self._half_thickness = np.full(points, 0.5 * sheet.fabric.thickness)
        self._half_thickness[nodes:] -= sheet.samples.allowance
        self._stiffness = np.concatenate(
            [sheet.contact_stiffness, np.tile(sheet.samples.stiffness, len(sheet.samples.places))]
        )
        self._contact_gaps = ToolGaps(model, index, state, points, acting, keep_normals=True)
        self._tool_forces = ToolForces(model, index, state, self._contact_gaps, acting)
        self._tool_fields = ToolFields(sheet)
        self._surface_fields = SurfaceFields(model, index, state, acting)
        # the distances at nodes and samples are known from the energies of the contact
        samples = [place.tolist() for place in sheet.samples.places]
        self._known = [samples.index(place) if place in samples else None for place in JUDGED_PLACES.tolist()]
        unknown = JUDGED_PLACES[[known is None for known in self._known]]
        self._at_samples, self._at_unknown = Surfaces(sheet.samples.places), Surfaces(unknown)
        self._corners = np.ascontiguousarray(sheet.blank.quads.T)
        # positions and directors there at the frame just taken, each (3, 4, element_count)
        self._at_corners = np.zeros((3, 4, 0)), np.zeros((3, 4, 0))
        self._judged_gaps = ToolGaps(model, index, state, (len(unknown) + 1) * elements, acting)
        # of the middles of the elements at the frame that was looked at last, which its fields want too
        self._looked_at, self._middle_distance = np.zeros((0, 3)), np.zeros((0, 0))
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
        whole = bool(self._model.kept.all())
        if not whole:
            fields, resultants = self._without_waste(fields), self._without_waste(resultants)
        position = motion[MotionRow.position.vector] + motion[MotionRow.remainder.vector]
        return SheetFrame(
            name=self._model.name,
            position=position,
            director=motion[MotionRow.director.vector],
            fields=fields,
            energies=self._entries(position, motion, ahead.sheets[self._index]),
            resultants=resultants,
            kept=np.zeros(0, dtype=bool) if whole else self._model.kept,
        )

    def _without_waste(self, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Not a number where an element is waste: nobody can take it for a value of the sheet."""
        return {name: np.where(self._model.kept, each, np.nan) for name, each in values.items()}

    def largest_energy(self, name: str) -> tuple[float, np.ndarray]:
        """The most that an element has of an energy at the frame just taken [J], and its flat place [m]."""
        row = self._by_element[self._energy_names.index(name)]
        element = int(np.argmax(row))
        return float(row[element]), self.place_of(element)

    def place_of(self, element: int) -> np.ndarray:
        """Middle of an element on the flat blank, (2,) [m]."""
        return self._model.blank.material_coordinates[self._model.blank.quads[element]].mean(axis=0)

    def directors_apart(self, frame: SheetFrame) -> np.ndarray:
        """Angle between the directors at both diagonals of every element, beyond the blank's [rad]; 0 of waste."""
        blank = self._model.blank
        grown = directors_apart(frame.director, blank.quads) - directors_apart(blank.initial_director, blank.quads)
        return np.where(self._model.kept, grown, 0.0)

    def fastest_node(self) -> tuple[float, np.ndarray]:
        """Kinetic energy of the node with most of it at the frame just taken [J], and its flat place [m]."""
        energy = 0.5 * self._model.node_mass * np.square(self._velocity).sum(axis=1)
        node = int(np.argmax(energy))
        return float(energy[node]), self._model.blank.material_coordinates[node]

    def tool_forces(self) -> PointForces:
        """Forces of the tools at its nodes and samples at the frame just taken; waits for the device."""
        return self._tool_forces(self._half_thickness, self._velocity)

    def written_fields(self, frame: SheetFrame) -> dict[str, np.ndarray]:
        """Fields that only the frames of observers have, of the frame just taken; waits for the device."""
        forces, node_distance = self.tool_forces(), self._distance[:, : len(frame.position)]
        found = self._tool_fields(forces, frame.director, frame.fields["area_ratio"])
        middle = self._middle_distance if self._looked_at is frame.position else None
        found |= self._surface_fields(frame.position, frame.fields, node_distance, middle)
        # in the precision of the run, as the fields of the kernels: no more is known, and files are smaller
        return {name: values.astype(self._model.precision.numpy).astype(np.float64) for name, values in found.items()}

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
        self._by_element = self._energies.numpy()[:, : sheet.blank.element_count].astype(np.float64)
        entries = dict(zip(self._energy_names, self._by_element.sum(axis=1).tolist(), strict=True))
        entries["internal"] = sum(entries[name] for name in self.internal)
        velocity, spin = _rates(motion)
        self._velocity = velocity
        next_velocity, next_spin = _rates(self._motion(ahead.motion))
        entries["kinetic"] = (
            self._kinetic(velocity, next_velocity, spin, next_spin) if started else self.initial_kinetic
        )
        entries |= self._contact_entries(position, motion[MotionRow.director.vector], ahead)
        works = dict.fromkeys(NodeWorkRow.names(), 0.0)
        booked = self._own.works()
        if started:
            booked = 0.5 * (booked + ahead.works())
        works.update(zip(sheet.node_work_rows, booked.tolist(), strict=True))
        if started and sheet.samples.count:
            # the next step books them up to the positions that it starts from
            between = zip(NodeWorkRow.names(), ahead.sample_works().tolist(), strict=True)
            works = {name: works[name] + value for name, value in between}
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

    def _contact_entries(self, position: np.ndarray, director: np.ndarray, ahead: SheetState) -> dict[str, float]:
        """Energies of the springs of contact and friction, at nodes and at the samples between them."""
        sheet, node_count, element_count = self._model, len(position), self._model.blank.element_count
        sample_count = len(sheet.samples.places)
        slot = sheet.samples.slot
        self._at_corners = at_corners(position, self._corners), at_corners(director, self._corners)
        points = [position, *self._at_samples(*self._at_corners)]
        if sheet.follows_thickness:
            own, between = (a.numpy()[ThicknessRow.half] for a in (ahead.thickness, ahead.sample_thickness))
            samples = [np.tile(between[slot], sample_count)] if sample_count else []
            self._half_thickness = np.concatenate([own[:node_count], *samples])
            self._half_thickness[node_count:] -= sheet.samples.allowance
        half_thickness, stiffness = self._half_thickness, self._stiffness
        self._distance = self._contact_gaps(np.concatenate(points))
        penetration = np.maximum(half_thickness - self._distance, 0.0)
        friction = sheet.friction_layout.read(ahead.friction)[: 3 * sheet.tool_count, :node_count]
        of_samples = sheet.samples.layout.read(ahead.sample_friction)[: 3 * sheet.tool_count]
        of_samples = of_samples.reshape(len(friction), sample_count, sheet.element_count)
        of_samples = of_samples.take(slot, axis=2).reshape(len(friction), sample_count * element_count)
        friction = np.concatenate([friction, of_samples], axis=1, dtype=np.float64)
        return {
            "contact": 0.5 * float((stiffness * np.square(penetration)).sum()),
            "friction_spring": 0.5 * TANGENTIAL_RATIO * float((stiffness * np.square(friction)).sum()),
        }

    def friction_arguments(self, tool: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Where the law of one of its tools was used at nodes, and at samples: flat places, smallest, largest so far.

        (k, 2) [m], (k,) and (k,), in the unit of the kernels; nothing without friction laws.
        """
        sheet, flat = self._model, self._model.blank.material_coordinates
        if not sheet.node_traits.friction_laws:
            return
        low, high = self._own.friction_argument.numpy()[2 * tool : 2 * tool + 2, : len(flat)]
        there = ~sheet.waste
        yield flat[there], low[there], high[there]
        if count := len(sheet.samples.places):
            rows = self._own.sample_friction_argument.numpy()[2 * tool : 2 * tool + 2]
            rows = rows.reshape(2, count, sheet.element_count)[..., sheet.samples.slot[sheet.kept]]
            yield flat[sheet.blank.quads[sheet.kept]].mean(axis=1), rows[0].min(axis=0), rows[1].max(axis=0)

    # --- distances to the tools --------------------------------------------------------------------------------------

    def penetration(self, frame: SheetFrame) -> Penetration:
        """Deepest penetration of a frame just taken."""
        sheet, quads, position = self._model, self._model.blank.quads, frame.position
        if not sheet.tool_count:
            return NO_PENETRATION
        node_count, element_count = len(position), len(quads)
        at_elements = half_thickness(sheet.fabric.thickness, frame.fields["thickness"], sheet.follows_thickness)
        at_nodes = np.full(node_count, 0.5 * sheet.fabric.thickness)
        if sheet.follows_thickness:
            there = quads[sheet.kept].ravel()
            own = np.bincount(there, np.repeat(at_elements[sheet.kept], 4), node_count)
            at_nodes = own / np.maximum(np.bincount(there, minlength=node_count), 1)
        at_nodes[sheet.waste], at_elements[~sheet.kept] = -np.inf, -np.inf
        places = self._judged_distances()
        self._looked_at, self._middle_distance = position, places[-1]
        depths = [(at_elements - distance).max(axis=0) for distance in places]
        depth = np.concatenate([(at_nodes - self._distance[:, :node_count]).max(axis=0), *depths])
        worst = int(depth[:-element_count].argmax())
        flat, element = sheet.blank.material_coordinates, (worst - node_count) % element_count
        x, y = flat[worst] if worst < node_count else self.place_of(element)
        return Penetration(
            at_nodes=float(depth[:node_count].max()),
            at_surface=float(depth[worst]),
            at_element_centres=float(depths[-1].max()),
            sheet=sheet.name,
            place=(float(x), float(y)),
        )

    def _judged_distances(self) -> list[np.ndarray]:
        """Of every element's ``JUDGED_PLACES`` and of its middle from the tools, (tool_count, element_count) each [m].

        Those at samples are known from the frame just taken.
        """
        a, b, c, d = self._at_corners[0].swapaxes(0, 1)
        points = [*self._at_unknown(*self._at_corners), ((a + b + c + d) / 4.0).T]
        shape = self._model.tool_count, -1, self._model.blank.element_count
        found, known = self._judged_gaps(np.concatenate(points)), self._distance[:, self._model.blank.node_count :]
        others, of_samples = iter(found.reshape(shape).swapaxes(0, 1)), known.reshape(shape)
        return [next(others) if place is None else of_samples[:, place] for place in self._known] + [next(others)]


def _rates(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and spins."""
    return motion[MotionRow.velocity.vector], motion[MotionRow.spin.vector]
