"""The stages of a job as those of a set-up."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...engine.staging.acting import Parts
from ...engine.staging.checks import check_stages
from ...errors import InputError, did_you_mean
from ...output.flat.part_edge import read_part_edge
from ...process.grippers import MOVES_ANCHORS
from ...process.stages import AtForce, AtRest, AtStroke, FrictionOf, Move, SheetPressure, Stage, StageEnd
from ...process.strokes import Fixed, ForceDriven, Motion, Stroke
from ...process.trims import Trim
from ...sheet.sheet import Sheet
from ...tools.tool import Tool
from ..blanks.plies import DISC_CORNERS
from ..friction import friction_of
from ..loads import Loads
from ..placing import FORCE_RAMP, RAMP_SHARE
from ..read import JobFile
from ..units import length_unit
from .places import Places
from .tables import EndTable, MoveTable, StagePressureTable, TrimTable

# What the engine says of motions, in the words of a job.
IN_A_JOB = (
    ("a motion, or Fixed() to stay where it is", "a [[stage.move]] with a motion, or with fixed = true to stay"),
    (MOVES_ANCHORS, "a stroke without a largest_force, a path, or fixed = true is needed"),
)


def stages_of(
    file: JobFile,
    sheets: Sequence[Sheet],
    made: Mapping[str, tuple[Tool, ...]],
    share: float,
    drawn: Mapping[str, float],
) -> tuple[Stage, ...]:
    """The stages of a job; none if it has none.

    Args:
        file: the job.
        sheets: its plies.
        made: its tools by the names of their tables; one that is cut has several.
        share: of the whole that is computed, by symmetry; forces and masses of a job are those of the whole.
        drawn: displacements at which the tools of the tables are where they are drawn [m].

    Raises:
        InputError: a name that is not there, a motion that does not fit, or an end that can never come.
    """
    if not file.job.stage:
        return ()
    builder = _Builder(file, sheets, made, share, drawn)
    stages = tuple(builder.stage(index) for index in range(len(file.job.stage)))
    grippers = tuple(gripper for sheet in sheets for gripper in sheet.grippers)
    touching = frozenset(sheet.name for sheet in sheets if len(sheets) > 1)
    try:
        check_stages(stages, Parts(tuple(builder.tools.values()), (), grippers), sheets, touching)
    except ValueError as error:
        text = str(error)
        for theirs, ours in IN_A_JOB:
            text = text.replace(theirs, ours)
        named = next((k for k, each in enumerate(stages) if text.startswith(f"stage {each.name}: ")), None)
        if named is None:
            file.refuse(["stage"], text.removeprefix("stages: "))
        file.refuse(["stage", named], text.removeprefix(f"stage {stages[named].name}: "))
    return stages


class _Builder:
    """Makes one stage after the other; remembers which tools have acted."""

    def __init__(
        self,
        file: JobFile,
        sheets: Sequence[Sheet],
        made: Mapping[str, tuple[Tool, ...]],
        share: float,
        drawn: Mapping[str, float],
    ) -> None:
        self.file, self.sheets, self.share, self.drawn = file, sheets, share, drawn
        self.tools = {tool.name: tool for own in made.values() for tool in own}
        self.segments = {name: tuple(tool.name for tool in own) for name, own in made.items() if len(own) > 1}
        self.loads = Loads(file, [sheet.name for sheet in sheets])
        self.groups = self._groups()
        self.places = Places(self.tools)
        self.acting = frozenset(self.tools)
        self.acted: frozenset[str] = frozenset()

    def _groups(self) -> dict[str, tuple[str, ...]]:
        """Grippers by the names of their tables, and each by its own."""
        own = [gripper.name for sheet in self.sheets for gripper in sheet.grippers]
        found: dict[str, tuple[str, ...]] = {name: (name,) for name in own}
        tables = (*self.file.job.spring, *self.file.job.gripper)
        single = {table.name for table in tables}  # another table may be named like one of a group
        for table in tables:
            numbered = re.compile(rf"{re.escape(table.name)}_\d+")
            group = tuple(name for name in own if numbered.fullmatch(name) and name not in single)
            if group and table.name not in found:
                found[table.name] = group
        return found

    def stage(self, index: int) -> Stage:
        """The next stage."""
        table, keys = self.file.job.stage[index], ["stage", index]
        tools = None
        if table.tools is not None:
            found = [
                own for name in table.tools for own in self.segments.get(name) or (self._tool([*keys, "tools"], name),)
            ]
            tools = tuple(dict.fromkeys(found))
        if tools is not None:
            self.acting = frozenset(tools)
        moves: dict[str, Motion] = {}
        for k, move in enumerate(table.move):
            moves |= self._moves([*keys, "move", k], move)
        duration = table.end.time if table.end is not None and table.end.time is not None else table.duration
        if duration is None:
            duration = self._of_strokes(keys, moves)
        self.acted |= self.acting
        pressures = None
        if table.pressure is not None:
            pressures = tuple(self._pressure([*keys, "pressure", k], each) for k, each in enumerate(table.pressure))
        try:
            made = Stage(
                table.name,
                duration,
                None if table.end is None else self._end([*keys, "end"], table.end),
                tools=tools,
                grippers=None if table.grippers is None else self._grippers(keys, table.grippers),
                moves=tuple(Move(name, motion) for name, motion in moves.items()),
                pressures=pressures,
                friction=self._frictions([*keys, "friction"], table.friction),
                trims=tuple(self._trim([*keys, "trim", k], each) for k, each in enumerate(table.trim)),
                gravity=None if table.gravity is None else (0.0, 0.0, -table.gravity if table.gravity else 0.0),
                damping=table.damping,
                director_damping=table.director_damping,
                target_step=table.target_step,
                frame_count=table.frame_count,
            )
        except InputError as error:
            self.file.refuse(keys, str(error).removeprefix("Stage: "))
        self.places.go_through(made, self.acting)
        return made

    def _frictions(self, keys: Sequence[object], values: Mapping[str, Any]) -> tuple[FrictionOf, ...]:
        """Of tools, all segments of one that is cut, and neighbours."""
        found: list[FrictionOf] = []
        for name, value in values.items():
            names = self.segments.get(name, (name,))
            friction = friction_of(self.file, [*keys, name], value, of_tool=names[0] in self.tools)
            found += [FrictionOf(own, friction) for own in names]
        return tuple(found)

    def _trim(self, keys: Sequence[object], table: TrimTable) -> Trim:
        if table.file is not None:
            path = self.file.file(table.file, [*keys, "file"])
            try:
                edge = read_part_edge(
                    path, metres_per_unit=None if table.unit is None else length_unit(table.unit), layer=table.layer
                )
            except InputError as error:
                self.file.refuse([*keys, "file"], error)
            curves = [curve[:, :2] for curve in (edge.outline, *edge.holes)]
        elif table.disc is not None:
            angle = np.linspace(0.0, 2.0 * np.pi, DISC_CORNERS, endpoint=False)
            curves = [0.5 * table.disc * np.column_stack([np.cos(angle), np.sin(angle)])]
        elif table.rectangle is not None:
            curves = [0.5 * np.array(table.rectangle) * [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]]
        else:
            curves = [np.array(table.polygon)]
        ply = self.loads.ply(keys, table.ply)
        return Trim(tuple(curve + table.centre for curve in curves), ply, table.view, table.keeps)

    def _known(self, keys: Sequence[object], name: str, what: str, known: Sequence[str]) -> None:
        if name not in known:
            there = f"there are {', '.join(known)}" if known else "the job has none"
            key = keys[-1] if not isinstance(keys[-1], int) else keys[-2]
            self.file.refuse(keys, f"{key} = {name!r}: there is no such {what}; {there}{did_you_mean(name, known)}")

    def _tool(self, keys: Sequence[object], name: str) -> str:
        self._known(keys, name, "[[tool]]", list(self.tools))
        return name

    def _grippers(self, keys: Sequence[object], names: Sequence[str]) -> tuple[str, ...]:
        found: list[str] = []
        for name in names:
            self._known([*keys, "grippers"], name, "[[spring]] or [[gripper]]", list(self.groups))
            found += [own for own in self.groups[name] if own not in found]
        return tuple(found)

    def _moves(self, keys: Sequence[object], table: MoveTable) -> dict[str, Motion]:
        """Motions by the names of what they move."""
        if table.name in self.segments:
            self._of_segments(keys, table)
            return dict.fromkeys(self.segments[table.name], Fixed())
        known = [*self.tools, *(name for name in self.groups if name not in self.tools)]
        self._known([*keys, "name"], table.name, "[[tool]], [[spring]] or [[gripper]]", known)
        if table.rotation is not None and table.name not in self.tools:
            self.file.refuse(
                [*keys, "rotation"],
                f"{table.name} is no [[tool]]: only tools turn; give springs and grippers a stroke or a path",
            )
        try:
            motion = table.carried(self._motion(table))
        except InputError as error:
            self.file.refuse(keys, str(error))
        names = (table.name,) if table.name in self.tools else self.groups[table.name]
        return dict.fromkeys(names, motion)

    def _of_segments(self, keys: Sequence[object], table: MoveTable) -> None:
        """Refuse a motion of a tool that is cut, other than to stay."""
        if not table.fixed:
            first = self.segments[table.name][0]
            self.file.refuse(
                keys,
                f"{table.name} is cut into segments: move each by its name, as {first}, or write fixed = true",
            )

    def _travel(self, table: MoveTable) -> float:
        """Of a stroke [m].

        Raises:
            InputError: "close" of something else than a whole tool, or from where only the run knows.
        """
        if not isinstance(table.stroke, str):
            assert table.stroke is not None
            return table.stroke
        name = table.name
        if name not in self.drawn or name not in self.tools:
            raise InputError(f'stroke = "close": {name} is no whole [[tool]] that is drawn closed; give the travel')
        at = self.places.at(name)
        if at is None or table.is_carried:
            raise InputError(
                f'stroke = "close": where {name} stands when the stage begins is decided by the run, since a force, a '
                "path or the early end of a stage has moved it; give the travel"
            )
        travel = self.drawn[name] - at
        if not travel > 0.0:
            raise InputError(
                f'stroke = "close": {name} stands {abs(1e3 * travel):.4g} mm beyond where it is drawn when the stage '
                "begins; give the travel, or fixed = true to stay"
            )
        return travel

    def _motion(self, table: MoveTable) -> Motion:
        if table.stroke is not None:
            assert table.speed is not None
            travel = self._travel(table)
            ramp = RAMP_SHARE * abs(travel) / table.speed if table.ramp is None else table.ramp
            limit = None if table.largest_force is None else table.largest_force * self.share
            return Stroke.smooth(travel, table.speed, ramp, start_time=table.delay, largest_force=limit)
        if table.fixed or (table.force is None and table.forces is None):
            return Fixed()
        cut = next((whole for whole, names in self.segments.items() if table.name in names), table.name)
        tool = next((tool for tool in self.file.job.tool if tool.name == cut), None)
        stop = None if tool is None else tool.stop  # the spacers stay where they are
        own = None if tool is None else tool.mass
        if cut != table.name:
            own = self.tools[table.name].motion.driven_mass or None
        mass = table.mass if table.mass is not None else own
        if mass is None:
            raise InputError("mass: is required with a force")
        if table.force is not None:
            ramp = FORCE_RAMP if table.ramp is None else table.ramp
            return ForceDriven.constant(table.force * self.share, mass * self.share, ramp, stop=stop)
        assert table.forces is not None and table.times is not None
        forces = tuple(force * self.share for force in table.forces)
        return ForceDriven(table.times, forces, mass * self.share, stop=stop)

    def _of_strokes(self, keys: Sequence[object], moves: dict[str, Motion]) -> float:
        """Time of the strokes that begin in a stage [s]."""
        first = {name: self.tools[name].motion for name in self.tools if name in self.acting - self.acted}
        found = [motion.travel_time for motion in (first | moves).values()]
        if not any(found):
            self.file.refuse(keys, "duration: is required, since no stroke begins in the stage")
        return max(found)

    def _end(self, keys: Sequence[object], table: EndTable) -> StageEnd | None:
        if table.rest is not None:
            return AtRest(table.rest, table.speed)
        if table.tool is None:
            return None
        tool = self._tool([*keys, "tool"], table.tool)
        if table.force is not None:
            return AtForce(tool, table.force * self.share)
        assert table.stroke is not None
        return AtStroke(tool, table.stroke)

    def _pressure(self, keys: Sequence[object], table: StagePressureTable) -> SheetPressure:
        name = self.loads.ply(keys, table.ply)
        sheet = next(sheet for sheet in self.sheets if sheet.name == name)
        return SheetPressure(self.loads.pressure(keys, table, sheet.blank, table.before), name)
