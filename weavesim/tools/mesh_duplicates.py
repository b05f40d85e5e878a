"""Triangles that a mesh has more than once, and bodies that its file lists one after the other."""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from .mesh_topology import directed_edges, edge_keys, labels, odd_edges, place

# Three numbers below this are one in 63 bits.
LARGEST_CUBE = 2**21


def separated(name: str, vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Triangles without duplicates, and vertices of its own for each body that the mesh lists as one.

    Bodies that touch share edges, and nothing in these tells which faces belong together; but files list one body
    after the other.

    Returns:
        vertices, faces, and notes of what was left out.
    """
    triangle, run = _triangle_numbers(faces), _closed_runs(faces)
    # a body has no triangle twice; what belongs to none, open or repeated, is loose
    count = int(triangle.max()) + 1
    distinct, counts = np.bincount(_distinct(run * count + triangle)[0] // count), np.bincount(run)
    whole = (distinct == counts) & (counts >= 4)
    alone, bodies = whole[run], np.flatnonzero(whole)
    alone[run == run[-1]] &= not _is_open(faces[run == run[-1]])
    removed = 0
    some_repeated = count < len(faces)
    # bodies that repeat another
    if some_repeated and len(bodies) > 1:
        content = np.zeros(len(counts), dtype=np.uint64)
        np.add.at(content, run, _mixed(triangle))
        _, first = np.unique(content[bodies], return_index=True)
        again = np.isin(run, np.delete(bodies, first)) & alone
        removed = int(again.sum())
        faces, triangle, run, alone = (values[~again] for values in (faces, triangle, run, alone))
    if some_repeated:
        repeated = ~alone & np.isin(triangle, triangle[alone])
        removed += int(repeated.sum())
        faces, run, alone = (values[~repeated] for values in (faces, run, alone))
    notes = [f"{name}: {removed} duplicate triangles removed"] if removed else []
    loose = faces[~alone]
    if len(loose):
        if some_repeated:
            loose, found = without_duplicates(name, loose)
            notes += found
        edges = directed_edges(loose)
        border = edges[odd_edges(edges, np.zeros(len(loose), dtype=int))]
        check_fins(name, vertices, border, directed_edges(faces[alone]))
    # vertices of a body of its own
    own, index = np.unique(np.repeat(run[alone], 3) * len(vertices) + faces[alone].ravel(), return_inverse=True)
    index = index.reshape(-1, 3) + len(vertices)
    return (
        np.concatenate([vertices, vertices[own % len(vertices)]]),
        np.concatenate([index, loose]).astype(np.int64, copy=False),
        notes,
    )


def _mixed(number: np.ndarray) -> np.ndarray:
    """Numbers whose sum tells sets of triangles apart."""
    return np.random.default_rng(0).integers(0, 2**63, int(number.max()) + 1, dtype=np.uint64)[number]


def _is_open(faces: np.ndarray) -> bool:
    return bool(np.any(_distinct(edge_keys(directed_edges(faces)))[1] % 2))


def _distinct(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """``np.unique`` with counts, by sorting: of millions of integers in a quarter of the time of hashing them."""
    ordered = np.sort(numbers)
    start = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)])
    return ordered[start], np.diff(np.append(start, len(ordered)))


def _closed_runs(faces: np.ndarray) -> np.ndarray:
    """Number of the run of each face: a run ends where an even number of its faces share each edge, or at the end."""
    key = edge_keys(directed_edges(faces))
    order = np.argsort(key, kind="stable")
    start = np.append(True, key[order[1:]] != key[order[:-1]])
    index = np.arange(len(key))
    nth = index - np.maximum.accumulate(np.where(start, index, 0))
    change = np.empty(len(key), dtype=np.int64)
    change[order] = np.where(nth % 2 == 0, 1, -1)  # opens an edge, or closes it
    ends = np.cumsum(change.reshape(-1, 3).sum(axis=1)) == 0
    return np.cumsum(ends) - ends


def _triangle_numbers(faces: np.ndarray) -> np.ndarray:
    """A number for each triangle, the same for any order of its corners."""
    corners = np.sort(faces, axis=1).astype(np.int64, copy=False)
    count = int(faces.max()) + 1
    if count < LARGEST_CUBE:
        key = (corners[:, 0] * count + corners[:, 1]) * count + corners[:, 2]
        return np.unique(key, return_inverse=True)[1]
    _, first_two = np.unique(corners[:, 0] * count + corners[:, 1], return_inverse=True)
    return np.unique(first_two * count + corners[:, 2], return_inverse=True)[1]


def without_duplicates(name: str, faces: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Each triangle once, (k, 3); none of a wall that two bodies share. And notes of what was left out."""
    _, first, group, counts = np.unique(
        _triangle_numbers(faces), return_index=True, return_inverse=True, return_counts=True
    )
    if len(first) == len(faces):
        return faces, []
    # corner order as an even or odd permutation of the sorted corners
    odd = (faces[:, 0] > faces[:, 1]) ^ (faces[:, 1] > faces[:, 2]) ^ (faces[:, 0] > faces[:, 2])
    odd_count = np.bincount(group, odd)
    two_sided = bool(np.all((odd_count > 0) & (odd_count < counts)))
    order = np.argsort(first)
    kept, counts = faces[first[order]], counts[order]
    notes = []
    wall = _shared_walls(kept, counts)
    if np.any(wall):
        notes.append(f"{name}: {int(wall.sum())} triangles between bodies that touch removed: they are one body")
    twice = int((counts - 1)[~wall].sum())
    if twice:
        notes.append(f"{name}: {twice} duplicate triangles removed" + (", all of other winding" if two_sided else ""))
    return kept[~wall], notes


def _shared_walls(faces: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Which of the faces, ``counts`` times in the mesh, are a wall between two bodies that share it."""
    multiple = counts > 1
    none = np.zeros(len(faces), dtype=bool)
    if np.all(multiple):
        return none
    _, edge = np.unique(edge_keys(directed_edges(faces)), return_inverse=True)
    edge = edge.reshape(-1, 3)
    of_multiple, of_single = (
        np.bincount(edge[kind].ravel(), minlength=edge.max() + 1) for kind in (multiple, ~multiple)
    )
    # patches of multiple faces end where a third face meets them; one that is closed is a body given twice
    inner = (of_multiple == 2) & (of_single == 0)
    patch = labels(len(faces), _linked(edge, inner[edge] & multiple[:, None]))
    rim = np.zeros(patch.max() + 1, dtype=bool)
    count = int(edge.max()) + 1
    of_patch, times = np.unique(np.repeat(patch, 3) * count + edge.ravel(), return_counts=True)
    rim[of_patch[times % 2 == 1] // count] = True
    wall = multiple & (counts % 2 == 0) & rim[patch]
    # a body is more than walls: where most faces are double, they are copies
    if not 0 < np.count_nonzero(wall) < 0.5 * len(faces):
        return none
    # only if what remains of the connected whole is closed
    whole = labels(len(faces), _linked(edge, np.ones_like(edge, dtype=bool)))
    left = np.bincount(edge[~wall].ravel(), minlength=edge.max() + 1)
    open_whole = np.zeros(whole.max() + 1, dtype=bool)
    open_whole[np.repeat(whole, 3)[(left[edge.ravel()] % 2) == 1]] = True
    return wall & ~open_whole[whole]


def _linked(edge: np.ndarray, use: np.ndarray) -> np.ndarray:
    """Pairs of faces that share an edge (numbers (m, 3)), among the edges to ``use``."""
    face, number = np.nonzero(use)[0], edge[use]
    order = np.argsort(number, kind="stable")
    face, number = face[order], number[order]
    same = number[1:] == number[:-1]
    return np.column_stack([face[:-1][same], face[1:][same]])


def check_fins(name: str, vertices: np.ndarray, border: np.ndarray, closed: np.ndarray) -> None:
    """Refuse a surface that begins at an edge of a closed body: it has no side of its own."""
    key = edge_keys(np.concatenate([border, closed]))
    attached = np.flatnonzero(np.isin(key[: len(border)], key[len(border) :]))
    if len(attached):
        where = place(vertices[border[attached[0]]].mean(axis=0))
        raise InputError(
            f"{name}: an open surface is attached to a closed body at {len(attached)} edges, one at {where}, so that "
            "inside and outside cannot be told; remove it, or give it a thickness."
        )
