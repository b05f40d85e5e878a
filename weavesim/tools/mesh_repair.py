"""Weld, orient, mirror and close the triangle mesh of a tool."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError
from ..input_files import unit_wish
from ..ranges import QUANTITIES
from .mesh_topology import directed_edges, labels

# Tools are between 2 mm and 20 m across; anything else is a unit error.
LARGEST_SIZE = QUANTITIES["length"].legal[1]
SMALLEST_SIZE = 0.002

# Vertices closer than this share of the size are merged; borders closer than the second are a seam, not a border.
WELD = 1e-6
SEAM = 1e-4
# A triangle of less area than the square of this share of the size has none.
LEAST_AREA = 1e-9


def checked_triangles(name: str, vertices: Any, faces: Any) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) [m] and faces (m, 3) as arrays, without vertices that no face uses.

    Args:
        name: of the mesh, for messages.
        vertices, faces: as given.

    Raises:
        InputError: no triangles, wrong shapes, indices beyond the vertices, values that are not finite, or a size that
            no tool has.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces)
    if faces.size == 0:
        raise InputError(f"{name} has no triangles; export the tool's surface as a triangle mesh.")
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError(
            f"{name} has vertices of shape {vertices.shape} and faces of shape {faces.shape}; "
            "(n, 3) coordinates and (m, 3) vertex indices are needed."
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(
            f"{name} has triangles that use vertex {faces.min() if faces.min() < 0 else faces.max()}; "
            f"vertices go from 0 to {len(vertices) - 1}."
        )
    bad = np.flatnonzero(~np.all(np.isfinite(vertices), axis=1))
    if len(bad):
        raise InputError(
            f"{name} has {len(bad)} vertices that are not finite, the first is vertex {bad[0]}; export the mesh again."
        )
    vertices, (faces,) = without_unused(vertices, [faces])
    check_size(name, vertices)
    return vertices, faces


def edge_products(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vector product of two edges of each face, along its normal and twice its area long: x, y, z, (m,) each [m^2].

    As ``np.cross`` to the bit, without its intermediate arrays of vectors: in a third of the time for large meshes.
    """
    i, j, k = np.ascontiguousarray(faces.T)
    along, across = zip(*((x[j] - x[i], x[k] - x[i]) for x in np.ascontiguousarray(vertices.T)), strict=True)
    x, y, z = (along[a] * across[b] - along[b] * across[a] for a, b in ((1, 2), (2, 0), (0, 1)))
    return x, y, z


def triangle_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Areas of the faces (m, 3) of ``vertices`` (n, 3) [m]: (m,) [m^2]."""
    x, y, z = edge_products(vertices, faces)
    return 0.5 * np.sqrt(x * x + y * y + z * z)


def mirrored_mesh(
    name: str, vertices: np.ndarray, faces: np.ndarray, plane: str, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) [m] and faces (m, 3) with their mirror image at a plane, welded there.

    Args:
        name: of the mesh, for messages.
        vertices, faces: of one half.
        plane: "x" for x = 0, or "y" for y = 0.
        tolerance: up to which the half may be away from the plane [m].

    Raises:
        InputError: another plane, or a mesh that does not end at it.
    """
    if plane not in ("x", "y"):
        raise InputError(f'{name}: mirror contains {plane!r}; "x" (plane x = 0) and "y" (plane y = 0) are allowed.')
    axis = "xy".index(plane)
    low, high = vertices[:, axis].min(), vertices[:, axis].max()
    if min(abs(low), abs(high)) > tolerance:
        raise InputError(
            f"{name}: mirror contains the plane {plane} = 0, but the mesh extends from {plane} = {low:.4g} m to "
            f"{high:.4g} m; it must end at the plane."
        )
    vertices = vertices.copy()
    on_plane = np.abs(vertices[:, axis]) <= tolerance
    vertices[on_plane, axis] = 0.0
    faces = faces[~np.all(on_plane[faces], axis=1)]  # the cut face of a closed mesh
    other = vertices * np.where(np.arange(3) == axis, -1.0, 1.0)
    return np.concatenate([vertices, other]), np.concatenate([faces, faces[:, ::-1] + len(vertices)])


def welded(vertices: np.ndarray, faces: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge vertices closer than ``tolerance``; at most 2 million times that across."""
    from scipy.spatial import cKDTree

    # those in one cell of a fine grid first: in a mesh without shared vertices these are most
    cells = np.floor((vertices - vertices.min(axis=0)) / tolerance).astype(np.int64)
    key = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    close = cKDTree(vertices[first]).query_pairs(tolerance, output_type="ndarray")
    if len(close):
        group = labels(len(first), close)
        _, one = np.unique(group, return_index=True)
        first, index = first[one], group[index]
    # vertices stay in their order
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return vertices[first[order]], place[index][faces]


def diagonal(points: np.ndarray) -> float:
    """Of the box around points (..., 3) [m]."""
    points = points.reshape(-1, 3)
    return float(np.linalg.norm([np.ptp(points[:, k]) for k in range(3)]))


def extent(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Diagonal of the box around all triangles that have an area [m]; stray corners of others do not count."""
    size = diagonal(vertices)
    none = triangle_areas(vertices, faces) <= (LEAST_AREA * size) ** 2
    return diagonal(vertices[faces[~none]]) if np.any(none) and not np.all(none) else size


def turned_outwards(faces: np.ndarray, component: np.ndarray, facing: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Orient a sheet as a whole towards positive ``facing``, then flip each component that clearly faces the other way.

    Args:
        faces: (m, 3).
        component: of each face.
        facing: component along the side of each face's normal, times its area.
        area: of each face, in the same unit.
    """
    sense = 1.0 if facing.sum() >= 0.0 else -1.0
    opposite = np.bincount(component, weights=sense * facing) < -0.2 * np.bincount(component, weights=area)
    flip = (sense < 0.0) != opposite[component]
    return np.where(flip[:, None], faces[:, ::-1], faces)


def ends_at(coordinate: np.ndarray, tolerance: float) -> bool:
    """Whether the mesh lies on one side of zero and at least three of its vertices lie at zero."""
    nearest = min(abs(coordinate.min()), abs(coordinate.max()))
    return bool(nearest <= tolerance and np.count_nonzero(np.abs(coordinate) <= tolerance) >= 3)


def directed_border(border: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Border edges, (k, 2) vertices, in the direction of their faces."""
    count = int(faces.max()) + 1
    at_border = np.zeros(count, dtype=bool)
    at_border[border.ravel()] = True
    edges = directed_edges(faces[np.count_nonzero(at_border[faces], axis=1) >= 2])
    low, high = edges.min(axis=1), edges.max(axis=1)
    given = border.min(axis=1) * count + border.max(axis=1)
    return edges[np.isin(low * count + high, given)]


def extruded(
    vertices: np.ndarray, faces: np.ndarray, border: np.ndarray, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The body behind a sheet, down to about ``shift``: the sheet, walls at its border, and a lid from these.

    The lid joins the lower ends of the walls to one point; its shape does not matter so far from the sheet.
    """
    count = len(vertices)
    used, index = np.unique(border, return_inverse=True)
    index = index.reshape(-1, 2) + count
    a, b = border[:, 0], border[:, 1]
    low_a, low_b = index[:, 0], index[:, 1]
    apex = np.full(len(border), count + len(used))
    walls = [np.column_stack([b, a, low_a]), np.column_stack([b, low_a, low_b]), np.column_stack([low_b, low_a, apex])]
    lower = vertices[used] + shift
    return np.concatenate([vertices, lower, lower.mean(axis=0, keepdims=True)]), np.concatenate([faces, *walls])


def without_unused(vertices: np.ndarray, faces: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Vertices that some of the ``faces`` use, and these faces."""
    used = np.zeros(len(vertices), dtype=bool)
    for part in faces:
        used[part.ravel()] = True
    place = np.cumsum(used) - 1
    return vertices[used], [place[part] for part in faces]


def check_size(name: str, vertices: np.ndarray, unit_scale: float = 1.0) -> None:
    """Check that vertices (n, 3) are those of a tool; what is not finite is no matter of this.

    Args:
        name: of the mesh, for messages.
        vertices: in units of the file.
        unit_scale: metres per unit.

    Raises:
        InputError: it is larger or smaller than any tool.
    """
    if len(vertices) == 0 or not np.all(np.isfinite(vertices)):
        return  # reported by checked_triangles
    size = unit_scale * float(np.ptp(vertices, axis=0).max())
    if size > LARGEST_SIZE:
        raise InputError(
            f"{name} is {size:.4g} m across, above {LARGEST_SIZE:g} m: it is probably in millimetres and 1000 times "
            f"too big. Give {unit_wish(1.0e-3)} for millimetres."
        )
    if size < SMALLEST_SIZE:
        raise InputError(
            f"{name} is {size:.4g} m across, below {SMALLEST_SIZE:g} m: its unit seems too small. Give "
            f"{unit_wish(1.0)} for metres, {unit_wish(1.0e-3)} for millimetres."
        )
