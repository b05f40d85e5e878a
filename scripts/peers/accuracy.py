"""Accuracy measures of a final state, from its nodes alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .problem import Problem


def measures(problem: Problem, position: np.ndarray, velocity: np.ndarray) -> dict[str, Any]:
    """Accuracy measures of a final state, from its nodes alone.

    Args:
        position, velocity: (node_count, 3) [m], [m/s].

    Returns:
        ``finite``, and if it is: ``largest_edge_stretch`` and ``mean_edge_stretch`` (elongation over rest length of
        the edges along the yarns; the mean is of absolute values), ``largest_yarn_stretch`` (of whole rows of edges
        from rim to rim), ``penetration`` of the lower face into the ball at the deepest node [m], ``corner_drop``, mean
        height that the corners lost [m], ``kinetic_energy`` [J].
    """
    if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
        return {"finite": False}
    side = math.isqrt(len(problem.quads)) + 1
    now, rest = (nodes.astype(np.float64).reshape(side, side, 3) for nodes in (position, problem.position))
    # rows of edges: (edge, yarn) of one family, then the other
    length, rest_length = (
        np.hstack([np.linalg.norm(np.diff(nodes, axis=0), axis=2), np.linalg.norm(np.diff(nodes, axis=1), axis=2).T])
        for nodes in (now, rest)
    )
    edge_stretch = length / rest_length - 1.0
    share = np.bincount(problem.quads.ravel(), minlength=len(position))
    mass = 0.25 * problem.areal_density * problem.cell_area * share
    gap = np.linalg.norm(now, axis=2).min() - problem.radius - 0.5 * problem.thickness
    return {
        "finite": True,
        "largest_edge_stretch": float(edge_stretch.max()),
        "mean_edge_stretch": float(np.abs(edge_stretch).mean()),
        "largest_yarn_stretch": float((length.sum(axis=0) / rest_length.sum(axis=0)).max() - 1.0),
        "penetration": max(0.0, -float(gap)),
        "corner_drop": float((rest - now)[[0, 0, -1, -1], [0, -1, 0, -1], 2].mean()),
        "kinetic_energy": float(0.5 * (mass * (velocity.astype(np.float64) ** 2).sum(axis=1)).sum()),
    }
