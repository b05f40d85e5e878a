"""The set-up of a run as tables: every value in words, with its unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .values import Row, number, rows_of, text_of

if TYPE_CHECKING:
    from ...engine.setup import Setup, World
    from ...run.frame import RunInfo
    from ...sheet.sheet import Sheet
    from ...tools.tool import Tool


# Fields of a set-up that have rows or tables of their own.
_SAID = ("worlds", "name", "solver", "duration", "frame_count", "leading_tool", "rest", "accept_unusual")


def setup_tables(info: RunInfo) -> list[tuple[str, list[Row]]]:
    """Heading and rows of each table."""
    setup = info.setup
    tables = [("Run", list(_run_rows(info, setup)))]
    if setup is None:
        return tables
    several = len(setup.worlds) > 1
    for world in setup.worlds:
        own = f" of {world.name}" if several else ""
        tables.append((f"Motion and contact{own}", list(rows_of(world.dynamics))))
        tables += [(_sheet_heading(world, sheet, own), list(_sheet_rows(world, sheet))) for sheet in world.sheets]
        tables += [(f"Tool: {tool.name.replace('_', ' ')}{own}", list(_tool_rows(world, tool))) for tool in world.tools]
        if world.interfaces:
            rows = [row for item in world.interfaces for row in _named_rows(item)]
            tables.append((f"Between plies{own}", rows))
    return [(heading, rows) for heading, rows in tables if rows]


def _run_rows(info: RunInfo, setup: Setup | None) -> Iterator[Row]:
    yield Row("duration", number(info.duration, "s"))
    yield Row("frames after the first", str(info.frame_count))
    yield Row("elements, nodes", f"{info.element_count}, {info.node_count}")
    counts = " or ".join(map(str, info.thread_counts))
    yield Row("computed by", f"{info.device}, {info.precision}, {counts} thread{'s' * (counts != '1')}")
    if setup is not None:
        yield from rows_of(setup.solver, without=("device", "precision", "threads"))
        if setup.rest is not None:
            yield from rows_of(setup.rest)
        yield from rows_of(setup, without=_SAID)
        if setup.tools:
            yield Row("stroke is that of", setup.tools[setup.leading_tool].name.replace("_", " "))


def _sheet_heading(world: World, sheet: Sheet, own: str) -> str:
    return f"Sheet{own}" if len(world.sheets) == 1 else f"Sheet: {sheet.name}{own}"


def _sheet_rows(world: World, sheet: Sheet) -> Iterator[Row]:
    blank = sheet.blank
    size = 1.0e3 * np.ptp(blank.material_coordinates, axis=0)
    planes = ", ".join(f"{plane} = 0" for plane in world.symmetry.planes)
    yield Row("fabric", sheet.fabric.name)
    yield Row("mesh", f"{blank.element_count} elements, {blank.node_count} nodes")
    yield Row("computed size, flat", f"{size[0]:.4g} × {size[1]:.4g} mm")
    yield Row("mirrored at", planes or "no plane: the whole is computed")
    left_out = ("blank", "fabric", "name", "free", "supports", "pressures", "grippers", "loads", "initial_velocity")
    yield from rows_of(sheet, without=left_out)
    for name in ("initial_velocity", "loads"):
        value = getattr(sheet, name)
        if value is not None:
            yield Row(name.replace("_", " "), text_of(value, "m/s" if name == "initial_velocity" else "N"))
    for support in sheet.supports:
        yield Row(f"support {support.name}", f"{len(support.nodes)} nodes")
        yield from rows_of(support, without=("name", "nodes"), depth=1)
    for heading, items in (("pressure", sheet.pressures), ("gripper", sheet.grippers)):
        for item in items:
            yield Row(f"{heading} {getattr(item, 'name', '')}".strip(), "")
            yield from rows_of(item, without=("name", "nodes"), depth=1)


def _tool_rows(world: World, tool: Tool) -> Iterator[Row]:
    for row in rows_of(tool, without=("name", "colour")):
        # of a tool that is not turned nothing is said
        if not (row.label == "rotation" and np.array_equal(np.array(_rotation(tool)), np.eye(3))):
            yield row
    if tool.motion.by_force and world.symmetry.planes:
        yield Row(
            "its forces", f"are those on the computed part; on the whole {1.0 / world.symmetry.share:g} times that"
        )


def _rotation(tool: Tool) -> object:
    return getattr(tool.shape, "rotation", None)


def _named_rows(item: object) -> Iterator[Row]:
    from ...checks import Parameters

    assert isinstance(item, Parameters)
    yield Row(str(getattr(item, "name", "") or type(item).__name__.lower()), "")
    yield from rows_of(item, without=("name",), depth=1)
