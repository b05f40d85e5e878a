"""Where a run is in its stages: times of its frames, ends that are reached, and what was."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...engine.staging.acting import Acting
from ...engine.staging.derive import AnchorPlace, Begin, acting_of, first_begin, gripper_places
from ...process.stages import AtForce, AtRest, AtStroke, Stage

if TYPE_CHECKING:
    from ...engine.model import Model
    from ...engine.setup import Setup
    from ...engine.state import State
    from ..frame import Frame

# Times in the duration of a stage at which a stroke or a force may end it.
CHECK_COUNT = 1000
# Looks in a row at which a stage is at rest.
REST_COUNT = 3
# Share of the duration over which the force on a tool is averaged: contact rings, and landing is not pressing.
FORCE_SHARE = 0.01


class Course:
    """The stages of a run; a run without stages is a single one.

    Args:
        setup: of the run.

    Attributes:
        acting: what acts in every stage; empty without stages.
        begins: of the stages so far.
        index: of the present stage.
        ended: the stages that are over, as the summary tells them.
        frames: the last frame of every stage so far, by its name.
        kept: elements of every sheet that no trim has taken away, (element_count,) bool; None for all of a sheet.
        trimmed: what every trim so far has done, as the summary tells it.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self.acting: list[Acting] = acting_of(setup) if setup.stages else []
        self.begins: list[Begin] = [first_begin(setup)] if setup.stages else []
        self.ended: list[dict[str, Any]] = []
        self.frames: dict[str, Frame] = {}
        self.kept: list[np.ndarray | None] = [None] * len(setup.sheets)
        self.trimmed: list[dict[str, Any]] = []
        self.index = self._first_frame = 0
        self._frame_counts = setup.frame_counts
        self._start_anew()

    def _start_anew(self) -> None:
        self._next_check, self._rests, self._largest_internal = 1, 0, 0.0
        self._reached = ""
        self._forces: list[tuple[float, float]] = []

    # ------------------------------------------------------------------------------------------------- the present one

    @property
    def stage(self) -> Stage | None:
        """The present stage; None in a run without stages."""
        return self._setup.stages[self.index] if self._setup.stages else None

    @property
    def name(self) -> str:
        """Of the present stage; empty without stages."""
        return "" if self.stage is None else self.stage.name

    @property
    def is_last(self) -> bool:
        """Whether no stage follows."""
        return self.index + 1 >= len(self._setup.stages)

    @property
    def begin(self) -> float:
        """From which its duration counts [s]."""
        return self.begins[-1].planned if self.begins else 0.0

    @property
    def duration(self) -> float:
        """The most that it takes [s]."""
        return self._setup.duration if self.stage is None else self.stage.duration

    @property
    def end_time(self) -> float:
        """When its duration is over [s]."""
        return self.begin + self.duration

    def frame_time(self, index: int) -> float:
        """Of a frame of the present stage [s]."""
        return self.begin + self.duration * (index - self._first_frame) / self._frame_counts[self.index]

    @property
    def released(self) -> Frame | None:
        """The frame at which the tools left a sheet that is to come to rest without them; None if they have not.

        What follows is judged by its rest: it is no forming, which is slow and driven.
        """
        free = len(self.begins)
        while free > 1 and not self.acting[free - 1].tools and isinstance(self._setup.stages[free - 1].end, AtRest):
            free -= 1
        if free == len(self.begins) or not self.acting[free - 1].tools:
            return None
        return self.frames.get(self._setup.stages[free - 1].name)

    # ------------------------------------------------------------------------------------------------------------ ends

    def targets(self, target: float) -> Iterator[float]:
        """Times up to ``target`` at which the run stops to ``check`` its state, and ``target`` [s]."""
        if self.stage is not None and isinstance(self.stage.end, AtStroke | AtForce):
            while (time := self._check_time) < target:
                yield time
        yield target

    @property
    def _check_time(self) -> float:
        return self.begin + self.duration * self._next_check / CHECK_COUNT

    def check(self, state: State) -> bool:
        """Whether a stroke or a force ends the stage now, if it is time to look; waits for the device."""
        stage = self.stage
        if stage is None or not isinstance(stage.end, AtStroke | AtForce):
            return False
        time = state.time
        if time < self._check_time:
            return False
        self._next_check = max(self._next_check, math.floor(CHECK_COUNT * (time - self.begin) / self.duration)) + 1
        k = self._tool(stage.end.tool)
        if isinstance(stage.end, AtStroke):
            moved = float(state.tool_displacement.numpy()[k]) - self.begins[-1].tools[k]
            self._reached = "stroke" if stage.end.reached(moved) else ""
        else:
            along = float(state.tool_force.numpy()[k] @ np.array(self._setup.tools[k].axis))
            window = FORCE_SHARE * self.duration
            self._forces = [(at, force) for at, force in self._forces if at > time - window] + [(time, along)]
            mean = sum(force for _, force in self._forces) / len(self._forces)
            self._reached = "force" if time - self.begin >= window and stage.end.reached(mean) else ""
        return bool(self._reached)

    def _tool(self, name: str) -> int:
        return next(k for k, tool in enumerate(self._setup.tools) if tool.name == name)

    def look(self, energies: Mapping[str, float], model: Model) -> None:
        """See whether the stage is at rest, from energies [J] at a look at the run."""
        if self.stage is None or not isinstance(self.stage.end, AtRest):
            return
        self._largest_internal = max(self._largest_internal, energies["internal"])
        mass = sum(float(sheet.node_mass.sum()) for sheet in model.sheets)
        kinetic = energies["kinetic"] + energies["tool_kinetic"]
        self._rests = self._rests + 1 if self.stage.end.reached(kinetic, self._largest_internal, mass) else 0
        if self._rests >= REST_COUNT:
            self._reached = "rest"

    @property
    def is_reached(self) -> bool:
        """Whether something other than time ends the present stage."""
        return bool(self._reached)

    def is_over(self, frame: Frame) -> bool:
        """Whether the last frame, taken of the present state, is the last of its stage."""
        if self.stage is None:
            rest = self._setup.rest
            return frame.time >= self._setup.duration or bool(rest and rest.reached(frame.time, frame.energies))
        return self.is_reached or frame.time >= self.end_time

    def finish(self, frame: Frame, now: Setup) -> None:
        """Note how the present stage, whose own set-up is ``now``, has ended."""
        if self.stage is None or len(self.ended) > self.index:
            return
        end = self.stage.end
        behind = {
            tool.name: abs(tool.motion.displacement_at(frame.time) - float(frame.tool_displacement[k]))
            for k, tool in enumerate(now.tools)
            if tool.motion.limiting_force
        }
        self.ended.append({
            "name": self.stage.name, "begin_s": self.begins[-1].time, "end_s": frame.time,
            "ended_by": self._reached or "duration", "reached": bool(end is None or self._reached),
            "stroke_mm": 1e3 * frame.stroke,
            "behind_mm": {name: 1e3 * way for name, way in behind.items()},
        })  # fmt: skip

    def keep(self, frame: Frame) -> None:
        """Keep a frame that the run has published, until the next one of its stage; a resumed run publishes all."""
        if frame.stage:
            self.frames[frame.stage] = frame

    def go_on(self, frame: Frame, now: Setup) -> None:
        """Begin the next stage at the last frame of a stage, whose set-up is ``now``."""
        planned = frame.time if self.is_reached else self.end_time
        begin = Begin(
            frame.time,
            planned,
            tuple(frame.tool_displacement.tolist()),
            tuple(frame.drive_displacement.tolist()),
            gripper_places(now, frame.time),
            tuple(tuple(pose) for pose in frame.tool_pose.tolist()),
        )
        self.begins.append(begin)
        self.index += 1
        self._first_frame = frame.index
        self._start_anew()

    # ------------------------------------------------------------------------------------------------ for a checkpoint

    def memory(self) -> dict[str, Any]:
        """All that it knows, for a checkpoint."""
        return {
            "begins": [
                [
                    *begin[:2],
                    list(begin.tools),
                    list(begin.drives),
                    [[place.along, *place.path] for place in begin.grippers],
                    [list(pose) for pose in begin.poses],
                ]
                for begin in self.begins
            ],
            "ended": [dict(each) for each in self.ended],
            "kept": list(self.kept),
            "trimmed": [dict(each) for each in self.trimmed],
            "index": self.index,
            "first_frame": self._first_frame,
            "next_check": self._next_check,
            "rests": self._rests,
            "largest_internal": self._largest_internal,
            "reached": self._reached,
            "forces": [list(each) for each in self._forces],
        }

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Be where ``memory`` was."""
        self.begins = [
            Begin(
                each[0],
                each[1],
                tuple(each[2]),
                tuple(each[3]),
                tuple(AnchorPlace(along, (x, y, z)) for along, x, y, z in each[4]),
                tuple(map(tuple, each[5])),
            )
            for each in memory["begins"]
        ]
        self.ended = [dict(each) for each in memory["ended"]]
        self.kept, self.trimmed = list(memory["kept"]), [dict(each) for each in memory["trimmed"]]
        self.index, self._first_frame = memory["index"], memory["first_frame"]
        self._next_check, self._rests = memory["next_check"], memory["rests"]
        self._largest_internal, self._reached = memory["largest_internal"], memory["reached"]
        self._forces = [(at, force) for at, force in memory["forces"]]
