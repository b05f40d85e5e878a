"""Decks for Abaqus and CalculiX: composite shell sections, each element with the orientations of its own layers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .lamina import Lamina
from .part import CORNERS, Cells, Part, ShellMesh
from .units import UnitSystem

_ABAQUS_TYPES = {"triangle": "S3", "quad": "S4R", "triangle6": "STRI65", "quad8": "S8R"}
# CalculiX takes composite sections on these only.
_CALCULIX_TYPES = {"triangle6": "S6", "quad8": "S8R"}


def abaqus_deck(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> str:
    """Model data for Abaqus: S4R and S3, or the elements of the other mesh."""
    return "\n".join(_lines(parts, lamina, units, _ABAQUS_TYPES, "Abaqus")) + "\n"


def calculix_deck(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> str:
    """Model data for CalculiX: S8R and S6, with nodes added in the middles of the sides where there are none."""
    node = max(int(part.mesh.node_labels.max()) for part in parts)
    second = []
    for part in parts:
        mesh = with_middle_nodes(part.mesh, node + 1)
        node = max(node, int(mesh.node_labels.max()))
        second.append(Part(part.name, mesh, part.plies, part.layers_per_ply, part.notes))
    return "\n".join(_lines(second, lamina, units, _CALCULIX_TYPES, "CalculiX")) + "\n"


def with_middle_nodes(mesh: ShellMesh, first_label: int) -> ShellMesh:
    """The mesh with elements of second order; new nodes lie in the middle between their corners.

    Args:
        mesh: of any elements.
        first_label: of the new nodes.
    """
    linear = [cells for cells in mesh.cells if cells.nodes.shape[1] == CORNERS[cells.kind]]
    if not linear:
        return mesh
    sides = np.concatenate([
        np.stack([c.nodes, np.roll(c.nodes, -1, axis=1)], axis=2).reshape(-1, 2) for c in linear
    ])  # fmt: skip
    unique, place = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    place, first = place.ravel() + len(mesh.nodes), 0
    blocks = []
    for cells in mesh.cells:
        if not any(cells is other for other in linear):
            blocks.append(cells)
            continue
        count = cells.nodes.shape[1]
        middle = place[first : first + cells.nodes.size].reshape(-1, count)
        first += cells.nodes.size
        kind = "triangle6" if count == 3 else "quad8"
        blocks.append(Cells(kind, np.concatenate([cells.nodes, middle], axis=1), cells.labels))
    nodes = np.concatenate([mesh.nodes, mesh.nodes[unique].mean(axis=1)])
    labels = np.concatenate([mesh.node_labels, first_label + np.arange(len(unique))])
    return ShellMesh(nodes, labels, tuple(blocks))


def _lines(parts: Sequence[Part], lamina: Lamina, units: UnitSystem, types: dict[str, str], code: str) -> Iterator[str]:
    yield "*HEADING"
    yield f"formed part from weavesim, for {code}; units {units.text}"
    yield "** layers from the bottom to the top of the element's normal; material axis 1 along the fibres"
    for part in parts:
        yield from (f"** {note}" for note in part.notes)
    for part in parts:
        yield f"*NODE, NSET={part.name.upper()}_NODES"
        for label, point in zip(part.mesh.node_labels, units.length * part.mesh.nodes, strict=True):
            yield f"{label}, " + ", ".join(f"{x:.9g}" for x in point)
    for part in parts:
        for cells in part.mesh.cells:
            yield f"*ELEMENT, TYPE={types[cells.kind]}, ELSET={part.name.upper()}"
            for label, row in zip(cells.labels, part.mesh.node_labels[cells.nodes], strict=True):
                yield f"{label}, " + ", ".join(map(str, row))
    yield from _material(lamina, units)
    for part in parts:
        yield from _sections(part, units)


def _material(lamina: Lamina, units: UnitSystem) -> Iterator[str]:
    yield f"** {lamina.source or 'elastic constants as given'}"
    yield "*MATERIAL, NAME=YARNS"
    yield "*ELASTIC, TYPE=ENGINEERING CONSTANTS"
    along, across, shear, rolling = (
        units.stress * value
        for value in (
            lamina.modulus_along, lamina.modulus_across, lamina.shear_modulus, lamina.shear_modulus_across,
        )
    )  # fmt: skip
    nu, nu_across = lamina.poisson_ratio, lamina.poisson_ratio_across
    values = (along, across, across, nu, nu, nu_across, shear, shear, rolling)
    text = [f"{value:.9g}" for value in values]
    yield ", ".join(text[:8]) + ","
    yield text[8]
    yield "*DENSITY"
    yield f"{units.density * lamina.density:.9g}"


def _sections(part: Part, units: UnitSystem) -> Iterator[str]:
    normal, layers = part.mesh.frames[:, 2], part.layers
    across = [np.cross(normal, layer.direction) for layer in layers]
    for row, label in enumerate(part.mesh.labels):
        yield f"*ELSET, ELSET={part.name.upper()}_{label}"
        yield f"{label}"
        for number, (layer, second) in enumerate(zip(layers, across, strict=True)):
            yield f"*ORIENTATION, NAME=O{label}_{number + 1}, SYSTEM=RECTANGULAR"
            yield ", ".join(f"{x:.7f}" for x in (*layer.direction[row], *second[row]))
            yield "3, 0."
        yield f"*SHELL SECTION, COMPOSITE, ELSET={part.name.upper()}_{label}"
        for number, layer in enumerate(layers):
            yield f"{units.length * layer.thickness[row]:.9g}, , YARNS, O{label}_{number + 1}"
