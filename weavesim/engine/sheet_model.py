"""Constants of one sheet: mesh, laws, masses, constraints, in the layout of the kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from ..device import Precision
from ..errors import InputError
from ..fabric.device import sheet_laws
from ..kernels.lane_types import LaneTypes, lane_types
from ..kernels.rows import (
    CORNER_ROW_COUNT,
    MOTION_RECORD_LENGTH,
    MOTION_VECTORS,
    ROWS_PER_CORNER,
    VELOCITY_REMAINDER,
    CornerRow,
    LoadRow,
    MotionRow,
    NodeWorkRow,
)
from ..kernels.shell.frequency import step_bounds_struct
from ..kernels.shell.kinematics import element_struct
from ..kernels.shell.laws import sheet_struct
from ..kernels.stepping.node_data import node_laws_struct, node_struct
from ..process.device import build_support_arrays
from ..process.grippers import Gripper
from ..sheet.geometry import ElementGeometry
from ..sheet.sheet import Sheet
from ..sheet.symmetry import nodes_of_odd_angle
from .frequencies import Frequencies, hourglass_coefficients
from .layout import RowLayout, Span, lanes_view, padded, rows_together
from .mesh.corners import corner_table
from .mesh.elements import element_tables, inverse, rows_padded
from .setup import STEP_SAFETY, World
from .staging.trimming import waste_nodes
from .surface.samples import Samples
from .traits import node_traits, sheet_traits

# Contact stiffness is this share of mass / step^2: two tools on one node then reduce the stable step by a few per cent.
CONTACT_SHARE = 0.05
TANGENTIAL_RATIO = 0.5
# The distance to a tool is evaluated again once less than this share of half the thickness is left.
SPARE_DISTANCE = 0.5
# Steps between two updates of the stable step.
REFRESH_INTERVAL = 20
# Padding elements use this many nodes of their own.
SPARE_NODE_COUNT = 4
# Elements from which constants lie together block by block (docs/decisions/0066), and a block asks for the next (0076).
LARGE_SHEET = 4096
# Rows of the motion array that make each of MOTION_VECTORS, (vectors, 3).
_VECTOR_ROWS = np.array(list(MOTION_VECTORS.values()))


@dataclass(frozen=True)
class Numerics:
    """How a run is computed; see ``Solver``.

    Attributes:
        device: Warp's.
        precision: of state and kernels.
        lane_count: elements or nodes per kernel thread.
        target_step: with mass scaling, the stable step aimed at [s]; None adds no mass.
    """

    device: wp.Device
    precision: Precision
    lane_count: int
    target_step: float | None = None

    @property
    def real(self) -> type:
        """Warp's scalar type."""
        return self.precision.real

    @property
    def types(self) -> LaneTypes:
        """Warp's vectors and matrices of it."""
        return lane_types(self.real, self.lane_count)


@dataclass(frozen=True)
class Places:
    """Ranges of one sheet in the arrays of a run.

    Attributes:
        tools: of its world, among all tools.
        drives: of its supports, among all drives.
        first_reaction, last_reaction: its blocks of nodes, then of elements, among those of its world.
    """

    tools: Span
    drives: Span
    first_reaction: int
    last_reaction: int


class SheetModel:
    """Constants of one sheet.

    Args:
        numerics: how the run is computed.
        sheet, world: the sheet, and what it shares with others.
        places: ranges of its tools, drives and nodes in the arrays of the run.
        kept: elements that are there, (element_count,) bool; None for all. Others are as padding, and their nodes stand
            still without mass.
        contact_step: on which contact stiffness is based [s]; None for ``reference_step``.

    Attributes:
        kept: as given, or all.
        waste: nodes of no element that is there, (node_count,) bool.
        blank: with the yarn directions of the sheet's orientation.
        free: (node_count, 6) bool, False where a displacement (x, y, z) or a rotation of the director about x, y, z is
            held; a held component keeps its initial velocity.
        reference_step: stable step with straight yarns [s]; contact stiffness and the first step are based on it.
        element_nodes: (4, padded elements) corner nodes.
        corners, motion_layout, friction_layout: layouts of the values that elements write at their corners
            (CORNER_ROW_COUNT), of the nodes' motion, and of their friction springs (three components per tool).
        samples: constants of the contact between nodes.
        added_mass_ratio: mass added by scaling over the mass of the blank.
    """

    def __init__(
        self,
        numerics: Numerics,
        sheet: Sheet,
        world: World,
        places: Places,
        kept: np.ndarray | None = None,
        contact_step: float | None = None,
    ) -> None:
        blank, fabric = world.symmetry.upright(sheet.oriented_blank), sheet.fabric
        self.kept = np.ones(blank.element_count, dtype=bool) if kept is None else kept
        self.waste = waste_nodes(blank, self.kept)
        self.name, self.blank, self.fabric, self.stabilisation = sheet.name, blank, fabric, sheet.stabilisation
        self.supports, self.loads, self.dynamics = sheet.supports, sheet.loads, world.dynamics
        self.symmetry, self.pressures, self.grippers = world.symmetry, sheet.pressures, sheet.grippers
        self.device, self.precision, self.lane_count = numerics.device, numerics.precision, numerics.lane_count
        self.real, self.types = numerics.real, numerics.types
        self.places, self.tool_count = places, places.tools.count
        self.free = sheet.freedom(world.symmetry) & ~self.waste[:, None]
        self.start_velocity = sheet.start_velocity
        self.element_count = padded(blank.element_count, 1)
        self.node_count = padded(blank.node_count, SPARE_NODE_COUNT)
        self.block_count = self.node_count // self.lane_count
        self.corners = RowLayout(CORNER_ROW_COUNT, self.element_count, self.lane_count, CORNER_ROW_COUNT)
        self.motion_layout = RowLayout(MotionRow.row_count(), self.node_count, self.lane_count, MOTION_RECORD_LENGTH)
        self.friction_layout = RowLayout(3 * max(self.tool_count, 1), self.node_count, self.lane_count)
        self.geometry = ElementGeometry.of(blank)
        self.sheet_traits = sheet_traits(fabric, self.geometry, world.dynamics)
        self.node_traits = node_traits(sheet, world)

        self.areal_density, frequencies = self._scaled_mass(numerics.target_step)
        self.reference_step = STEP_SAFETY * 2.0 / math.sqrt((frequencies.straight + frequencies.constant).max())
        corner_mass = np.where(self.kept, 0.25 * self.areal_density * self.geometry.area, 0.0)
        self.node_mass = self._to_nodes(corner_mass)
        self.node_inertia = self._to_nodes(corner_mass * frequencies.rotary_radius_squared)
        # squared, of one tool's spring [1/s^2]
        self._contact_frequency = CONTACT_SHARE / (contact_step or self.reference_step) ** 2
        self.contact_stiffness = self._contact_frequency * self.node_mass
        self.samples = Samples.of(
            world.tools if self.node_traits.sampled else (), fabric.thickness, world.dynamics.contact_allowance,
            self.geometry, blank.node_position[blank.quads], 4.0 * corner_mass, self._contact_frequency, self.corners,
        )  # fmt: skip

        # padding elements keep an infinite areal density: they never limit the step
        inertia = np.stack([self.kept / self.areal_density, 1.0 / frequencies.rotary_radius_squared])
        self.step_inertia = self._array(rows_padded(inertia, self.element_count), self.real)
        self.step_bounds = self._step_bounds()
        self._element_arrays = self._fill_elements()
        self.elements = self._elements(self.lane_count)
        self.elements_single = self._elements(1)
        self.cell_law = fabric.unit_cell.law()
        self.cell = fabric.unit_cell.device_parameters(self.precision)
        self.laws = self._sheet_laws()
        self.nodes = self._nodes(self.free)
        self.held, self.drive_direction = build_support_arrays(
            sheet.supports, self.node_count, self.real, self.lane_count, self.device, np.flatnonzero(self.waste)
        )

    def _scaled_mass(self, target_step: float | None) -> tuple[np.ndarray, Frequencies]:
        """Areal density of every element [kg/m^2], raised where a stable ``target_step`` needs it, and frequencies."""
        density = np.full(self.blank.element_count, self.fabric.areal_density)
        frequencies = Frequencies.of(self.fabric, self.stabilisation, self.geometry, density)
        if target_step is not None:
            squared = (frequencies.straight + frequencies.constant) * (0.5 * target_step / STEP_SAFETY) ** 2
            density = density * np.maximum(1.0, squared)
            frequencies = Frequencies.of(self.fabric, self.stabilisation, self.geometry, density)
        return density, frequencies

    @property
    def added_mass_ratio(self) -> float:
        """Mass added by scaling over the mass of the blank."""
        area, density = self.geometry.area, self.areal_density
        return float((density * area).sum() / (self.fabric.areal_density * area).sum() - 1.0)

    def _step_bounds(self):
        bounds, cell = step_bounds_struct(self.real)(), self.fabric.unit_cell
        springs = 2.0 * self._contact_frequency if self.tool_count else 0.0  # of two tools
        bounds.sample_frequency, bounds.sample_turning = 2.0 * self.samples.frequency, 2.0 * self.samples.turning
        bounds.contact_frequency = springs + bounds.sample_frequency + self._grip_frequency
        bounds.bending = self.fabric.largest_bending_stiffness
        bounds.warp, bounds.weft = cell.yarn_stiffness_per_width
        bounds.shear = cell.shear_stiffness
        bounds.steps_ahead = REFRESH_INTERVAL
        return bounds

    @property
    def _grip_frequency(self) -> float:
        """Largest squared frequency of the springs of grippers [1/s^2]."""
        found = (inverse(self.node_mass[each.nodes], each.stiffness * self.shares(each)) for each in self.grippers)
        return max((float(squared.max()) for squared in found), default=0.0)

    def shares(self, gripper: Gripper) -> np.ndarray:
        """Share of each node of a gripper in its stiffness and forces, as of the area around it, (k,)."""
        area = self._to_nodes(0.25 * self.geometry.area)[gripper.nodes]
        return area / area.sum()

    def bound_plies(self, below: float, above: float) -> None:
        """Make room in the stable step for contact with other plies.

        Args:
            below, above: squared frequency that an interface on either face adds at most [1/s^2]; 0 without one.
        """
        of_tools = self._contact_frequency if self.tool_count else 0.0
        of_springs = max(below, of_tools) + max(above, of_tools) + self._grip_frequency
        self.step_bounds.contact_frequency = of_springs + self.step_bounds.sample_frequency

    @property
    def follows_thickness(self) -> bool:
        """Whether contact with tools uses the current thickness."""
        return self.dynamics.contact_thickness == "current"

    @property
    def node_work_rows(self) -> tuple[str, ...]:
        """Names of the rows of ``NodeWorkRow`` that this run has."""
        first = NodeWorkRow.thickness_work if self.loads is not None else NodeWorkRow.load_work
        return NodeWorkRow.names()[: None if self.follows_thickness else first]

    # --- layout ------------------------------------------------------------------------------------------------------

    def _to_nodes(self, per_corner: np.ndarray) -> np.ndarray:
        total = np.zeros(self.blank.node_count)
        for corner in range(4):
            np.add.at(total, self.blank.quads[:, corner], per_corner)
        return total

    def _array(self, values: np.ndarray, dtype: type, shape: tuple[int, ...] | None = None) -> wp.array:
        return wp.array(values, dtype=dtype, device=self.device, shape=shape)

    def _fill_elements(self) -> dict[str, wp.array]:
        """Arrays of the element struct, [row, element], by its field names."""
        tables = element_tables(
            self.blank.quads, self.geometry, self.areal_density, self.kept, self.blank.node_count, self.element_count
        )
        # those of the whole mesh: the same tiles whatever has been trimmed
        self.element_nodes = tables.nodes
        arrays = {name: self._array(value, self.real) for name, value in tables.values.items()}
        return {"corner_node": self._array(self.motion_layout.entry(0, tables.corners), wp.int32), **arrays}

    def _elements(self, lane_count: int):
        elements = element_struct(self.real, lane_count)()
        elements.looks_ahead = int(lane_count > 1 and self.element_count >= LARGE_SHEET)
        views = {name: lanes_view(array, lane_count) for name, array in self._element_arrays.items()}
        if elements.looks_ahead:
            whole = {n: a for n, a in self._element_arrays.items() if a.shape[-1] == self.element_count}
            views |= rows_together(whole, lane_count)
        for name, view in views.items():
            setattr(elements, name, view)
        elements.node_stride = self.motion_layout.stride
        return elements

    def device_sheet(self, lane_count: int):
        """Elements, unit cell and laws in one struct, for kernels with ``lane_count`` lanes."""
        sheet = sheet_struct(self.real, lane_count, self.cell_law, self.sheet_traits)()
        sheet.elements = self.elements_single if lane_count == 1 else self.elements
        sheet.cell, sheet.laws = self.cell, self.laws
        return sheet

    def _sheet_laws(self):
        laws = sheet_laws(self.fabric, self.precision, self.device)
        coefficients = hourglass_coefficients(self.fabric, self.stabilisation)
        laws.hourglass_in_plane, laws.hourglass_warping, laws.hourglass_director = coefficients
        return laws

    def _nodes(self, free: np.ndarray):
        count = self.blank.node_count
        if free.shape != (count, 6):
            raise InputError(f"free: shape {free.shape}, but ({count}, 6) is needed")
        if np.any((self.node_mass == 0.0) & ~self.waste):
            raise InputError(f"blank mesh: node {int(np.argmin(self.node_mass))} belongs to no element; remove it")
        nodes = node_struct(self.real, self.lane_count)()
        elements, spare = np.arange(self.blank.element_count), self.blank.element_count
        table = corner_table(self.blank.quads, self.node_count, self.corners, elements, spare)
        nodes.corner_offset = self.node_indices(table)
        nodes.corner_stride = self.corners.stride
        nodes.looks_ahead = self.elements.looks_ahead
        # elements that are not there write zeros
        sharing = inverse(np.bincount(self.blank.quads[self.kept].ravel(), minlength=count).astype(np.float64))
        angle_weight = np.where(nodes_of_odd_angle(self.blank, free), 0.0, sharing)
        bits = (free @ (1 << np.arange(6))).astype(np.int32)
        freedom = np.zeros(self.node_count, dtype=np.int32)
        freedom[:count] = bits
        nodes.freedom = self._array(freedom.reshape(-1, self.lane_count), self.types.indices)
        loads = np.zeros((LoadRow.row_count(), self.node_count if self.loads else 0, 3))
        if self.loads:
            loads[:, :count] = self.loads.arrays(count) * ~self.waste[:, None]
        nodes.load = self._array(loads, self.types.vec3)
        nodes.load_time = self._array(np.array(self.loads.times if self.loads else ()), wp.float64)
        nodes.load_share = self._array(np.array(self.loads.shares if self.loads else ()), wp.float64)

        def lanes(values):
            return lanes_view(self._array(rows_padded(values, self.node_count), self.real), self.lane_count)

        nodes.angle_weight = lanes(angle_weight)
        if self.follows_thickness:
            nodes.thickness_weight = lanes(sharing)
        nodes.mass = lanes(self.node_mass)
        nodes.inverse_mass = lanes(inverse(self.node_mass))
        nodes.inverse_inertia = lanes(inverse(self.node_inertia))
        return nodes

    def node_indices(self, table: np.ndarray) -> wp.array:
        """Indices around every node, (slots, padded nodes), as [slot, block] of lanes."""
        return self._array(table.reshape(len(table), -1, self.lane_count), self.types.indices)

    def node_laws(self):
        """Constants of the time integration and contact, as a new struct."""
        laws = node_laws_struct(self.real)()
        laws.gravity = self.types.vec3(*self.dynamics.gravity)
        laws.damping = self.dynamics.damping
        laws.director_damping = self.dynamics.director_damping
        laws.half_thickness = 0.5 * self.fabric.thickness
        laws.contact_stiffness = self._contact_frequency
        # c = 2 zeta sqrt(k m) with k = frequency m
        laws.contact_damping_time = 2.0 * self.dynamics.contact_damping_ratio / math.sqrt(self._contact_frequency)
        laws.tangential_ratio = TANGENTIAL_RATIO
        laws.in_plane_bending_stiffness = self.fabric.in_plane_bending_stiffness
        laws.spare_distance = SPARE_DISTANCE * 0.5 * self.fabric.thickness
        laws.tool_count = self.tool_count
        return laws

    # --- initial values ----------------------------------------------------------------------------------------------

    def initial_unknowns(self) -> np.ndarray:
        """Unknowns of every element's unit cell at rest, (rows, padded elements)."""
        rows = np.zeros((self.cell_law.kept_row_count, self.element_count))
        rows[: self.cell_law.unknown_count] = np.array(self.fabric.unit_cell.initial_unknowns)[:, None]
        return rows

    def read_motion(self, motion: wp.array) -> np.ndarray:
        """MOTION_VECTORS of a motion array, (vectors, padded nodes, 3); waits for the device."""
        rows = self.motion_layout.read(motion)[_VECTOR_ROWS]
        return rows.transpose(0, 2, 1)

    def write_motion(self, motion: wp.array, rows: np.ndarray, mean_angle: np.ndarray | None = None) -> None:
        """Set MOTION_VECTORS of a motion array, and the mean shear angles of the nodes [rad] if given."""
        values = self.motion_layout.read(motion)
        values[_VECTOR_ROWS] = rows.transpose(0, 2, 1)
        if mean_angle is not None:
            values[MotionRow.mean_angle, : len(mean_angle)] = mean_angle
        motion.assign(self.motion_layout.flat(values))

    def corner_rows(self, corner_force: wp.array) -> np.ndarray:
        """What the elements wrote at their corners, (corner, row of CornerRow, element); waits for the device.

        For the arrays of ``Stepper.look_ahead`` and after ``Stepper.evaluate``: the steps of large sheets keep theirs
        elsewhere, see ``CornerRing``.
        """
        return self.corners.read(corner_force)[:, : self.blank.element_count].reshape(4, ROWS_PER_CORNER, -1)

    def nodal_forces(self, corner_force: wp.array) -> np.ndarray:
        """Forces of the elements on the nodes, (node_count, 3) [N]; see ``corner_rows``."""
        corners = self.corner_rows(corner_force)[:, CornerRow.force.span].astype(np.float64)
        result = np.zeros((self.blank.node_count, 3))
        for corner in range(4):
            np.add.at(result, self.blank.quads[:, corner], corners[corner].T)
        return result

    def initial_motion(self) -> np.ndarray:
        """MOTION_VECTORS at the start, (vectors, padded nodes, 3)."""
        count = self.blank.node_count
        rows = np.zeros((len(MOTION_VECTORS), self.node_count, 3))
        position, velocities, director = (rows[MotionRow[name].vector] for name in ("position", "velocity", "director"))
        remainder, velocity_remainder = rows[MotionRow.remainder.vector], rows[VELOCITY_REMAINDER]
        position[:count] = self.blank.node_position
        # the padding square may be anywhere: its nodes have no contact stiffness
        position[count : count + 4, :2] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        director[:, 2] = 1.0
        director[:count] = self.blank.initial_director
        if self.start_velocity is not None:
            velocities[:count] = self.start_velocity
        # the rounding errors
        remainder[:] = position - position.astype(self.precision.numpy)
        velocity_remainder[:] = velocities - velocities.astype(self.precision.numpy)
        return rows
