"""Contents of every shared array, row by row: names, numbers, units and descriptions for kernels and host.

Each array has one class, whose members are its rows in order. A member is an integer, the number of its first row, so
that kernels and host index with it: ``fields[ElementField.area_ratio, e]``. Its ``name`` is used on the host. To add a
row, add a member; to change the order, move one: nothing else counts rows. This module does not import Warp.
"""

from enum import IntEnum
from functools import cache
from typing import Self


class Rows(IntEnum):
    """Rows of one array, each declared as unit, description and, for a vector, number of rows.

    Attributes:
        unit: in SI; "1" for a pure number.
        description: contents of the row.
        width: number of rows, starting from its own number.
        vector: index of a vector among those of its array, for arrays (vector, item, component).
    """

    unit: str
    description: str
    width: int
    vector: int

    def __new__(cls, unit: str, description: str, width: int = 1) -> Self:
        first = sum(member.width for member in cls)
        member = int.__new__(cls, first)
        member._value_ = first
        member.unit, member.description, member.width = unit, description, width
        member.vector = sum(other.width == 3 for other in cls)
        return member

    @classmethod
    @cache
    def names(cls) -> tuple[str, ...]:
        """Names of all members, in order."""
        return tuple(member.name for member in cls)

    @classmethod
    def row_count(cls) -> int:
        """Total number of rows."""
        return sum(member.width for member in cls)

    @property
    def span(self) -> slice:
        """All rows of the member."""
        return slice(int(self), self + self.width)


class MotionRow(Rows):
    """Motion of the nodes. Records of ``MOTION_RECORD_LENGTH``, which elements read, come first; see records.py."""

    position = "m", "position, rounded to the precision of the run", 3
    mean_angle = "rad", "mean shear angle of the elements around the node"
    remainder = "m", "what rounding cut off the position", 3
    velocity_remainder_x = "m/s", "what rounding cut off the velocity, along x"
    director = "1", "unit director", 3
    velocity_remainder_y = "m/s", "along y"
    velocity = "m/s", "velocity, half a step before the position", 3
    velocity_remainder_z = "m/s", "along z"
    spin = "1/s", "rate at which the director turns, half a step before it", 3


MOTION_RECORD_LENGTH = int(MotionRow.spin)
# Rows of each vector of the motion array; the remainder of the velocity has the places behind three others.
MOTION_VECTORS = {row.name: (row, row + 1, row + 2) for row in MotionRow if row.width == 3} | {
    "velocity_remainder": (
        MotionRow.velocity_remainder_x,
        MotionRow.velocity_remainder_y,
        MotionRow.velocity_remainder_z,
    )
}
# Its index among them, as ``MotionRow.velocity.vector``.
VELOCITY_REMAINDER = list(MOTION_VECTORS).index("velocity_remainder")


class CornerRow(Rows):
    """Values that an element writes at each of its four corners: four times these rows, all in its record."""

    force = "N", "force on the node", 3
    thickness = "m", "current thickness of the element, where tools meet that"
    couple = "N m", "minus the derivative of the energy by the director", 3
    angle = "rad", "shear angle of the element"


ROWS_PER_CORNER = CornerRow.row_count()
CORNER_ROW_COUNT = 4 * ROWS_PER_CORNER


class CellReportRow(Rows):
    """Report of the unit cell of each element: what every step reads and writes, then what some do."""

    iterations = "1", "iterations of this step"
    worst_residual = "1", "worst relative residual so far"
    surplus = "J/m^2", "energy that the time integration has made, and not yet taken back; negative where it lost some"
    energy = "J/m^2", "energy of the membrane at the last step"
    warp_strain = "1", "warp stretch - 1 at the last step"
    weft_strain = "1", "weft stretch - 1 at the last step"
    warp_impulse = "N s/m", "force along the warp at the last step, with its correction, times the mean step"
    weft_impulse = "N s/m", "the same along the weft"
    shear_angle = "rad", "shear angle at the last step, if the cell depends on it"
    moment_impulse = "N s/m", "shear moment of the cell at the last step times the mean step"
    snap_loss = "J/m^2", "energy lost in snaps so far"


class SlipRow(Rows):
    """History of friction inside the sheet: sliders, the springs in series with them, and the work lost."""

    shear_slip = "rad", "slip between the yarns that turn on each other"
    warp_bending_slip = "1/m", "slip inside the bent warp"
    weft_bending_slip = "1/m", "slip inside the bent weft"
    shear_spring = "rad", "spring before the slider of shear"
    warp_bending_spring = "1/m", "spring before the slider of the warp"
    weft_bending_spring = "1/m", "spring before the slider of the weft"
    shear_friction_loss = "J/m^2", "work lost between the yarns so far"
    bending_friction_loss = "J/m^2", "work lost inside the bent yarns so far"
    shear_friction_remainder = "J/m^2", "what rounding cut off the work lost between the yarns"
    bending_friction_remainder = "J/m^2", "what rounding cut off the work lost inside the bent yarns"


class NodeWorkRow(Rows):
    """Works at the nodes. A run has the first three, four with loads, all with current-thickness contact.

    Those of the steps since the last update of the stable step, of each node; and those before, of each block of nodes,
    in double precision: in single precision a sum of 1e5 small increments is wrong by up to a per cent.
    """

    friction_work = "J", "work done against friction, lost or held in the friction springs"
    damping_loss = "J", "energy lost in damping"
    support_work = "J", "work of what holds the nodes"
    load_work = "J", "work of the loads on the nodes"
    thickness_work = "J", "work of the change of thickness on the tools"


class ThicknessRow(Rows):
    """Thickness of the sheet at the nodes, where tools meet that."""

    half = "m", "half the current thickness of the sheet"
    growth = "m", "last change of half the thickness"


class SampleRow(Rows):
    """What a sample of an element keeps of the last step, to book works at the instants of the positions."""

    friction = "N s", "friction of all tools times the mean step", 3
    dashpots = "N s", "their dashpots times the mean step", 3
    friction_power = "J", "work of the moving tools against friction"
    dashpot_power = "J", "the same of the dashpots"


class MovedRow(Rows):
    """How far the nodes of a block moved in the last step, for the samples of the elements between them."""

    travel = "m", "furthest travel of a node"
    turn = "rad", "largest turn of a director"


class SheetEnergy(Rows):
    """Energies of each element; in their array these rows come after those of the unit cell."""

    compression = "J", "of the sheet's own stiffness along yarns that are pushed together"
    shear = "J", "of in-plane shear, with the spring of its friction"
    in_plane_bending = "J", "of a varying shear angle"
    bending = "J", "of bending, with the springs of its friction"
    transverse_shear = "J", "of transverse shear"
    hourglass = "J", "of the stabilisation"
    snap_loss = "J", "lost in snaps of the unit cell so far"
    surplus = "J", "made by the time integration at kinks of the membrane, not yet taken back; negative: lost"
    shear_friction_loss = "J", "lost between the yarns so far"
    bending_friction_loss = "J", "lost inside the bent yarns so far"


class ElementField(Rows):
    """Fields of each element, for output."""

    shear_angle = "rad", "shear angle between warp and weft"
    warp_stretch = "1", "current over initial length along the warp"
    weft_stretch = "1", "current over initial length along the weft"
    warp_force = "N/m", "force along the warp per width"
    weft_force = "N/m", "force along the weft per width"
    crossover_pressure = "N/m^2", "pressure between warp and weft per reference area"
    area_ratio = "1", "current over reference area"
    shear_moment = "N/m", "moment of shear, elastic and friction, without in-plane bending"


class ResultantRow(Rows):
    """Resultants of each element per reference area, for output; contravariant, along the convected yarn vectors."""

    shear11 = "N/m", "T of in-plane shear: the law, its friction, and a unit cell that depends on the angle"
    shear12 = "N/m", "the same"
    shear22 = "N/m", "the same"
    in_plane_moment = "N/m", "moment of the bending of the yarns in the plane"
    bending11 = "N/m", "T of bending: what a change of the metric does to the bending energy"
    bending12 = "N/m", "the same"
    bending22 = "N/m", "the same"
    moment11 = "N", "M of bending, with the friction inside the bent yarns"
    moment12 = "N", "the same"
    moment22 = "N", "the same"
    transverse1 = "N/m", "Q of transverse shear"
    transverse2 = "N/m", "the same"


class ExtremeRow(Rows):
    """Extremes of each element over all blocks of steps so far."""

    min_warp = "1", "smallest strain of the warp"
    max_warp = "1", "largest strain of the warp"
    min_weft = "1", "smallest strain of the weft"
    max_weft = "1", "largest strain of the weft"
    angle = "rad", "largest absolute shear angle"
    warp_curvature = "1/m", "largest absolute curvature of the warp, out of the sheet"
    weft_curvature = "1/m", "largest absolute curvature of the weft, out of the sheet"


class ClockEntry(Rows):
    """The clock, always in double precision."""

    time = "s", "time of the positions"
    step = "s", "step to come"
    mean_step = "s", "mean of the step to come and the last one, over which velocities change"


class ToolWorkRow(Rows):
    """Values booked for each tool."""

    on_sheet = "J", "work of the tool on the sheet so far"
    driving = "J", "work of the driving force so far"
    damping = "J", "energy lost in the damper of a tool that a force moves"
    carrying = "J", "work of the path and the rotation of a tool on the sheet so far"


class ToolPoseRow(Rows):
    """Pose of a tool that is carried along a path and turned: a point X of it, as drawn, is at rotation X + shift."""

    rotation = "1", "turn, row by row", 9
    shift = "m", "of the origin", 3
    pivot = "m", "where the point is about which it turns", 3
    velocity = "m/s", "along its path, without that along its axis, half a step before", 3
    spin = "rad/s", "rate at which it turns, half a step before", 3
    offset = "m", "way along its path", 3
    angle = "rad", "of its rotation"


class ToolDriveRow(Rows):
    """What the drive of each tool keeps from step to step."""

    carrying = "s", "time for which sheets have carried a tool that a force moves, since it landed"
    stroke_time = "s", "time on the curve of a stroke, which waits at its largest force"


class GripRow(Rows):
    """What the spring of a gripped node keeps from step to step, always in double precision."""

    slip = "m", "slip through the gripper so far"
    force = "N", "force of the spring"
    pull = "N", "the same as a vector, on the node", 3
    travel = "m", "displacement of the anchor", 3
    tight = "m", "shortening by the pretension"
    work = "J", "work of the anchor and of the pretension so far"
    loss = "J", "energy lost in slip and at the release so far"


class ToolWatchRow(Rows):
    """What is watched of each tool at every step."""

    peak = "N", "largest force of the sheets so far"
    waited = "s", "time in which a driving force was wanted before the tool first met a sheet"
    wanted = "s", "time during which one was wanted since then"
    idle = "s", "of that, the time in which the sheets carried less than half of it"
    wanted_impulse = "N s", "driving force over time"
    carried_impulse = "N s", "what the sheets carried of it over time"
    most_wanted = "N", "largest driving force so far"


class PlyRow(Rows):
    """What a node keeps of its contact with another ply. Records of ``PLY_RECORD_LENGTH`` come first."""

    force = "N", "contact force on the node", 3
    xi = "1", "first coordinate of its foot on the facet, from -1 to 1"
    drag = "N", "friction within that force", 3
    eta = "1", "second coordinate of its foot"
    spring = "m", "tangential spring", 3
    push = "N", "force of the normal spring"
    dashpot = "N", "force of the dashpot along the normal; where it pulls, at most as much as the spring pushes"
    distance = "m", "distance of the mid-surfaces at which they touch, with the facet's sagitta"
    entry = "m", "penetration at which the contact began, as far as it has not been given back: it makes no force"
    depth = "m", "penetration, with the entry; NO_DEPTH without a foot"
    stray = "m", "where the node has no foot: how far it may move before it can have one; 0 with a foot"
    travel = "m", "way along the other ply since the lists of candidates were made"
    slip = "m", "way that it has slid under pressure so far"
    largest_entry = "m", "largest entry so far"
    low = "law's argument", "smallest argument of the friction law so far, under pressure"
    high = "law's argument", "largest one"


PLY_RECORD_LENGTH = int(PlyRow.spring)


class PlyWorkRow(Rows):
    """Works of one pass of an interface at its nodes, as ``NodeWorkRow``: up to the instant of the positions."""

    friction_work = "J", "work done against friction, lost or held in the friction springs"
    damping_loss = "J", "energy lost in dashpots, and of springs that are released at a free edge"
    thickness_work = "J", "work of the change of the distance at which the plies touch"


class LoadRow(Rows):
    """Prescribed loads of the nodes, at a factor of one; rows of vectors."""

    force = "N", "force"
    couple = "N m", "couple"


class GradientRow(Rows):
    """Element shape functions: gradients of the diagonals p = x_1 - x_3 and q = x_2 - x_4 along warp and weft."""

    bp1 = "1/m", "b_p1, of p along the warp"
    bp2 = "1/m", "b_p2, of p along the weft"
    bq1 = "1/m", "b_q1, of q along the warp"
    bq2 = "1/m", "b_q2, of q along the weft"


class OffsetRow(Rows):
    """Shares of the diagonals in the hourglass vector of an element."""

    p = "1", "c_p"
    q = "1", "c_q"


class CurvatureRow(Rows):
    """Curvatures of an element, with respect to the convected yarn vectors."""

    k11 = "1/m", "along the warp"
    k12 = "1/m", "twist"
    k22 = "1/m", "along the weft"


class TransverseShearRow(Rows):
    """Transverse shears of an element."""

    g1 = "1", "along the warp"
    g2 = "1", "along the weft"


class HourglassRow(Rows):
    """Hourglass strains of an element."""

    warping = "m", "warping"
    director1 = "1", "hourglass vector of the directors along the warp"
    director2 = "1", "hourglass vector of the directors along the weft"


class InertiaRow(Rows):
    """Inertia of an element, for the stable step."""

    inverse_areal_density = "m^2/kg", "with any added mass; 0 for padding"
    inverse_squared_radius = "1/m^2", "of the scaled rotary inertia"


class StrainRow(Rows):
    """Strains of a unit cell."""

    warp = "1", "warp stretch - 1"
    weft = "1", "weft stretch - 1"
    shear_angle = "rad", "shear angle"


class CellForceRow(Rows):
    """Forces of a unit cell."""

    warp = "N/m", "n_1"
    weft = "N/m", "n_2"
    moment = "N/m", "m"
    crossover_pressure = "N/m^2", "pressure between warp and weft per reference area"


class TangentRow(Rows):
    """Derivatives of a unit cell's forces n_1, n_2, m with respect to its strains."""

    c11 = "N/m", "dn_1/dlambda_1"
    c12 = "N/m", "dn_1/dlambda_2"
    c22 = "N/m", "dn_2/dlambda_2"
    c13 = "N/m", "dn_1/dgamma"
    c23 = "N/m", "dn_2/dgamma"
    c33 = "N/m", "dm/dgamma"


class ConvergenceRow(Rows):
    """Convergence of a unit cell's solution."""

    worst_residual = "1", "worst relative residual on the path"
    most_iterations = "1", "most iterations on the path"
    snap_loss = "J/m^2", "energy lost in snaps on the path"
