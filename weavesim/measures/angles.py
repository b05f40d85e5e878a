"""Shear angles at nodes and points, and yarn directions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..sheet.symmetry import WHOLE, Symmetry, on_plane, shear_angle_parity
from ..sheet.topology import at_corners, flat_areas, length_tolerance

if TYPE_CHECKING:
    from ..sheet.blank import Blank


# ----------------------------------------------------------------------------------------------- angles at points


def smoothed_shear_angle(blank: Blank, shear_angle: np.ndarray, symmetry: Symmetry = WHOLE) -> np.ndarray:
    """Shear angle smoothed to the nodes for pictures and points: area-weighted mean around each, (node_count,) [rad].

    On a symmetry plane the mirrored elements count as well, by their ``shear_angle_parity``.

    The solver uses another mean (theory, "mean shear angle around a node"), in which all elements around a node have
    the same weight: it is part of a bending energy, where it only has to be smooth and cheap to gather. A result must
    not depend on the grading of the mesh, so here elements are weighted by area. On uniform meshes both are equal.
    """
    return smoothed(blank, smoothing_weights(blank, symmetry), shear_angle)


def smoothed(blank: Blank, weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Element ``values`` smoothed to the nodes with ``smoothing_weights`` of the blank, which frames can share."""
    return np.bincount(blank.quads.ravel(), (weights * values[:, None]).ravel(), blank.node_count)


def smoothing_weights(blank: Blank, symmetry: Symmetry = WHOLE) -> np.ndarray:
    """Weight of each element in the smoothed shear angle of its corners, (element_count, 4)."""
    area = flat_areas(blank)
    weight = np.repeat(area[:, None], 4, axis=1)
    share = np.ones_like(weight)
    for plane in symmetry.planes:
        sign = shear_angle_parity(blank, plane)
        share = np.where(on_plane(blank, plane)[blank.quads], share * 0.5 * (1.0 + sign[:, None]), share)
    total = np.bincount(blank.quads.ravel(), weight.ravel(), blank.node_count)
    return weight * share / np.maximum(total, 1.0e-300)[blank.quads]


def locate(blank: Blank, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Element that contains each flat point, (k,), and the bilinear weights of its four corners, (k, 4).

    Raises:
        InputError: a point outside the blank.
    """
    elements, weights = located(blank, points)
    if (outside := np.flatnonzero(elements < 0)).size:
        point = np.atleast_2d(np.asarray(points, dtype=float))[outside[0]]
        x, y = blank.material_coordinates.min(axis=0), blank.material_coordinates.max(axis=0)
        raise InputError(
            f"point ({point[0]:.6g}, {point[1]:.6g}) m lies outside the blank, which spans {x[0]:.6g} to "
            f"{y[0]:.6g} m in x and {x[1]:.6g} to {y[1]:.6g} m in y; give a point on the flat blank"
        )
    return elements, weights


def located(blank: Blank, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """``locate`` of points (k, 2) [m] that may lie outside the blank: their element is -1, their weights are zero."""
    corners = blank.material_coordinates[blank.quads]
    slack = 10.0 * length_tolerance(blank)
    lower, upper = corners.min(axis=1) - slack, corners.max(axis=1) + slack
    places = np.atleast_2d(np.asarray(points, dtype=float))
    elements, weights = np.full(len(places), -1), np.zeros((len(places), 4))
    for k, point in enumerate(places):
        candidates = np.flatnonzero(np.all((point >= lower) & (point <= upper), axis=1))
        local, shapes = _local_coordinates(corners[candidates], point)
        outside = np.abs(local).max(axis=1, initial=0.0)
        if len(candidates) and outside[best := int(np.argmin(outside))] <= 1.0 + 1.0e-3:
            elements[k], weights[k] = candidates[best], shapes[best]
    return elements, weights


def _local_coordinates(corner: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A point's coordinates from -1 to 1 in each element (k, 4, 2): coordinates (k, 2), and the corners' weights."""
    local = np.zeros((len(corner), 2))
    shapes = np.full((len(corner), 4), 0.25)
    for _ in range(20):  # Newton on the bilinear map; exact after one step on parallelograms
        r, s = local.T
        shapes = 0.25 * np.stack([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)], axis=1)
        by_r = 0.25 * np.stack([s - 1, 1 - s, 1 + s, -1 - s], axis=1)
        by_s = 0.25 * np.stack([r - 1, -1 - r, 1 + r, 1 - r], axis=1)
        jacobian = np.stack([np.einsum("ec,ecx->ex", d, corner) for d in (by_r, by_s)], axis=2)
        miss = point - np.einsum("ec,ecx->ex", shapes, corner)
        determinant = jacobian[:, 0, 0] * jacobian[:, 1, 1] - jacobian[:, 0, 1] * jacobian[:, 1, 0]
        solvable = np.abs(determinant) > 1.0e-300
        step = (
            np.stack(
                [
                    jacobian[:, 1, 1] * miss[:, 0] - jacobian[:, 0, 1] * miss[:, 1],
                    jacobian[:, 0, 0] * miss[:, 1] - jacobian[:, 1, 0] * miss[:, 0],
                ],
                axis=1,
            )
            / np.where(solvable, determinant, 1.0)[:, None]
        )
        moved = np.clip(local + step, -3.0, 3.0)
        if np.array_equal(moved, local):  # so would all further steps
            break
        local = moved
    return local, shapes


def shear_angle_at(blank: Blank, shear_angle: np.ndarray, points: np.ndarray, symmetry: Symmetry = WHOLE) -> np.ndarray:
    """Absolute shear angle at material points, (k,) [degrees].

    Rule: signed element values are averaged to the nodes by flat area, mirrored elements included
    (``smoothed_shear_angle``), and interpolated bilinearly in the element that contains the point. Where symmetry
    makes the angle odd it is zero, also at the corner of a border and a symmetry line.

    Args:
        shear_angle: one per element, (element_count,) [rad].
        points: flat coordinates, (k, 2) [m].
        symmetry: planes at which the computed part is mirrored.
    """
    element, weight = locate(blank, points)
    nodal = smoothed_shear_angle(blank, shear_angle, symmetry)
    return np.abs(np.rad2deg(np.einsum("kc,kc->k", weight, nodal[blank.quads[element]])))


def ten_points(half_length: float, half_width: float) -> np.ndarray:
    """Points 1 to 10 of the double dome, (10, 2) [m]: evenly spaced from (half_length, 0) to (0, half_width)."""
    return np.linspace((half_length, 0.0), (0.0, half_width), 10)


def yarn_vectors(
    blank: Blank, position: np.ndarray, components: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Unit warp and weft directions at the element centres of the formed sheet, two of (element_count, 3).

    Args:
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        components: ``yarn_components(blank)``, which frames can share.
    """
    components = yarn_components(blank) if components is None else components
    a, b, c, d = at_corners(position, blank.quads.T).swapaxes(0, 1)
    along, across = b + c - a - d, c + d - a - b
    warp, weft = (_unit(component[:, 0] * along + component[:, 1] * across) for component in components)
    return warp, weft


def yarn_angles(blank: Blank, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles of warp and weft in each element's own frame, two of (element_count,) [rad], within +-pi.

    The frame of a formed element: x from its first corner to the second, seen along the normal; angles are counted
    towards the third corner.
    """
    corner = position[blank.quads]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = corner[:, 1] - corner[:, 0]
    along = along - np.einsum("ei,ei->e", along, normal)[:, None] * normal
    across = np.cross(normal, along)
    warp, weft = (
        np.arctan2(np.einsum("ei,ei->e", yarn, across), np.einsum("ei,ei->e", yarn, along))
        for yarn in yarn_vectors(blank, position)
    )
    return warp, weft


def yarn_components(blank: Blank) -> np.ndarray:
    """Components of warp and weft direction along the two mean sides of each flat element, (2, element_count, 2)."""
    along = _sides(blank.node_position[blank.quads])
    metric = np.einsum("eai,ebi->eab", along, along)
    return np.stack([
        np.linalg.solve(metric, np.einsum("eai,ei->ea", along, direction)[:, :, None])[:, :, 0]
        for direction in (blank.warp_direction, blank.weft_direction)
    ])  # fmt: skip


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) along vectors (3, n)."""
    x, y, z = vectors
    return np.stack(vectors / np.sqrt(x * x + y * y + z * z), axis=1)


def _sides(corner: np.ndarray) -> np.ndarray:
    return np.stack([corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3],
                     corner[:, 2] + corner[:, 3] - corner[:, 0] - corner[:, 1]], axis=1)  # fmt: skip
