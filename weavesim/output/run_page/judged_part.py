"""The formed part against limits, and what speaks against the run: what the page says first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...input_files import shown
from ...measures.defects.judgement import Judgement, Limits, Region
from ..results import Results
from ..stored.judged import ToolsOfRun, distance_to, own_locking_angle, place_text, read_limits, region_text
from .shown_fields import JUDGED_FIELDS
from .values import number, words

# Field that shows what a region is about.
_FIELD = {
    "wrinkle": "wrinkle_amplitude", "bridging": "tool_gap", "gap": "tool_gap", "locking": "shear_angle",
    "self-contact": "self_contact_gap",
}  # fmt: skip
# More regions or elements than a reader looks at.
LARGEST_REGION_COUNT = 60


@dataclass(frozen=True)
class JudgedPart:
    """The sheets of a run against limits.

    Attributes:
        limits: that were looked at.
        sheets: the judgement of each sheet.
        regions: for the page, the most severe first.
        fields: of each sheet, at the last frame, by names of ``JUDGED_FIELDS``.
    """

    limits: Limits
    sheets: tuple[Judgement, ...] = ()
    regions: tuple[dict[str, Any], ...] = ()
    fields: tuple[dict[str, np.ndarray], ...] = field(default_factory=tuple)

    @property
    def region_count(self) -> int:
        """Of all sheets."""
        return sum(len(sheet.regions) for sheet in self.sheets)

    @property
    def limit_text(self) -> str:
        """What was looked at, in words."""
        limits, parts = self.limits, []
        if limits.wrinkle_amplitude is not None:
            parts.append(
                f"wrinkle amplitude {number(limits.wrinkle_amplitude, 'm')} where yarns are shortened by more than "
                f"{number(limits.wrinkle_compression)}"
            )
        if limits.bridging_gap is not None:
            parts.append(f"bridging gap {number(limits.bridging_gap, 'm')}")
        if limits.gap is not None:
            parts.append(f"gap {number(limits.gap, 'm')} anywhere")
        if limits.self_contact_gap is not None:
            parts.append(f"sheet within {number(limits.self_contact_gap, 'm')} of itself")
        angles = {sheet.locking_angle for sheet in self.sheets} - {None}
        parts += [f"shear angle {number(angle, 'degrees')}" for angle in sorted(a for a in angles if a is not None)]
        return "; ".join(parts) or "none"


def judge(results: Results, options: Mapping[str, Any]) -> JudgedPart | None:
    """Judge the sheets of a run at its last frame by the limits that its user gave; None for a run without tools.

    Args:
        results: of the run.
        options: given by the user, of which ``limits`` may name a file.
    """
    if not results.info.tools:
        return None
    limits = read_limits(Path(options["limits"]) if options.get("limits") else None)
    sheets, regions, fields = [], [], []
    names, tools = list(results.info.tool_names), ToolsOfRun(results.info.tools)
    for place, sheet in enumerate(results.sheets):
        judgement = Judgement(
            sheet.formed, limits, distance_to([(tools[names.index(name)], at) for name, _, at in sheet.tools]),
            own_locking_angle(sheet.info.fabric),
        )  # fmt: skip
        sheets.append(judgement)
        found = {one.name: judgement.fields.get(one.name) for one in JUDGED_FIELDS}
        # a sheet without folds is nowhere near itself
        fields.append(
            {
                name: sheet.in_whole(values)
                for name, values in found.items()
                if values is not None and np.isfinite(values).any()
            }
        )
        several = len(results.sheets) > 1
        name = sheet.info.name if several else ""
        regions += [region_of_page(region, place, name, sheet.elements) for region in judgement.regions]
    regions.sort(key=lambda region: -region["severity"])
    return JudgedPart(limits, tuple(sheets), tuple(regions[:LARGEST_REGION_COUNT]), tuple(fields))


def region_of_page(region: Region, place: int, name: str, elements: np.ndarray) -> dict[str, Any]:
    """A region for the page.

    Args:
        region: of a sheet.
        place: number of the sheet.
        name: of it, which is said if it is given.
        elements: places of its elements among those that the page shows, (k,).
    """
    text = region_text(region)
    return {
        "sheet": place,
        "kind": region.kind,
        "text": f"{name}: {text}" if name else text,
        "field": _FIELD[region.kind],
        "worst": int(elements[region.worst]),
        "elements": elements[region.elements].tolist(),
        "severity": region.severity,
    }


@dataclass(frozen=True)
class Remark:
    """One thing that a reader must know.

    Attributes:
        level: "do not use", "warning" or "note".
        text: what was found.
        advice: what it means, or what to do.
        where: sheet, place and time in words; "" if unknown.
        sheet, element: of the place, for the viewer; None if it has none.
    """

    level: str
    text: str
    advice: str = ""
    where: str = ""
    sheet: int | None = None
    element: int | None = None


def warnings_of(results: Results, summary: Mapping[str, Any]) -> list[Remark]:
    """Doubts, the worst first, then what could not be written, then notes about the input."""
    doubts: Sequence[Mapping[str, Any]] = summary.get("doubts") or ()
    order = {"do not use": 0, "warning": 1, "note": 2}
    found = [_of_doubt(results, doubt) for doubt in doubts]
    said = {str(doubt.get("message")) for doubt in doubts}
    advice = "see run.log; files that are named as missing are not there, the others are complete"
    found += [
        Remark("warning", shown(text), "" if text not in results.failures else advice)
        for text in results.warnings
        if text not in said
    ]
    found += [Remark("note", shown(str(note))) for note in summary.get("notes") or () if str(note) not in said]
    return sorted(found, key=lambda item: order.get(item.level, 1))


def _of_doubt(results: Results, doubt: Mapping[str, Any]) -> Remark:
    where, place, sheet, element = [], doubt.get("place_m"), None, None
    names = [one.info.name for one in results.sheets]
    if doubt.get("sheet") and len(names) > 1:
        where.append(f"sheet {doubt['sheet']}")
    if place:
        where.append(f"at {place_text([1.0e3 * float(value) for value in place[:2]])} mm on the flat blank")
        if len(names) == 1 or doubt.get("sheet") in names:
            sheet = 0 if len(names) == 1 else names.index(str(doubt["sheet"]))
            blank = results.sheets[sheet].info.blank
            centre = blank.material_coordinates[blank.quads].mean(axis=1)
            nearest = int(np.argmin(np.linalg.norm(centre - np.asarray(place, dtype=float)[:2], axis=1)))
            element = int(results.sheets[sheet].elements[nearest])
    if doubt.get("time_s") is not None:
        where.append(f"at {number(float(doubt['time_s']), 's')}")
    return Remark(
        str(doubt.get("level", "warning")), shown(str(doubt.get("text", ""))), shown(str(doubt.get("advice", ""))),
        ", ".join(where), sheet, element,
    )  # fmt: skip


def verdict_of(summary: Mapping[str, Any], outcome: str, part: JudgedPart | None) -> dict[str, Any]:
    """What the page says first: a word and a sentence on the run, and on the part.

    ``tone`` is "good", "doubtful", "bad" or "open".
    """
    word = str(summary.get("verdict") or "")
    doubts: Sequence[Mapping[str, Any]] = summary.get("doubts") or ()
    count = {level: sum(doubt.get("level") == level for doubt in doubts) for level in ("do not use", "warning", "note")}
    tone = {"trusted": "good", "doubtful": "doubtful", "do not use": "bad"}.get(word, "open")
    parts = [
        f"{count[level]} {text}{'s' * (count[level] > 1)}"
        for level, text in (("do not use", "reason not to use it"), ("warning", "warning"), ("note", "note"))
        if count[level]
    ]
    text = ", ".join(parts).replace("reason not to use its", "reasons not to use it") or "nothing speaks against it"
    if outcome == "running":
        word, tone, text = "running", "open", "The run goes on: this is what there is so far."
    elif outcome != "finished":
        tone = "bad" if tone == "bad" else "doubtful"
        rest = f"{text[:1].upper()}{text[1:]}"
        text = f"The run did not reach its end ({outcome}): what follows is its last good frame. {rest}"
    found: dict[str, Any] = {"word": words(word) if word else "not judged", "tone": tone, "text": text, "part": None}
    if part is not None:
        good = part.region_count == 0
        word = (
            "within all limits" if good else f"{part.region_count} region{'s' * (part.region_count > 1)} beyond limits"
        )
        found["part"] = {"word": word, "tone": "good" if good else "bad", "limits": part.limit_text}
    return found
