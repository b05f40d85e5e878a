"""The set-up of one stage: tools, supports, grippers, pressures and loads as they act in it.

It has all tools, supports and grippers of the run, so that the state of the run fits it. Times stay those of the run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...process.friction import AmongLaws, has_law, law_of
from ...process.grippers import Gripper
from ...process.interfaces import Interface
from ...process.loads import NodalLoads
from ...process.motions.paths import PathMotion, Pose, place_of
from ...process.pressure import Pressure
from ...process.stages import AtStroke
from ...process.strokes import ForceDriven, Motion, SmoothStroke, Stroke
from ...process.supports import Drive, Support
from ...quantities import Vector
from ...sheet.sheet import Sheet
from ...tools.tool import Tool
from ..setup import Setup, World
from .acting import Acting, Given, Parts, acting_in


class AnchorPlace(NamedTuple):
    """Displacement of the anchors of a gripper along its direction [m], and along a path in addition, (x, y, z) [m]."""

    along: float
    path: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Begin(NamedTuple):
    """Where a run is when a stage begins.

    Attributes:
        time: [s].
        planned: end of the stage before it by its duration, from which this one counts its own [s].
        tools, drives: displacements of all tools, and of all drives of all supports, in order [m].
        grippers: those of the anchors of all grippers along their direction [m], and along a path, (x, y, z) [m].
        poses: of all tools if one is carried in any stage, twelve numbers each; else none.
    """

    time: float
    planned: float
    tools: tuple[float, ...]
    drives: tuple[float, ...]
    grippers: tuple[AnchorPlace, ...]
    poses: tuple[tuple[float, ...], ...] = ()


class _First(NamedTuple):
    """Places of the first drive and the first gripper of a sheet among those of the run."""

    drives: int
    grippers: int


def acting_of(setup: Setup) -> list[Acting]:
    """What acts in every stage of a set-up."""
    return acting_in(setup.stages, Parts(setup.tools, setup.supports, setup.grippers))


def stage_setup(setup: Setup, acting: Acting, begins: Sequence[Begin]) -> Setup:
    """The set-up of one stage alone.

    Args:
        setup: of the whole run.
        acting: what acts in the stage.
        begins: of the stages up to this one.
    """
    worlds, tool_count, first = [], 0, _First(0, 0)
    for world in setup.worlds:
        tools, lawful = [], among_laws(setup, world)
        for tool in world.tools:
            motion = _tool_motion(setup, tool, acting, begins, tool_count)
            changed: dict[str, Any] = {} if motion is tool.motion else {"motion": motion}
            friction = acting.friction.get(tool.name, tool.friction)
            if tool.name in lawful and not has_law(friction):
                friction = AmongLaws.of(friction)
            if friction is not tool.friction:
                changed["friction"] = friction
            tools.append(tool.model_copy(update=changed) if changed else tool)
            tool_count += 1
        sheets = []
        for sheet in world.sheets:
            sheets.append(_sheet(sheet, setup, acting, begins, first))
            drive_count = sum(len(support.drives) for support in sheet.supports)
            first = _First(first.drives + drive_count, first.grippers + len(sheet.grippers))
        dynamics = world.dynamics.model_copy(update=acting.dynamics) if acting.dynamics else world.dynamics
        own = {"tools": tuple(tools), "sheets": tuple(sheets), "dynamics": dynamics}
        worlds.append(world.model_copy(update=own | {"interfaces": _interfaces(world, acting)}))
    return _copied(setup, acting, tuple(worlds))


def among_laws(setup: Setup, world: World) -> frozenset[str]:
    """Names of the tools of a world whose friction stages change, if it is a law in any: all stages then have the
    kernels and the state of laws.
    """
    names = frozenset(tool.name for tool in world.tools)
    given = [each.friction for stage in setup.stages for each in stage.friction if each.name in names]
    laws = any(has_law(friction) for friction in (*given, *(tool.friction for tool in world.tools)))
    return names if given and laws else frozenset()


def _interfaces(world: World, acting: Acting) -> tuple[Interface, ...]:
    return tuple(
        each.model_copy(update={"friction": law_of(acting.friction[each.name])})
        if each.name in acting.friction
        else each
        for each in world.interfaces
    )


def _copied(setup: Setup, acting: Acting, worlds: tuple[World, ...]) -> Setup:
    solver = setup.solver
    if acting.target_step is not None:
        solver = solver.model_copy(update={"target_step": acting.target_step or None, "mass_scaling": None})
    # what the run may take has been judged as a whole
    changed = {"worlds": worlds, "solver": solver, "stages": (), "accept_unusual": True}
    return setup.model_copy(update=changed)


def planned_begins(setup: Setup, acting: Sequence[Acting]) -> list[Begin]:
    """Begin of every stage if each takes its whole duration; tools moved by forces stay where they are."""
    begins = [first_begin(setup)]
    for now in acting[:-1]:
        last, end = begins[-1], begins[-1].planned + now.stage.duration
        tools, poses = [], []
        for k, tool in enumerate(setup.tools):
            motion = _tool_motion(setup, tool, now, begins, k)
            at = last.tools[k] if motion.by_force else motion.displacement_at(end)
            if isinstance(now.stage.end, AtStroke) and now.stage.end.tool == tool.name:
                at = last.tools[k] + now.stage.end.displacement
            tools.append(at)
            place = place_of(motion, tool.axis, at, end)
            poses.append(place.numbers if isinstance(place, Pose) else ())
        anchors = gripper_places(stage_setup(setup, now, begins), end)
        begins.append(Begin(end, end, tuple(tools), begins[0].drives, anchors, tuple(poses) if any(poses) else ()))
    return begins


def first_begin(setup: Setup) -> Begin:
    """The start of a run."""
    starts = tuple(0.0 if tool.motion.by_force else tool.motion.displacement_at(0.0) for tool in setup.tools)
    drives = tuple(0.0 for support in setup.supports for _ in support.drives)
    poses: tuple[tuple[float, ...], ...] = ()
    if carried_tools(setup):
        motions = [PathMotion.of(tool.motion) for tool in setup.tools]
        found = [
            motion.pose_at(0.0, start * np.array(tool.axis))
            for motion, start, tool in zip(motions, starts, setup.tools, strict=True)
        ]
        poses = tuple(pose.numbers for pose in found)
    return Begin(0.0, 0.0, starts, drives, gripper_places(setup, 0.0), poses)


def carried_tools(setup: Setup) -> frozenset[str]:
    """Names of the tools that are carried along a path or turned in any stage."""
    names = {tool.name for tool in setup.tools}
    moved = [(move.name, move.motion) for stage in setup.stages for move in stage.moves if move.name in names]
    every = [*((tool.name, tool.motion) for tool in setup.tools), *moved]
    return frozenset(name for name, motion in every if motion.is_carried)


def _tool_motion(setup: Setup, tool: Tool, acting: Acting, begins: Sequence[Begin], index: int) -> Motion:
    """Motion of a tool in a stage, in the time of the run; one that is carried in any stage is so in all of them."""
    given = acting.tool_motions[tool.name]
    if tool.name not in carried_tools(setup):
        return _shifted(given, begins, index)
    if given.since == 0 and not given.onwards:
        return PathMotion.of(given.motion)
    begin = begins[given.since]
    if not given.onwards:
        return carried_on(
            PathMotion.of(given.motion),
            begin.time,
            0.0,
            tool.axis,
            Pose.from_numbers(PathMotion.of(tool.motion).placed),
        )
    return carried_on(
        PathMotion.of(given.motion), begin.time, begin.tools[index], tool.axis, Pose.from_numbers(begin.poses[index])
    )


def carried_on(motion: PathMotion, time: float, displacement: float, axis: Vector, pose: Pose) -> PathMotion:
    """A motion that begins at ``time`` [s], with a tool in a pose, displaced by ``displacement`` [m] along its axis."""
    along = displacement * np.array(axis)
    rotation, placed = motion.rotation, Pose.of(pose.matrix, np.array(pose.shift) - along)
    if rotation is not None:
        # given where the tool then stands; the kernels add the displacement
        changed = {
            "times": tuple(at + time for at in rotation.times),
            "point": tuple((np.array(rotation.point) - along).tolist()),
        }
        rotation = rotation.model_copy(update=changed)
    return motion.model_copy(
        update={
            "times": tuple(at + time for at in motion.times),
            "rotation": rotation,
            "along": shifted(motion.along, time, displacement),
            "placed": placed.numbers,
        }
    )


def gripper_places(setup: Setup, time: float) -> tuple[AnchorPlace, ...]:
    """Where the anchors of all grippers are at ``time`` [s]."""
    return tuple(_anchor_place(gripper.motion, time) for gripper in setup.grippers)


def _anchor_place(motion: Motion, time: float) -> AnchorPlace:
    x, y, z = motion.state_at(time)[0].tolist() if isinstance(motion, PathMotion) else (0.0, 0.0, 0.0)
    return AnchorPlace(motion.displacement_at(time), (x, y, z))


def _shifted(given: Given, begins: Sequence[Begin], tool: int) -> Motion:
    """Motion of a tool in the time of the run."""
    begin = begins[given.since]
    if given.since == 0 and not given.onwards:
        return given.motion
    return shifted(given.motion, begin.time, begin.tools[tool] if given.onwards else 0.0)


def shifted(motion: Motion, time: float, displacement: float) -> Motion:
    """A motion that begins at ``time`` [s], and a stroke at ``displacement`` [m]."""
    times, values = motion.curve()
    if motion.by_force:
        assert isinstance(motion, ForceDriven)
        return motion.model_copy(update={"times": tuple((times + time).tolist())})
    return Stroke(
        tuple((times + time).tolist()), tuple((values + displacement).tolist()), motion.limiting_force or None
    )


def _from_zero(times: np.ndarray, *rows: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """Knots with one more at time zero, at which all values are zero, if the first comes later."""
    if times[0] > 0.0:
        times, rows = np.append(0.0, times), tuple(np.append(0.0, row) for row in rows)
    return tuple(tuple(row.tolist()) for row in (times, *rows))


def _sheet(sheet: Sheet, setup: Setup, acting: Acting, begins: Sequence[Begin], first: _First) -> Sheet:
    changed: dict[str, Any] = {}
    supports, drive = [], first.drives
    for support in sheet.supports:
        supports.append(_support(support, acting, begins, drive))
        drive += len(support.drives)
    if any(new is not old for new, old in zip(supports, sheet.supports, strict=True)):
        changed["supports"] = tuple(supports)
    grippers = tuple(_gripper(each, acting, begins, k) for k, each in enumerate(sheet.grippers, first.grippers))
    if any(new is not old for new, old in zip(grippers, sheet.grippers, strict=True)):
        changed["grippers"] = grippers
    if any(stage.pressures is not None for stage in setup.stages):
        changed["pressures"] = _pressures(sheet, acting, begins)
    given = [stage.loads for stage in setup.stages if stage.loads is not None]
    own = bool(given) and sheet.loads is not None  # which a stage that loads nothing, or another sheet, takes away
    if own or any(each.sheet in (None, sheet.name) for loads in given for each in loads):
        changed["loads"] = _loads(sheet, acting, begins)
    return sheet.model_copy(update=changed) if changed else sheet


def _support(support: Support, acting: Acting, begins: Sequence[Begin], drive: int) -> Support:
    given = acting.support_motions.get(support.name)
    if given is not None:
        begin = begins[given.since]
        moved = _drive_motion(given.motion, begin.time, begin.drives[drive])
        support = support.model_copy(update={"drives": (Drive(moved, support.drives[0].direction),)})
    if support.name in acting.supports:
        return support
    still = tuple(Drive(each.motion, np.zeros_like(each.direction)) for each in support.drives)
    return support.model_copy(update={"drives": still, "displacements": "", "rotations": ""})


def _drive_motion(motion: Motion, time: float, displacement: float) -> Motion:
    if isinstance(motion, SmoothStroke):
        given = np.array(motion.times) + time, np.array(motion.displacements) + displacement, np.array(motion.speeds)
        return SmoothStroke(*_from_zero(*given))
    times, values = motion.curve()
    return Stroke(*_from_zero(times + time, values + displacement))


def _gripper(gripper: Gripper, acting: Acting, begins: Sequence[Begin], index: int) -> Gripper:
    changed: dict[str, Any] = {}
    given, released = acting.gripper_motions.get(gripper.name), acting.released.get(gripper.name)
    if given is not None:
        begin = begins[given.since]
        times, values = given.motion.curve()
        at = begin.grippers[index]
        along = Stroke(*_from_zero(times + begin.time, values + at.along))
        changed["motion"] = _along_path(along, given.motion, begin.time, np.array(at.path))
    if released is not None:
        opened = begins[released].time
        changed["release_time"] = opened if gripper.release_time is None else min(opened, gripper.release_time)
    return gripper.model_copy(update=changed) if changed else gripper


def _along_path(along: Stroke, motion: Motion, time: float, place: np.ndarray) -> Motion:
    """A motion of anchors that began at ``time`` [s] in a ``place`` on an earlier path, (3,) [m]."""
    given = motion if isinstance(motion, PathMotion) else PathMotion()
    if not given.points and not place.any():
        return along
    times = np.array(given.times or (0.0,)) + time
    points = place + np.array(given.points or ((0.0, 0.0, 0.0),))
    if times[0] > 0.0:  # a run begins at zero, and so does every motion of anchors; this one begins at rest
        times = np.concatenate([[0.0, 0.5 * times[0]], times])
        points = np.concatenate([np.zeros((1, 3)), points[:1], points])
    return PathMotion(tuple(times.tolist()), tuple(map(tuple, points.tolist())), along=along)


def _loads(sheet: Sheet, acting: Acting, begins: Sequence[Begin]) -> NodalLoads:
    """The loads on a sheet, without force where there are none, so that their work has its place in every stage."""
    none = NodalLoads()
    if acting.loads is None:
        return sheet.loads or none
    given, since = acting.loads
    own = next((each.loads for each in given if each.sheet in (None, sheet.name)), none)
    begin = begins[since].time
    return own.model_copy(update={"times": tuple(time + begin for time in own.times)})


def _pressures(sheet: Sheet, acting: Acting, begins: Sequence[Begin]) -> tuple[Pressure, ...]:
    """All pressures on a sheet, at least one, so that their work has its place in every stage."""
    own = sheet.pressures
    if acting.pressures is not None:
        given, since = acting.pressures
        begin = begins[since].time
        own = tuple(
            each.pressure.model_copy(update={"times": tuple(time + begin for time in each.pressure.times)})
            for each in given
            if each.sheet in (None, sheet.name)
        )
    return own or (Pressure("top", (0.0,)),)
