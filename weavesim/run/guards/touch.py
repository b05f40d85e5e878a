"""Tools that cannot meet the sheet, and tools that did not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..frame import Outcome
from ..watch.tool_distance import ToolDistances
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...engine.setup import World
    from ...process.motions.paths import Place
    from ...process.strokes import Motion
    from ...tools.tool import Tool
    from ..verdict import Judged

# Places along its way at which a tool is looked at.
PLACE_COUNT = 9
# Of one that is carried, in time.
CARRIED_PLACE_COUNT = 65
# What the strokes of others move a sheet by, at most: a free end may swing further than the tool that moves it.
SWING = 1.5


class ToolReach(Guard):
    """Tools that are nowhere near the sheet on all of their way."""

    name = "tool_reach"
    watches = "whether every tool can reach the sheet"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Tools further from the sheet, on all of their way, than the sheet can move."""
        distances, first = ToolDistances(start.model), 0
        for number, world in enumerate(start.model.setup.worlds):
            nodes = np.concatenate([sheet.blank.node_position for sheet in world.sheets])
            ways = [
                list(_places(start, number, k, nodes, partial(distances, first + k))) for k in range(len(world.tools))
            ]
            nearest = [
                [float(distances(first + k, at, nodes)[0].min()) - blind for at, blind in way]
                for k, way in enumerate(ways)
            ]
            thickness = max(sheet.fabric.thickness for sheet in world.sheets)
            for k, tool in enumerate(world.tools):
                if not nearest[k]:
                    continue  # it never acts
                # what presses the sheet on another tool does not carry it away
                held = any(
                    not other.motion.by_force and min(nearest[i], default=np.inf) <= thickness
                    for i, other in enumerate(world.tools)
                    if i != k
                )
                reach = sum(
                    _reach(phase.setup.worlds[number], k, (phase.begin, phase.end), held) for phase in start.phases
                )
                if min(nearest[k]) > reach and not _near(start, distances, first + k, ways[k], reach):
                    yield self.doubt(
                        Level.WARNING,
                        f"{tool.name}: it stays {1e3 * min(nearest[k]):.4g} mm away from the blank, which can move by "
                        f"about {1e3 * reach:.3g} mm",
                        "it will never meet the sheet: check the place of its origin, its stroke and the unit of its "
                        "mesh",
                        value=min(nearest[k]),
                        limit=reach,
                    )
            first += len(world.tools)


class NeverTouched(Guard):
    """Tools that met no node of any sheet in the whole run."""

    name = "never_touched"
    watches = "whether every tool met the sheet"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Tools that met nothing, of a run that reached its end."""
        if run.run.outcome is not Outcome.FINISHED:
            return
        info = run.run.info
        for tool, name, met in zip(info.tools, info.tool_names, run.extremes.touched, strict=True):
            if not met:
                moves = any(
                    motion.by_force or motion.is_carried or len(set(motion.curve()[1])) > 1
                    for motion in _motions(run, tool)
                )
                yield self.doubt(
                    Level.DO_NOT_USE if moves else Level.WARNING,
                    f"{name} never touched a node of the sheet",
                    "it missed the sheet, or passed between its nodes" if moves else "leave it out, or check its place",
                )


def _motions(run: Judged, tool: Tool) -> list[Motion]:
    """Of a tool in all stages."""
    stages = run.run.setup.stages
    moved = [move.motion for stage in stages for move in stage.moves if move.name == tool.name]
    return [tool.motion, *moved]


def _places(
    start: Start, world: int, tool: int, nodes: np.ndarray, distance: Callable[..., tuple[np.ndarray, ...]]
) -> Iterator[tuple[Place, float]]:
    """Places that a tool may have in all stages in which it acts, and how much nearer it may be between them [m]."""
    ways, carried = [], []
    begun = since = 0.0  # where a force last took it over, and when
    for phase in start.phases:
        own = phase.setup.worlds[world].tools[tool]
        acts, by_force = own.name in phase.tools, own.motion.by_force
        if by_force:
            there = partial(_from, distance, own, begun, phase.begin)
            way = begun + _flight(own, phase.end - since, nodes, there) if acts else np.empty(0)
        else:
            begun, way = own.motion.displacement_at(phase.end), _way(own, phase.begin, phase.end)
        if not (acts and by_force):
            since = phase.end
        if acts and not own.motion.is_carried:
            ways.append(way)
        elif acts:
            for time in np.linspace(phase.begin, phase.end, CARRIED_PLACE_COUNT).tolist():
                along = way.tolist() if by_force else [own.motion.displacement_at(time)]
                carried += [(own.place(at, time), _blind(own, way)) for at in along]
    every = np.unique(np.concatenate([[], *ways]))
    blind = _blind(start.model.setup.worlds[world].tools[tool], every)
    yield from ((at, blind) for at in every.tolist())
    yield from carried


def _from(
    distance: Callable[..., tuple[np.ndarray, ...]], tool: Tool, begun: float, time: float, at: float, nodes: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Distances from a tool that has moved on by ``at`` [m] from where a force took it over."""
    return distance(tool.place(begun + at, time), nodes)


def _near(start: Start, distances: ToolDistances, tool: int, way: list[tuple[Place, float]], reach: float) -> bool:
    """Whether any point of a sheet, also between nodes, is nearer to a tool on its way than ``reach`` [m]."""
    for sheet, frame in zip(start.model.sheets, start.frame.sheets, strict=True):
        if sheet.places.tools.start <= tool < sheet.places.tools.stop:
            for at, _ in way:
                if distances.deepest(tool, at, frame.position, sheet, reach).element is not None:
                    return True
    return False


def _flight(
    tool: Tool, duration: float, nodes: np.ndarray, distance: Callable[..., tuple[np.ndarray, ...]]
) -> np.ndarray:
    """Displacements that a tool moved by a force may have, in free flight, but not far beyond the sheets [m]."""
    furthest = float(distance(0.0, nodes)[0].min()) + float(np.linalg.norm(np.ptp(nodes, axis=0)))
    forces = tool.motion.curve()[1]
    ends = [0.5 * force / tool.motion.driven_mass * duration**2 for force in (forces.min(), forces.max())]
    ends = np.clip(ends, -max(furthest, 0.0), max(furthest, 0.0))
    return np.unique(
        [*np.linspace(0.0, min(ends[0], 0.0), PLACE_COUNT), *np.linspace(0.0, max(ends[1], 0.0), PLACE_COUNT)]
    )


def _blind(tool: Tool, way: np.ndarray) -> float:
    """How much nearer a tool may be between the places of its flight than at them [m]."""
    return 0.5 * float(np.diff(way).max(initial=0.0)) if tool.motion.by_force else 0.0


def _way(tool: Tool, begin: float, end: float) -> np.ndarray:
    """Displacements of a tool along its stroke between two times [m]."""
    times, displacements = tool.motion.curve()
    # a stroke may go further between these times
    knots = displacements[(times >= begin) & (times <= end)]
    ends = [knots.min(), knots.max()] if len(knots) else []
    return np.unique([*np.interp(np.linspace(begin, end, PLACE_COUNT), times, displacements), *ends])


def _reach(world: World, own: int, between: tuple[float, float], held: bool) -> float:
    """How far nodes of a sheet may move between two times without the tool ``own`` [m]; ``held``: against forces."""
    begin, end = between
    duration = end - begin
    size = max(float(np.ptp(sheet.blank.node_position, axis=0).max()) for sheet in world.sheets)
    others = [tool for k, tool in enumerate(world.tools) if k != own]
    strokes = [float(np.ptp(_way(tool, begin, end))) for tool in others if not tool.motion.by_force]
    for tool in others:
        if tool.motion.by_force and not held:
            # in free flight, but no further than the sheet is long
            force = float(np.abs(tool.motion.curve()[1]).max())
            strokes.append(min(0.5 * force / tool.motion.driven_mass * duration**2, size))
    reach = SWING * max(strokes, default=0.0)
    if any(tool.motion.is_carried for tool in others):
        reach += size  # they take the sheet along
    reach += 0.5 * float(np.linalg.norm(world.dynamics.gravity)) * duration**2
    for sheet in world.sheets:
        reach += sheet.fabric.thickness
        for support in sheet.supports:
            for drive in support.drives:
                reach += SWING * drive.largest_displacement * float(np.linalg.norm(drive.direction, axis=-1).max())
        if sheet.initial_velocity is not None:
            reach += duration * float(np.linalg.norm(sheet.initial_velocity, axis=1).max())
        if sheet.loads is not None:
            reach += size
    return reach
