"""What acts in every stage of a run, after all that its stages say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ...process.friction import Friction
from ...process.grippers import Gripper
from ...process.stages import SheetLoads, SheetPressure, Stage
from ...process.strokes import Fixed, Motion, Stroke
from ...process.supports import Support
from ...tools.tool import Tool


class Given(NamedTuple):
    """A motion in a stage.

    Attributes:
        motion: of a tool, of the anchors of a gripper, or of the drive of a support.
        since: stage at whose begin its time is zero.
        onwards: whether its displacements count from the place at that time.
    """

    motion: Motion
    since: int
    onwards: bool


class Parts(NamedTuple):
    """What a run has, of all its worlds."""

    tools: tuple[Tool, ...]
    supports: tuple[Support, ...]
    grippers: tuple[Gripper, ...]

    @property
    def names(self) -> tuple[list[str], list[str], list[str]]:
        """Of tools, of supports and of grippers."""
        return (
            [tool.name for tool in self.tools],
            [support.name for support in self.supports],
            [gripper.name for gripper in self.grippers],
        )


@dataclass(frozen=True)
class Acting:
    """What acts in one stage.

    Attributes:
        stage, index: it.
        tools, supports, grippers: names of those that act.
        tool_motions: of all tools by name, also of those that do not act.
        support_motions, gripper_motions: of those that do not move as they would without stages.
        released: stage in which a gripper was released, by name.
        pressures: on the sheets and the stage that began them; None for those of the sheets themselves.
        loads: the same of loads on nodes.
        friction: coefficients and laws that are others now, by names of tools and interfaces.
        dynamics: attributes of ``Dynamics`` that are others now.
        target_step: of the solver [s]; 0 for none, None for that of the set-up.
    """

    stage: Stage
    index: int
    tools: frozenset[str]
    supports: frozenset[str]
    grippers: frozenset[str]
    tool_motions: dict[str, Given]
    support_motions: dict[str, Given] = field(default_factory=dict)
    gripper_motions: dict[str, Given] = field(default_factory=dict)
    released: dict[str, int] = field(default_factory=dict)
    pressures: tuple[tuple[SheetPressure, ...], int] | None = None
    loads: tuple[tuple[SheetLoads, ...], int] | None = None
    friction: dict[str, Friction | float] = field(default_factory=dict)
    dynamics: dict[str, object] = field(default_factory=dict)
    target_step: float | None = None


def acting_in(stages: Sequence[Stage], parts: Parts) -> list[Acting]:
    """What acts in every stage. Names must be known; see ``check_stages``."""
    of_tools, of_supports, of_grippers = map(frozenset, parts.names)
    result: list[Acting] = []
    for index, stage in enumerate(stages):
        last = result[-1] if result else Acting(stage, 0, of_tools, of_supports, of_grippers, {})
        tools, supports, grippers = (
            before if said is None else frozenset(said)
            for before, said in zip(
                (last.tools, last.supports, last.grippers), (stage.tools, stage.supports, stage.grippers), strict=True
            )
        )
        now = replace(
            last,
            stage=stage,
            index=index,
            tools=tools,
            supports=supports,
            grippers=grippers,
            released=last.released | dict.fromkeys(sorted(last.grippers - grippers), index),
            dynamics=last.dynamics | {name: stage.changes[name] for name in _DYNAMICS if name in stage.changes},
            pressures=last.pressures if stage.pressures is None else (stage.pressures, index),
            loads=last.loads if stage.loads is None else (stage.loads, index),
            friction=last.friction | {each.name: each.friction for each in stage.friction},
            target_step=last.target_step if stage.target_step is None else stage.target_step,
        )
        moved = {move.name: Given(move.motion, index, True) for move in stage.moves}
        result.append(
            replace(
                now,
                tool_motions={tool.name: moved.get(tool.name) or _of_tool(tool, now, result) for tool in parts.tools},
                support_motions=last.support_motions | _of(moved, parts.supports),
                gripper_motions=last.gripper_motions | _of(moved, parts.grippers),
            )
        )
    return result


_DYNAMICS = ("gravity", "damping", "director_damping")


def _of(moved: dict[str, Given], parts: Sequence[Support] | Sequence[Gripper]) -> dict[str, Given]:
    names = [part.name for part in parts]
    return {name: given for name, given in moved.items() if name in names}


def _of_tool(tool: Tool, now: Acting, before: Sequence[Acting]) -> Given:
    """Motion of a tool that is not moved anew: as before, or at rest where it is."""
    acted = [index for index, each in enumerate(before) if tool.name in each.tools]
    if tool.name not in now.tools and not acted:
        start = 0.0 if tool.motion.by_force else tool.motion.displacement_at(0.0)
        return Given(Stroke((0.0,), (start,)), 0, False)
    if not acted:
        return Given(tool.motion, now.index, False)
    last = before[-1].tool_motions[tool.name]
    stops = tool.name not in now.tools and tool.name in before[-1].tools
    return Given(Fixed(), now.index, True) if stops else last
