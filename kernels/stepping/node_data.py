"""Data of the node kernel: traits of a run, constants, and the current values of one block of nodes."""

from dataclasses import dataclass
from functools import cache

import warp as wp

from ..contact.tool_distance import tool_set_struct
from ..lane_types import lane_types


@dataclass(frozen=True)
class NodeTraits:
    """What acts on the nodes of a run: their kernel is generated for it, as those of the sheet for ``SheetTraits``.

    Attributes:
        follows_thickness: contact with tools uses the current thickness.
        loaded: forces or couples are prescribed.
        supported: nodes are held by supports.
        shape_kinds: of the parts of all tools, see kernels/contact/tool_shapes.py; empty without tools.
        rotated: whether any part is rotated.
        touched: whether other plies may touch it.
        sampled: whether tools are met between nodes too.
        friction_laws: whether the friction of a tool is more than one coefficient.
        carried: whether a tool follows a path or turns.
    """

    follows_thickness: bool = False
    loaded: bool = False
    supported: bool = False
    shape_kinds: tuple[str, ...] = ()
    rotated: bool = False
    touched: bool = False
    sampled: bool = False
    friction_laws: bool = False
    carried: bool = False


@cache
def node_struct(real: type, lane_count: int):
    """Constant node data; arrays are [block of lanes] or [row, block]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Nodes:
        corner_offset: wp.array2d(dtype=types.indices)  # [slot, block]: first entry of an adjacent corner's rows
        corner_stride: wp.int32  # entries between two components
        looks_ahead: wp.int32  # 1: the rows of the next block are fetched while one is computed
        mass: wp.array(dtype=types.lanes)  # [kg]; 0 for padding
        inverse_mass: wp.array(dtype=types.lanes)
        inverse_inertia: wp.array(dtype=types.lanes)  # scaled rotary inertia [1/(kg m^2)]
        angle_weight: wp.array(dtype=types.lanes)  # weight of each adjacent element in the node's mean shear angle
        thickness_weight: wp.array(dtype=types.lanes)  # weight of each in its mean thickness, if contact uses that
        load: wp.array2d(dtype=types.vec3)  # rows: see LoadRow
        load_time: wp.array(dtype=wp.float64)  # knots of the loads' share [s]
        load_share: wp.array(dtype=wp.float64)
        freedom: wp.array(dtype=types.indices)  # bits 0-2: x, y, z may move; bits 3-5: director may turn about x, y, z

    return Nodes


@cache
def support_struct(real: type, lane_count: int):
    """Nodes that are held and possibly driven; constant except ``increment`` and ``holding``."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Supports:
        held: wp.array(dtype=types.indices)  # bits 0-2: x, y, z of the node follow the drives
        direction: wp.array2d(dtype=types.vec3)  # [drive, node]: displacement of the node over that of the drive
        increment: wp.array(dtype=real)  # of each drive in this step [m]
        holding: wp.array(dtype=types.vec3)  # written: force of a support on its node [N]

    return Supports


@cache
def surroundings_struct(real: type, lane_count: int):
    """What acts on the nodes from outside the sheet, and when."""

    @wp.struct
    class Surroundings:
        clock: wp.array(dtype=wp.float64)  # see ClockEntry
        tools: tool_set_struct(real)
        supports: support_struct(real, lane_count)
        ply_force: wp.array2d(dtype=lane_types(real, lane_count).lanes)  # of other plies on the nodes [N]

    return Surroundings


@cache
def node_laws_struct(real: type):
    """Constants of the time integration and contact."""

    @wp.struct
    class NodeLaws:
        gravity: wp.types.vector(3, real)  # [m/s^2]
        damping: real  # mass-proportional [1/s]
        director_damping: real  # [1/s]
        half_thickness: real  # [m]
        contact_stiffness: real  # of a node over its mass [1/s^2]
        contact_damping_time: real  # normal dashpot = contact stiffness times this [s]
        tangential_ratio: real  # friction spring over normal spring
        in_plane_bending_stiffness: real  # of the sheet [N m]
        spare_distance: real  # margin of the distance before contact, for the rounding of positions and distances [m]
        tool_count: wp.int32

    return NodeLaws


@cache
def present_struct(real: type, lane_count: int):
    """One block of nodes at the beginning of a step.

    All of it is read before anything is written: a GPU waits for every read that follows a write, since for all that
    the compiler knows the arrays may overlap.
    """
    types = lane_types(real, lane_count)

    @wp.struct
    class Present:
        block: wp.int32
        step: real  # the next step [s]
        mean_step: real  # mean of the next step and the last one, over which forces act [s]
        position: types.lanes3  # [m]
        remainder: types.lanes3  # of the position [m]
        mean_angle: types.lanes  # of the elements around the node [rad]
        velocity: types.lanes3  # half a step ago [m/s]
        velocity_remainder: types.lanes3  # [m/s]
        director: types.lanes3
        spin: types.lanes3  # half a step ago [1/s]
        mean_angle: types.lanes  # mean shear angle of the elements around, which they used in this step [rad]
        mass: types.lanes  # [kg]
        inverse_mass: types.lanes
        inverse_inertia: types.lanes  # [1/(kg m^2)]
        freedom: types.indices  # bits as in Nodes
        friction_work: types.lanes  # works so far: see NodeWorkRow
        damping_loss: types.lanes
        support_work: types.lanes
        half_thickness: types.lanes  # of the sheet, for contact with tools [m]
        growth: types.lanes  # of the half thickness in this step [m]
        thickened: real  # largest growth of the half thickness in the last step, not below zero [m]

    return Present
