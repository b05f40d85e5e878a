"""The tables of a study file. Documents (docs/studies.md) are generated from them."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ..checks import Finite, NotNegative, Positive
from ..job.tables import JobTable
from ..measures.defects.judgement import Limits
from ..names import Label
from ..ranges import ACCEPTING_IN_FILE, Quantity, check_usual

Method = Literal["factorial", "latin-hypercube", "sobol", "optimise"]
# More runs than this are hardly meant.
LARGEST_RUN_COUNT = 1_000_000
# Where numerical noise is estimated if nothing is said.
NOISE_POINTS = 3


class VaryTable(JobTable):
    """A parameter: keys of the job, and the values that they take. `[[vary]]`, one table per parameter."""

    key: str | tuple[str, ...] = Field(
        description="of the job, as --set takes it, such as tools.ring.force; several get the same value"
    )
    name: Label | None = Field(default=None, description="in all results; the key if left out")
    range: tuple[Any, Any] | None = Field(default=None, description="smallest and largest value, with units or in SI")
    values: tuple[Any, ...] | None = Field(default=None, description="the values themselves, of any kind")
    mean: Any = Field(default=None, description="of a normal distribution, which is cut off at three deviations")
    deviation: Any = Field(default=None, description="standard deviation of that distribution")
    count: int | None = Field(default=None, ge=2, description="number of values of a factorial study")
    scale: Literal["linear", "log"] = Field(default="linear", description="of the range")
    step: Any = Field(default=None, description="values are multiples of it, counted from the smallest; 1 counts")

    @model_validator(mode="after")
    def _is_given_in_one_way(self) -> Self:
        ways = [name for name in ("range", "values", "mean") if getattr(self, name) is not None]
        if len(ways) != 1:
            what = f"{' and '.join(ways)} are given" if ways else "none is given"
            raise ValueError(f"range, values or mean: one of them is needed, {what}")
        if (self.mean is None) != (self.deviation is None):
            raise ValueError("mean and deviation: both are needed")
        if self.range is None:
            for name in ("count", "step"):
                if getattr(self, name) is not None:
                    raise ValueError(f"{name}: has no effect without a range; leave it out")
            if self.scale != "linear":
                raise ValueError("scale: has no effect without a range; leave it out")
        if self.values is not None and len(self.values) < 2:
            raise ValueError(f"values = {list(self.values)}: at least two are needed")
        return self


class MeasureTable(JobTable):
    """A number of each run. `[[measure]]`, one table per measure."""

    name: str = Field(description="of a number of the summary, with or without its unit; docs/studies.md lists more")
    goal: Literal["least", "most"] | None = Field(default=None, description="what is best; only shown if left out")
    at_most: Finite | None = Field(default=None, description="a run beyond it is not good, in the measure's unit")
    at_least: Finite | None = Field(default=None, description="a run below it is not good")

    @model_validator(mode="after")
    def _leaves_some(self) -> Self:
        if self.at_most is not None and self.at_least is not None and self.at_most < self.at_least:
            raise ValueError(
                f"at_most = {self.at_most:g}, at_least = {self.at_least:g}: no run can be good; exchange them"
            )
        return self


class NoiseTable(JobTable):
    """Numerical noise: some runs are repeated with a change that means nothing. `[noise]`."""

    repeats: int = Field(default=4, ge=2, le=1000, description="of each of these runs, besides the run itself")
    by: Literal["unevenness", "mesh"] = Field(
        default="unevenness", description="a random initial velocity across the plies, or another mesh size"
    )
    points: int | Literal["all"] = Field(
        default=NOISE_POINTS, description="how many points are repeated, spread over the study, or all"
    )
    speed: Annotated[Positive, Quantity("speed")] = Field(
        default=0.01, description="of the unevenness, root mean square"
    )
    spread: Annotated[Positive, Quantity("strain")] = Field(
        default=0.05, description="largest share by which the mesh size is changed"
    )

    @model_validator(mode="after")
    def _are_some(self) -> Self:
        if self.points != "all" and self.points < 1:
            raise ValueError(f"points = {self.points}: at least 1 is needed")
        return self


class StudyTable(JobTable):
    """Top of a study file."""

    name: Label = Field(default="study", description="title of the page")
    job: str = Field(description="the job file, beside the study file")
    method: Method = Field(
        default="factorial",
        description="all combinations; a Latin hypercube; Sobol's design, which gives indices; or optimisation",
    )
    set: tuple[str, ...] = Field(
        default=(), description='values of the job for all runs, such as "ply.mesh_size=10 mm"'
    )
    samples: int | None = Field(
        default=None, ge=2, le=LARGEST_RUN_COUNT,
        description="runs of a Latin hypercube; of Sobol's design a power of two, times the number of parameters + 2",
    )  # fmt: skip
    budget: int | None = Field(
        default=None, ge=2, le=LARGEST_RUN_COUNT, description="points that an optimisation may try"
    )
    batch: int = Field(default=4, ge=1, le=10_000, description="points that an optimisation tries at a time")
    optimiser: Literal["tpe", "cma-es", "gp"] = Field(
        default="tpe", description="tree-structured Parzen estimator; CMA-ES; Gaussian process (needs PyTorch)"
    )
    scenarios: int = Field(
        default=4, ge=2, le=10_000, description="of a robust optimisation: samples of [[scatter]] at each point"
    )
    risk: NotNegative = Field(
        default=2.0, description="of a robust optimisation: best is mean plus so many standard deviations"
    )
    accept: Literal["trusted", "doubtful", "do not use"] = Field(
        default="doubtful", description="worst verdict that a run may have to be called best"
    )
    seed: int = Field(default=0, ge=0, le=2**31, description="of designs and optimisers")
    retries: int = Field(default=2, ge=0, le=100, description="times that a run is tried again if its worker dies")
    field_points: int = Field(
        default=1000, ge=4, le=1_000_000, description="material points of --fields on each ply, about"
    )
    vary: tuple[VaryTable, ...] = Field(default=(), description="[[vary]]")
    scatter: tuple[VaryTable, ...] = Field(
        default=(), description="[[scatter]]: parameters that nobody controls, for a robust optimisation"
    )
    measure: tuple[MeasureTable, ...] = Field(default=(), description="[[measure]]")
    noise: NoiseTable | None = Field(default=None, description="[noise]")
    limits: Limits = Field(default=Limits(), description="[limits], of wrinkles and bridging, as weavesim verdict has")
    accept_unusual: bool = Field(default=False, description="take unusual limits as meant; the job has its own")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not self.vary:
            raise ValueError("[[vary]]: at least one parameter is needed")
        if not self.accept_unusual:
            check_usual(self.limits, "limits", ACCEPTING_IN_FILE)
        if not self.measure:
            raise ValueError("[[measure]]: at least one measure is needed")
        names = [measure.name for measure in self.measure]
        if again := next((name for place, name in enumerate(names) if name in names[:place]), None):
            raise ValueError(f"[[measure]]: {again} is given twice; give each once, with its goal and its limits")
        needed = {"latin-hypercube": "samples", "sobol": "samples", "optimise": "budget"}.get(self.method)
        if needed is not None and getattr(self, needed) is None:
            raise ValueError(f'{needed}: is required with method = "{self.method}"')
        for name in ("samples", "budget"):
            if getattr(self, name) is not None and name != needed:
                raise ValueError(f'{name}: has no effect with method = "{self.method}"; leave it out')
        if self.method == "sobol" and self.samples is not None and self.samples & (self.samples - 1):
            raise ValueError(f"samples = {self.samples}: a power of two is needed for Sobol's design, such as 64")
        goals = [measure for measure in self.measure if measure.goal]
        if self.method == "optimise" and not goals:
            raise ValueError('[[measure]]: an optimisation needs one with goal = "least" or "most"')
        if self.scatter and self.method != "optimise":
            raise ValueError('[[scatter]]: has no effect without method = "optimise"; use [[vary]]')
        for name in ("batch", "optimiser"):
            if name in self.model_fields_set and self.method != "optimise":
                raise ValueError(f'{name}: has no effect without method = "optimise"; leave it out')
        for name in ("scenarios", "risk"):
            if name in self.model_fields_set and not self.scatter:
                raise ValueError(f"{name}: has no effect without [[scatter]]; leave it out")
        if self.scatter and self.noise is not None:
            raise ValueError(
                "[noise]: has no effect with [[scatter]], whose scenarios make the error bars; leave it out"
            )
        if self.optimiser == "cma-es" and len(goals) > 1:
            raise ValueError('optimiser = "cma-es": one measure may have a goal; "tpe" takes several')
        return self
