"""What a mesh of quadrilaterals needs to be one sheet, and nodes that coincide without being shared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..input_files import unit_wish
from ..meshes.numbering import each_once
from ..ranges import QUANTITIES
from .topology import doubled_normals, part_of_nodes

if TYPE_CHECKING:
    from .blank import Blank

_LARGEST_EXTENT_M = QUANTITIES["length"].legal[1]
# Nodes closer than this share of the shortest edge coincide.
_COINCIDENT = 1.0e-3
# Elements meet at a place in fours; this many nodes there are a mistake.
_MOST_AT_ONE_PLACE = 64
# Allowed deviation from length one, and from the plane of the element; smallest sine of the angle between the yarns.
_UNIT_TOLERANCE = 1.0e-6
_PLANE_TOLERANCE = 1.0e-3
_LEAST_YARN_SINE = 1.0e-3
# More do not fit into the memory of any device [elements].
LARGEST_ELEMENT_COUNT = 2.0e7


def check_count(count: float, what: str) -> None:
    """Refuse to make a mesh that no machine can hold, before memory is taken for it.

    Raises:
        InputError: more than ``LARGEST_ELEMENT_COUNT`` elements.
    """
    if not count <= LARGEST_ELEMENT_COUNT:
        raise InputError(
            f"{what} divide the blank into about {count:,.0f}; at most {LARGEST_ELEMENT_COUNT:,.0f} are allowed: "
            "give larger elements"
        )


@dataclass(frozen=True)
class Names:
    """What messages call a mesh, its nodes and elements: by the file's numbers, or by rows counted from 0.

    Attributes:
        mesh: for the start of a message.
        nodes: numbers of the nodes, None for rows.
        elements: numbers of the elements, None for rows.
        elements_are: what these numbers count, such as lines of the file.
    """

    mesh: str = "blank mesh"
    nodes: np.ndarray | None = None
    elements: np.ndarray | None = None
    elements_are: str = "element"

    def of(self, nodes: np.ndarray, elements: np.ndarray) -> Names:
        """Those of some rows of nodes and elements; rows that have no numbers get them, counted from 1."""
        of_nodes = nodes + 1 if self.nodes is None else self.nodes[nodes]
        of_elements = elements + 1 if self.elements is None else self.elements[elements]
        return Names(self.mesh, of_nodes, of_elements, self.elements_are)

    def node(self, row: Any) -> int:
        """Number of the node in a row."""
        return int(row if self.nodes is None else self.nodes[row])

    def element(self, row: Any) -> str:
        """Number of the element in a row, and of what, for messages."""
        number = str(int(row if self.elements is None else self.elements[row]))
        return number if self.elements_are == "element" else f"of {self.elements_are} {number}"


ROWS = Names()


def check_arrays(position: np.ndarray, quads: np.ndarray, names: Names = ROWS) -> None:
    """Shapes, references and coordinates.

    Raises:
        InputError: one that is not as needed.
    """
    if position.ndim != 2 or position.shape[1] != 3 or quads.ndim != 2 or quads.shape[1:] != (4,) or not len(quads):
        raise InputError(
            f"{names.mesh}: nodes {position.shape} and elements {quads.shape}; (n, 3) and (m, 4), m > 0 are needed"
        )
    if quads.min() < 0 or quads.max() >= len(position):
        raise InputError(f"{names.mesh}: elements use nodes {quads.min()} to {quads.max()}; there are {len(position)}")
    if not np.all(np.isfinite(position)):
        row = int(np.argmin(np.all(np.isfinite(position), axis=1)))
        raise InputError(f"{names.mesh}: node {names.node(row)} is at {position[row]}; coordinates must be finite")
    extent = np.ptp(position, axis=0).max()
    if extent > _LARGEST_EXTENT_M:
        raise InputError(
            f"{names.mesh}: it is {extent:.4g} m wide, as a blank of {extent:.4g} mm read as metres would be "
            f"(1000 times too big); scale it to metres ({unit_wish(1.0e-3)})"
        )


def check_elements(position: np.ndarray, quads: np.ndarray, names: Names = ROWS) -> None:
    """Convex quadrilaterals of four nodes each, none twice, all wound the same way.

    Raises:
        InputError: one that is not so.
    """
    ordered = np.sort(quads, axis=1)
    repeated = np.any(ordered[:, 1:] == ordered[:, :-1], axis=1)
    if np.any(repeated):
        row = int(np.argmax(repeated))
        raise InputError(
            f"{names.mesh}: {_some(repeated, 'element')} degenerate, with a repeated node, the first is element "
            f"{names.element(row)} with nodes {[names.node(k) for k in quads[row]]}: it is no quadrilateral; four "
            "different nodes are needed"
        )
    order = np.lexsort(ordered.T)
    same = np.all(ordered[order[1:]] == ordered[order[:-1]], axis=1)
    if np.any(same):
        k = int(np.argmax(same))
        first, second = map(names.element, sorted(order[k : k + 2]))
        raise InputError(
            f"{names.mesh}: {_some(same, 'element')} given twice: elements {first} and {second} have the same nodes; "
            "remove one of them"
        )
    corner = position[quads]
    mean_normal = doubled_normals(position, quads)
    size = np.linalg.norm(mean_normal, axis=1)
    mean_normal /= np.maximum(size, 1.0e-300)[:, None]
    edge = np.roll(corner, -1, axis=1) - corner
    doubled = np.einsum("eij,ej->ei", np.cross(np.roll(edge, 1, axis=1), edge), mean_normal)
    longest = np.square(np.linalg.norm(edge, axis=2).max(axis=1))
    bad = (doubled.min(axis=1) <= 1.0e-4 * longest) | (size <= 1.0e-4 * longest)
    if np.any(bad):
        row = int(np.argmax(bad))
        raise InputError(
            f"{names.mesh}: {int(bad.sum())} elements are degenerate or not convex, the first is element "
            f"{names.element(row)} with nodes {[names.node(k) for k in quads[row]]} at "
            f"{corner[row].round(6).tolist()}; every corner angle must lie between 0 and 180 degrees"
        )
    # edges as single numbers: sorting these is ten times faster than sorting pairs
    edges = quads.astype(np.int64) * len(position) + np.roll(quads, -1, axis=1)
    key, count = np.unique(edges, return_counts=True)
    if np.any(count > 1):
        a, b = divmod(int(key[np.argmax(count > 1)]), len(position))
        rows = np.flatnonzero(np.any(edges == a * len(position) + b, axis=1))
        raise InputError(
            f"{names.mesh}: two elements have the edge from node {names.node(a)} to node {names.node(b)} in the same "
            f"direction ({names.element(rows[0])} and {names.element(rows[1])}), so one of them is flipped (or three "
            "elements share it); order the corners of all elements counter-clockwise"
        )


def check_connection(position: np.ndarray, quads: np.ndarray, names: Names = ROWS) -> None:
    """One sheet: no lonely nodes, one part, elements that meet in more than a corner.

    Raises:
        InputError: one that is not so.
    """
    lonely = np.bincount(quads.ravel(), minlength=len(position)) == 0
    if lonely.any():
        raise InputError(
            f"{names.mesh}: node {names.node(np.argmax(lonely))} belongs to no element; remove it "
            f"({_some(lonely, 'node')} in all)"
        )
    part = part_of_nodes(quads, len(position))
    parts, count = np.unique(part[quads[:, 0]], return_counts=True)
    if len(parts) > 1:
        raise InputError(
            f"{names.mesh}: it has {len(parts)} parts that share no node, of {', '.join(map(str, count[:5]))}"
            f"{' and more' if len(parts) > 5 else ''} elements; they would pass through each other undetected: "
            "make each part a separate sheet, or join them (merge_nodes) if they are one"
        )
    corner = np.bincount(border_edges(quads, len(position)).ravel(), minlength=len(position)) > 2
    if np.any(corner):
        raise InputError(
            f"{names.mesh}: elements meet only in a corner at {_some(corner, 'node')}, the first is node "
            f"{names.node(np.argmax(corner))}: it would be a hinge without stiffness; let them share an edge, or make "
            "the parts separate sheets"
        )


def check_coincident(position: np.ndarray, quads: np.ndarray, names: Names = ROWS) -> None:
    """Check that no nodes of the border lie at the same place.

    Raises:
        InputError: some do.
    """
    tolerance = _COINCIDENT * _shortest_edge(position, quads)
    border = np.unique(border_edges(quads, len(position)))
    pairs = border[close_pairs(position[border], tolerance)]
    if len(pairs):
        a, b = pairs[0]
        at = ", ".join(f"{c:.4g}" for c in position[a])
        raise InputError(
            f"{names.mesh}: {len(np.unique(pairs))} nodes of its border lie at the same place as another but are not "
            f"shared by the elements on both sides, the first are nodes {names.node(a)} and {names.node(b)} at ({at}) "
            f"m: the sheet is cut there. If it should not be, give merge_nodes={_rounded_up(tolerance)}, a distance in "
            "metres, to merge them; if the cut is meant, give merge_nodes=0"
        )


def merged_nodes(position: np.ndarray, quads: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes closer than ``distance`` [m] as one, the first of them.

    Returns:
        positions (n', 3), quads in terms of these (m, 4), rows of ``position`` that were kept (n',).

    Raises:
        InputError: a distance as long as an edge, or dozens of nodes at one place.
    """
    shortest = _shortest_edge(position, quads)
    if distance >= shortest > 0.0:
        raise InputError(
            f"merge_nodes = {distance:g}: must be below {shortest:.4g} m, the shortest edge of an element, or elements "
            "lose their edges"
        )
    kept, row = np.unique(part_of_nodes(close_pairs(position, distance), len(position)), return_inverse=True)
    return position[kept], row.reshape(-1)[quads].astype(quads.dtype), kept


def close_pairs(position: np.ndarray, distance: float) -> np.ndarray:
    """Pairs of rows of ``position`` (n, 3) at most ``distance`` apart, (k, 2).

    Raises:
        InputError: dozens of nodes at one place.
    """
    if len(position) < 2 or not distance > 0.0:
        return np.empty((0, 2), dtype=np.int64)
    scaled = (position - position.min(axis=0)) / (2.0 * distance)
    found = []
    # two that are this close share a cell of at least one of eight grids, shifted by half a cell
    for shift in np.ndindex(2, 2, 2):
        cells = np.floor(scaled + 0.5 * np.array(shift)).astype(np.int64)
        order = np.lexsort(cells.T)
        cells = cells[order]
        step = 1
        while step < len(order):
            same = np.all(cells[step:] == cells[:-step], axis=1)
            if not np.any(same):
                break
            if step > _MOST_AT_ONE_PLACE:
                x, y, z = position[order[int(np.argmax(same))]]
                raise InputError(
                    f"blank mesh: more than {_MOST_AT_ONE_PLACE} nodes lie within {distance:.3g} m of each other near "
                    f"({x:.4g}, {y:.4g}, {z:.4g}) m: remove what is there more than once"
                )
            found.append(np.column_stack([order[:-step][same], order[step:][same]]))
            step += 1
    if not found:
        return np.empty((0, 2), dtype=np.int64)
    pairs = np.unique(np.sort(np.concatenate(found), axis=1), axis=0)
    gap = np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1)
    return pairs[gap <= distance]


def faces_down(position: np.ndarray, quads: np.ndarray) -> bool:
    """Whether a sheet as a whole is wound clockwise as seen from above."""
    normal = doubled_normals(position, quads)
    return bool(normal[:, 2].sum() < -0.5 * np.linalg.norm(normal, axis=1).sum())


def number_array(name: str, value: Any) -> np.ndarray:
    """``value`` in double precision; an InputError unless it is an array of numbers."""
    try:
        given = np.asarray(value)
    except ValueError:  # rows of different lengths
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "iuf":
        raise InputError(f"{name}: an array of numbers is needed, not of {given.dtype}")
    return given.astype(np.float64, copy=False)


def whole_numbers(quads: Any) -> np.ndarray:
    """Corner nodes of elements as int32, of the shape given; an InputError unless they are whole numbers."""
    given = number_array("blank mesh: elements", quads)
    wrong = ~((np.abs(given) < 2.0**31) & (given == np.rint(given)))
    if wrong.any():
        raise InputError(f"blank mesh: elements name node {given[wrong][0]:g}; whole numbers are needed")
    return given.astype(np.int32)


def check_rows(name: str, rows: np.ndarray, good: np.ndarray, needed: str) -> None:
    """Raises an InputError that names the first row which is not good, and what is needed."""
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(f"{name}: entry {row} is {rows[row].tolist()}; {needed}")


def check_directions(blank: Blank) -> None:
    """Yarn directions span the planes of their elements, and all directions have length one.

    Raises:
        InputError: they do not.
    """
    for name in ("warp_direction", "weft_direction", "initial_director"):
        rows = getattr(blank, name)
        # not <= rather than >: NaN is refused too
        good = np.abs(np.linalg.norm(rows, axis=1) - 1.0) <= _UNIT_TOLERANCE
        check_rows(name, rows, good, "a direction of length 1 is needed")
    normal = doubled_normals(blank.node_position, blank.quads)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    warp, weft = blank.warp_direction, blank.weft_direction
    for name, yarn in (("warp_direction", warp), ("weft_direction", weft)):
        good = np.abs(np.einsum("ij,ij->i", yarn, normal)) <= _PLANE_TOLERANCE
        check_rows(name, yarn, good, "a direction in the plane of the element is needed")
    good = np.linalg.norm(np.cross(warp, weft), axis=1) >= _LEAST_YARN_SINE
    check_rows("weft_direction", weft, good, "a direction that is not parallel to the warp is needed")


def check_numbers(name: str, numbers: np.ndarray | None, count: int) -> None:
    """Numbers of a user's mesh: one for each row, each once.

    Raises:
        ValueError: they are not.
    """
    if numbers is None:
        return
    if numbers.shape != (count,):
        raise ValueError(f"{name}: shape {numbers.shape}, but ({count},) is needed")
    if not each_once(numbers):
        raise ValueError(f"{name}: whole numbers from 1 on are needed, each once")


def _shortest_edge(position: np.ndarray, quads: np.ndarray) -> float:
    edge = position[quads] - position[np.roll(quads, -1, axis=1)]
    return float(np.linalg.norm(edge, axis=2).min())


def border_edges(quads: np.ndarray, node_count: int) -> np.ndarray:
    """Edges (k, 2) of one element only."""
    following = np.roll(quads, -1, axis=1)
    key = np.minimum(quads, following).astype(np.int64) * node_count + np.maximum(quads, following)
    key, count = np.unique(key, return_counts=True)
    return np.column_stack(np.divmod(key[count == 1], node_count))


def _rounded_up(value: float) -> str:
    """``value`` with one digit, not less than it."""
    power = 10.0 ** np.floor(np.log10(value))
    return f"{np.ceil(value / power) * power:.1g}"


def _some(mask: np.ndarray, word: str) -> str:
    count = int(mask.sum())
    return f"{count} {word}{'' if count == 1 else 's'}"
