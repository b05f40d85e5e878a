"""What can be known of a job before it runs, as a table: tools, gaps, speeds, the time step, time and memory."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ..engine.plies.pass_model import nodal_areas
from ..engine.setup import Setup
from ..errors import InputError
from ..meshes.numbering import scatter_told
from ..process.motions.paths import PathMotion
from ..process.strokes import Motion
from ..ranges import ACCEPTING, Quantity
from ..run.guards import Doubt, Level, Start
from ..run.guards.closing import on_both_sides, smallest_gap
from ..run.guards.tool_mesh import FEWEST_ELEMENTS_PER_QUARTER_TURN, LEAST_ELEMENTS_PER_QUARTER_TURN
from ..run.simulation import Simulation
from ..run.staging.rehearsal import phases_of
from ..run.watch.tool_distance import ToolDistances
from ..tools.mesh_tool import MeshSurface
from ..tools.mesh_topology import place
from ..tools.sampling import DOUBTFUL_ERROR
from ..tools.shapes import Shape
from ..tools.surfaces.flaws import forgotten_holes, holes_of, sharper_than
from .advice.speed import suggested_speed
from .advice.told import LOOK, NOTE, OK, Row, damping_rows
from .stages.told import stage_lines

if TYPE_CHECKING:
    from ..run.estimate import Estimate

# Of the stack: a closed gap below the first crushes it, one above the second does not press it.
TIGHT, LOOSE = 0.95, 1.5
# A tool that a force moves is in touch within this share of the stack.
IN_TOUCH = 0.1
# Over the suggested speed: more is doubtful.
TOO_FAST = 2.0
# Of the area of a ply: a tool that touches less meets it in a point, about which it will close.
LEAST_TOUCHED = 0.005
# A force-driven tool should close a gap of a tenth of the stack within this share of the run.
SLOW_HOLDER = 0.02


@dataclass(frozen=True)
class Checked:
    """What is known of a run before it starts.

    Attributes:
        setup: of the run.
        rows: the table.
        doubts: what the guards say.
        expected: time and memory.
        errors: of the distance from each mesh tool, that 99 % of points near it have at most, and the largest [m].
    """

    setup: Setup
    rows: tuple[Row, ...]
    doubts: tuple[Doubt, ...]
    expected: Estimate | None
    errors: dict[str, tuple[float, float]]


def check_setup(setup: Setup) -> Checked:
    """Prepare a run, without running it, and say what is known.

    Raises:
        InputError: the run would be refused.
    """
    # what the run would ask about is told in the table
    prepared = Simulation(setup.model_copy(update={"accept_unusual": True})).prepare()
    start = Start(prepared.model, prepared.ledger, prepared.frame, phases_of(setup))
    doubts = tuple(prepared.guards.first)
    errors = _errors(start)
    rows = [
        *_plies(setup, start),
        *_tools(setup, start, errors),
        *_gaps(setup, start),
        *_holders(setup, start),
        *(Row("stages", name, text) for name, text in stage_lines(setup)),
        *_speeds(setup),
        *damping_rows(setup),
        *_cost(prepared.info.expected, setup),
        *(
            Row("doubts", doubt.guard.replace("_", " "), doubt.text, _judgement(doubt), doubt.advice)
            for doubt in doubts
            if doubt.guard not in ("tool_radius", "closing_gap")  # told above
        ),
    ]
    return Checked(setup, tuple(rows), doubts, prepared.info.expected, errors)


def _judgement(doubt: Doubt) -> str:
    return NOTE if doubt.level == Level.NOTE else LOOK


def _plies(setup: Setup, start: Start) -> Iterator[Row]:
    for sheet, model in zip(setup.sheets, start.model.sheets, strict=True):
        area = float(model.geometry.area.sum())
        fabric = sheet.fabric
        yield Row("plies", sheet.name, fabric.name)
        yield Row(
            "plies",
            "mesh",
            f"{sheet.blank.element_count:,} elements of {1e3 * model.geometry.largest_size:.3g} mm, "
            f"{1e4 * area:.4g} cm2",
        )
        if told := scatter_told(sheet.blank.quads):
            yield Row("plies", "numbering", told.partition(": ")[0], NOTE, told.partition(": ")[2])
        yield Row("plies", "fabric", f"{1e3 * fabric.thickness:.3g} mm, {1e3 * fabric.areal_density * area:.4g} g")


def _errors(start: Start) -> dict[str, tuple[float, float]]:
    """Errors of the sampled distance of each tool with a mesh."""
    found: dict[str, tuple[float, float]] = {}
    for tool in start.model.setup.tools:
        surfaces = [part.surface for part in tool.shape.parts() if part.surface is not None]
        samples = [start.model.samples[surface] for surface in surfaces]
        if samples:
            found[tool.name] = max(s.usual_error for s in samples), max(s.largest_error for s in samples)
    return found


def _tools(setup: Setup, start: Start, errors: dict[str, tuple[float, float]]) -> Iterator[Row]:
    size = max(sheet.geometry.largest_size for sheet in start.model.sheets)
    thickness = min(sheet.fabric.thickness for sheet in setup.sheets)
    for tool in setup.tools:
        parts = [(part, part.surface) for part in tool.shape.parts() if part.surface is not None]
        surfaces = [surface for _, surface in parts]
        kind = ", ".join(
            f"{len(s.faces):,} triangles, {'closed' if s.closed else 'open, solid behind it'}" for s in surfaces
        )
        yield Row("tools", tool.name, kind or type(tool.shape).__name__)
        for surface in surfaces:
            for note in surface.notes()[1:]:
                text = note.removeprefix(f"{surface.name}: ")
                is_fact = text.startswith("faces (")
                yield Row("tools", "side" if is_fact else "repaired", text, "" if is_fact else NOTE)
        for part, surface in parts:
            yield from _holes(part, surface)
        radius = tool.fillet_radius
        if math.isfinite(radius):
            count = tool.elements_per_quarter_turn(size)
            wanted = 0.5 * math.pi * radius / LEAST_ELEMENTS_PER_QUARTER_TURN
            sharp = _sharp_places(parts, size)
            yield Row(
                "tools",
                "smallest radius",
                f"{1e3 * radius:.3g} mm: {count:.1f} elements on 90 degrees{sharp}",
                OK if count >= LEAST_ELEMENTS_PER_QUARTER_TURN and not sharp
                else NOTE if count >= FEWEST_ELEMENTS_PER_QUARTER_TURN else LOOK,
                "" if count >= LEAST_ELEMENTS_PER_QUARTER_TURN else f"five need mesh_size = \"{1e3 * wanted:.2g} mm\"",
            )  # fmt: skip
        if tool.name in errors:
            usual, largest = errors[tool.name]
            trusted = DOUBTFUL_ERROR * thickness
            samples = [(part, start.model.samples[surface]) for part, surface in parts]
            part, worst = max(samples, key=lambda each: each[1].largest_error)
            spacing = max(sampled.spacing for _, sampled in samples)
            yield Row(
                "tools",
                "error of distance",
                f"{1e3 * usual:.2g} mm (99 %), {1e3 * largest:.2g} mm at most, with samples every "
                f"{1e3 * spacing:.2g} mm"
                + (f", the worst about {place(_in_world(part, worst.worst_points[0]))}" if largest > trusted else ""),
                OK if usual <= trusted else LOOK,
                f"at most {1e3 * trusted:.2g} mm are trusted",
            )


def _in_world(part: Shape, point: np.ndarray) -> np.ndarray:
    """A point of a mesh where its tool is at the start [m]."""
    return point @ np.array(part.rotation).T + np.array(part.origin)


def _holes(part: Shape, surface: MeshSurface) -> Iterator[Row]:
    """Holes in an open sheet: large ones are openings, and small ones were probably forgotten."""
    if openings := [hole for hole in holes_of(surface) if hole.is_opening]:
        widths = ", ".join(f"{1e3 * hole.width:.3g}" for hole in openings)
        yield Row("tools", "opening", f"{widths} mm across, with nothing of the tool in it")
    if small := forgotten_holes(part):
        yield Row(
            "tools",
            "holes",
            f"{len(small)} in the surface, {1e3 * small[0].width:.3g} to {1e3 * small[-1].width:.3g} mm across, one "
            f"about {place(_in_world(part, small[-1].place))}",
            LOOK,
            "the sheet meets nothing there; close them in the CAD file if the tool has none",
        )


def _sharp_places(parts: Sequence[tuple[Shape, MeshSurface]], size: float) -> str:
    """Where a tool has radii on which there are fewer than three elements of a ``size`` [m], in words."""
    radius = FEWEST_ELEMENTS_PER_QUARTER_TURN * size / (0.5 * math.pi)
    found = [(part, sharp) for part, surface in parts if (sharp := sharper_than(surface, radius)) is not None]
    if not found:
        return ""
    part, sharp = max(found, key=lambda each: each[1].share)
    where = place(_in_world(part, sharp.place))
    return f"; {100 * sharp.share:.2g} % of its surface has fewer than three, as about {where}"


def _gaps(setup: Setup, start: Start) -> Iterator[Row]:
    """The gap of every pair of tools on both sides of the sheets, when they are closed."""
    first = 0
    for number, world in enumerate(setup.worlds):
        stack = sum(sheet.fabric.thickness for sheet in world.sheets)
        for a, b in combinations(range(len(world.tools)), 2):
            if not on_both_sides(start, world, first, a, b):
                continue
            gap, time, _ = smallest_gap(start, number, first, (a, b))
            if not math.isfinite(gap):
                continue
            share = gap / stack
            judgement, advice = OK, f"the stack is {1e3 * stack:.3g} mm"
            pressed = any(tool.motion.by_force for tool in (world.tools[a], world.tools[b]))
            if share < TIGHT:
                judgement, advice = LOOK, f"{advice}: too tight, shorten the stroke or widen the gap"
                limited = any(tool.motion.limiting_force for tool in (world.tools[a], world.tools[b]))
                if not (pressed or limited or setup.accept_unusual):
                    advice += ", or give it a largest_force; a run is refused without accept_unusual"
            elif share > LOOSE and not pressed:
                judgement, advice = NOTE, f"{advice}: it is not pressed"
            yield Row(
                "gaps", f"{world.tools[a].name} - {world.tools[b].name}", f"{1e3 * gap:.3g} mm at {1e3 * time:.4g} ms",
                judgement, advice,
            )  # fmt: skip
        first += len(world.tools)


def _holders(setup: Setup, start: Start) -> Iterator[Row]:
    """Tools that a force moves: whether they touch, and whether their mass suits the force."""
    distances = ToolDistances(start.model)
    for index, tool in enumerate(setup.tools):
        if not tool.motion.by_force:
            continue
        found = [
            distances(index, tool.place(0.0, 0.0), frame.position)[0] - 0.5 * sheet.fabric.thickness
            for sheet, frame in zip(setup.sheets, start.frame.sheets, strict=True)
        ]
        gap, stack = min(float(each.min()) for each in found), sum(sheet.fabric.thickness for sheet in setup.sheets)
        touches = gap <= IN_TOUCH * stack
        yield Row(
            "forces",
            tool.name,
            f"{1e3 * max(gap, 0.0):.3g} mm above the sheet" if not touches else "in touch at the start",
            OK if touches else LOOK,
            "" if touches else 'it flies there first: start = "touching"',
        )
        force, mass = _largest_force([tool.motion]), tool.motion.driven_mass
        moves = [move.motion for stage in setup.stages for move in stage.moves if move.name == tool.name]
        largest = max(force, _largest_force(moves))
        if largest > 0.0 and touches:
            areas = [nodal_areas(sheet) for sheet in start.model.sheets]
            touched = max(
                float(area[each <= gap + IN_TOUCH * stack].sum()) for area, each in zip(areas, found, strict=True)
            )
            if touched >= LEAST_TOUCHED * max(float(area.sum()) for area in areas):
                yield _pressure(largest, touched)
        if force > 0.0:
            follow = math.sqrt(2.0 * IN_TOUCH * stack * mass / force)
            quick = follow <= SLOW_HOLDER * setup.duration
            yield Row(
                "forces",
                "mass",
                f"{force:.4g} N on {mass:.3g} kg close {1e3 * IN_TOUCH * stack:.2g} mm in {1e3 * follow:.2g} ms",
                OK if quick else NOTE,
                "" if quick else f"slow for a run of {1e3 * setup.duration:.3g} ms: a lighter tool follows the sheet",
            )


def _largest_force(motions: Sequence[Motion]) -> float:
    """The largest force of any of these [N]; 0 of none that is by force."""
    return max((float(np.abs(motion.curve()[1]).max()) for motion in motions if motion.by_force), default=0.0)


def _pressure(force: float, area: float) -> Row:
    """What a force [N] makes of the area of the sheet that it is in touch with at the start [m^2]."""
    pressure, quantity = force / area, Quantity("holder pressure")
    question = quantity.unusual(pressure)
    low, high = (f"{1e-3 * bound:g}" for bound in quantity.row.plausible)
    advice = f"usual are {low} to {high} kPa"
    if question is not None:
        for factor, meant, given in ((1.0e-3, f"{1e-3 * force:.4g} N", "kN"), (1.0e3, f"{force:.4g} kN", "N")):
            if quantity.unusual(factor * pressure) is None:
                advice += f"; was {meant} meant, not {given}?"
    return Row(
        "forces",
        "pressure",
        f"{force:.4g} N on {1e4 * area:.4g} cm2 that it touches: "
        + (f"{1e-3 * pressure:.4g} kPa" if pressure < 1.0e6 else f"{1e-6 * pressure:.4g} MPa"),
        OK if question is None else LOOK,
        advice,
    )


def _speeds(setup: Setup) -> Iterator[Row]:
    speed = suggested_speed(sheet.fabric for sheet in setup.sheets)
    named = {tool.name for tool in setup.tools}
    motions = [(tool.name, tool.motion) for tool in setup.tools] + [
        (f"{move.name} in {stage.name}", move.motion)
        for stage in setup.stages
        for move in stage.moves
        if move.name in named
    ]
    for name, motion in motions:
        yield from _turning_speeds(name, motion, speed, setup)
        times, travel = motion.curve()
        if motion.by_force or len(set(travel)) < 2:
            continue
        fastest = float(np.abs(np.diff(travel) / np.diff(times)).max())
        yield Row(
            "speeds",
            name,
            f"{1e3 * np.ptp(travel):.4g} mm at {fastest:.3g} m/s",
            OK if fastest <= TOO_FAST * speed else LOOK,
            f"suggested: {speed:g} m/s, at which inertia is about a hundredth of the work of shearing",
        )


def _turning_speeds(name: str, motion: Motion, speed: float, setup: Setup) -> Iterator[Row]:
    """Along the path of a tool that is carried, and about its axis at the distance of the furthest node."""
    if not isinstance(motion, PathMotion):
        return
    along, spin = motion.largest_rates(0.0, motion.duration)
    nodes = np.concatenate([sheet.blank.node_position for sheet in setup.sheets]) - np.array(motion.point)
    radius = float(np.linalg.norm(np.cross(nodes, np.array(motion.axis)), axis=1).max())
    fastest = along + spin * radius
    yield Row(
        "speeds",
        f"{name}, path",
        f"{along:.3g} m/s and {spin:.3g} rad/s: up to {fastest:.3g} m/s at the blank",
        OK if fastest <= TOO_FAST * speed else LOOK,
        f"suggested: {speed:g} m/s, at which inertia is about a hundredth of the work of shearing",
    )


def _cost(expected: Estimate | None, setup: Setup) -> Iterator[Row]:
    from ..run.estimate import check_bounds, duration_text

    if expected is None or expected.time_step is None or expected.seconds is None or expected.step_count is None:
        return
    yield Row("cost", "time step", f"{1e6 * expected.time_step:.3g} us, {expected.step_count:,.0f} steps")
    yield Row("cost", "time", f"about {duration_text(expected.seconds)}, half or twice as long")
    yield Row(
        "cost", "memory and disk", f"{max(1.0, expected.memory / 1e6):,.0f} MB, {max(1.0, expected.disk / 1e6):,.0f} MB"
    )
    try:
        check_bounds(expected, setup)
    except InputError as error:
        text = str(error).replace(ACCEPTING, "").strip()
        yield Row("cost", "bounds", text, LOOK, "a run is refused without accept_unusual")


def table_of(rows: Sequence[Row], width: int) -> str:
    """The rows as text for that many columns: what is judged first, then fact and advice."""
    import textwrap

    widest = max((len(row.what) for row in rows), default=0)
    lines, topic = [], ""
    for row in rows:
        if row.topic != topic:
            topic = row.topic
            lines.append(topic)
        start = f"  {row.judgement:<5} {row.what:<{widest}}  "
        text = row.value + (f" ({row.advice})" if row.advice else "")
        indent = " " * len(start)
        lines += textwrap.wrap(text, max(width, len(start) + 30), initial_indent=start, subsequent_indent=indent)
    return "\n".join(lines)
