"""Weld, orient, mirror and close the triangle mesh of a tool."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import InputError
from ..ranges import QUANTITIES

# Tools are between 2 mm and 20 m across; anything else is a unit error.
LARGEST_SIZE = QUANTITIES["length"].legal[1]
SMALLEST_SIZE = 0.002

# Vertices closer than this share of the size are merged; borders closer than the second are a seam, not a border.
WELD = 1e-6
SEAM = 1e-4


def checked_triangles(name: str, vertices: Any, faces: Any) -> tuple[np.ndarray, np.ndarray]:
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
    used, faces = np.unique(faces, return_inverse=True)
    vertices = vertices[used]
    check_size(name, vertices)
    return vertices, faces.reshape(-1, 3)


def triangle_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1)


def mirrored_mesh(
    name: str, vertices: np.ndarray, faces: np.ndarray, plane: str, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
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
    """Merge vertices in the same cell of a fine grid."""
    cells = np.round(vertices / tolerance).astype(np.int64)
    _, first, index = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return vertices[first], index.reshape(-1)[faces]


def _directed_edges(faces: np.ndarray) -> np.ndarray:
    """(3 m, 2): the edges of face i are rows 3 i to 3 i + 2."""
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)


def neighbours(faces: np.ndarray) -> np.ndarray:
    """Pairs of edges (rows of ``_directed_edges``) that two triangles share, (k, 2)."""
    key = np.sort(_directed_edges(faces), axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    same = np.all(key[order[1:]] == key[order[:-1]], axis=1)
    # where more than two triangles meet, none are neighbours
    twice = np.append(same[1:], False) | np.append(False, same[:-1])
    pick = np.flatnonzero(same & ~twice)
    return np.column_stack([order[pick], order[pick + 1]])


def oriented(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces oriented consistently with their neighbours, and the number of each face's connected component."""
    edges = _directed_edges(faces)
    pairs = neighbours(faces)
    agree = edges[pairs[:, 0], 0] != edges[pairs[:, 1], 0]
    links: list[list[tuple[int, bool]]] = [[] for _ in range(len(faces))]
    for (a, b), same in zip((pairs // 3).tolist(), agree.tolist(), strict=True):
        links[a].append((b, same))
        links[b].append((a, same))
    component = np.full(len(faces), -1)
    flip = np.zeros(len(faces), dtype=bool)
    count = 0
    for start in range(len(faces)):
        if component[start] >= 0:
            continue
        component[start] = count
        waiting = [start]
        while waiting:
            a = waiting.pop()
            for b, same in links[a]:
                if component[b] < 0:
                    component[b] = count
                    flip[b] = flip[a] != (not same)
                    waiting.append(b)
        count += 1
    faces = faces.copy()
    faces[flip] = faces[flip][:, ::-1]
    return faces, component


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


def open_border(vertices: np.ndarray, faces: np.ndarray, tolerance: float) -> np.ndarray:
    """Edges (k, 2) that have no neighbour, not even one that merely touches as at a seam of two patches."""
    key, counts = np.unique(np.sort(_directed_edges(faces), axis=1), axis=0, return_counts=True)
    border = key[counts == 1]
    start, end = vertices[border[:, 0]], vertices[border[:, 1]]
    middle, along = 0.5 * (start + end), end - start
    square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
    seam = np.zeros(len(border), dtype=bool)
    for k in range(len(border)):
        share = np.clip(np.einsum("ij,ij->i", middle[k] - start, along) / square, 0.0, 1.0)
        gap = np.linalg.norm(start + share[:, None] * along - middle[k], axis=1)
        gap[k] = np.inf
        seam[k] = gap.min() < min(tolerance, 0.4 * math.sqrt(square[k]))
    return border[~seam]


def directed_border(border: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Border edges in the direction of their faces."""
    edges = _directed_edges(faces)
    count = int(faces.max()) + 1
    low, high = edges.min(axis=1), edges.max(axis=1)
    return edges[np.isin(low * count + high, border[:, 0] * count + border[:, 1])]


def extruded(
    vertices: np.ndarray, faces: np.ndarray, border: np.ndarray, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The body swept by a sheet moved by ``shift``: the sheet, its reversed copy, and walls at the border."""
    count = len(vertices)
    a, b = border[:, 0], border[:, 1]
    walls = np.concatenate([np.column_stack([b, a, a + count]), np.column_stack([b, a + count, b + count])])
    return np.concatenate([vertices, vertices + shift]), np.concatenate([faces, faces[:, ::-1] + count, walls])


def check_size(name: str, vertices: np.ndarray, unit_scale: float = 1.0) -> None:
    if len(vertices) == 0 or not np.all(np.isfinite(vertices)):
        return  # reported by checked_triangles
    size = unit_scale * float(np.ptp(vertices, axis=0).max())
    if size > LARGEST_SIZE:
        raise InputError(
            f"{name} is {size:.4g} m across, above {LARGEST_SIZE:g} m: it is probably in millimetres and 1000 times "
            "too big. Give unit_scale=0.001 for millimetres."
        )
    if size < SMALLEST_SIZE:
        raise InputError(
            f"{name} is {size:.4g} m across, below {SMALLEST_SIZE:g} m: "
            f"unit_scale, the metres per unit of the file, is {unit_scale:g} and seems too small."
        )
