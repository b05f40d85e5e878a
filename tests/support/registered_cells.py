"""All unit cells, each with its energy in NumPy: add a cell here and ``test_unit_cells.py`` tests it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from warp import float64 as real

from weavesim.checks import Positive
from weavesim.fabric.cell import EnergyCell, UnitCell
from weavesim.fabric.cell.weaves import FloatWeave
from weavesim.fabric.presets import UNIT_CELLS


@wp.func
def net_energy(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Threads along both yarns with a bound knot each, one knotted to the angle."""
    warp = warp_stretch - real(1.0) - q[0]
    weft = weft_stretch - real(1.0) - q[1]
    return (
        real(0.5) * p.thread * (warp * warp + weft * weft)
        + real(0.5) * p.knot * (q[0] * q[0] + q[1] * q[1] + q[0] * q[1] + real(3.0) * q[0] * q[0] * q[0] * q[0])
        + p.turning * (real(1.0) - wp.cos(shear_angle - q[1]))
    )


class KnottedNet(EnergyCell):
    """A cell as a user would add it: everything depends on everything."""

    unknown_count = 2
    energy = net_energy

    thread: Positive = 1.0e5
    knot: Positive = 4.0e4
    turning: Positive = 2.0e3

    @property
    def yarn_stiffness_per_width(self) -> tuple[float, float]:
        return self.thread, self.thread

    @property
    def shear_stiffness(self) -> float:
        return self.turning


@wp.func
def taut_energy(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Threads that are free at a stretch of 0.9."""
    warp = warp_stretch - real(0.9)
    weft = weft_stretch - real(0.9)
    return real(0.5) * p.thread * (warp * warp + weft * weft)


class TautNet(KnottedNet):
    """A mistake: the undeformed net is under tension."""

    unknown_count = 0
    energy = taut_energy


def net_reference(cell: KnottedNet, stretch, angle, q) -> float:
    threads = 0.5 * cell.thread * ((stretch[0] - 1 - q[0]) ** 2 + (stretch[1] - 1 - q[1]) ** 2)
    knots = 0.5 * cell.knot * (q[0] ** 2 + q[1] ** 2 + q[0] * q[1] + 3 * q[0] ** 4)
    return threads + knots + cell.turning * (1 - math.cos(angle - q[1]))


def crossed_yarns_reference(cell, stretch, angle, q) -> float:
    """Plain weave (q is w_1, w_2 [m]) and weaves with floats (w over a scale, strains of the floats)."""
    repeat = getattr(cell, "repeat", 2)
    heights = np.array(q[:2]) * (cell.parameters()["height_scale"] if isinstance(cell, FloatWeave) else 1.0)
    strains = q[2:] if isinstance(cell, FloatWeave) else (0.0, 0.0)
    energy = 0.0
    for k in range(2):
        spacing, height = cell.half_spacing[k], cell.crimp_height[k]
        float_length = (repeat / 2 - 1) * spacing
        x = stretch[k] * repeat / 2 * spacing - (1 + strains[k]) * float_length
        h = height + heights[k]
        l0 = math.hypot(spacing, height)

        def bar(elongation, length, k=k):
            stiffness = cell.axial_stiffness[k] if elongation > 0 else cell.compressive_stiffness[k]
            return 0.5 * stiffness / length * elongation**2 if length else 0.0

        rotation = math.atan2(h, x) - math.atan2(height, spacing)
        energy += bar(math.hypot(x, h) - l0, l0) + bar(strains[k] * float_length, float_length)
        energy += 1.5 * cell.bending_stiffness[k] / l0 * rotation**2
    opening = heights.sum()
    if not (cell.contact == "unilateral" and opening > 0):
        energy += 0.5 * cell.contact_stiffness * opening**2
    return energy / (repeat * cell.warp_half_spacing * cell.weft_half_spacing)


def tape_reference(cell, stretch, angle, q) -> float:
    corner = np.array([cell.stitch_pitch, cell.tow_spacing])
    # yarns of a sheared sheet: the weft leans by the angle
    weft = np.array([math.sin(angle), math.cos(angle)])
    energy = 0.0
    for k, sign in enumerate((1.0, -1.0)):
        leg = np.array([corner[0] * stretch[0], 0.0]) + sign * corner[1] * stretch[1] * weft
        strain = np.linalg.norm(leg) / np.linalg.norm(corner) - 1 - cell.stitch_slack - (q[0] if k == 0 else -q[0])
        energy += 0.5 * cell.stitch_stiffness * max(strain, 0.0) ** 2
    energy += 0.5 * cell.slip_stiffness * q[0] ** 2
    for strain, pull, push in (
        (stretch[0] - 1, cell.tow_stiffness, cell.tow_compressive_stiffness),
        (stretch[1] - 1, cell.transverse_stiffness, cell.transverse_compressive_stiffness),
    ):
        energy += 0.5 * (pull if strain > 0 else push) * strain**2
    return energy


def membrane_reference(cell, stretch, angle, q) -> float:
    stiffness = np.array(
        [[cell.warp_stiffness, cell.coupling_stiffness], [cell.coupling_stiffness, cell.weft_stiffness]]
    )
    strain = np.asarray(stretch) - 1
    return 0.5 * strain @ stiffness @ strain


@dataclass(frozen=True)
class Registered:
    """A cell, its energy in NumPy, and how large its unknowns are: one is large for all but the plain weave's."""

    make: Callable[[], UnitCell]
    reference: Callable[..., float]
    unknown_scale: float = 1.0


CELLS = {
    "plain-weave": Registered(UNIT_CELLS["plain-weave"], crossed_yarns_reference, 6e-4),
    "plain-weave-unilateral": Registered(UNIT_CELLS["plain-weave-unilateral"], crossed_yarns_reference, 6e-4),
    "plain weave as floats of no length": Registered(
        lambda: FloatWeave(**UNIT_CELLS["plain-weave"]().model_dump(), repeat=2), crossed_yarns_reference
    ),
    "twill": Registered(UNIT_CELLS["twill"], crossed_yarns_reference),
    "satin-5": Registered(UNIT_CELLS["satin-5"], crossed_yarns_reference),
    "satin-8": Registered(UNIT_CELLS["satin-8"], crossed_yarns_reference),
    "stitched-tape": Registered(UNIT_CELLS["stitched-tape"], tape_reference),
    "linear-membrane": Registered(UNIT_CELLS["linear-membrane"], membrane_reference),
    "user's net": Registered(KnottedNet, net_reference),
}
