"""Signed distances by other means than the code under test."""

import numpy as np


def box_distance(points, size, centre=(0.0, 0.0, 0.0)):
    """Exact signed distance of a box along the axes."""
    over = np.abs(points - np.array(centre)) - 0.5 * np.array(size)
    return np.linalg.norm(np.maximum(over, 0.0), axis=1) + np.minimum(over.max(axis=1), 0.0)


def union_distance(points, boxes):
    """Of boxes (size, centre): exact outside, a bound inside."""
    return np.min([box_distance(points, size, centre) for size, centre in boxes], axis=0)


def triangle_distance(points, vertices, faces):
    """Unsigned distance of points (n, 3) to triangles, by brute force: to faces, edges and corners."""
    result = np.full(len(points), np.inf)
    for face in faces:
        a, b, c = vertices[face]
        normal = np.cross(b - a, c - a)
        normal = normal / np.linalg.norm(normal)
        height = (points - a) @ normal
        foot = points - height[:, None] * normal
        inside = np.ones(len(points), dtype=bool)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.cross(q - p, foot - p) @ normal >= 0.0
            share = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0)
            result = np.minimum(result, np.linalg.norm(points - p - share[:, None] * (q - p), axis=1))
        result = np.where(inside, np.minimum(result, np.abs(height)), result)
    return result
