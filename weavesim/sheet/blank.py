"""The sheet before forming: a quadrilateral mesh with yarn directions."""

from __future__ import annotations

import os
from typing import Any, Self

import numpy as np
from pydantic import model_validator

from ..arrays import FloatArray, IndexArray, IntArray
from ..checks import Parameters
from ..errors import InputError
from ..meshes import read_mesh
from ..meshes.numbering import (
    Numbering,
    checked_numbering,
    each_once,
    neighbouring_order,
    rows_numbered,
    scatter_told,
)
from ..quantities import finite
from ..ranges import QUANTITIES, argument, illegal
from .mesh_checks import (
    ROWS,
    Names,
    check_arrays,
    check_coincident,
    check_connection,
    check_count,
    check_directions,
    check_elements,
    check_numbers,
    check_rows,
    faces_down,
    merged_nodes,
    number_array,
    whole_numbers,
)
from .topology import checked_distortion, longest_outline, unit_normals

# Size of the elements of a rectangle over its longer side, with room for blanks of one element.
LARGEST_ELEMENT_SHARE = 2.0


class Blank(Parameters):
    """Immutable mesh of one connected sheet, checked on construction.

    Attributes:
        node_position: initial nodes, (node_count, 3) [m].
        material_coordinates: flat coordinates, (node_count, 2) [m].
        quads: corner nodes of each element, counter-clockwise seen from above, (element_count, 4).
        warp_direction, weft_direction: unit yarn directions at the element centres, (element_count, 3).
        initial_director: unit normals at the nodes, (node_count, 3).
        source_notes: what was merged or left out when the mesh was read, for the log.
        node_number, element_number: numbers of the nodes, (node_count,), and of the elements, (element_count,), in the
            mesh of a user, which results carry; None where they are the rows, counted from 1.

    Raises:
        InputError: a bad mesh (see ``from_mesh``), numbers that are not finite, directions that do not have length 1,
            yarns that are parallel or not in the plane of their element.
    """

    positional = (
        "node_position", "material_coordinates", "quads", "warp_direction", "weft_direction", "initial_director"
    )  # fmt: skip

    node_position: FloatArray
    material_coordinates: FloatArray
    quads: IndexArray
    warp_direction: FloatArray
    weft_direction: FloatArray
    initial_director: FloatArray
    source_notes: tuple[str, ...] = ()
    node_number: IntArray | None = None
    element_number: IntArray | None = None

    @model_validator(mode="after")
    def _is_a_sheet(self) -> Self:
        check_numbers("node_number", self.node_number, len(self.node_position))
        check_numbers("element_number", self.element_number, len(self.quads))
        check_arrays(self.node_position, self.quads, self.names)
        check_elements(self.node_position, self.quads, self.names)
        check_connection(self.node_position, self.quads, self.names)
        for name, shape in (
            ("material_coordinates", (self.node_count, 2)), ("initial_director", (self.node_count, 3)),
            ("warp_direction", (self.element_count, 3)), ("weft_direction", (self.element_count, 3)),
        ):  # fmt: skip
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name}: shape {getattr(self, name).shape}, but {shape} is needed")
        check_rows("material_coordinates", self.material_coordinates, np.isfinite(self.material_coordinates).all(1),
                   "finite numbers are needed")  # fmt: skip
        check_directions(self)
        return self

    @property
    def node_count(self) -> int:
        """How many nodes."""
        return len(self.node_position)

    @property
    def element_count(self) -> int:
        """How many elements."""
        return len(self.quads)

    @property
    def size(self) -> float:
        """Longest side of the box around the nodes [m]."""
        return float(np.ptp(self.node_position, axis=0).max())

    @property
    def names(self) -> Names:
        """What messages call its nodes and elements."""
        return Names("blank mesh", self.node_number, self.element_number)

    def nodes_numbered(self, numbers: Any) -> np.ndarray:
        """Rows of the nodes that have these numbers in the mesh of the user, (k,); an InputError if there is none."""
        return rows_numbered("node", numbers, self.node_number, self.node_count)

    def elements_numbered(self, numbers: Any) -> np.ndarray:
        """Rows of the elements that have these numbers in the mesh of the user, (k,)."""
        return rows_numbered("element", numbers, self.element_number, self.element_count)

    def element_centres(self) -> np.ndarray:
        """Initial centres of the elements, (element_count, 3) [m]."""
        return self.node_position[self.quads].mean(axis=1)

    def part(self, kept: np.ndarray) -> tuple[Blank, np.ndarray]:
        """The blank of some elements, (element_count,) bool, in order, and the nodes of the whole that it has, (k,).

        Raises:
            InputError: they do not hang together.
        """
        nodes, corners = np.unique(self.quads[kept], return_inverse=True)
        position, flat, director = (
            values[nodes] for values in (self.node_position, self.material_coordinates, self.initial_director)
        )
        warp, weft = self.warp_direction[kept], self.weft_direction[kept]
        return Blank(
            position, flat, corners.reshape(-1, 4), warp, weft, director, source_notes=self.source_notes,
            node_number=None if self.node_number is None else self.node_number[nodes],
            element_number=None if self.element_number is None else self.element_number[kept],
        ), nodes  # fmt: skip

    def boundary_loop(self) -> np.ndarray:
        """Nodes of the longest closed outline, in order, counter-clockwise, (k,)."""
        return longest_outline(self.quads, self.node_count)

    @classmethod
    def rectangle(
        cls,
        lower: tuple[float, float],
        upper: tuple[float, float],
        element_size: float | tuple[float, float],
        *,
        yarn_angle: float = 0.0,
        height: float = 0.0,
        distortion: float = 0.0,
        seed: int = 0,
    ) -> Blank:
        """A flat rectangle in the plane z = ``height``, with nearly square elements.

        Args:
            lower, upper: opposite corners (x, y) [m].
            element_size: target edge length [m]; the sides are divided evenly.
            yarn_angle: angle from the x axis to the warp [degrees]; the weft is at plus 90 degrees.
            height: z of all nodes [m].
            distortion: random displacement of the inner nodes, as a share of the element size (below 0.4).
            seed: of that displacement.

        Raises:
            InputError: sizes that are not positive, or not finite; a distortion out of range.
        """
        lower, upper = _pair("lower", lower), _pair("upper", upper)
        size = np.array(_pair("element_size", element_size if np.ndim(element_size) else (element_size, element_size)))
        height, distortion = finite("height", height), checked_distortion(distortion)
        extent = np.subtract(upper, lower)
        if np.any(extent <= 0.0) or np.any(size <= 0.0):
            raise InputError(
                f"blank from {lower} to {upper} m with elements of {element_size} m: sides and element size must be "
                "finite and positive"
            )
        if size.min() > LARGEST_ELEMENT_SHARE * extent.max():
            raise InputError(
                f"blank from {lower} to {upper} m with elements of {element_size} m: elements are larger than the "
                "blank; write 0.005 for 5 mm"
            )
        if problem := illegal(float(extent.max()), QUANTITIES["length"]):
            raise InputError(f"blank from {lower} to {upper} m, {extent.max():.4g} m wide: {problem}")
        check_count(float(np.prod(extent / size)), f"elements of {element_size} m")
        count = np.maximum(1, np.rint(extent / size)).astype(int)
        x, y = (np.linspace(lower[i], upper[i], count[i] + 1) for i in range(2))
        plan = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        if distortion:
            shift = np.random.default_rng(seed).uniform(-distortion, distortion, plan.shape) * extent / count
            plan[1:-1, 1:-1] += shift[1:-1, 1:-1]
        index = np.arange(plan.shape[0] * plan.shape[1]).reshape(plan.shape[:2])
        quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
        plan = plan.reshape(-1, 2)
        position = np.column_stack([plan, np.full(len(plan), height)])
        return cls.from_mesh(position, quads, yarn_angle=yarn_angle)

    @classmethod
    def fitted(
        cls,
        outline: np.ndarray,
        element_size: float,
        *,
        mesh_angle: float = 0.0,
        yarn_angle: float = 0.0,
        height: float = 0.0,
        distortion: float = 0.0,
        seed: int = 0,
    ) -> Blank:
        """A flat sheet with any outline; the mesh may be at any angle to outline and yarns.

        The elements are squares except for those near the outline; corners and sides are represented exactly.

        Args:
            outline: corners in order, (k, 2) [m]; give a curve as many corners with small turns.
            element_size: edge length of the inner elements [m].
            mesh_angle: angle from the x axis to the edges of the elements [degrees].
            yarn_angle: angle from the x axis to the warp [degrees].
            height: z of all nodes [m].
            distortion: random displacement of the inner nodes, as a share of the element size (below 0.4).
            seed: of that displacement.

        Raises:
            InputError: an outline that crosses itself, or has corners that elements of this size cannot fill.
        """
        from .fitted_mesh import fitted_mesh

        height = finite("height", height)
        plan, quads = fitted_mesh(outline, element_size, mesh_angle=mesh_angle, distortion=distortion, seed=seed)
        return cls.from_mesh(np.column_stack([plan, np.full(len(plan), height)]), quads, yarn_angle=yarn_angle)

    @classmethod
    def disc(cls, radius: float, element_size: float, **options: Any) -> Blank:
        """A flat disc around the origin [m], as a polygon with 720 sides; ``options`` are those of ``fitted``."""
        radius, angle = argument("radius", radius, "length"), np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
        return cls.fitted(radius * np.column_stack([np.cos(angle), np.sin(angle)]), element_size, **options)

    @classmethod
    def from_mesh(
        cls,
        node_position: np.ndarray,
        quads: np.ndarray,
        *,
        yarn_angle: float = 0.0,
        warp_direction: np.ndarray | None = None,
        material_coordinates: np.ndarray | None = None,
        merge_nodes: float | None = None,
        numbering: Numbering = "kept",
    ) -> Blank:
        """Any quadrilateral mesh, flat or curved.

        The warp is the projection onto each element of ``warp_direction`` ((3,) or (element_count, 3)), by default of
        the direction at ``yarn_angle`` degrees from x in the xy plane. ``material_coordinates`` default to x and y.

        ``merge_nodes`` is the distance [m] up to which nodes are merged. Without it, nodes of the border that lie at
        the same place are refused, because the sheet would be cut there; 0 says that the cut is meant.

        ``numbering="neighbouring"`` puts nodes and elements in an order in which neighbours follow each other: up to
        twice as fast in large meshes in no order. All arrays of the blank are then in this order, and those that a
        sheet is given too: ``given[blank.node_number - 1]`` puts rows of the given nodes into it, and
        ``nodes_numbered`` finds single nodes by their number, the given row + 1.

        Raises:
            InputError: NaN, degenerate or flipped elements, elements or nodes given twice, several parts, or a mesh
                that appears to be in millimetres.
        """
        position = number_array("blank mesh: nodes", node_position)
        quads = whole_numbers(quads)
        return cls._of_mesh(
            position, quads, ROWS, merge_nodes, (), yarn_angle, numbering, None, warp_direction, material_coordinates
        )

    @classmethod
    def _of_mesh(
        cls,
        position: np.ndarray,
        quads: np.ndarray,
        names: Names,
        merge_nodes: float | None,
        notes: tuple[str, ...],
        yarn_angle: float,
        numbering: Numbering,
        numbers: Names | None,
        warp_direction: Any = None,
        material_coordinates: Any = None,
    ) -> Blank:
        numbering = checked_numbering(numbering)
        check_arrays(position, quads, names)
        if merge_nodes is not None and (distance := finite("merge_nodes", merge_nodes)) != 0.0:
            if distance < 0.0:
                raise InputError(f"merge_nodes = {merge_nodes!r}: a distance in metres is needed, or 0 for none")
            count = len(position)
            position, quads, kept = merged_nodes(position, quads, distance)
            names = Names(names.mesh, kept if names.nodes is None else names.nodes[kept], names.elements)
            if numbers is not None or len(kept) < count:
                numbers = (numbers or ROWS).of(kept, np.arange(len(quads)))
            if np.shape(material_coordinates) == (count, 2):
                material_coordinates = np.asarray(material_coordinates)[kept]
            notes = (*notes, f"{names.mesh}: {count - len(kept)} nodes merged with another up to {distance:g} m away")
        check_elements(position, quads, names)
        if merge_nodes is None:
            check_coincident(position, quads, names)
        check_connection(position, quads, names)
        director, normal = unit_normals(position, quads)
        if warp_direction is None:
            angle = np.deg2rad(argument("yarn_angle", yarn_angle, "angle", zero=True, negative=True))
            warp_direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        wished = number_array("warp_direction", warp_direction)
        if wished.shape not in ((3,), normal.shape):
            raise InputError(f"warp_direction: shape {wished.shape}, but (3,) or {normal.shape} is needed")
        wished = np.broadcast_to(wished, normal.shape)
        if not np.isfinite(wished).all():
            raise InputError("warp_direction: finite numbers are needed")
        warp = wished - np.einsum("ij,ij->i", wished, normal)[:, None] * normal
        length = np.linalg.norm(warp, axis=1, keepdims=True)
        if not np.all(length >= 1.0e-6):
            raise InputError(
                f"warp direction of element {int(np.argmin(length))} is normal to the sheet: give another direction"
            )
        warp /= length
        given = position[:, :2] if material_coordinates is None else material_coordinates
        flat = number_array("material_coordinates", given)
        if numbering == "neighbouring" and flat.shape[:1] == (len(position),):
            nodes, elements = neighbouring_order(quads, len(position))
            numbers, place = (numbers or ROWS).of(nodes, elements), np.argsort(nodes)
            position, flat, director = position[nodes], flat[nodes], director[nodes]
            quads, warp, normal = place[quads[elements]], warp[elements], normal[elements]
        elif told := scatter_told(quads):
            notes = (*notes, f"{names.mesh}: {told}")
        return cls(
            node_position=position,
            material_coordinates=flat,
            quads=quads,
            warp_direction=warp,
            weft_direction=np.cross(normal, warp),
            initial_director=director,
            source_notes=notes,
            node_number=None if numbers is None else numbers.nodes,
            element_number=None if numbers is None else numbers.elements,
        )

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        *,
        unit_scale: float = 1.0,
        yarn_angle: float = 0.0,
        merge_nodes: float | None = None,
        numbering: Numbering = "kept",
    ) -> Blank:
        """Quadrilaterals from a mesh file: a deck of Abaqus, CalculiX or Nastran, VTK, Gmsh, Medit, OBJ, PLY or OFF.

        A sheet that faces down is turned over, so that its normal and the sense of angles are those seen from above.
        What is left out, merged or turned is said in the log. ``node_number`` and ``element_number`` are those of a
        deck; those of other files are counted from 1 in their order.

        Args:
            path: of the file; its ending names the format.
            unit_scale: metres per unit of the file: 1 for metres, 0.001 for millimetres.
            yarn_angle, merge_nodes, numbering: those of ``from_mesh``.

        Raises:
            InputError: a file that cannot be read, cells that are not quadrilaterals, or a bad mesh (see
                ``from_mesh``).
        """
        unit_scale = argument("unit_scale", unit_scale, "unit scale")
        mesh = read_mesh(path, "blank mesh")
        quads, labels = mesh.quads()
        mesh.check_unit(unit_scale)
        used, quads = np.unique(quads, return_inverse=True)
        notes = [f"{mesh.name}: {note}" for note in mesh.notes]
        if len(used) < len(mesh.vertices):
            notes.append(f"{mesh.name}: {len(mesh.vertices) - len(used)} nodes left out: no element uses them")
        node_labels = used + 1 if mesh.node_labels is None else mesh.node_labels[used]
        names = Names(mesh.name, node_labels, labels, mesh.label_word)
        quads, position = quads.reshape(-1, 4).astype(np.int32), unit_scale * mesh.vertices[used]
        if faces_down(position, quads):
            quads = quads[:, ::-1]
            notes.append(f"{mesh.name}: all elements turned over: they were wound clockwise as seen from above")
        numbers, of_elements = ROWS.of(used, np.arange(len(quads))), mesh.label_word == "element"
        if not each_once(node_labels) or (of_elements and not each_once(labels)):
            notes.append(f"{mesh.name}: some numbers are there twice: nodes and elements are counted from 1 instead")
        else:
            numbers = Names(mesh.name, node_labels, labels if of_elements else numbers.elements)
        return cls._of_mesh(position, quads, names, merge_nodes, tuple(notes), yarn_angle, numbering, numbers)


def _pair(name: str, value: Any) -> tuple[float, float]:
    try:
        x, y = value
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: two numbers are needed") from None
    return finite(name, x), finite(name, y)
