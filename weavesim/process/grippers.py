"""Springs and grippers at the edges of a sheet, or on patches of it."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from pydantic import SerializeAsAny, field_validator, model_validator

from ..arrays import IntArray
from ..checks import NotNegative, Parameters, Positive
from ..names import Label
from ..quantities import UnitVector
from ..ranges import Quantity
from .motions.paths import PathMotion, Pose
from .strokes import Fixed, Motion

# Straight pieces between two knots of a path of anchors.
PATH_DIVISION = 32
MOVES_ANCHORS = (
    "a Stroke without a largest_force, Fixed, or a PathMotion of these without a rotation, at rest at its ends, is "
    "needed"
)


def moves_anchors(motion: Motion) -> bool:
    """Whether a motion can move the anchors of springs."""
    if isinstance(motion, PathMotion):
        is_own = motion.rotation is not None or motion.placed != Pose().numbers or not motion.at_rest
        return not is_own and moves_anchors(motion.along)
    return motion.moves_tools and not motion.by_force and not motion.limiting_force


class Gripper(Parameters):
    """Nodes that springs pull towards anchors; where it holds too little, the sheet slips out of it.

    Every node has a spring of its own to an anchor that lies at ``length`` along ``direction``, with a share of the
    stiffness and the forces: that of the area of the sheet around it. The springs pull and do not push; their direction
    follows node and anchor. With symmetry planes all values are those of the modelled part. Stored energy, work and
    loss are booked as ``gripper_spring``, ``gripper_work`` and ``gripper_loss``.

    Attributes:
        name: used in outputs, unique in a run.
        nodes: indices, each once (k,).
        direction: from the nodes to their anchors, scaled to length one.
        stiffness: of all springs together [N/m].
        length: of the springs at the start [m]: the longer, the less their direction turns as the sheet moves.
        pretension: force at the start, of all together [N].
        ramp_time: in which the pretension is applied [s].
        largest_force: of all together [N]: beyond its share the sheet slips through the gripper at a node; None for a
            gripper that holds.
        motion: of the anchors along ``direction``, positive away from the sheet: a ``Stroke``, or ``Fixed``; or a
            ``PathMotion`` without a rotation, whose path in space is added to that.
        release_time: at which the gripper opens [s]; None for one that stays.
    """

    positional = ("name", "nodes", "direction", "stiffness")

    name: Label
    nodes: IntArray
    direction: UnitVector
    stiffness: Annotated[Positive, Quantity("spring stiffness")]
    length: Annotated[Positive, Quantity("length")] = 0.1
    pretension: Annotated[NotNegative, Quantity("force")] = 0.0
    ramp_time: Annotated[NotNegative, Quantity("time")] = 0.0
    largest_force: Annotated[Positive, Quantity("force")] | None = None
    motion: SerializeAsAny[Motion] = Fixed()
    release_time: Annotated[Positive, Quantity("time")] | None = None

    @field_validator("nodes")
    @classmethod
    def _are_some(cls, value: np.ndarray) -> np.ndarray:
        if value.ndim != 1 or not len(value):
            raise ValueError("indices of one or more nodes are needed")
        if len(np.unique(value)) < len(value):
            raise ValueError("a node is listed twice; list each node once")
        return value

    @field_validator("motion")
    @classmethod
    def _moves_anchors(cls, value: Motion) -> Motion:
        if not moves_anchors(value):
            raise ValueError(MOVES_ANCHORS)
        return value

    @model_validator(mode="after")
    def _holds(self) -> Self:
        if self.largest_force is not None and self.pretension > self.largest_force:
            raise ValueError(
                f"gripper {self.name}: a pretension of {self.pretension:g} N slips at a largest_force of "
                f"{self.largest_force:g} N; lower the one, or raise the other"
            )
        start = float(np.linalg.norm(self.way_at(0.0)))
        if start != 0.0:
            raise ValueError(
                f"gripper {self.name}: its motion is {start:.4g} m away at time zero; it must start from 0, where "
                "length puts the anchors"
            )
        return self

    def way_at(self, time: float) -> np.ndarray:
        """Displacement of the anchors at ``time`` [s], (3,) [m]."""
        way: np.ndarray = self.motion.displacement_at(time) * np.array(self.direction)
        return way + self.motion.state_at(time)[0] if isinstance(self.motion, PathMotion) else way

    def anchor_curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacement of the anchors: times (n,) [s], and values (n, 3) [m], straight between them.

        The smooth curve of a path is divided, so that a quarter of a circle in one piece is met within 1e-4 of it.
        """
        times, travel = self.motion.curve()
        if not isinstance(self.motion, PathMotion):
            return times, travel[:, None] * np.array(self.direction)
        knots = np.array(self.motion.times)
        fine = [np.linspace(begin, end, PATH_DIVISION + 1) for begin, end in zip(knots[:-1], knots[1:], strict=True)]
        times = np.unique(np.concatenate([times, knots, *fine]))
        return times, np.array([self.way_at(float(time)) for time in times])

    @property
    def limit(self) -> float:
        """``largest_force``, or infinity [N]."""
        return math.inf if self.largest_force is None else self.largest_force
