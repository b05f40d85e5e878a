"""What was found for the same input before: variants of one problem share most of what is checked at their start."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from ...engine.model import Model
from ...tools.tool import Tool

Found = TypeVar("Found")

# Findings that are kept, the last ones.
LARGEST_COUNT = 256

_found: OrderedDict[tuple[Hashable, ...], Any] = OrderedDict()


def remembered(key: tuple[Hashable, ...] | None, find: Callable[[], Found]) -> Found:
    """What ``find`` returns, or returned the last time for an equal ``key``; without a key it is always asked."""
    if key is None:
        return find()
    if key not in _found:
        _found[key] = find()
        while len(_found) > LARGEST_COUNT:
            _found.popitem(last=False)
    _found.move_to_end(key)
    found: Found = _found[key]
    return found


def geometry_key(model: Model, tools: tuple[Tool, ...]) -> tuple[Hashable, ...] | None:
    """All that distances of tools from the flat sheets of a run depend on; None for tools that are sampled."""
    if any(part.surface is not None for tool in tools for part in tool.shape.parts()):
        return None
    setup = model.setup
    return (
        str(model.device),
        model.precision,
        setup.duration,
        *((sheet.blank, sheet.fabric.thickness) for sheet in setup.sheets),
        *((tool.shape, tool.axis, tool.motion) for tool in tools),
    )
