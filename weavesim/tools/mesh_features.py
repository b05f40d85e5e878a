"""Features of a mesh that decide how finely a sheet must be meshed: fillets, sharp edges, and slender bodies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .mesh_repair import diagonal, edge_products
from .mesh_topology import neighbours

# Edges sharper than this [rad] are real edges, not between the facets of a fillet.
SHARP = math.radians(50.0)
# Faces whose curvature is estimated at most; of larger meshes a random part stands for all.
CURVATURE_FACE_COUNT = 50_000
# Parts whose silhouettes are drawn at most.
LARGEST_PART_COUNT = 50
# Pixels across the smaller side of a silhouette, and in all.
SILHOUETTE_WIDTH = 400
SILHOUETTE_COUNT = 1_000_000


def face_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (m, 3) and areas (m,) of the faces."""
    product = edge_products(vertices, faces)
    x, y, z = product
    length = np.sqrt(x * x + y * y + z * z)
    least, normal = np.maximum(length, 1e-300), np.empty((len(faces), 3))
    for k in range(3):
        np.divide(product[k], least, out=normal[:, k])
    return normal, 0.5 * length


class Facets(NamedTuple):
    """What several features of a mesh are made from.

    Attributes:
        normal: of each face, (m, 3).
        area: of each face, (m,) [m^2].
        pairs: edges that two faces share, see ``neighbours``.
    """

    normal: np.ndarray
    area: np.ndarray
    pairs: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray) -> Facets:
        """Of the faces (m, 3) of ``vertices`` (n, 3) [m]."""
        return cls(*face_normals(vertices, faces), neighbours(faces))


def sharp_edges(vertices: np.ndarray, faces: np.ndarray, facets: Facets | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Convex sharp edges: the vertices of each (k, 2), and the normals of its two faces (k, 2, 3).

    Neither a border nor the bottom of a groove: a sheet is not bent around those.
    """
    normal, _, pairs = facets or Facets.of(vertices, faces)
    one, other = pairs[:, 0] // 3, pairs[:, 1] // 3
    sharp = np.einsum("ij,ij->i", normal[one], normal[other]) < math.cos(SHARP)
    pairs, one, other = pairs[sharp], one[sharp], other[sharp]
    # convex: the other face's far corner lies behind this face
    far = faces[other, (pairs[:, 1] % 3 + 2) % 3]
    start = faces[one, pairs[:, 0] % 3]
    end = faces[one, (pairs[:, 0] % 3 + 1) % 3]
    convex = np.einsum("ij,ij->i", vertices[far] - vertices[start], normal[one]) < 0.0
    return np.column_stack([start, end])[convex], np.stack([normal[one], normal[other]], axis=1)[convex]


def fillet_radius(vertices: np.ndarray, faces: np.ndarray, facets: Facets | None = None) -> float:
    """Area-weighted 5th percentile of the convex fillet radii [m]; infinite if nothing is rounded.

    From the second fundamental form per face that best fits the rotation of the vertex normals along its three edges.
    Sharp edges are ignored.
    """
    facets = facets or Facets.of(vertices, faces)
    normal, area, _ = facets
    usable = _rounded_faces(len(vertices), faces, facets)
    if len(usable) > CURVATURE_FACE_COUNT:
        usable = np.sort(np.random.default_rng(0).choice(usable, CURVATURE_FACE_COUNT, replace=False))
    if not len(usable):
        return math.inf
    curvature = _largest_curvature(vertices, faces[usable], normal[usable], _vertex_normals(vertices, faces, normal))
    convex = curvature > 0.5 / diagonal(vertices)
    if not np.any(convex):
        return math.inf
    radius, weight = 1.0 / curvature[convex], area[usable][convex]
    order = np.argsort(radius)
    share = np.cumsum(weight[order]) / weight.sum()
    return float(radius[order][np.searchsorted(share, 0.05)])


def convex_radii(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Smallest convex radius of each face, as ``fillet_radius`` estimates it, (m,) [m].

    Infinite where a face is flat or hollow, and beside sharp edges.
    """
    facets = Facets.of(vertices, faces)
    normal = facets.normal
    usable = _rounded_faces(len(vertices), faces, facets)
    radius = np.full(len(faces), math.inf)
    if len(usable):
        vertex_normal = _vertex_normals(vertices, faces, normal)
        curvature = _largest_curvature(vertices, faces[usable], normal[usable], vertex_normal)
        convex = curvature > 0.5 / diagonal(vertices)
        radius[usable[convex]] = 1.0 / curvature[convex]
    return radius


def _rounded_faces(vertex_count: int, faces: np.ndarray, facets: Facets) -> np.ndarray:
    """Faces whose curvature can be estimated, (k,): a vertex at a sharp edge has no normal, and its faces none."""
    normal, area, pairs = facets
    pairs = pairs // 3
    sharp = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]]) < math.cos(SHARP)
    rounded_vertex = np.ones(vertex_count, dtype=bool)
    rounded_vertex[faces[np.unique(pairs[sharp])].ravel()] = False
    return np.flatnonzero(np.all(rounded_vertex[faces], axis=1) & (area > 1e-6 * area.max()))


def _vertex_normals(vertices: np.ndarray, faces: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Normals of the vertices, weighted with the angles of their faces."""
    result = np.zeros_like(vertices)
    for k in range(3):
        corner = vertices[faces[:, k]]
        u, v = vertices[faces[:, (k + 1) % 3]] - corner, vertices[faces[:, (k + 2) % 3]] - corner
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        for axis in range(3):
            result[:, axis] += np.bincount(faces[:, k], angle * normal[:, axis], minlength=len(vertices))
    return result / np.maximum(np.linalg.norm(result, axis=1, keepdims=True), 1e-30)


def _largest_curvature(
    vertices: np.ndarray, faces: np.ndarray, normal: np.ndarray, vertex_normal: np.ndarray
) -> np.ndarray:
    """Largest principal curvature of each face [1/m], positive where convex."""
    corners = vertices[faces]
    axis = corners[:, 1] - corners[:, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    other = np.cross(normal, axis)
    rows, right = [], []
    for k in range(3):
        edge = corners[:, (k + 1) % 3] - corners[:, k]
        turn = vertex_normal[faces[:, (k + 1) % 3]] - vertex_normal[faces[:, k]]
        s, t = np.einsum("ij,ij->i", edge, axis), np.einsum("ij,ij->i", edge, other)
        zero = np.zeros_like(s)
        rows += [np.stack([s, t, zero], axis=-1), np.stack([zero, s, t], axis=-1)]
        right += [np.einsum("ij,ij->i", turn, axis), np.einsum("ij,ij->i", turn, other)]
    matrix, turned = np.stack(rows, axis=1), np.stack(right, axis=1)
    xx, xy, yy = np.einsum("ijk,ik->ij", np.linalg.pinv(matrix), turned).T
    return 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)


def width_along(vertices: np.ndarray, faces: np.ndarray, axis: np.ndarray) -> float:
    """Diameter of the largest circle in the mesh's silhouette seen along ``axis`` [m].

    A body whose width is below the sheet's elements may pass between its nodes. Drawn in pixels, it is exact to two
    per cent for slender bodies.
    """
    from PIL import Image, ImageDraw
    from scipy.ndimage import distance_transform_edt

    used, faces = np.unique(faces, return_inverse=True)
    faces = faces.reshape(-1, 3)
    flat = _across(vertices[used], axis)
    size = np.ptp(flat, axis=0)
    pixel = max(float(size.min()) / SILHOUETTE_WIDTH, math.sqrt(float(size[0] * size[1]) / SILHOUETTE_COUNT))
    if not pixel > 1e-9:
        return 0.0
    # a margin of one pixel: the distance is that to the next empty pixel
    places = (flat - flat.min(axis=0)) / pixel + 1.0
    columns, rows = (int(length / pixel) + 3 for length in size)
    picture = Image.new("1", (columns, rows))
    draw = ImageDraw.Draw(picture)
    corners = places[faces]
    large = np.ptp(corners, axis=1).max(axis=1) > 0.5
    for triangle in corners[large].reshape(-1, 6).tolist():
        draw.polygon(triangle, fill=1)
    filled = np.array(picture)
    cells = np.floor(corners[~large].reshape(-1, 2)).astype(np.int64)
    filled[cells[:, 1], cells[:, 0]] = True
    # the nearest empty pixel lies half a pixel beyond the outline, on either side
    return min((2.0 * float(distance_transform_edt(filled).max()) - 1.0) * pixel, float(size.min()))


def smallest_width(vertices: np.ndarray, parts: list[np.ndarray], axis: np.ndarray) -> float:
    """Least ``width_along`` of the parts; of many, only those with the smallest silhouettes are drawn [m]."""
    unit = axis / np.linalg.norm(axis)
    flat = vertices - np.outer(vertices @ unit, unit)
    size = [float(np.linalg.norm(np.ptp(flat[part.ravel()], axis=0))) for part in parts]
    drawn = np.argsort(size, kind="stable")[:LARGEST_PART_COUNT]
    return min(width_along(vertices, parts[k], axis) for k in drawn)


def _across(vertices: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Coordinates (n, 2) across ``axis``, the first along the longest side of their convex hull's narrowest box."""
    from scipy.spatial import ConvexHull, QhullError

    unit = axis / np.linalg.norm(axis)
    first = np.cross(unit, np.eye(3)[np.argmin(np.abs(unit))])
    first /= np.linalg.norm(first)
    flat = vertices @ np.column_stack([first, np.cross(unit, first)])
    try:
        corners = flat[ConvexHull(flat).vertices]
    except QhullError:  # all in one line
        return flat
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    widths = np.array([np.ptp(corners @ (-y, x)) for x, y in along])
    x, y = along[np.argmin(widths)]
    return flat @ np.array([[x, -y], [y, x]])


def points_near(vertices: np.ndarray, faces: np.ndarray, count: int, offset: float) -> np.ndarray:
    """Random points (count, 3) up to ``offset`` [m] off the surface, evenly over its area."""
    random = np.random.default_rng(0)
    area = face_normals(vertices, faces)[1]
    face = faces[random.choice(len(area), size=count, p=area / area.sum())]
    weight = random.dirichlet([1.0, 1.0, 1.0], size=count)
    points = np.einsum("ij,ijk->ik", weight, vertices[face])
    direction = random.normal(size=points.shape)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return points + offset * random.random((count, 1)) * direction
