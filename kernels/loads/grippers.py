"""Springs between nodes and moving anchors: grippers that slip at their largest force (docs/theory.md, section 7)."""

from functools import cache

import warp as wp

from ..rows import ClockEntry, GripRow, MotionRow


@wp.struct
class Grip:
    """The spring of one node; its curve is a range of knots in the common arrays."""

    position: wp.int32  # first entry of the node's record in the flat motion array
    corner: wp.int32  # entry of the force along x at one corner of the node, in the flat array of corner forces
    anchor: wp.vec3d  # at time zero [m]
    length: wp.float64  # of the spring without a force [m]
    stiffness: wp.float64  # [N/m]
    pretension: wp.float64  # [N]
    ramp_time: wp.float64  # in which the pretension is applied [s]
    largest_force: wp.float64  # at which the gripper slips [N]
    release_time: wp.float64  # [s]
    first_knot: wp.int32
    knot_count: wp.int32


@wp.struct
class Grips:
    """The springs of all gripped nodes of a sheet."""

    grip: wp.array(dtype=Grip)
    curve_time: wp.array(dtype=wp.float64)  # knots of all curves [s]
    curve_value: wp.array(dtype=wp.vec3d)  # displacement of the anchor [m]
    node_stride: wp.int32  # entries between two rows of the motion array
    corner_stride: wp.int32  # entries between two rows of the corner forces


@wp.func
def moved(grips: Grips, grip: Grip, time: wp.float64):
    """Displacement of the anchor [m], piecewise linear in time and constant beyond its ends."""
    before = grip.first_knot
    after = grip.first_knot + grip.knot_count - 1
    while after - before > 1:
        middle = (before + after) // 2
        if time > grips.curve_time[middle]:
            before = middle
        else:
            after = middle
    result = grips.curve_value[before]
    if after > before and time > grips.curve_time[before]:
        width = grips.curve_time[after] - grips.curve_time[before]
        share = wp.min((time - grips.curve_time[before]) / width, wp.float64(1.0))
        result = grips.curve_value[before] + share * (grips.curve_value[after] - grips.curve_value[before])
    return result


@wp.func
def tightened(grip: Grip, time: wp.float64):
    """What the pretension shortens the spring by [m]."""
    share = wp.float64(1.0)
    if time < grip.ramp_time:
        share = time / grip.ramp_time
    return share * grip.pretension / grip.stiffness


@wp.func
def spring_force(grip: Grip, elongation: wp.float64, time: wp.float64):
    """Force that pulls, up to the largest one [N], and the slip beyond that [m]."""
    none = wp.float64(0.0)
    trial = wp.max(grip.stiffness * elongation, none)
    force = wp.min(trial, grip.largest_force)
    slipped = (trial - force) / grip.stiffness
    if time >= grip.release_time:
        force = none
        slipped = none
    return force, slipped


@wp.func
def change(rows: wp.array2d(dtype=wp.float64), row: int, k: int, value: wp.float64):
    """Put ``value`` in place of the last one, which is returned."""
    last = rows[row, k]
    rows[row, k] = value
    return last


@cache
def grip_function(real: type):
    """Function that adds the force of spring k to one corner of its node, and books works.

    Work of a step is that of the mean of the forces at its ends.
    """

    @wp.func
    def place(motion: wp.array(dtype=real), entry: int, stride: int):
        result = wp.vec3d()
        for c in range(3):
            rounded = motion[entry + (MotionRow.position + c) * stride]
            rest = motion[entry + (MotionRow.remainder + c) * stride]
            result[c] = wp.float64(rounded) + wp.float64(rest)
        return result

    @wp.func
    def pull_node(
        # In
        k: wp.int32,
        grips: Grips,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        corner_force: wp.array(dtype=real),  # flat, rows: see CornerRow
        kept: wp.array2d(dtype=wp.float64),  # rows: see GripRow
    ):
        half = wp.float64(0.5)
        grip = grips.grip[k]
        time = clock[ClockEntry.time]
        travel = moved(grips, grip, time)
        spring = grip.anchor + travel - place(motion, grip.position, grips.node_stride)
        length = wp.max(wp.length(spring), wp.float64(1.0e-12))
        tight = tightened(grip, time)
        old_slip = kept[GripRow.slip, k]
        force, slipped = spring_force(grip, length - grip.length + tight - old_slip, time)
        kept[GripRow.slip, k] = old_slip + slipped
        pulled = force / length * spring
        for c in range(3):
            entry = grip.corner + c * grips.corner_stride
            corner_force[entry] = corner_force[entry] + real(pulled[c])
        last = change(kept, GripRow.force, k, force)
        gained = wp.float64(0.0)
        for c in range(3):
            last_pull = change(kept, GripRow.pull + c, k, pulled[c])
            gained = gained + half * (last_pull + pulled[c]) * (
                travel[c] - change(kept, GripRow.travel + c, k, travel[c])
            )
        gained = gained + half * (last + force) * (tight - change(kept, GripRow.tight, k, tight))
        lost = half * (last + force) * slipped
        if time >= grip.release_time:
            # the spring flies off with what it stores
            gained = wp.float64(0.0)
            lost = half * last * last / grip.stiffness
        kept[GripRow.work, k] = kept[GripRow.work, k] + gained
        kept[GripRow.loss, k] = kept[GripRow.loss, k] + lost

    return pull_node


@cache
def grip_kernel(real: type):
    """Kernel, launched after the elements: the springs of all gripped nodes."""
    pull_node = grip_function(real)

    @wp.kernel(module="unique", enable_backward=False)
    def pull(
        # In
        first: wp.int32,
        grips: Grips,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        corner_force: wp.array(dtype=real),
        kept: wp.array2d(dtype=wp.float64),
    ):
        pull_node(first + wp.tid(), grips, motion, clock, corner_force, kept)

    return pull
