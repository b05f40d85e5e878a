"""Options common to all scenes: mesh size, device and precision, output folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple, Self

from pydantic import Field, field_validator, model_validator

from ..checks import NotNegative, Parameters, Positive, as_typed
from ..device import LARGEST_THREAD_COUNT, Precision
from ..engine.setup import Solver
from ..output.writer import chosen_writers, known_writers
from ..process.scaling.mass import Tolerances, tolerances_of
from ..ranges import Quantity, check_usual
from ..run.checkpoint.pace import INTERVAL
from ..run.estimate import BYTES_PER_ELEMENT

# Beyond it the user is asked.
LARGEST_ELEMENT_COUNT = 1.0e6


class Need(NamedTuple):
    """What an option needs to have an effect.

    Attributes:
        text: in words, after "without".
        is_met: whether the options have it.
    """

    text: str
    is_met: Callable[[Any], bool]


class RunOptions(Parameters):
    """Base class of a scene's parameters; every field becomes a command-line option.

    A scene sets its own defaults by redeclaring a field. A field's ``description`` is the option's help text.
    ``needs`` names the options that have an effect only together with others; given without these they are refused. A
    scene's own are added to those of its base classes.
    """

    needs: ClassVar[Mapping[str, Need]] = {
        "threads": Need("device = cpu", lambda options: options.device == "cpu"),
        "limits": Need("strict", lambda options: options.strict),
        "strict": Need("the results file (results)", lambda options: "results" in options.writers),
    }

    mesh_size: Annotated[Positive, Quantity("mesh size")] = Field(
        default=0.005, description="edge length of an element [m]"
    )
    device: str = Field(default="cpu", description='where to compute: "cpu" or "cuda:0", "cuda:1", ...')
    precision: Precision = Field(default=Precision.SINGLE, description="scalar type of state and kernels")
    threads: Annotated[int, Field(ge=1, le=LARGEST_THREAD_COUNT)] | None = Field(
        default=None, description="CPU threads; results are bit-identical for any number [default: fastest, measured]"
    )
    time_step: Annotated[Positive, Quantity("time step")] | None = Field(
        default=None, description="largest time step [s]; must be stable"
    )
    target_step: Annotated[Positive, Quantity("time step")] | None = Field(
        default=None, description="scale the mass until this time step is stable [s]; the added mass is reported"
    )
    mass_scaling_angle: Annotated[Positive, Quantity("angle error")] | None = Field(
        default=None,
        description="find the largest mass scaling, by runs on elements 1.5 times as large, that changes the shear "
        "angles by at most this [degrees]; with mass_scaling_draw_in",
    )
    mass_scaling_draw_in: Annotated[Positive, Quantity("position error")] | None = Field(
        default=None,
        description="the same for the border of the sheets [m]; by default 0.5 degrees and 0.0005 m, if one is given",
    )
    out: Path = Field(default=Path("out"), description="folder for the results")
    write: str | None = Field(
        default=None,
        description=f"results to write, comma-separated: {','.join(known_writers())} [default: all]",
    )
    without: str | None = Field(default=None, description="results to leave out, comma-separated")
    solver_fields: bool = Field(
        default=False, description="frames for ParaView have the fields of the solver too, unit_cell_*"
    )
    overwrite: bool = Field(default=False, description="replace the results of an earlier run in that folder")
    checkpoint_interval: Annotated[NotNegative, Quantity("wall time")] = Field(
        default=INTERVAL,
        description="wall time between two checkpoints, from which weavesim resume goes on [s]; 0 writes none",
    )
    stop_on: str | None = Field(
        default=None,
        description="guards that end the run, comma-separated: GUARD, GUARD:do-not-use, or do-not-use for any",
    )

    strict: bool = Field(
        default=False, description="judge the run by limits at its end: exit code 5 beyond one (weavesim verdict)"
    )
    limits: Path | None = Field(default=None, description="TOML file of these limits [default: built in]")
    accept_unusual: bool = Field(
        default=False, description="take unusual values as meant, such as a thickness that looks like millimetres"
    )

    @field_validator("out", mode="before")
    @classmethod
    def _is_named(cls, value: Any) -> Any:
        if isinstance(value, str) and not value.strip():
            raise ValueError("a folder is needed ('.' is the current one)")
        return value

    @field_validator("write", "without")
    @classmethod
    def _are_known(cls, value: str | None) -> str | None:
        chosen_writers(_names(value))
        return value

    @field_validator("stop_on")
    @classmethod
    def _are_guards(cls, value: str | None) -> str | None:
        if value is not None:
            from ..run.watch.stops import stop_levels

            stop_levels(_names(value) or ())
        return value

    @model_validator(mode="after")
    def _leaves_results(self) -> Self:
        if not self.writers:
            given = "write" if self.write is not None else "without"
            raise ValueError(
                f"{as_typed(given)} = {getattr(self, given)!r}: no results would be written; choose from "
                f"{', '.join(known_writers())}"
            )
        return self

    @model_validator(mode="after")
    def _scales_in_one_way(self) -> Self:
        if self.tolerances is not None and (self.target_step is not None or self.time_step is not None):
            name = "target_step" if self.target_step is not None else "time_step"
            raise ValueError(
                f"{as_typed(name)}: it is what a search by {as_typed('mass_scaling_angle')} or "
                f"{as_typed('mass_scaling_draw_in')} is to find; give one of them"
            )
        return self

    @model_validator(mode="after")
    def _writes_solver_fields(self) -> Self:
        if self.solver_fields and "paraview" not in self.writers:
            raise ValueError(f"{as_typed('solver_fields')}: has no effect without the results paraview; leave it out")
        return self

    @model_validator(mode="after")
    def _has_an_effect(self) -> Self:
        needs = {
            name: need for cls in reversed(type(self).__mro__) for name, need in vars(cls).get("needs", {}).items()
        }
        for name, need in needs.items():
            default = type(self).model_fields[name].get_default(call_default_factory=True)
            if getattr(self, name) != default and not need.is_met(self):
                # not the whole sentence: "without" and "out" are options too
                given = f"{as_typed(name)} = {getattr(self, name)}"
                raise ValueError(f"{given}: has no effect without {as_typed(need.text)}; leave it out")
        return self

    @model_validator(mode="after")
    def _is_usual(self) -> Self:
        if not self.accept_unusual:
            check_usual(self)
        return self

    def blank_area(self) -> float | None:
        """Area of all blanks that the scene divides into elements of ``mesh_size`` [m^2]; None if it does not."""
        return None

    def disproportions(self) -> Iterator[str]:
        """A mesh that is far too fine for its blank, before it is made."""
        count = (self.blank_area() or 0.0) / self.mesh_size**2
        if count > LARGEST_ELEMENT_COUNT:
            yield (
                f"mesh_size = {self.mesh_size:g} m divides the blank into about {count:,.0f} elements, which take "
                f"{count * BYTES_PER_ELEMENT / 1e9:,.0f} GB of memory"
            )

    @property
    def writers(self) -> tuple[str, ...]:
        """Names of the requested writers, for a ``ResultFolder``."""
        return tuple(kind.name for kind in chosen_writers(_names(self.write), _names(self.without) or ()))

    @property
    def tolerances(self) -> Tolerances | None:
        """What a mass scaling has to keep, for ``choose_mass_scaling``; None if none is sought."""
        return tolerances_of(self.mass_scaling_angle, self.mass_scaling_draw_in)

    @property
    def stops(self) -> tuple[str, ...]:
        """What ends the run, for a ``Simulation``."""
        return tuple(_names(self.stop_on) or ())

    def solver(self, **given: Any) -> Solver:
        """Solver settings from these options; ``given`` are additional values."""
        return Solver(
            device=self.device, precision=self.precision, threads=self.threads, time_step=self.time_step,
            target_step=self.target_step, **given,
        )  # fmt: skip


def _names(value: str | None) -> list[str] | None:
    """ "film, report" as a list; None stays None."""
    return None if value is None else [name.strip() for name in value.split(",") if name.strip()]
