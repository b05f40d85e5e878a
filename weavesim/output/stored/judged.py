"""Judgement of a whole run: every sheet by the same limits; ``verdict.json``, ``verdict.csv`` and a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...measures.defects.judgement import Distance, Judgement, Limits, Region
from ...ranges import read_parameters
from ...tools.surfaces.distance import ToolDistance
from ..files import write_summary
from ..tables import write_table
from .file import StoredRun, StoredSheet

if TYPE_CHECKING:
    from ...fabric.fabric import Fabric
    from ...process.motions.paths import Place
    from ...tools.tool import Tool

_COLUMNS = (
    "sheet", "kind", "place_x_mm", "place_y_mm", "place_z_mm", "flat_x_mm", "flat_y_mm", "area_mm2", "amplitude_mm",
    "wavelength_mm", "crest_count", "gap_mm", "shear_angle_deg", "severity", "element_count",
)  # fmt: skip


def read_limits(path: Path | None) -> Limits:
    """Limits of a TOML or JSON file, or those that are built in.

    Raises:
        InputError: a file that cannot be read, or limits that are not allowed or not usual.
    """
    return Limits() if path is None else read_parameters(Limits, path, "file of limits")


@dataclass(frozen=True, eq=False)
class JudgedRun:
    """The sheets of a run with what is beyond the limits.

    Attributes:
        run: that was judged.
        limits: that it has to keep.
        sheets: in the order of the run.
    """

    run: StoredRun
    limits: Limits
    sheets: tuple[Judgement, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing is beyond a limit."""
        return not any(sheet.regions for sheet in self.sheets)

    def as_dict(self) -> dict[str, Any]:
        """As ``verdict.json`` has it."""
        return {
            "run_id": self.run.run_id,
            "passed": self.passed,
            "limits": self.limits.model_dump(mode="json"),
            "sheets": [
                {
                    "name": stored.name,
                    "locking_angle_deg": sheet.locking_angle,
                    "largest_amplitude_mm": 1.0e3 * float(sheet.fields["wrinkle_amplitude"].max()),
                    "largest_gap_mm": 1.0e3 * float(sheet.fields["gap"].max()) if "gap" in sheet.fields else None,
                    "largest_compression": float(sheet.fields["yarn_compression"].max()),
                    "largest_shear_angle_deg": float(sheet.fields["shear_angle_deg"].max()),
                    "regions": [region.as_dict() for region in sheet.regions],
                }
                for stored, sheet in zip(self.run.sheets, self.sheets, strict=True)
            ],
        }

    def rows(self) -> Iterator[dict[str, Any]]:
        """A row for each region."""
        for stored, sheet in zip(self.run.sheets, self.sheets, strict=True):
            for region in sheet.regions:
                row = region.as_dict()
                place, flat = row.pop("place_mm"), row.pop("flat_place_mm")
                names = ("place_x_mm", "place_y_mm", "place_z_mm", "flat_x_mm", "flat_y_mm")
                yield {"sheet": stored.name, **row, **dict(zip(names, (*place, *flat), strict=True))}

    def lines(self) -> Iterator[str]:
        """What a user is told."""
        count = sum(len(sheet.regions) for sheet in self.sheets)
        yield "within all limits" if self.passed else f"beyond limits: {count} region{'s' * (count > 1)}"
        for stored, sheet in zip(self.run.sheets, self.sheets, strict=True):
            name = f"{stored.name}: " if len(self.sheets) > 1 else ""
            for region in sheet.regions:
                yield f"  {name}{region_text(region)}"


def region_text(region: Region) -> str:
    """Kind, place, size, severity and area of a region in one line."""
    row = region.as_dict()
    size = {
        "wrinkle": "amplitude {amplitude_mm:.2f} mm, wavelength {wavelength_mm:.0f} mm, {crest_count} crests",
        "locking": "shear angle {shear_angle_deg:.1f} degrees",
    }.get(row["kind"], "gap {gap_mm:.2f} mm")
    text = f"{size.format(**row)}, {row['severity']:.2g} times the limit, {row['area_mm2']:.0f} mm²"
    return f"{row['kind']} at {place_text(row['place_mm'])} mm: {text}"


def place_text(place: Sequence[float]) -> str:
    """A place in whole numbers: "(72, -0.3, -12)" as "(72, 0, -12)"."""
    return f"({', '.join(f'{round(value):d}' for value in place)})"


def judge_run(run: StoredRun, limits: Limits) -> JudgedRun:
    """Judge every sheet of a run at its end."""
    tools = ToolsOfRun(run.tools)
    return JudgedRun(run, limits, tuple(_judge(run, sheet, limits, tools) for sheet in run.sheets))


def _judge(run: StoredRun, sheet: StoredSheet, limits: Limits, tools: ToolsOfRun) -> Judgement:
    distance = tool_distance(run, sheet, tools)
    return Judgement(run.formed(sheet), limits, distance, own_locking_angle(run.fabric(sheet)))


def own_locking_angle(fabric: Fabric) -> float | None:
    """Where the shear law of a fabric locks [degrees]; None if it does not."""
    law = fabric.shear
    angle = getattr(law, "locking_angle", None) if law.locking_slope else None
    return None if angle is None else math.degrees(angle)


class ToolsOfRun:
    """Distances to the tools of a run; a tool of several sheets is sampled once, when it is first asked for.

    Args:
        tools: in the order of the run.
    """

    def __init__(self, tools: Sequence[Tool]) -> None:
        self._tools, self._found = tuple(tools), dict[int, ToolDistance]()

    def __getitem__(self, number: int) -> ToolDistance:
        if number not in self._found:
            self._found[number] = ToolDistance(self._tools[number])
        return self._found[number]


def tool_distance(run: StoredRun, sheet: StoredSheet, tools: ToolsOfRun) -> Distance | None:
    """Distance to the nearest tool of a sheet that acts at the end of its run; None without one."""
    return distance_to([(tools[k], run.place(k)) for k in run.acting_tools(sheet)])


def distance_to(tools: Sequence[tuple[ToolDistance, Place]]) -> Distance | None:
    """Distance to the nearest of tools at their places; None without tools."""
    if not tools:
        return None

    def distance(points: np.ndarray) -> np.ndarray:
        return np.min([tool(points, place)[0] for tool, place in tools], axis=0)

    return distance


def write_judged(folder: Path, judged: JudgedRun) -> list[Path]:
    """Write ``verdict.json``, ``verdict.csv`` and ``verdict.png``; returns the files."""
    from ..pictures.style import write_picture
    from ..pictures.verdict import verdict_picture

    files = [folder / f"verdict.{ending}" for ending in ("json", "csv", "png")]
    write_summary(files[0], judged.as_dict())
    write_table(files[1], _COLUMNS, ([row.get(name, "") for name in _COLUMNS] for row in judged.rows()))
    names = [sheet.name for sheet in judged.run.sheets]
    write_picture(verdict_picture(names, judged.sheets), files[2], judged.run.run_id)
    return files
