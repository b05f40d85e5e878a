"""Which runs can be stepped in the same launches, and what keeps others apart."""

from __future__ import annotations

from collections.abc import Iterator

from ...process.friction import has_law
from ..model import Model, arrays_in
from ..setup import Setup


def obstacles(setup: Setup) -> list[str]:
    """What keeps a run from sharing launches with any other, in words; empty if nothing does."""
    return list(_obstacles(setup))


def _obstacles(setup: Setup) -> Iterator[str]:
    if len(setup.sheets) > 1:
        yield f"it has {len(setup.sheets)} sheets"
    if any(sheet.self_contact is not None for sheet in setup.sheets):
        yield "its sheet may touch itself"
    if setup.sheets[0].pressures:
        yield "there is pressure on its sheet"
    if setup.stages:
        yield "it has stages"
    if any(tool.motion.is_carried for tool in setup.tools):
        yield "a tool follows a path or turns"
    if any(has_law(tool.friction) for tool in setup.tools):
        yield "the friction of a tool is more than one coefficient"


def likeness(model: Model) -> dict[str, object]:
    """What runs that share launches have in common, by its name for the user."""
    sheet = model.sheet
    return {
        "precision": model.precision.value,
        "number of elements": sheet.element_count,
        "number of nodes": sheet.node_count,
        "kind of unit cell": sheet.cell_law,
        "kinds of laws of the sheet": sheet.sheet_traits,
        "kinds of tools, loads and supports": sheet.node_traits,
        "places of contact between nodes": sheet.samples.places.tolist(),
        "number of tools": model.tools.count,
        "number of drives": model.drives.count,
        "number of gripped nodes": sum(len(gripper.nodes) for gripper in sheet.grippers),
        "kinds of curves and tables": _sizes(model),
    }


def _sizes(model: Model) -> tuple[tuple[int, ...], ...]:
    """Shapes of the constant arrays: knots of strokes and drives, parts of tools, entries of tables."""
    drives = model.drives
    own = [*model.arrays(), *arrays_in(model.tools.drives), drives.first_piece, drives.start, drives.piece]
    return tuple(tuple(array.shape) for array in own)


def differences(first: Model, other: Model) -> list[str]:
    """What keeps two runs from sharing launches, in words; empty if nothing does."""
    own, others = likeness(first), likeness(other)
    plain = (int, str)
    return [
        f"their {name} {'differ' if name.startswith('kinds') else 'differs'}"
        + (f" ({value} and {others[name]})" if isinstance(value, plain) else "")
        for name, value in own.items()
        if value != others[name]
    ]
