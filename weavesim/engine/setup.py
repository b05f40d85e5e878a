"""All input of a run as one value: sheets and tools in their worlds, duration, and solver settings.

A set-up is checked on construction, which does not load Warp, compile or step.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Self

from pydantic import field_validator, model_validator

from ..checks import NotNegative, Parameters, Positive
from ..device import LARGEST_THREAD_COUNT, Precision, resolve_precision
from ..errors import InputError, did_you_mean
from ..names import FileName, Label
from ..process.dynamics import Dynamics
from ..process.grippers import Gripper
from ..process.interfaces import Interface
from ..process.scaling.mass import MassScaling
from ..process.stages import Stage
from ..process.supports import Support
from ..ranges import Quantity, check_usual
from ..sheet.sheet import Sheet
from ..sheet.symmetry import AXES, Symmetry
from ..tools.proportions import disproportionate_tools
from ..tools.tool import Tool
from .staging.acting import Parts
from .staging.change_checks import check_changes
from .staging.checks import check_stages

# Largest share of the stable step 2/omega that may be used.
STEP_SAFETY = 0.9
# Elements per kernel thread: on a GPU, and on a CPU.
LANE_COUNTS = (1, 16)
# Fields of a world that a set-up with one world accepts directly.
_WORLD_FIELDS = ("sheets", "tools", "symmetry", "dynamics", "interfaces")


class Solver(Parameters):
    """Settings for how and where a run is computed.

    Attributes:
        device: "cpu", "cuda:0", ...
        precision: scalar type of state and kernels, "float32" or "float64".
        threads: CPU threads; None uses the fastest number, measured during the run.
        lane_count: elements per kernel thread, 1 or 16; chosen by the device if None.
        time_step: largest step allowed [s]; must be stable. None uses the stable step.
        target_step: step for which the mass is scaled up [s]; None adds no mass.
        mass_scaling: how ``target_step`` was found, by ``choose_mass_scaling``, for the summary; None if it was given.
        step_safety: share of the stable step 2/omega that is used; a smaller one reduces the error of the time
            integration.
    """

    device: str = "cpu"
    precision: Precision = Precision.SINGLE
    threads: int | None = None
    lane_count: int | None = None
    time_step: Annotated[Positive, Quantity("time step")] | None = None
    target_step: Annotated[Positive, Quantity("time step")] | None = None
    mass_scaling: MassScaling | None = None
    step_safety: float = STEP_SAFETY

    @field_validator("precision", mode="before")
    @classmethod
    def _is_a_precision(cls, value: Any) -> Precision:
        return resolve_precision(value)

    @field_validator("threads")
    @classmethod
    def _are_some(cls, value: int | None) -> int | None:
        if value is not None and not 1 <= value <= LARGEST_THREAD_COUNT:
            raise ValueError(f"1 to {LARGEST_THREAD_COUNT} threads are allowed")
        return value

    @field_validator("lane_count")
    @classmethod
    def _is_known(cls, value: int | None) -> int | None:
        if value not in (None, *LANE_COUNTS):
            raise ValueError(f"{LANE_COUNTS[0]} or {LANE_COUNTS[1]} lanes are allowed")
        return value

    @field_validator("step_safety")
    @classmethod
    def _is_stable(cls, value: float) -> float:
        if not 0.0 < value <= STEP_SAFETY:
            raise ValueError(f"must be above 0 and at most {STEP_SAFETY} to be stable")
        return value

    @model_validator(mode="after")
    def _is_what_was_found(self) -> Self:
        found = self.mass_scaling
        if found is not None and found.target_step != self.target_step:
            raise ValueError(
                f"mass_scaling found target_step = {found.target_step} s, and it is {self.target_step} s; give that, "
                "or leave mass_scaling out"
            )
        return self

    def lanes(self, *, is_cpu: bool) -> int:
        """Elements per kernel thread on a CPU or a GPU."""
        return self.lane_count or LANE_COUNTS[is_cpu]


class Rest(Parameters):
    """Ends a run at the first frame in which its sheets are at rest.

    Attributes:
        after: earliest time [s].
        kinetic_share: kinetic over internal energy below which a sheet counts as at rest.
    """

    positional = ("after", "kinetic_share")

    after: Annotated[NotNegative, Quantity("time")]
    kinetic_share: Annotated[Positive, Quantity("energy share")]

    def reached(self, time: float, energies: Mapping[str, float]) -> bool:
        """Whether a frame at ``time`` [s] with these ``energies`` [J] is at rest."""
        return time > self.after and energies["kinetic"] < self.kinetic_share * energies["internal"]


class World(Parameters):
    """Sheets that share tools, gravity and damping. Objects in different worlds never touch.

    Attributes:
        sheets: at least one.
        tools: rigid, in the order of all outputs.
        symmetry: planes at which the sheets are cut; their nodes on these planes are held accordingly.
        dynamics: gravity, damping and contact.
        interfaces: which sheets touch; others pass through each other.
        name: of the world.
    """

    positional = ("sheets", "tools")

    sheets: tuple[Sheet, ...]
    tools: tuple[Tool, ...] = ()
    symmetry: Symmetry = Symmetry()
    dynamics: Dynamics = Dynamics()
    interfaces: tuple[Interface, ...] = ()
    name: Label = "world"

    @field_validator("symmetry", mode="before")
    @classmethod
    def _planes_will_do(cls, value: Any) -> Any:
        return Symmetry(tuple(value)) if isinstance(value, tuple | list) else value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not self.sheets:
            raise ValueError(f"world {self.name}: at least one sheet is needed")
        _check_names("tools", [tool.name for tool in self.tools])
        for sheet in self.sheets:
            sheet.check_symmetry(self.symmetry)
        for plane in self.symmetry.planes:
            if self.dynamics.gravity[AXES[plane]] != 0.0:
                raise ValueError(
                    f"gravity = {self.dynamics.gravity}: it pulls across the plane of symmetry {plane} = 0, in whose "
                    f"mirror image it would pull the other way; leave {plane!r} out of symmetry"
                )
        self._check_interfaces()
        return self

    def _check_interfaces(self) -> None:
        names = [sheet.name for sheet in self.sheets]
        _check_names("interfaces", [" / ".join(sorted((each.lower, each.upper))) for each in self.interfaces])
        for interface in self.interfaces:
            for name in (interface.lower, interface.upper):
                if name not in names:
                    raise ValueError(
                        f"interface {interface.name}: there is no sheet {name!r} in world {self.name}; its sheets are "
                        f"{', '.join(names)}{did_you_mean(name, names)}"
                    )
        own = [sheet.name for sheet in self.sheets if sheet.self_contact is not None]
        if own and self.dynamics.contact_thickness != "initial":
            raise ValueError(
                f"contact_thickness = {self.dynamics.contact_thickness!r}: self-contact of sheet {own[0]} is at the "
                'initial thickness; write "initial"'
            )
        if self.interfaces and self.dynamics.contact_thickness != "initial":
            raise ValueError(
                f"contact_thickness = {self.dynamics.contact_thickness!r}: interfaces between plies are at the initial "
                'thickness; write "initial"'
            )

    def disproportions(self) -> Iterator[str]:
        for sheet in self.sheets:
            yield from disproportionate_tools(sheet, self.tools, self.symmetry)


class Setup(Parameters):
    """All input of a run.

    With one world, its ``sheets``, ``tools``, ``symmetry`` and ``dynamics`` may be given directly instead of
    ``worlds``.

    Attributes:
        name: used for the names of the result files, so no path.
        worlds: sheets and their tools; the names of all sheets must differ, and those of all supports.
        duration: time at which the run ends [s]; with stages, the sum of theirs, which it need not be given.
        frame_count: frames after the first, evenly spaced in time; see ``Stage.frame_count``.
        leading_tool: index, among the tools of all worlds, of the tool whose displacement is the stroke.
        rest: ends the run early, at rest; None runs the full duration.
        solver: how and where the run is computed.
        stages: of the process, one after the other; none for a run in which everything acts all the time.
        accept_unusual: take values outside their plausible range, or that hardly fit each other, as meant
            (docs/fabrics.md); otherwise they are refused, with the likely slip.

    Raises:
        InputError: any bad input that can be detected without a device.
    """

    positional = ("name", "worlds")

    name: FileName
    worlds: tuple[World, ...]
    duration: Annotated[Positive, Quantity("duration")]
    frame_count: int = 60
    leading_tool: int = 0
    rest: Rest | None = None
    solver: Solver = Solver()
    stages: tuple[Stage, ...] = ()
    accept_unusual: bool = False

    @model_validator(mode="before")
    @classmethod
    def _one_world_will_do(cls, values: Any) -> Any:
        if not isinstance(values, Mapping):
            return values
        if values.get("stages") and values.get("duration") is None:
            values = {**values, "duration": _duration_of(values["stages"])}
        own = {name: values[name] for name in _WORLD_FIELDS if name in values}
        if not own:
            return values
        if "worlds" in values:
            raise ValueError(f"{', '.join(own)}: belong in worlds, which are given too")
        if "sheets" not in own:
            raise ValueError("sheets: is required")
        return {**{name: value for name, value in values.items() if name not in own}, "worlds": (World(**own),)}

    @field_validator("frame_count")
    @classmethod
    def _has_frames(cls, value: int) -> int:
        if value < 1:
            raise ValueError("at least one frame is needed")
        return value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not self.worlds:
            raise ValueError("worlds: at least one is needed")
        if not 0 <= self.leading_tool < max(1, len(self.tools)):  # without tools it stays 0
            raise ValueError(f"leading_tool = {self.leading_tool}: there are {len(self.tools)} tools, counted from 0")
        _check_names("worlds", [world.name for world in self.worlds])
        _check_names("sheets", [sheet.name for sheet in self.sheets])
        _check_names("supports", [support.name for support in self.supports])
        _check_names("grippers", [gripper.name for gripper in self.grippers])
        if self.stages:
            self._check_stages()
        return self

    def _check_stages(self) -> None:
        _check_names("stages", [stage.name for stage in self.stages])
        # stages say by name what acts
        _check_names("tools", [tool.name for tool in self.tools])
        if self.rest is not None:
            raise ValueError("rest: with stages, let the last one end AtRest instead")
        if self.duration != _duration_of(self.stages):
            raise ValueError(
                f"duration = {self.duration:g}: the stages take {_duration_of(self.stages):g} s together; leave it out"
            )
        check_changes(self.stages, self.tools, self.sheets, self.interfaces)
        touching = frozenset(name for each in self.interfaces for name in (each.lower, each.upper))
        check_stages(self.stages, Parts(self.tools, self.supports, self.grippers), self.sheets, touching)

    @model_validator(mode="after")
    def _is_usual(self) -> Self:
        if not self.accept_unusual:
            check_usual(self)
        return self

    @property
    def frame_counts(self) -> tuple[int, ...]:
        """Frames after the first, of every stage, or of the run without stages."""
        if not self.stages:
            return (self.frame_count,)
        shares = [self.frame_count * stage.duration / self.duration for stage in self.stages]
        return tuple(each.frame_count or max(1, round(share)) for each, share in zip(self.stages, shares, strict=True))

    @property
    def trims(self) -> bool:
        """Whether a stage trims a sheet."""
        return any(stage.trims for stage in self.stages)

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """Of all worlds, in order."""
        return tuple(sheet for world in self.worlds for sheet in world.sheets)

    @property
    def sheet(self) -> Sheet:
        """The only sheet of a run.

        Raises:
            InputError: the run has several.
        """
        if len(self.sheets) != 1:
            raise InputError(f"setup {self.name}: it has {len(self.sheets)} sheets; use one of setup.sheets")
        return self.sheets[0]

    @property
    def tools(self) -> tuple[Tool, ...]:
        """Of all worlds, in order."""
        return tuple(tool for world in self.worlds for tool in world.tools)

    @property
    def grippers(self) -> tuple[Gripper, ...]:
        """Of all sheets, in order."""
        return tuple(gripper for sheet in self.sheets for gripper in sheet.grippers)

    @property
    def interfaces(self) -> tuple[Interface, ...]:
        """Of all worlds, in order."""
        return tuple(interface for world in self.worlds for interface in world.interfaces)

    @property
    def supports(self) -> tuple[Support, ...]:
        """Of all sheets, in order."""
        return tuple(support for sheet in self.sheets for support in sheet.supports)


def _duration_of(stages: Any) -> float | None:
    """Of all stages, which may be values or what JSON has of them [s]; None where that is no number."""
    try:
        return sum(float(s["duration"] if isinstance(s, Mapping) else s.duration) for s in stages)
    except (AttributeError, KeyError, TypeError, ValueError):
        return None


def _check_names(what: str, names: list[str]) -> None:
    for index, name in enumerate(names):
        if name in names[:index]:
            raise ValueError(
                f"{what}: the name {name!r} of entry {index} is that of entry {names.index(name)} already; outputs "
                "tell them apart by their names, so give each its own"
            )


def hash_of_run(setup: Setup) -> str:
    """What is the same for set-ups whose runs have the same states, wherever they are computed and shown."""
    elsewhere = {"device": "cpu", "precision": "float32", "threads": None, "lane_count": None}
    solver = setup.solver.model_copy(update=elsewhere)
    stages = tuple(stage.model_copy(update={"frame_count": None}) for stage in setup.stages)
    return setup.model_copy(update={"solver": solver, "frame_count": 1, "stages": stages}).content_hash
