"""Lines and outline of a formed sheet: draw-in and yarn stretch along them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import InputError
from ..sheet.symmetry import AXES, WHOLE, Symmetry, on_plane
from ..sheet.topology import length_tolerance

if TYPE_CHECKING:
    from ..sheet.blank import Blank


# ------------------------------------------------------------------------------------------------ lines and outline


class MaterialLine(NamedTuple):
    """Points along a straight line of the flat blank, as points on mesh edges: ``start + share (end - start)``."""

    start: np.ndarray
    end: np.ndarray
    share: np.ndarray

    def of(self, values: np.ndarray) -> np.ndarray:
        """Nodal values at the points of the line, (k, ...)."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        return (1.0 - share) * values[self.start] + share * values[self.end]


def symmetry_line(blank: Blank, along: str) -> MaterialLine:
    """The flat line y = 0 (``along`` "x") or x = 0 ("y"), by increasing coordinate; through nodes or across edges.

    Raises:
        InputError: the blank does not cross the line.
    """
    axis = AXES[along]
    across = blank.material_coordinates[:, 1 - axis]
    tolerance = length_tolerance(blank)
    nodes = np.flatnonzero(np.abs(across) <= tolerance)
    edges = np.concatenate([blank.quads[:, [i, (i + 1) % 4]] for i in range(4)])
    a, b = across[edges].T
    edges = edges[(np.minimum(a, b) < -tolerance) & (np.maximum(a, b) > tolerance)]
    edges = np.unique(np.sort(edges, axis=1), axis=0)  # few are left of thousands
    a, b = across[edges].T
    if not len(nodes) and not len(edges):
        raise InputError(f"the blank does not cross the line along {along}: place it over the origin")
    start, end = np.concatenate([nodes, edges[:, 0]]), np.concatenate([nodes, edges[:, 1]])
    share = np.concatenate([np.zeros(len(nodes)), a / (a - b)])
    line = MaterialLine(start, end, share)
    order = np.argsort(line.of(blank.material_coordinates[:, axis]), kind="stable")
    return MaterialLine(start[order], end[order], share[order])


def draw_in(blank: Blank, position: np.ndarray, along: str) -> float:
    """Draw-in at the positive end of a symmetry line [m]: flat coordinate minus formed plan coordinate."""
    axis = AXES[along]
    line = symmetry_line(blank, along)
    return float(line.of(blank.material_coordinates[:, axis])[-1] - line.of(position[:, axis])[-1])


class Outline(NamedTuple):
    """Free border of the computed part, without the edges on symmetry planes.

    Attributes:
        node: in order, (k,).
        closed: whether the last node joins the first.
        normal: outward flat unit normal, (k, 2).
    """

    node: np.ndarray
    closed: bool
    normal: np.ndarray


def outline(blank: Blank, symmetry: Symmetry = WHOLE) -> Outline:
    """Free border of the blank, counter-clockwise like the elements."""
    loop = blank.boundary_loop()
    following = np.roll(loop, -1)
    free = np.ones(len(loop), dtype=bool)
    for plane in symmetry.planes:
        held = on_plane(blank, plane)
        free &= ~(held[loop] & held[following])
    closed = bool(free.all())
    if not closed:  # begin after a symmetry plane
        first = int(np.flatnonzero(free & ~np.roll(free, 1))[0])
        loop, free = np.roll(loop, -first), np.roll(free, -first)
        loop = loop[: int(np.argmin(free)) + 1]
    flat = blank.material_coordinates[loop]
    edge = np.roll(flat, -1, axis=0) - flat if closed else np.diff(flat, axis=0)
    sideways = np.column_stack([edge[:, 1], -edge[:, 0]])
    sideways /= np.linalg.norm(sideways, axis=1, keepdims=True)
    if closed:
        normal = sideways + np.roll(sideways, 1, axis=0)
    else:
        normal = np.concatenate([sideways[:1], sideways[1:] + sideways[:-1], sideways[-1:]])
    return Outline(loop, closed, normal / np.linalg.norm(normal, axis=1, keepdims=True))


def whole_outline(blank: Blank, values: np.ndarray, symmetry: Symmetry = WHOLE) -> np.ndarray:
    """Nodal vectors (node_count, 2 or 3) on the closed outline of the whole part, (k, 2 or 3)."""
    border = outline(blank, symmetry)
    own = values[border.node]
    if border.closed:
        return own
    flat = blank.material_coordinates[border.node]
    pieces = []
    for sign in symmetry.mirror_factors:
        step = 1 if sign[0] * sign[1] > 0 else -1
        middle = flat[len(flat) // 2] * sign
        factor = np.array([*sign, 1.0])[: values.shape[1]]
        pieces.append((np.arctan2(middle[1], middle[0]), (own * factor)[::step], (flat * sign)[::step]))
    pieces.sort(key=lambda piece: piece[0])
    chain, flat_chain = (np.concatenate([piece[i] for piece in pieces]) for i in (1, 2))
    # Where two copies meet, the node on the symmetry plane appears twice.
    repeated = np.linalg.norm(flat_chain - np.roll(flat_chain, 1, axis=0), axis=1) <= length_tolerance(blank)
    return chain[~repeated]


def border_draw_in(blank: Blank, position: np.ndarray, border: Outline) -> np.ndarray:
    """Draw-in along the border, (k,) [m]: in-plan displacement against the outward normal of the flat outline."""
    movement = position[border.node, :2] - blank.material_coordinates[border.node]
    return -np.einsum("ki,ki->k", movement, border.normal)


def integrated_yarn_stretch(blank: Blank, stretch: np.ndarray, along: str) -> float:
    """Elongation of the yarns on the positive half of a symmetry line [m]: (stretch - 1) integrated over its length.

    The elements that touch the line contribute, each with its flat extent along the line; if there are elements on
    both sides, the two sides are averaged. ``stretch`` is that of the yarns along the line, (element_count,).
    """
    axis = AXES[along]
    corner = blank.material_coordinates[blank.quads]
    across = corner[:, :, 1 - axis]
    tolerance = length_tolerance(blank)
    touches = np.sum(across <= tolerance, axis=1) >= 2
    touches &= np.sum(across >= -tolerance, axis=1) >= 2
    extent = np.clip(corner[:, :, axis], 0.0, None)
    extent = np.where(touches, extent.max(axis=1) - extent.min(axis=1), 0.0)
    if extent.sum() == 0.0:
        raise InputError(f"no element touches the line along {along}: place the blank over the origin")
    length = symmetry_line(blank, along).of(blank.material_coordinates[:, axis])[-1]
    length -= max(0.0, float(corner[touches][:, :, axis].min()))
    return float(length * np.sum(extent * (stretch - 1.0)) / extent.sum())


def taut_path_draw_in(
    punch_radius: float, die_radius: float, depth: float, thickness: float, clearance: float
) -> float:
    """Draw-in of inextensible straight yarns on a symmetry line of a double dome [m].

    The mid-surface follows the punch at ``punch_radius + thickness/2``, a common tangent, the die entry at
    ``die_radius + thickness/2``, and is flat from there; the draw-in is the length of this path minus its plan length.
    ``depth`` is measured from the die face to the nose of the punch, which touches a sheet on the die face at a depth
    of minus ``thickness``. The die wall is at ``punch_radius + clearance``.

    Raises:
        InputError: there is no such path for these lengths.
    """
    given = (
        f"punch radius {punch_radius:g}, die radius {die_radius:g}, depth {depth:g}, thickness {thickness:g}, "
        f"clearance {clearance:g} m"
    )
    if not min(punch_radius, die_radius, depth, thickness) > 0.0 or not clearance >= thickness * (1.0 - 1.0e-9):
        raise InputError(f"taut path: {given}; lengths must be positive and the clearance at least the thickness")
    on_punch, on_die = punch_radius + 0.5 * thickness, die_radius + 0.5 * thickness
    # Centre of the die entry relative to that of the punch; heights are those of the mid-surface.
    across = punch_radius + clearance + die_radius
    up = -on_die - (-(depth + thickness) + on_punch)
    distance, radii = np.hypot(across, up), on_punch + on_die
    if distance < radii:
        raise InputError(f"taut path: {given}: punch and die overlap; reduce the depth or increase the clearance")
    angle = np.arctan2(up, across) + np.arcsin(radii / distance)
    if not 0.0 < angle <= 0.5 * np.pi + 1.0e-9:
        raise InputError(f"taut path: {given}: the wall would lean over by {np.rad2deg(angle):.1f} degrees")
    return float(radii * angle + np.sqrt(distance**2 - radii**2) - across)
