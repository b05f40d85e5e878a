"""Numbers of a run as measures of a study: those of its summary, by one name each, and some that vary little by chance.

A largest value over all elements is that of one element, and changes with the mesh and with every fold that falls
elsewhere. A percentile or a mean says more with fewer runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, did_you_mean
from ..measures.defects.judgement import Judgement, Limits
from ..measures.findings import Finding, FormedSheet, found
from ..measures.units import DEGREES, MILLIMETRES, PURE, SQUARE_MILLIMETRES, split_unit
from ..output.stored.judged import ToolsOfRun, distance_to, own_locking_angle
from ..run.staging.part import part_of
from ..sheet.topology import area_percentile, flat_areas

if TYPE_CHECKING:
    from ..run.simulation import Simulation

# Of clocks and machines: another in every run of the same set-up.
VOLATILE = {
    "wall_time_s", "stepping_time_s", "output_time_s", "element_steps_per_second", "threads", "run_id", "device",
    "weavesim_version",
}  # fmt: skip
PERCENTILE = 99.0


@dataclass(frozen=True, eq=False)
class FormedRun:
    """The sheets of a run at its end, judged."""

    sheets: tuple[Judgement, ...]

    @cached_property
    def areas(self) -> tuple[np.ndarray, ...]:
        """Areas of the elements of each flat sheet, (element_count,) each [m^2]."""
        return tuple(flat_areas(judged.sheet.blank) for judged in self.sheets)

    @cached_property
    def area(self) -> np.ndarray:
        """Those of all elements of all sheets, one after the other, (n,) [m^2]."""
        return np.concatenate(self.areas)

    def field(self, name: str) -> np.ndarray:
        """A field of all elements of all sheets, (n,), in the units of frames."""
        return np.concatenate([judged.fields[name] for judged in self.sheets])

    def percentile(self, name: str, share: float) -> float:
        """Value that a share [%] of the area stays below."""
        return area_percentile(self.field(name), self.area, share)

    def mean_square_root(self, name: str) -> float:
        """Root mean square over the area."""
        return math.sqrt(float(np.average(self.field(name) ** 2, weights=self.area)))

    def regions(self, kind: str) -> list[Any]:
        """Regions of one kind beyond their limit."""
        return [region for judged in self.sheets for region in judged.regions if region.kind == kind]

    @property
    def has_tools(self) -> bool:
        """Whether there are gaps."""
        return all(judged.distance is not None for judged in self.sheets)


def _largest(run: FormedRun, kind: str) -> float:
    return 1.0e3 * max((region.largest for region in run.regions(kind)), default=0.0)


STUDY_FINDINGS: tuple[Finding, ...] = (
    Finding(
        "max_shear_p99", DEGREES, "shear angle that 99 % of the area stay below",
        lambda run: run.percentile("shear_angle_deg", PERCENTILE),
    ),
    Finding(
        "mean_shear", DEGREES, "mean shear angle over the area",
        lambda run: float(np.average(run.field("shear_angle_deg"), weights=run.area)),
    ),
    Finding(
        "wave_amplitude_rms", MILLIMETRES, "amplitude of waves shorter than the limits' longest, root mean square",
        lambda run: 1.0e3 * run.mean_square_root("wrinkle_amplitude"),
    ),
    Finding(
        "wave_amplitude_p99", MILLIMETRES, "amplitude of waves that 99 % of the area stay below",
        lambda run: 1.0e3 * run.percentile("wrinkle_amplitude", PERCENTILE),
    ),
    Finding("wrinkle_count", PURE, "wrinkles beyond the limits", lambda run: len(run.regions("wrinkle"))),
    Finding(
        "wrinkle_area", SQUARE_MILLIMETRES, "area of the wrinkles beyond the limits",
        lambda run: 1.0e6 * sum(region.area for region in run.regions("wrinkle")),
    ),
    Finding(
        "largest_wrinkle", MILLIMETRES, "largest amplitude of a wrinkle beyond the limits",
        lambda run: _largest(run, "wrinkle"),
    ),
    Finding(
        "bridging_area", SQUARE_MILLIMETRES, "area that bridges hollows, beyond the limits",
        lambda run: 1.0e6 * sum(region.area for region in run.regions("bridging")) if run.has_tools else None,
    ),
    Finding(
        "largest_bridging_gap", MILLIMETRES, "largest gap of it",
        lambda run: _largest(run, "bridging") if run.has_tools else None,
    ),
)  # fmt: skip


def formed_run(simulation: Simulation, limits: Limits) -> FormedRun:
    """The sheets of a run as they are now."""
    info, frame = simulation.info, simulation.frame
    tools = ToolsOfRun(info.tools)

    def judged(place: int) -> Judgement:
        sheet, state = part_of(info.sheets[place], frame.sheets[place])
        acting = [(tools[k], frame.place(k)) for k in sheet.tools if frame.acts(k)]
        formed = FormedSheet(
            sheet.blank, state.position, state.fields, sheet.fabric.thickness, sheet.symmetry,
            follows_thickness=sheet.follows_thickness,
        )  # fmt: skip
        return Judgement(formed, limits, distance_to(acting), own_locking_angle(sheet.fabric))

    return FormedRun(tuple(judged(place) for place in range(len(info.sheets))))


def study_numbers(simulation: Simulation, limits: Limits) -> dict[str, float]:
    """``STUDY_FINDINGS`` of a run as it is now."""
    return found(STUDY_FINDINGS, formed_run(simulation, limits))


def flattened(summary: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a summary by dotted names, such as "peak_tool_force_n.punch"; those of clocks are left out."""
    numbers: dict[str, Any] = {}

    def enter(name: str, value: Any) -> None:
        if isinstance(value, bool):
            numbers[name] = int(value)
        elif isinstance(value, int | float):
            numbers[name] = value
        elif isinstance(value, Mapping):
            for key, item in value.items():
                enter(f"{name}.{key}", item)
        elif isinstance(value, list | tuple):
            for index, item in enumerate(value, start=1):
                label = item.get("name", index) if isinstance(item, Mapping) else index
                enter(f"{name}.{label}", item)

    for key, value in summary.items():
        if key not in VOLATILE and key not in ("doubts", "warnings", "notes"):
            enter(key, value)
    return numbers


def resolved(name: str, known: Iterable[str]) -> str:
    """The key of a measure that a user names with or without its unit.

    Raises:
        InputError: there is none, or several.
    """
    names = set(known)
    if name in names:
        return name
    same = sorted(key for key in names if _without_unit(key) == name or key.endswith(f".{name}"))
    if len(same) == 1:
        return same[0]
    if same:
        raise InputError(f"{name!r}: several numbers have this name; write one of {', '.join(same[:8])}")
    hint = did_you_mean(name, sorted({*names, *map(_without_unit, names)}))
    raise InputError(f"{name!r}: a run has no such number{hint}; docs/studies.md and docs/results.md list them")


def _without_unit(key: str) -> str:
    head, dot, tail = key.partition(".")
    return split_unit(head)[0] + dot + tail


def unit_of(key: str) -> str:
    """Symbol of the unit of a number, by its name; "" for a pure number."""
    parts = [split_unit(part)[1].symbol for part in key.split(".")]
    return next((part for part in parts if part), "")
