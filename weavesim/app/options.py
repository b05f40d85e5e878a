"""Options common to all scenes: mesh size, device and precision, output folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator

from ..checks import Parameters, Positive
from ..device import LARGEST_THREAD_COUNT, Precision
from ..engine.setup import Solver
from ..output.writer import chosen_writers, known_writers
from ..ranges import Quantity, check_usual


class RunOptions(Parameters):
    """Base class of a scene's parameters; every field becomes a command-line option.

    A scene sets its own defaults by redeclaring a field. A field's ``description`` is the option's help text.
    """

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
    out: Path = Field(default=Path("out"), description="folder for the results")
    write: str | None = Field(
        default=None,
        description=f"results to write, comma-separated: {','.join(known_writers())} [default: all]",
    )
    without: str | None = Field(default=None, description="results to leave out, comma-separated")
    overwrite: bool = Field(default=False, description="replace the results of an earlier run in that folder")

    accept_unusual: bool = Field(
        default=False, description="take unusual values as meant, such as a thickness that looks like millimetres"
    )

    @field_validator("write", "without")
    @classmethod
    def _are_known(cls, value: str | None) -> str | None:
        chosen_writers(_names(value))
        return value

    @model_validator(mode="after")
    def _is_usual(self) -> Self:
        if not self.accept_unusual:
            check_usual(self)
        return self

    @property
    def writers(self) -> tuple[str, ...]:
        """Names of the requested writers, for a ``ResultFolder``."""
        return tuple(kind.name for kind in chosen_writers(_names(self.write), _names(self.without) or ()))

    def solver(self, **given: Any) -> Solver:
        """Solver settings from these options; ``given`` are additional values."""
        return Solver(
            device=self.device, precision=self.precision, threads=self.threads, time_step=self.time_step,
            target_step=self.target_step, **given,
        )  # fmt: skip


def _names(value: str | None) -> list[str] | None:
    """ "film, report" as a list; None stays None."""
    return None if value is None else [name.strip() for name in value.split(",") if name.strip()]
