"""Lines of the table of what is known before a run, and those of the damping."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...engine.setup import Setup
from ...process.stages import AtRest
from ...run.staging.rehearsal import Phase, phases_of
from ...sheet.blank import Blank
from ...sheet.symmetry import AXES, Symmetry
from .damping import FAR_OFF, release_damping, slowest_bending, suggested_damping
from .speed import KINETIC_SHARE

OK, NOTE, LOOK = "ok", "note", "look"


class Row(NamedTuple):
    """A line of the table.

    Attributes:
        topic: of the group of lines.
        what: that is known.
        value: with its unit.
        judgement: "ok", "note" or "look"; "" for a mere fact.
        advice: what to do, or how it is judged.
    """

    topic: str
    what: str
    value: str
    judgement: str = ""
    advice: str = ""


def damping_rows(setup: Setup) -> Iterator[Row]:
    """The damping while tools move, and that of every stage that is to come to rest, beside what is suggested."""
    phases = phases_of(setup)
    forming = [phase for phase in phases if not isinstance(phase.end_by, AtRest)]
    time = sum(phase.end - phase.begin for phase in forming)
    stages: dict[float, list[str]] = {}
    for phase in forming:
        stages.setdefault(_rate(phase), []).append(phase.name)
    for given, names in stages.items():
        suggested = suggested_damping(time)
        most = 2.0 * suggested * time * KINETIC_SHARE
        far = given < suggested / FAR_OFF or given > suggested * FAR_OFF
        slow = "vibrations last for the whole run" if given < suggested else "it holds back what moves slowly"
        alone = "of nodes" if len(phases) == 1 else "while tools move"
        yield Row(
            "damping",
            alone if len(stages) == 1 else f"in {', '.join(names)}",
            f"{given:g} 1/s",
            LOOK if far else OK,
            (f"{slow}; " if far else "")
            + f"suggested: {suggested:g} 1/s, by which vibrations fall by e six times in {1e3 * time:.3g} ms; a sheet "
            f"as fast as its punch all the way would lose {most:.0%} of the work of shearing, most moves far less",
        )
    for phase in phases:
        if isinstance(phase.end_by, AtRest):
            yield from _damping_to_rest(phase)


def _damping_to_rest(phase: Phase) -> Iterator[Row]:
    length, sheet = max(
        ((_length(sheet.blank, world.symmetry), sheet) for world in phase.setup.worlds for sheet in world.sheets),
        key=lambda each: each[0],
    )
    slowest = slowest_bending(sheet.fabric, length)
    if slowest == 0.0:
        return
    given, suggested = _rate(phase), release_damping(sheet.fabric, length)
    low = given < suggested / FAR_OFF
    yield Row(
        "damping",
        f"until {phase.name} is at rest",
        f"{given:g} 1/s",
        LOOK if low else NOTE if given > suggested * FAR_OFF else OK,
        ("it swings for long; " if low else "it creeps to its rest; " if given > suggested * FAR_OFF else "")
        + f"suggested: {suggested:g} 1/s, critical for the slowest bending of the flat sheet, {slowest:.3g} rad/s; a "
        "formed part is stiffer",
    )


def _length(blank: Blank, symmetry: Symmetry) -> float:
    """The longer side of a whole blank, of which symmetry may leave a half or a quarter [m]."""
    sides = np.ptp(blank.node_position[:, :2], axis=0)
    sides[[AXES[plane] for plane in symmetry.planes]] *= 2.0
    return float(sides.max())


def _rate(phase: Phase) -> float:
    return max(world.dynamics.damping for world in phase.setup.worlds)
