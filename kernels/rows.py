"""What every shared array holds, row by row; kernels and host read it here."""

import warp as wp

# Rows of the cell report: iterations of this step, energy lost in snaps so far [J/m^2], worst relative residual so far.
CELL_REPORT_ROWS = ("iterations", "snap_loss", "worst_residual")
ITERATIONS_ROW = wp.constant(0)
SNAP_LOSS_ROW = wp.constant(1)
WORST_RESIDUAL_ROW = wp.constant(2)
# Rows of the corner array, eight per corner: force; director gradient; shear angle; thickness if tools meet it.
CORNER_ROW_COUNT = 32
ROWS_PER_CORNER = wp.constant(8)
COUPLE_ROW = wp.constant(3)
ANGLE_ROW = wp.constant(6)
THICKNESS_ROW = wp.constant(7)
# Vectors of the motion array of the nodes, three rows each; the remainder is what rounding cut off the position. Then
# one row for the mean shear angle of the elements around the node [rad].
MOTION_ROWS = ("position", "velocity", "director", "spin", "remainder")
POSITION_ROW = wp.constant(0)
VELOCITY_ROW = wp.constant(3)
DIRECTOR_ROW = wp.constant(6)
SPIN_ROW = wp.constant(9)
REMAINDER_ROW = wp.constant(12)
MEAN_ANGLE_ROW = wp.constant(15)
MOTION_ROW_COUNT = 16
# Rows of the node report, of which a run has the first three, four with loads, all where tools meet the current
# thickness: work done against friction so far, lost or held in the friction springs [J]; energy lost in damping so far
# [J]; work of what holds the node, and of the loads on it, so far [J]; half the current thickness of the sheet and its
# last change [m]; work of its change on the tools so far [J].
NODE_REPORT_ROWS = (
    "friction_work",
    "damping_loss",
    "support_work",
    "load_work",
    "half_thickness",
    "half_thickness_growth",
    "thickness_work",
)
FRICTION_ROW = wp.constant(0)
DAMPING_ROW = wp.constant(1)
SUPPORT_ROW = wp.constant(2)
LOAD_ROW = wp.constant(3)
HALF_THICKNESS_ROW = wp.constant(4)
GROWTH_ROW = wp.constant(5)
THICKNESS_WORK_ROW = wp.constant(6)
# Rows of what friction inside the sheet remembers: slip and spring of the sliders, and the work lost in them [J/m^2].
SLIP_ROWS = (
    "shear_slip",
    "warp_bending_slip",
    "weft_bending_slip",
    "shear_spring",
    "warp_bending_spring",
    "weft_bending_spring",
    "shear_friction_loss",
    "bending_friction_loss",
)
SHEAR_SLIP_ROW = wp.constant(0)
BENDING_SLIP_ROW = wp.constant(1)
SHEAR_SPRING_ROW = wp.constant(3)
BENDING_SPRING_ROW = wp.constant(4)
SHEAR_LOSS_ROW = wp.constant(6)
BENDING_LOSS_ROW = wp.constant(7)
# Rows of the element energies [J] after those of the unit cell, in this order.
SHEET_ENERGIES = (
    "compression", "shear", "in_plane_bending", "bending", "transverse_shear", "hourglass",
    "snap_loss", "shear_friction_loss", "bending_friction_loss",
)  # fmt: skip
# Rows of the element fields; the crossover force still per reference area, the host multiplies it by the cell's.
ELEMENT_FIELDS = (
    "shear_angle",
    "warp_stretch",
    "weft_stretch",
    "warp_force",
    "weft_force",
    "crossover_pressure",
    "area_ratio",
    "shear_moment",
)
# Entries of the clock, always in double precision.
CLOCK_TIME = wp.constant(0)
CLOCK_STEP = wp.constant(1)
CLOCK_MEAN_STEP = wp.constant(2)
CLOCK_LENGTH = 3
