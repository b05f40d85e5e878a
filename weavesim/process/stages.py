"""Stages of a process: what acts in each, and when it ends."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, SerializeAsAny, field_validator

from ..checks import Finite, Kinded, NotNegative, Parameters, Positive
from ..names import Label
from ..quantities import FiniteVector
from ..ranges import Quantity
from .friction import FrictionValue
from .loads import NodalLoads
from .pressure import Pressure
from .strokes import Motion
from .trims import Trim


class StageEnd(Kinded):
    """When a stage ends before its ``duration`` is over.

    Attributes:
        tool_name: of the tool that decides; None where none does.
    """

    @property
    def tool_name(self) -> str | None:
        """Of the tool that decides; None where none does."""
        return None


class AtStroke(StageEnd):
    """Ends a stage when a tool has moved far enough.

    Attributes:
        tool: its name.
        displacement: along its axis, from where it stood when the stage began [m].
    """

    positional = ("tool", "displacement")

    tool: Label
    displacement: Annotated[Finite, Quantity("displacement")]

    @field_validator("displacement")
    @classmethod
    def _is_a_way(cls, value: float) -> float:
        if value == 0.0:
            raise ValueError("a displacement other than 0 is needed")
        return value

    @property
    def tool_name(self) -> str | None:
        """Of the tool that moves."""
        return self.tool

    def reached(self, moved: float) -> bool:
        """Whether a tool that has ``moved`` [m] since the stage began is there."""
        return moved >= self.displacement if self.displacement > 0.0 else moved <= self.displacement


class AtForce(StageEnd):
    """Ends a stage when the sheets push a tool with a force, on average over a hundredth of the ``duration``.

    Attributes:
        tool: its name.
        force: of the sheets on it along its axis, either way [N]; with symmetry planes, of the modelled part.
    """

    positional = ("tool", "force")

    tool: Label
    force: Annotated[Positive, Quantity("force")]

    @property
    def tool_name(self) -> str | None:
        """Of the tool that is pushed."""
        return self.tool

    def reached(self, along: float) -> bool:
        """Whether a force ``along`` the axis of the tool [N] is large enough."""
        return abs(along) >= self.force


class AtRest(StageEnd):
    """Ends a stage when sheets and tools are at rest, in three looks at the run one after the other.

    A run is looked at a hundred times in the ``duration`` of a stage.

    Attributes:
        kinetic_share: largest kinetic energy, over the largest internal energy of the stage so far.
        speed: largest speed of the sheets, the root of the mean square over their mass [m/s].
    """

    positional = ("kinetic_share", "speed")

    kinetic_share: Annotated[Positive, Quantity("energy share")] = 1.0e-3
    speed: Annotated[Positive, Quantity("speed")] = 0.01

    def reached(self, kinetic: float, largest_internal: float, mass: float) -> bool:
        """Whether energies [J] and the mass of the sheets [kg] are those of a rest."""
        return kinetic <= self.kinetic_share * largest_internal and 2.0 * kinetic <= mass * self.speed**2


class Move(Parameters):
    """A motion that begins with a stage.

    Attributes:
        name: of a tool, a gripper, or a support with one drive.
        motion: in the time since the stage began. A stroke starts from 0, where the tool, the anchors or the drive then
            are; ``Fixed`` keeps them there. A ``ForceDriven`` tool goes on from its place and at its speed.
    """

    positional = ("name", "motion")

    name: Label
    motion: SerializeAsAny[Motion]


class SheetPressure(Parameters):
    """A pressure on one sheet, in the time since its stage began.

    Attributes:
        pressure: its curve.
        sheet: name of the sheet; None for the only one of a run.
    """

    positional = ("pressure", "sheet")

    pressure: Pressure
    sheet: Label | None = None


class SheetLoads(Parameters):
    """Loads on the nodes of one sheet, in the time since their stage began.

    Attributes:
        loads: forces and couples, with their curve.
        sheet: name of the sheet; None for the only one of a run.
    """

    positional = ("loads", "sheet")

    loads: NodalLoads
    sheet: Label | None = None


class FrictionOf(Parameters):
    """Another friction, as a lubricant or a heated tool has.

    Attributes:
        name: of a tool, or of an interface between plies, "LOWER / UPPER".
        friction: from the stage on: a Coulomb coefficient, or a law.
    """

    positional = ("name", "friction")

    name: Label
    friction: FrictionValue


class Stage(Parameters):
    """A part of a process. What a stage does not say stays as in the stage before it.

    In the first stage all tools act, all supports hold and all grippers pull, unless it says which; motions, loads and
    pressures of tools, sheets and grippers are in the time of the run, those of a tool that is left out at first in the
    time since it acts.

    Attributes:
        name: used in outputs, unique in a run.
        duration: of the stage [s]; with an ``end``, the most that it takes.
        end: ends it earlier; None for its duration.
        tools: names of those that act; others stay where they are, and the sheets pass through them. One that acts
            again needs a ``Move``.
        supports: names of those that hold; one that takes hold again keeps its nodes where they then are.
        grippers: names of those that pull; one that has been released stays open.
        moves: motions that begin with the stage; a mapping from names to motions will do.
        pressures: all pressures on sheets from the stage on.
        loads: all loads on the nodes of sheets from the stage on.
        friction: other coefficients or laws of tools and interfaces; a mapping from names to them will do.
        trims: cuts through sheets as it begins; what they take away does not come back.
        gravity: (3,) [m/s^2].
        damping: mass-proportional damping rate of the nodes [1/s].
        director_damping: the same for the directors [1/s].
        target_step: step for which the mass is scaled up [s]; 0 takes the added mass away.
        frame_count: frames evenly spaced in its duration; None for its share of those of the set-up, by duration.
    """

    positional = ("name", "duration", "end")

    name: Label
    duration: Annotated[Positive, Quantity("duration")]
    end: SerializeAsAny[StageEnd] | None = None
    tools: tuple[Label, ...] | None = None
    supports: tuple[Label, ...] | None = None
    grippers: tuple[Label, ...] | None = None
    moves: tuple[Move, ...] = ()
    pressures: tuple[SheetPressure, ...] | None = None
    loads: tuple[SheetLoads, ...] | None = None
    friction: tuple[FrictionOf, ...] = ()
    trims: tuple[Trim, ...] = ()
    gravity: Annotated[FiniteVector, Quantity("acceleration")] | None = None
    damping: Annotated[NotNegative, Quantity("damping rate")] | None = None
    director_damping: Annotated[NotNegative, Quantity("damping rate")] | None = None
    target_step: Annotated[NotNegative, Quantity("time step")] | None = None
    frame_count: Annotated[int, Field(ge=1)] | None = None

    @field_validator("moves", mode="before")
    @classmethod
    def _a_mapping_will_do(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            return tuple(Move(name, motion) for name, motion in value.items())
        return value

    @field_validator("friction", mode="before")
    @classmethod
    def _a_mapping_of_frictions_will_do(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            return tuple(FrictionOf(name, friction) for name, friction in value.items())
        return value

    @field_validator("moves")
    @classmethod
    def _are_of_different_names(cls, value: tuple[Move, ...]) -> tuple[Move, ...]:
        names = [move.name for move in value]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"{name} is moved twice; one motion each is needed")
        return value

    @property
    def changes(self) -> dict[str, Any]:
        """Attributes that are said of this stage, by name, without its name and end."""
        own = ("tools", "supports", "grippers", "pressures", "gravity", "damping", "director_damping", "target_step")
        return {name: getattr(self, name) for name in own if getattr(self, name) is not None}
