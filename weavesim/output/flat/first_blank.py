"""A first blank from a kinematic drape: the edge of a part on a net, and a margin around it."""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ...sheet.blank import Blank
from ...sheet.outline import checked_outline
from ...sheet.symmetry import WHOLE, Symmetry
from ..comparison.kinematic import KinematicDrape
from ..stored.file import StoredSheet
from .part_edge import PartEdge, plan_area
from .trimming import FlatPattern, flat_pattern

# Yarns lie along planes of symmetry within this.
ALONG = 1.0e-6
# Segments of a full turn of a margin's line around a corner.
TURN_SEGMENTS = 72


def pattern_of_net(
    drape: KinematicDrape, blank: Blank, thickness: float, name: str, edge: PartEdge, symmetry: Symmetry = WHOLE
) -> FlatPattern:
    """The material of a net under the edge of a part, in the place of the flat blank.

    Args:
        drape: of the blank.
        blank: flat, with straight yarns.
        thickness: of the fabric [m].
        name: of the sheet.
        edge: of the part.
        symmetry: planes at which the blank is cut.

    Raises:
        InputError: an edge beyond the net, or yarns across planes of symmetry.
    """
    yarns = np.stack([blank.warp_direction[0, :2], blank.weft_direction[0, :2]])
    if symmetry.planes and np.abs(yarns).min(axis=1).max() > ALONG:
        raise InputError(
            "kinematic drape: yarns along the planes of symmetry are needed for the whole net; give the job the "
            "whole blank"
        )
    net = drape.net
    rows, columns = net.position.shape[:2]
    steps = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"), axis=-1).reshape(-1, 2)
    flat = np.array(drape.seed) + net.side * (steps + np.array(net.first)) @ yarns
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    points = net.position.reshape(-1, 3)
    there = np.isfinite(points[quads]).all(axis=(1, 2))
    for plane in symmetry.planes:
        there &= flat[quads].mean(axis=1)[:, "xy".index(plane)] > 0.0
    if not there.any():
        raise InputError(f"kinematic drape: the net on {drape.tool} has no cell; give another seed, or a smaller side")
    used, quads = np.unique(quads[there], return_inverse=True)
    flat, points, quads = flat[used], points[used], quads.reshape(-1, 4)
    corner = flat[quads]
    p, q = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    if np.any(p[:, 0] * q[:, 1] < p[:, 1] * q[:, 0]):  # a weft to the right of its warp
        quads = quads[:, ::-1]
    for plane in symmetry.planes:  # rounding of the seed
        axis = "xy".index(plane)
        flat[np.abs(flat[:, axis]) < 1e-9, axis] = 0.0
    sheet = StoredSheet(
        name=name,
        blank=Blank.from_mesh(
            np.column_stack([flat, np.zeros(len(flat))]), quads, merge_nodes=0.0,
            warp_direction=np.append(yarns[0], 0.0),
        ),
        position=points, director=np.zeros_like(points), values={}, thickness=thickness, symmetry=symmetry, tools=(),
        fabric="",
    )  # fmt: skip
    called = f"net of {name} on {drape.tool}"
    if drape.ends:
        called += f" (which covers {100.0 * drape.covered_share:.3g} % of it)"
    return flat_pattern(sheet, edge, called)


def with_margin(outline: np.ndarray, margin: float) -> np.ndarray:
    """The line around a closed line (k, 2) at the distance ``margin`` [m] outside it, corners rounded; (n, 2)."""
    outline = checked_outline(outline)
    if margin == 0.0:
        return outline
    from manifold3d import CrossSection, FillRule, JoinType

    # the library rounds to 1e-8 units: in margins, which may be millimetres of metres
    grown = CrossSection([outline / margin], FillRule.NonZero).offset(1.0, JoinType.Round, 2.0, TURN_SEGMENTS)
    lines = [margin * np.asarray(line, dtype=np.float64) for line in grown.to_polygons()]
    largest = max(lines, key=lambda line: abs(plan_area(line)))
    return largest if plan_area(largest) > 0.0 else largest[::-1]
