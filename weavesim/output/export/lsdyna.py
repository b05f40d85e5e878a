"""A keyword deck for LS-DYNA: every element with its own layers, ``*ELEMENT_SHELL_COMPOSITE``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .lamina import Lamina
from .part import Part, check_columns
from .units import UnitSystem

_MATERIAL, _SECTION = 1, 1


def lsdyna_deck(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> str:
    """Nodes, elements, part, section and material.

    Raises:
        InputError: a number of a node or an element that is too long for its columns.
    """
    check_columns(parts, "LS-DYNA")
    return "\n".join(_lines(parts, lamina, units)) + "\n"


def _lines(parts: Sequence[Part], lamina: Lamina, units: UnitSystem) -> Iterator[str]:
    yield "*KEYWORD"
    yield f"$ formed part from weavesim; units {units.text}"
    yield "$ layers from the bottom to the top of the element's normal; B: from the side N1-N2 to the fibres [degrees]"
    for part in parts:
        yield from (f"$ {note}" for note in part.notes)
    yield "*NODE"
    for part in parts:
        for label, (x, y, z) in zip(part.mesh.node_labels, units.length * part.mesh.nodes, strict=True):
            yield f"{label:8d}{x:16.8E}{y:16.8E}{z:16.8E}"
    for number, part in enumerate(parts, start=1):
        yield from ("*PART", part.name[:80], f"{number:10d}{_SECTION:10d}{_MATERIAL:10d}")
    # a fully integrated shell; the layers are those of its elements
    yield from ("*SECTION_SHELL", f"{_SECTION:10d}{16:10d}{0.833:10.3f}{2:10d}", f"{0.0:10.3f}" * 4)
    yield from _material(lamina, units)
    for number, part in enumerate(parts, start=1):
        yield "*ELEMENT_SHELL_COMPOSITE"
        yield from _elements(number, part, units)
    yield "*END"


def _material(lamina: Lamina, units: UnitSystem) -> Iterator[str]:
    """``*MAT_ORTHOTROPIC_ELASTIC`` (2), its axes from the nodes of the element (AOPT = 0)."""
    along, across = units.stress * lamina.modulus_along, units.stress * lamina.modulus_across
    shear, rolling = units.stress * lamina.shear_modulus, units.stress * lamina.shear_modulus_across
    # nu_ba, nu_ca, nu_cb with nu_ba/E_b = nu_ab/E_a
    minor = lamina.poisson_ratio * across / along
    yield f"$ {lamina.source or 'elastic constants as given'}"
    yield "*MAT_ORTHOTROPIC_ELASTIC"
    first = (units.density * lamina.density, along, across, across, minor, minor, lamina.poisson_ratio_across)
    yield f"{_MATERIAL:10d}" + "".join(f"{value:10.3E}" for value in first)
    yield "".join(f"{value:10.3E}" for value in (shear, rolling, shear, 0.0))
    yield from (f"{0.0:10.3f}" * 6, f"{0.0:10.3f}" * 7)


def _elements(number: int, part: Part, units: UnitSystem) -> Iterator[str]:
    row = 0
    for cells in part.mesh.cells:
        labels = part.mesh.node_labels[cells.corners]
        for label, corners in zip(cells.labels, labels, strict=True):
            four = [*corners, corners[-1]][:4]
            yield f"{label:8d}{number:8d}" + "".join(f"{node:8d}" for node in four)
            layers = [
                f"{_MATERIAL:10d}{units.length * layer.thickness[row]:10.4E}{layer.angle[row]:10.4f}{'':10}"
                for layer in part.layers
            ]
            for k in range(0, len(layers), 2):
                yield "".join(layers[k : k + 2]).rstrip()
            row += 1
