"""Everything that the page says, from the results of a run or of a run in progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...measures.findings import SHEET_FINDINGS
from ...measures.units import Unit, split_unit
from ...run.frame import Outcome, RunInfo
from ...run.verdict import RUN_FINDINGS
from ...sheet.topology import area_percentile, flat_areas
from ..history import History, energy_copies, tool_copies
from ..results import Results
from .fabric_part import fabrics_of
from .history_part import charts_of, share_text
from .judged_part import JudgedPart, Remark, judge, verdict_of, warnings_of
from .provenance import provenance_rows, record_of
from .recorder import FrameRecorder
from .scene import scene_of
from .setup_rows import setup_tables
from .values import Row, number, text_of, words

Part = TypeVar("Part")

DESCRIPTIONS = {finding.key: finding.description for finding in (*SHEET_FINDINGS, *RUN_FINDINGS)}
# Shown by themselves, or not for readers of a page.
_ELSEWHERE = (
    "warnings", "missing", "doubts", "notes", "sheets", "energies_j", "verdict", "run_id", "name", "weavesim_version",
    "peak_tool_force_n", "outcome",
)  # fmt: skip
# What a reader sees first, those of them that a run has.
_HEADLINE = (
    ("max_shear_angle_deg", "largest shear angle"), ("draw_in_long_axis_mm", "draw-in, long axis"),
    ("draw_in_short_axis_mm", "draw-in, short axis"), ("max_thickness_mm", "largest thickness"),
    ("min_stretch", "smallest yarn stretch"), ("wall_time_s", "wall time"),
)  # fmt: skip
# Pictures that the page shows by itself, and better.
_DRAWN_ANEW = ("tool_forces", "energies", "drive_forces")
# Of a run in progress the page has at most about so many frames: it is written often.
LIVE_FRAME_COUNT = 24
SHARES = {1.0: "whole blank", 0.5: "half of the blank", 0.25: "quarter of the blank"}


@dataclass
class PageContent:
    """What the template shows; see it for how."""

    title: str
    run_id: str
    subtitle: str
    verdict: dict[str, Any]
    headline: list[tuple[str, str]] = field(default_factory=list)
    regions: list[dict[str, Any]] = field(default_factory=list)
    warnings: list[Remark] = field(default_factory=list)
    draw_in: list[tuple[Path, str]] = field(default_factory=list)
    pictures: list[tuple[Path, str]] = field(default_factory=list)
    fallback: list[tuple[Path, str]] = field(default_factory=list)
    forces: list[tuple[str, str, str]] = field(default_factory=list)
    numbers: list[tuple[str, list[Row]]] = field(default_factory=list)
    fabrics: list[dict[str, Any]] = field(default_factory=list)
    setup: list[tuple[str, list[Row]]] = field(default_factory=list)
    options: list[Row] = field(default_factory=list)
    provenance: list[Row] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    data: dict[str, Any] = field(default_factory=dict)


class ConstantParts:
    """What does not change during a run: its fabrics and its set-up, computed at their first use."""

    def __init__(self, info: RunInfo) -> None:
        self._info = info

    def prepare(self) -> None:
        """Compute them now; what fails does so again where it is used, and is told there."""
        with suppress(Exception):
            _ = self.fabrics, self.setup

    @cached_property
    def fabrics(self) -> list[dict[str, Any]]:
        """Of ``fabrics_of``."""
        return fabrics_of(self._info)

    @cached_property
    def setup(self) -> list[tuple[str, list[Row]]]:
        """Of ``setup_tables``."""
        return setup_tables(self._info)


@dataclass
class BegunPage:
    """What can be said before anything else is written.

    Attributes:
        content: without what ``finished`` adds.
        part: the judgement of the part; None if there is none.
    """

    content: PageContent
    part: JudgedPart | None

    def finished(self, results: Results) -> PageContent:
        """The page of a run that has ended, with the pictures that were drawn, and the failures."""
        summary, info, content, part = results.whole_summary, results.info, self.content, self.part
        pictures = [picture for picture in results.pictures if picture[0].stem not in _DRAWN_ANEW]
        content.verdict = verdict_of(summary, _outcome(summary), part)
        content.headline = list(_headline(summary))
        content.warnings = warnings_of(results, summary)
        content.fallback = [item for item in pictures if item[0].stem.startswith("formed_sheet")]
        content.draw_in = [item for item in pictures if item[0].stem.startswith("draw_in")]
        content.pictures = [item for item in pictures if item not in (*content.fallback, *content.draw_in)]
        content.forces = list(_forces(info, results.history, summary))
        content.numbers = _numbers(info, {**summary, "support_force_n": _on_supports(info, summary)})
        content.options = [
            Row(words(name), text_of(value)) for name, value in results.setup.items() if not _says_nothing(value)
        ]
        return content


def begun_page(
    results: Results, recorder: FrameRecorder, folder: Path, constant: ConstantParts | None = None
) -> BegunPage:
    """The page of a run that has ended, however it did, as far as it does not depend on what is written."""
    outcome, failed = _outcome(results.whole_summary), list[str]()
    options = record_of(folder).get("options") or {}
    part: JudgedPart | None = _safely("the judgement of the part", failed, None, partial(judge, results, options))
    constant = constant or ConstantParts(results.info)
    content = _frame_of_page(results.info, results.history, recorder, folder, outcome, failed, part, constant)
    content.regions = content.data["regions"] = list(part.regions) if part else []
    return BegunPage(content, part)


def _outcome(summary: Mapping[str, Any]) -> str:
    return str(summary.get("outcome") or Outcome.FINISHED.value)


def page_so_far(
    info: RunInfo, history: History, recorder: FrameRecorder, folder: Path, constant: ConstantParts | None = None
) -> PageContent:
    """The page of a run that goes on: of its frames so far at most about ``LIVE_FRAME_COUNT``, evenly spaced."""
    recorder = recorder.thinned(LIVE_FRAME_COUNT)
    constant = constant or ConstantParts(info)
    content = _frame_of_page(info, history, recorder, folder, "running", [], None, constant)
    content.verdict = verdict_of({}, "running", None)
    content.forces = list(_forces(info, history, {}))
    return content


def _frame_of_page(
    info: RunInfo, history: History, recorder: FrameRecorder, folder: Path, outcome: str, failed: list[str],
    part: JudgedPart | None, constant: ConstantParts,
) -> PageContent:  # fmt: skip
    """What finished and running runs have in common."""
    title = info.name.replace("_", " ")
    scene = partial(scene_of, info, recorder, history, part.fields if part else ())
    none: list[Any] = []
    areas = np.concatenate([flat_areas(sheet.blank) / sheet.symmetry.share for sheet in info.sheets])
    angles = [_angles(frame, areas) for frame in _shear_angles(recorder, info)]
    return PageContent(
        title[:1].upper() + title[1:],
        info.run_id,
        _subtitle(info, outcome),
        {},
        fabrics=_safely("the curves of the fabric", failed, none, lambda: constant.fabrics),
        setup=_safely("the set-up", failed, none, lambda: constant.setup),
        provenance=provenance_rows(record_of(folder), info.run_id),
        failures=failed,
        data={
            "run": {"name": info.name, "id": info.run_id, "outcome": outcome, "duration": info.duration},
            "scene": _safely("the view", failed, {"frameCount": 0, "sheets": [], "tools": []}, scene),
            "charts": _safely("the charts", failed, none, partial(charts_of, info, history, recorder.places, angles)),
            "regions": [],
        },
    )


def _safely(what: str, failed: list[str], otherwise: Part, make: Callable[[], Part]) -> Part:
    """A part of the page; one that cannot be made is named, and costs nothing else."""
    try:
        return make()
    except Exception as error:
        failed.append(f"{what} could not be made: {type(error).__name__}: {error}")
        return otherwise


def _subtitle(info: RunInfo, outcome: str) -> str:
    fabrics = ", ".join(dict.fromkeys(sheet.fabric.name for sheet in info.sheets))
    shares = ", ".join(dict.fromkeys(SHARES[sheet.symmetry.share] for sheet in info.sheets))
    state = "in progress" if outcome == "running" else outcome
    plies = f"{len(info.sheets)} sheets · " if len(info.sheets) > 1 else ""
    return f"{fabrics} · {plies}{shares} computed{share_text(info)} · {info.element_count} elements · run {state}"


def _headline(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, label in _HEADLINE:
        if isinstance(value := summary.get(key), int | float) and not isinstance(value, bool):
            _, unit = split_unit(key)
            yield label, with_unit(float(value), unit)


def with_unit(value: float, unit: Unit) -> str:
    """A number in the unit of its name, for readers."""
    text = number(value)
    return text if text == "–" or not unit.symbol else f"{text}{'' if unit.symbol == '°' else chr(0x202F)}{unit.symbol}"


def _forces(info: RunInfo, history: History, summary: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Tool, force at the last frame and largest force in any step [N], on the whole part, along the tool's axis."""
    peaks = summary.get("peak_tool_force_n") or {}
    for k, (name, tool, copies) in enumerate(zip(info.tool_names, info.tools, tool_copies(info), strict=True)):
        last = "–"
        if history.frame_count:
            last = number(copies * abs(float(history.tool_reaction[-1, k] @ np.asarray(tool.axis, dtype=float))), "N")
        peak = number(copies * float(peaks[name]), "N") if name in peaks else "–"
        yield name.replace("_", " "), last, peak


def _numbers(info: RunInfo, summary: Mapping[str, Any]) -> list[tuple[str, list[Row]]]:
    tables = [("Numbers of the run", list(_rows(summary)))]
    tables += [(f"Sheet {sheet['name']}", list(_rows(sheet))) for sheet in summary.get("sheets") or ()]
    if isinstance(energies := summary.get("energies_j"), Mapping):
        copies = energy_copies(info) or 1.0
        rows = [Row(words(name), number(copies * float(value), "J")) for name, value in energies.items() if value]
        tables.append(("Energies at the end", rows))
    return [(heading, rows) for heading, rows in tables if rows]


def _on_supports(info: RunInfo, summary: Mapping[str, Any]) -> dict[str, list[float]]:
    """Force of each support and its mirror images on the whole part [N]: what points across a plane cancels."""
    forces = summary.get("support_force_n") or {}
    found: dict[str, list[float]] = {}
    for sheet in info.sheets:
        factors = np.sum([(*each, 1.0) for each in sheet.symmetry.mirror_factors], axis=0)
        names = [info.supports[place].name for place in sheet.supports]
        found |= {name: (factors * np.asarray(forces[name])).tolist() for name in names if name in forces}
    return found


def _rows(summary: Mapping[str, Any]) -> Iterator[Row]:
    for key, value in summary.items():
        if key in _ELSEWHERE or _says_nothing(value):
            continue
        name, unit = split_unit(key)
        yield Row(words(name), _text(value, unit), meaning=DESCRIPTIONS.get(key, ""))


def _says_nothing(value: Any) -> bool:
    return value is None or (hasattr(value, "__len__") and len(value) == 0)


def _text(value: Any, unit: Unit) -> str:
    if isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and unit.symbol):
        return with_unit(float(value), unit)
    if isinstance(value, Mapping):
        return "; ".join(f"{_label(str(key))} {_text(item, _own(str(key), unit))}" for key, item in value.items())
    if isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value):
        return " | ".join(_text(item, unit) for item in value)
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, np.generic):
        return _text(value.item(), unit)
    if isinstance(value, list | tuple) and all(isinstance(item, int | float) for item in value):
        # one unit behind all
        text = ", ".join(number(float(item)) for item in value)
        return f"{text}{'' if unit.symbol in ('', '°') else chr(0x202F)}{unit.symbol}"
    return text_of(value)


def _label(key: str) -> str:
    """The name of an entry without its unit, in words; names of things keep their capitals."""
    name, unit = split_unit(key.lower())
    return words(key[: len(name)] if unit.symbol else key)


def _own(key: str, unit: Unit) -> Unit:
    """Unit of an entry: that of its own name, or else that of the whole."""
    own = split_unit(key.lower())[1]
    return own if own.symbol else unit


def _shear_angles(recorder: FrameRecorder, info: RunInfo) -> Iterator[list[np.ndarray]]:
    fields = [recorder.field(k, "shear_angle") for k in range(len(info.sheets) if recorder.frame_count else 0)]
    if fields and all(kept is not None for kept in fields):
        for place in range(len(recorder.places)):
            yield [np.abs(np.rad2deg(kept.values[place])) for kept in fields if kept is not None]


def _angles(sheets: list[np.ndarray], areas: np.ndarray) -> list[float]:
    every = np.concatenate(sheets)
    return [float(np.nanmax(every)), area_percentile(every, areas, 99.0)]
