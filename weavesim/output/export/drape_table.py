"""Thinning and fibre angle of every element and layer: ``/DRAPE`` of OpenRadioss, ``DRAPE`` of OptiStruct."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...errors import InputError
from .part import Layer, Part, across_normal
from .units import UnitSystem

# Where the reference direction is closer to an element's normal, there is no angle to count from [degrees].
LEAST_ANGLE_DEG = 5.0


def openradioss_deck(parts: Sequence[Part], units: UnitSystem, reference: Sequence[float] = (1.0, 0.0, 0.0)) -> str:
    """Nodes, elements and a ``/DRAPE`` for each layer, to be included in a starter deck with its own plies.

    Args:
        parts: to write.
        units: of the deck.
        reference: the vector (VX, VY, VZ) of the stack's property, from whose projection angles are counted.

    Raises:
        InputError: the reference is normal to an element.
    """
    return "\n".join(_radioss_lines(parts, units, np.asarray(reference, dtype=float))) + "\n"


def optistruct_table(parts: Sequence[Part]) -> str:
    """``DRAPE`` cards: angles from each element's side between its first and second node."""
    lines = ["$ formed part from weavesim: thinning, and angle from the side G1-G2 to the fibres [degrees]"]
    identity = 0
    for part in parts:
        for layer in part.layers:
            identity += 1
            lines += [f"$ {part.name}, {layer.name}", f"DRAPE   {identity:8d}"]
            for label, thinning, angle in zip(part.mesh.labels, thinnings(layer), layer.angle, strict=True):
                lines.append(f"{'':8}{'ELEM':8}{label:8d}{thinning:8.5f}{angle:8.3f}")
    return "\n".join(lines) + "\n"


def thinnings(layer: Layer) -> np.ndarray:
    """Current over initial thickness, (element_count,)."""
    return layer.thickness / layer.initial_thickness


def angle_from(reference: np.ndarray, part: Part, layer: Layer) -> np.ndarray:
    """Angle about the normal from the projection of a vector to the fibres, above -90 and up to 90 [degrees].

    Raises:
        InputError: the vector is normal to an element.
    """
    normal = part.mesh.frames[:, 2]
    unit = reference / np.linalg.norm(reference)
    steep = np.abs(normal @ unit) > np.cos(np.deg2rad(LEAST_ANGLE_DEG))
    if steep.any():
        raise InputError(
            f"reference {tuple(float(x) for x in reference)}: it is within {LEAST_ANGLE_DEG:g} degrees of the normal "
            f"of {int(steep.sum())} elements (element {part.mesh.labels[int(np.argmax(steep))]} of {part.name}), where "
            "no angle can be counted from it; give another direction with --reference"
        )
    along = across_normal(np.broadcast_to(unit, normal.shape), normal)
    across = np.cross(normal, along)
    x, y = (np.einsum("ei,ei->e", axis, layer.direction) for axis in (along, across))
    return 90.0 - np.mod(90.0 - np.rad2deg(np.arctan2(y, x)), 180.0)


def _radioss_lines(parts: Sequence[Part], units: UnitSystem, reference: np.ndarray) -> Iterator[str]:
    yield "#RADIOSS STARTER"
    yield f"# formed part from weavesim; units {units.text}"
    text = ", ".join(f"{x:g}" for x in reference)
    yield f"# theta_drape [degrees] from the projection of ({text}) onto the element to the fibres, about its normal:"
    yield "# give this vector as (VX, VY, VZ) of /STACK or of the property, and plies at 0 degrees without drape"
    yield "/NODE"
    for part in parts:
        for label, (x, y, z) in zip(part.mesh.node_labels, units.length * part.mesh.nodes, strict=True):
            yield f"{label:10d}{x:20.10G}{y:20.10G}{z:20.10G}"
    for number, part in enumerate(parts, start=1):
        for cells in part.mesh.cells:
            yield f"/{'SHELL' if cells.corners.shape[1] == 4 else 'SH3N'}/{number}"
            for label, corners in zip(cells.labels, part.mesh.node_labels[cells.corners], strict=True):
                yield f"{label:10d}" + "".join(f"{node:10d}" for node in corners)
    identity = 0
    for part in parts:
        yield from (f"# {note}" for note in part.notes)
        for layer in part.layers:
            identity += 1
            yield f"/DRAPE/{identity}"
            yield f"{part.name} {layer.name}"[:100]
            angles = iter(zip(part.mesh.labels, thinnings(layer), angle_from(reference, part, layer), strict=True))
            for cells in part.mesh.cells:
                entity = "SHELL" if cells.corners.shape[1] == 4 else "SH3N"
                for _ in cells.labels:
                    label, thinning, angle = next(angles)
                    yield f"{entity:10}{label:10d}{thinning:20.8f}{angle:20.6f}"
    yield "/END"
