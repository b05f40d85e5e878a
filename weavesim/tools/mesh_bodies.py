"""Closed bodies and open sheets of a triangle mesh: told apart, oriented each by itself, and united."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from .mesh_duplicates import check_fins
from .mesh_features import face_normals
from .mesh_repair import diagonal
from .mesh_topology import (
    Contacts,
    directed_edges,
    edge_keys,
    labels,
    neighbours,
    odd_edges,
    oriented,
    place,
    seam_contacts,
)

if TYPE_CHECKING:
    import manifold3d

# A closed body of less volume than this share of its area times its size encloses nothing.
LEAST_VOLUME = 1e-8
# Parts smaller than this share of the largest, and farther from it than its size, are far flecks.
FLECK = 0.05
# Points of a body that are looked for in another, and faces times points that are held at once.
PROBE_COUNT = 12
PROBE_CHUNK = 4_000_000


@dataclass
class Parts:
    """Faces of a mesh, told apart.

    Attributes:
        bodies: faces (m, 3) of each closed body with its cavities, oriented outwards.
        sheet: faces (m, 3) of all open patches, neighbours oriented alike.
        patch: number of the connected patch of each face of the sheet.
        border: open edges (k, 2) of the sheet in the direction of its faces.
        given: the faces of the sheet as they were given, (m, 3).
        turned: faces (k, 3) of closed bodies that were given the other way round than the rest of theirs.
        notes: what was found and changed.
    """

    bodies: list[np.ndarray]
    sheet: np.ndarray
    patch: np.ndarray
    border: np.ndarray
    given: np.ndarray
    turned: np.ndarray
    notes: list[str] = field(default_factory=list)


def parts_of(name: str, vertices: np.ndarray, faces: np.ndarray, tolerance: float) -> Parts:
    """Tell closed bodies and open patches apart; borders closer than ``tolerance`` [m] are a seam.

    Raises:
        InputError: a surface is one-sided, three walls meet, or a closed body encloses nothing.
    """
    given = faces
    pairs = neighbours(faces)
    edges = directed_edges(faces)
    agree = edges[pairs[:, 0], 0] != edges[pairs[:, 1], 0]
    faces, component, one_sided = oriented(faces, pairs // 3, agree)
    if np.any(one_sided):
        where = place(vertices[faces[np.argmax(one_sided)]].mean(axis=0))
        raise InputError(
            f"{name}: the surface about {where} has one side only, like a Moebius strip, so that nothing is behind "
            "it; export the tool as a closed body or as a sheet with two sides."
        )
    edges = directed_edges(faces)
    rows = odd_edges(edges, component)
    contacts = seam_contacts(vertices, edges[rows], tolerance)
    seam = np.zeros(len(rows), dtype=bool)
    seam[contacts.edge] = True
    border = edges[rows[~seam]]
    group = labels(int(component.max()) + 1, component[rows // 3][np.column_stack([contacts.edge, contacts.other])])[
        component
    ]
    is_open = np.zeros(group.max() + 1, dtype=bool)
    is_open[group[rows[~seam] // 3]] = True
    closed_face = ~is_open[group]
    faces = _across_seams(faces, rows, contacts, component, closed_face)
    edges = directed_edges(faces)
    _check_walls(name, vertices, edges[rows], group[rows // 3], is_open)
    check_fins(name, vertices, border, edges[np.repeat(closed_face, 3)])
    rows_of_bodies = _rows_of(group, closed_face)
    bodies = [faces[rows] for rows in rows_of_bodies]
    odd = [_odd_ones(given[rows], body) for rows, body in zip(rows_of_bodies, bodies, strict=True)]
    notes: list[str] = []
    outwards = [_outwards(name, vertices, body) for body in bodies]
    if len(bodies) > 1:
        turned_count = sum(body is not given for body, given in zip(outwards, bodies, strict=True))
        notes.append(
            f"{name}: {len(bodies)} closed bodies"
            + (f", {turned_count} of them faced inwards: turned" if turned_count else "")
        )
    bodies = _nested(name, vertices, outwards, notes)
    odd_ones = np.concatenate([np.empty((0, 3), dtype=faces.dtype), *odd])
    return Parts(bodies, faces[~closed_face], component[~closed_face], border, given[~closed_face], odd_ones, notes)


def _odd_ones(given: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Faces that were ``given`` (m, 3) the other way round than most of a body that is oriented alike, (k, 3)."""
    other = given[:, 0] != body[:, 0]
    return body[other if 2 * np.count_nonzero(other) <= len(other) else ~other]


def _boxes(vertices: np.ndarray, parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners of the box around each part (m, 3) of a mesh, (part_count, 3) each [m]."""
    corners = [vertices[part.ravel()] for part in parts]
    return np.array([points.min(axis=0) for points in corners]), np.array([points.max(axis=0) for points in corners])


def _rows_of(group: np.ndarray, wanted: np.ndarray) -> list[np.ndarray]:
    """Rows of each group, in the order of their first row, among the wanted ones."""
    rows = np.flatnonzero(wanted)
    if not len(rows):
        return []
    _, first, number = np.unique(group[rows], return_index=True, return_inverse=True)
    number = np.argsort(np.argsort(first))[number]
    order = np.argsort(number, kind="stable")
    return np.split(rows[order], np.flatnonzero(np.diff(number[order])) + 1)


def _across_seams(
    faces: np.ndarray, rows: np.ndarray, contacts: Contacts, component: np.ndarray, closed_face: np.ndarray
) -> np.ndarray:
    """Closed bodies of several patches, which are oriented alike where their seams allow it."""
    edge, other = component[rows[contacts.edge] // 3], component[rows[contacts.other] // 3]
    # where more than two patches meet, none are neighbours
    _, number, counts = np.unique(edge_keys(directed_edges(faces)[rows]), return_inverse=True, return_counts=True)
    two = counts[number] <= 2
    used = closed_face[rows[contacts.edge] // 3] & (edge != other) & two[contacts.edge] & two[contacts.other]
    if not np.any(used):
        return faces
    count = int(component.max()) + 1
    # each patch as one item, turned as a whole
    stand_in = np.tile(np.arange(3), (count, 1))
    turned, _, one_sided = oriented(stand_in, np.column_stack([edge, other])[used], ~contacts.along[used])
    flip = (turned[:, 0] != 0) & ~one_sided
    return np.where(flip[component][:, None], faces[:, ::-1], faces)


def _check_walls(name: str, vertices: np.ndarray, edges: np.ndarray, group: np.ndarray, is_open: np.ndarray) -> None:
    """Refuse bodies where more than two surfaces meet and do not bound each other, as at an inner wall."""
    key, first, number, counts = np.unique(edge_keys(edges), return_index=True, return_inverse=True, return_counts=True)
    balance = np.bincount(number, np.where(edges[:, 0] < edges[:, 1], 1, -1))
    bad = first[(counts > 2) & (balance != 0)]
    bad = bad[~is_open[group[bad]]]
    if len(bad):
        where = place(vertices[edges[bad[0]]].mean(axis=0))
        raise InputError(
            f"{name}: more than two surfaces meet at {len(bad)} edges, one at {where}, and inside and outside cannot "
            "be told; remove inner walls, and export each body by itself, one after the other."
        )


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Signed volume of a closed body, positive where its faces face outwards [m^3]."""
    p, q, r = (vertices[faces[:, k]] - vertices[faces[0, 0]] for k in range(3))
    return float(np.einsum("ij,ij->", p, np.cross(q, r))) / 6.0


def _outwards(name: str, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    enclosed = volume(vertices, faces)
    corners = vertices[faces.ravel()]
    if abs(enclosed) < LEAST_VOLUME * diagonal(corners) * float(face_normals(vertices, faces)[1].sum()):
        raise InputError(
            f"{name}: the {len(faces)} triangles about {place(corners.mean(axis=0))} are closed, but enclose nothing: "
            "they are a sheet with two coincident sides; export one side of it, or a body with a thickness."
        )
    return faces if enclosed > 0.0 else faces[:, ::-1]


def _nested(name: str, vertices: np.ndarray, bodies: list[np.ndarray], notes: list[str]) -> list[np.ndarray]:
    """Bodies with those inside them as their cavities, and bodies in cavities as bodies again."""
    if len(bodies) < 2:
        return bodies
    low, high = _boxes(vertices, bodies)
    around: list[list[int]] = []
    for k, body in enumerate(bodies):
        outer = np.flatnonzero(np.all(low <= low[k], axis=1) & np.all(high >= high[k], axis=1))
        around.append([j for j in outer.tolist() if j != k and _lies_within(vertices, body, bodies[j])])
    depth = np.array([len(outer) for outer in around])
    result: dict[int, list[np.ndarray]] = {k: [body] for k, body in enumerate(bodies) if depth[k] % 2 == 0}
    for k in np.flatnonzero(depth % 2 == 1).tolist():
        parent = next(j for j in around[k] if depth[j] == depth[k] - 1)
        result[parent].append(bodies[k][:, ::-1])
    cavities = int(np.count_nonzero(depth % 2))
    if cavities:
        k = int(np.argmax(depth % 2))
        where = place(0.5 * (low[k] + high[k]))
        notes.append(f"{name}: {cavities} closed surfaces lie inside another and are cavities of it, one about {where}")
    if np.any((depth > 0) & (depth % 2 == 0)):
        notes.append(f"{name}: {np.count_nonzero((depth > 0) & (depth % 2 == 0))} bodies lie in such cavities")
    return [np.concatenate(surfaces) for surfaces in result.values()]


def _lies_within(vertices: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> bool:
    """Whether all of some points of a closed surface lie inside another."""
    step = max(1, len(inner) // PROBE_COUNT)
    points = vertices[inner[::step]].mean(axis=1)
    return bool(np.all(winding_numbers(vertices, outer, points) > 0.75))


def winding_numbers(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How often a surface winds around each point (n, 3): one inside a closed body that faces outwards, else zero."""
    total = np.zeros(len(points))
    size = max(1, PROBE_CHUNK // max(len(points), 1))
    for first in range(0, len(faces), size):
        a, b, c = (vertices[faces[first : first + size, k]][None] - points[:, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
        over = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
        under = la * lb * lc + lc * np.einsum("ijk,ijk->ij", a, b)
        under += la * np.einsum("ijk,ijk->ij", b, c) + lb * np.einsum("ijk,ijk->ij", c, a)
        total += np.arctan2(over, under).sum(axis=1)
    return total / (2.0 * np.pi)


def united(vertices: np.ndarray, solids: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray], int, int]:
    """Solids that meet made one, without the surfaces inside them.

    Returns:
        vertices; faces of each solid; how many were united; how many of these could not be and remain as given.
    """
    low, high = _boxes(vertices, solids)
    slack = 1e-6 * float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    meets = [
        np.flatnonzero(np.all((low <= high[k] + slack) & (high >= low[k] - slack), axis=1)) for k in range(len(low))
    ]
    links = np.concatenate([np.column_stack([np.full(len(near), k), near]) for k, near in enumerate(meets)])
    cluster = labels(len(solids), links)
    result: list[np.ndarray] = []
    joined = failed = 0
    for members in _rows_of(cluster, np.ones(len(solids), dtype=bool)):
        union = None
        if len(members) > 1:
            joined += len(members)
            union = _boolean_union(vertices, [solids[k] for k in members])
            failed += 0 if union else len(members)
        if union is None:
            result += [solids[k] for k in members]
        else:
            result.append(union[1] + len(vertices))
            vertices = np.concatenate([vertices, union[0]])
    return vertices, result, joined, failed


def _boolean_union(vertices: np.ndarray, solids: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertices and faces of the union; None if a solid is no manifold."""
    import manifold3d

    given = []
    for faces in solids:
        used, index = np.unique(faces, return_inverse=True)
        given.append(_manifold(vertices[used], index.reshape(-1, 3)))
    if not all(map(_is_solid, given)):
        return None
    union = manifold3d.Manifold.batch_boolean(given, manifold3d.OpType.Add)
    return _triangles_of(union) if _is_solid(union) else None


def simplified(
    vertices: np.ndarray, faces: np.ndarray, tolerances: Sequence[float]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Closed bodies of fewer triangles, within each of rising tolerances [m]; as given if no manifold."""
    body = _manifold(vertices, faces)
    result = [(vertices, faces)]
    for tolerance in tolerances:
        body = body.simplify(tolerance)
        result.append(_triangles_of(body) if _is_solid(body) else result[-1])
    return result[1:]


def _manifold(vertices: np.ndarray, faces: np.ndarray) -> manifold3d.Manifold:
    import manifold3d

    mesh = manifold3d.Mesh64(
        vert_properties=np.ascontiguousarray(vertices), tri_verts=np.ascontiguousarray(faces.astype(np.uint64))
    )
    return manifold3d.Manifold(mesh)


def _is_solid(body: manifold3d.Manifold) -> bool:
    import manifold3d

    return body.status() == manifold3d.Error.NoError and not body.is_empty()


def _triangles_of(body: manifold3d.Manifold) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) [m] and faces (m, 3)."""
    mesh = body.to_mesh64()
    return np.array(mesh.vert_properties[:, :3], dtype=np.float64), np.array(mesh.tri_verts, dtype=np.int64)


def far_flecks(name: str, vertices: np.ndarray, parts: list[np.ndarray]) -> list[str]:
    """Notes of parts that are small, and farther from the largest one than that is long: probably leftovers."""
    if len(parts) < 2:
        return []
    low, high = _boxes(vertices, parts)
    size = np.linalg.norm(high - low, axis=1)
    main = int(np.argmax(size))
    gap = np.linalg.norm(np.maximum(np.maximum(low - high[main], low[main] - high), 0.0), axis=1)
    return [
        f"{name}: {len(parts[k])} triangles, {1e3 * size[k]:.3g} mm across, lie far from the rest, about "
        f"{place(0.5 * (low[k] + high[k]))}: are they part of the tool?"
        for k in np.flatnonzero((size < FLECK * size[main]) & (gap > size[main]))
    ]
