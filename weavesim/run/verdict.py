"""Assessment of a run: its numbers. What speaks against them is said by ``guards``."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measures.findings import SHEET_FINDINGS, Finding, FormedSheet, found
from ..measures.units import DEGREES, JOULES, MILLIMETRES, NEWTONS, PER_SECOND, PURE, SECONDS
from ..version import __version__
from .frame import SheetFrame, SheetInfo
from .guards.law_range import beyond_data
from .staging.part import part_of

if TYPE_CHECKING:
    from .simulation import Simulation
    from .watch.condition import Condition, StackCondition
    from .watch.extremes import Extremes

# The balance error of a state is relative to the work so far, but at least to this share of the run's work.
LEAST_WORK = 1.0e-4
# Below this share of the thickness as a lift of all sheets under gravity, nothing has happened: no ratio is formed.
LEAST_LIFT = 1.0e-3
GRAVITY = 9.81
# Hourglass and kinetic over internal energy are judged only above this share of the largest internal energy.
LEAST_INTERNAL = 0.05


@dataclass(frozen=True, eq=False)
class Judged:
    """A run, and intermediate values that several of its numbers use."""

    run: Simulation

    @cached_property
    def sheets(self) -> list[FormedSheet]:
        """At the last frame, without what was trimmed."""
        return [
            FormedSheet(info.blank, frame.position, frame.fields, info.fabric.thickness, info.symmetry)
            for info, frame in self._parts
        ]

    @cached_property
    def _parts(self) -> list[tuple[SheetInfo, SheetFrame]]:
        return [part_of(*each) for each in zip(self.run.info.sheets, self.run.frame.sheets, strict=True)]

    @cached_property
    def step_count(self) -> int:
        """Of the run so far."""
        return self.run.state.step_count

    @cached_property
    def history(self) -> list[dict[str, float]]:
        """Time, stroke and energies of all states that the run watched, at least one."""
        return self.run.watch.history

    @cached_property
    def least_energy(self) -> float:
        """Energy below which nothing has happened: ``LEAST_LIFT`` of the thickness as a lift of the sheets [J]."""
        sheets = self.run.model.sheets
        return sum(LEAST_LIFT * GRAVITY * float(s.node_mass.sum()) * s.fabric.thickness for s in sheets)

    @cached_property
    def scale(self) -> float | None:
        """Largest supplied, kinetic or internal energy of any state [J]; None where nothing has happened."""
        names = ("supplied", "kinetic", "internal")
        largest = float(np.max([abs(entry[name]) for entry in self.history for name in names]))
        return None if largest < self.least_energy else largest  # not finite: a number that is then doubted

    @cached_property
    def stored(self) -> list[dict[str, float]]:
        """States that store enough energy for energy ratios to be meaningful."""
        largest = max(max(entry["internal"] for entry in self.history), self.least_energy / LEAST_INTERNAL)
        return [entry for entry in self.history if entry["internal"] > LEAST_INTERNAL * largest]

    @cached_property
    def last_quarter(self) -> list[dict[str, float]]:
        """The ``stored`` states in the last quarter of the stroke; without a stroke, of the time; before a release."""
        released = self.run.stages.released
        last = released or self.run.frame
        stroke, time = abs(last.stroke), last.time
        return [
            entry
            for entry in self.stored
            if (released is None or entry["time"] <= time)
            and (abs(entry["stroke"]) >= 0.75 * stroke if stroke > 0.0 else entry["time"] >= 0.75 * time)
        ]

    @cached_property
    def balance_errors(self) -> list[tuple[float, float]]:
        """Error of the energy balance over the work, and time [s], of all states; none where nothing has happened."""
        scale = self.scale
        if scale is None:
            return []
        # what contact stores at the start, as under a ring in touch, was neither supplied nor made by the run
        start = self.history[0]["balance_error"]
        return [
            (
                abs(entry["balance_error"] - start)
                / max(abs(entry["supplied"]), entry["used"], self.least_energy, LEAST_WORK * scale),
                entry["time"],
            )
            for entry in self.history
        ]

    def shares(self, name: str, entries: list[dict[str, float]]) -> list[tuple[float, float]]:
        """An energy over the internal energy, and time [s], of some states."""
        return [(entry[name] / entry["internal"], entry["time"]) for entry in entries]

    @property
    def damping_rates(self) -> list[tuple[float, float]]:
        """Mean power of the damping [W] between two states, up to a release, and time of the second one [s]."""
        end = (self.run.stages.released or self.run.frame).time
        entries = [entry for entry in self.history if entry["time"] <= end]
        return [
            ((now["damping_loss"] - last["damping_loss"]) / (now["time"] - last["time"]), now["time"])
            for last, now in pairwise(entries)
        ]

    @property
    def damping_share(self) -> float | None:
        """Damping loss over ``scale``, up to a release: damping has to stop a sheet that is released."""
        last = self.run.stages.released or self.run.frame
        return None if self.scale is None else last.energies["damping_loss"] / self.scale

    def share_of_supplied(self, name: str) -> float | None:
        """An entry of the ledger at the last frame over ``scale``."""
        return None if self.scale is None else self.run.frame.energies[name] / self.scale

    @property
    def extremes(self) -> Extremes:
        """Over all steps so far."""
        return self.run.watch.extremes

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Of every sheet so far: passes through itself, folds."""
        return self.run.watch.conditions

    @property
    def stacks(self) -> tuple[StackCondition, ...]:
        """Of the sheets of every world with several: pass through each other."""
        return self.run.watch.stacks

    @cached_property
    def thickness(self) -> float:
        """Of the thinnest sheet [m]."""
        return min(sheet.fabric.thickness for sheet in self.run.info.sheets)

    def number(self, key: str) -> Any:
        """A number of the summary."""
        if key not in self._numbers:
            self._numbers[key] = next(finding for finding in RUN_FINDINGS if finding.key == key).compute(self)
        return self._numbers[key]

    @cached_property
    def _numbers(self) -> dict[str, Any]:
        return {}

    def values(self, name: str) -> list[np.ndarray]:
        """A field of every sheet at the last frame."""
        return [frame.fields[name] for _, frame in self._parts]


def _of_sheets(name: str, which: Callable[[Any], float]) -> Finding:
    """A finding of sheets as a finding of a run: the value chosen by ``which`` among all sheets."""
    finding = next(finding for finding in SHEET_FINDINGS if finding.name == name)
    return Finding(
        name, finding.unit, finding.description,
        lambda judged: which(finding.compute(sheet) for sheet in judged.sheets),
    )  # fmt: skip


def _largest(values: list[tuple[float, float]]) -> float | None:
    """The largest of values with their times; one that is not a number is above all others."""
    return float(np.max([value for value, _ in values])) if values else None


def _gravity_ratio(judged: Judged) -> float | None:
    share = judged.share_of_supplied("gravity_work")
    return None if share is None else abs(share)


def _furthest(judged: Judged, name: str) -> list[float]:
    """An extreme of every sheet over all steps."""
    return [getattr(sheet, name).value for sheet in judged.extremes.sheets]


def _penetration_at_nodes(judged: Judged) -> float | None:
    """None in a run without tools."""
    if not judged.run.info.tools:
        return None
    return 1e3 * (max(_furthest(judged, "depth")) or judged.run.penetration.at_nodes)


def _penetration_of_surface(judged: Judged) -> float | None:
    """None in a run without tools."""
    return 1e3 * judged.run.penetration.at_surface if judged.run.info.tools else None


def _penetration_at_element_centres(judged: Judged) -> float | None:
    """None in a run without tools."""
    return 1e3 * judged.run.penetration.at_element_centres if judged.run.info.tools else None


def _peak_forces(judged: Judged) -> dict[str, float]:
    return dict(zip(judged.run.info.tool_names, judged.extremes.tools["peak"].tolist(), strict=True))


def _support_forces(judged: Judged) -> dict[str, list[float]]:
    names = (support.name for support in judged.run.info.supports)
    return {name: force.tolist() for name, force in zip(names, judged.run.frame.support_force, strict=True)}


def _sheet_intersections(judged: Judged) -> dict[str, dict[str, int]] | None:
    """None in a run whose sheets cannot meet."""
    return {
        f"{first} and {second}": {
            "at_end": int(tally.last), "most": int(tally.most), "total": stack.total[first, second],
            "state_count": stack.look_count,
        }
        for stack in judged.stacks
        for (first, second), tally in stack.crossings.items()
    } or None  # fmt: skip


RUN_FINDINGS: tuple[Finding, ...] = (
    Finding("weavesim_version", PURE, "version of weavesim", lambda judged: __version__),
    Finding("name", PURE, "of the run", lambda judged: judged.run.info.name),
    Finding(
        "fabric", PURE, "names of the fabrics",
        lambda judged: ", ".join(dict.fromkeys(sheet.fabric.name for sheet in judged.run.info.sheets)),
    ),
    Finding(
        "outcome", PURE, "how the run ended",
        lambda judged: judged.run.outcome.value if judged.run.outcome else "not run",
    ),
    Finding("device", PURE, "that computed", lambda judged: judged.run.info.device),
    Finding("precision", PURE, "scalar type of state and kernels", lambda judged: judged.run.info.precision),
    Finding("threads", PURE, "CPU threads that most steps ran on", lambda judged: judged.run.stepper.thread_count),
    Finding("lane_count", PURE, "elements per kernel thread", lambda judged: judged.run.model.lane_count),
    Finding("element_count", PURE, "elements of all sheets", lambda judged: judged.run.info.element_count),
    Finding("node_count", PURE, "nodes of all sheets", lambda judged: judged.run.info.node_count),
    Finding("step_count", PURE, "time steps", lambda judged: judged.step_count),
    Finding("time_step", SECONDS, "mean time step", lambda judged: judged.run.state.time / max(judged.step_count, 1)),
    Finding("time", SECONDS, "time reached", lambda judged: judged.run.state.time),
    Finding("wall_time", SECONDS, "wall time", lambda judged: judged.run.wall_time),
    Finding("stepping_time", SECONDS, "wall time of the steps", lambda judged: judged.run.stepping_time),
    Finding(
        "output_time", SECONDS, "wall time of frames and their files",
        lambda judged: max(judged.run.wall_time - judged.run.stepping_time, 0.0),
    ),
    Finding(
        "element_steps", PER_SECOND, "elements times steps over the wall time of the steps",
        lambda judged: judged.run.info.element_count * judged.step_count / max(judged.run.stepping_time, 1.0e-9),
    ),
    Finding(
        "interfaces", PURE, "force, pressure, slip, entry offset and energies of every interface between plies",
        lambda judged: judged.run.ledger.interface_report() or None,
    ),
    Finding(
        "stages", PURE, "of every stage: name, begin, end, what ended it, whether that was wanted, stroke",
        lambda judged: judged.run.stages.ended or None,
    ),
    Finding(
        "trims", PURE,
        "of every trim: stage, sheet, time, area, mass, momentum and energy of the waste, and how far the new border "
        "is off the curves",
        lambda judged: judged.run.stages.trimmed or None,
    ),
    _of_sheets("max_shear_angle", max),
    _of_sheets("min_stretch", min),
    _of_sheets("max_stretch", max),
    Finding(
        "max_shear_angle_of_run", DEGREES, "largest shear angle at any time",
        lambda judged: math.degrees(max(_furthest(judged, "angle"))),
    ),
    Finding(
        "min_stretch_of_run", PURE, "smallest yarn stretch at any time",
        lambda judged: min(_furthest(judged, "min_stretch")),
    ),
    Finding(
        "max_stretch_of_run", PURE, "largest yarn stretch at any time",
        lambda judged: max(_furthest(judged, "max_stretch")),
    ),
    Finding(
        "share_beyond_data", PURE, "largest share of the elements of a sheet that left the measured range of a law",
        lambda judged: max(
            (entry.share for info, sheet in zip(judged.run.info.sheets, judged.extremes.sheets, strict=False)
             for entry in beyond_data(info.fabric, sheet.rows)),
            default=0.0,
        ),
    ),
    Finding(
        "hourglass_energy_ratio", PURE, "hourglass over internal energy, the largest",
        lambda judged: _largest(judged.shares("hourglass", judged.stored)) or 0.0,
    ),
    Finding(
        "kinetic_energy_ratio", PURE, "kinetic over internal energy, the largest of the last quarter",
        lambda judged: _largest(judged.shares("kinetic", judged.last_quarter)) or 0.0,
    ),
    Finding(
        "damping_loss_ratio", PURE, "damping loss over the largest supplied, kinetic or internal energy",
        lambda judged: judged.damping_share,
    ),
    Finding(
        "gravity_work_ratio", PURE, "work of gravity over the same",
        _gravity_ratio,
    ),
    Finding(
        "energy_balance_error", PURE, "error of the energy balance over the work, the largest",
        lambda judged: _largest(judged.balance_errors),
    ),
    Finding(
        "added_mass_ratio", PURE, "mass that scaling added, over the blank's",
        lambda judged: max(sheet.added_mass_ratio for sheet in judged.run.model.sheets),
    ),
    Finding(
        "mass_scaling", PURE,
        "how the scaling of the mass was found for a stated error: tolerances, what was tried on a coarser mesh, the "
        "factor and the target step that were chosen",
        lambda judged: scaling.as_told() if (scaling := judged.run.setup.solver.mass_scaling) else None,
    ),
    Finding("support_force", NEWTONS, "force of each support on its sheet, by name", _support_forces),
    Finding("peak_tool_force", NEWTONS, "largest force of the sheets on each tool in any step, by name", _peak_forces),
    Finding(
        "penetration_at_nodes", MILLIMETRES, "deepest node in a tool at any time, if any was touched",
        _penetration_at_nodes,
    ),
    Finding(
        "penetration_of_surface", MILLIMETRES,
        "deepest point of a sheet's surface, as its directors describe it, in a tool, of the watched states",
        _penetration_of_surface,
    ),
    Finding(
        "penetration_at_element_centres", MILLIMETRES,
        "deepest middle of a flat element in a tool, of the watched states; over curved tools most is the chord",
        _penetration_at_element_centres,
    ),
    Finding(
        "self_intersections", PURE, "pairs of triangles of a sheet that pass through each other, at the end",
        lambda judged: sum(int(condition.crossings.last) for condition in judged.conditions),
    ),
    Finding(
        "most_self_intersections", PURE, "the same at the worst of the watched states",
        lambda judged: sum(int(condition.crossings.most) for condition in judged.conditions),
    ),
    Finding(
        "sheet_intersections", PURE,
        "pairs of triangles of two sheets that pass through each other, by the sheets' names: at the end, at the worst "
        "of the watched states, and the sum over all of these",
        _sheet_intersections,
    ),
    Finding(
        "folded_elements", PURE, "elements or neighbours folded onto each other, at the worst of the watched states",
        lambda judged: sum(int(condition.folded.most) for condition in judged.conditions),
    ),
    Finding(
        "inverted_elements", PURE, "elements turned over against their directors, at the worst of the watched states",
        lambda judged: sum(int(condition.inverted.most) for condition in judged.conditions),
    ),
    Finding(
        "beyond_symmetry", MILLIMETRES, "furthest that a node was beyond a symmetry plane",
        lambda judged: 1e3 * max(condition.beyond.most for condition in judged.conditions),
    ),
    Finding(
        "unit_cell_max_residual", PURE, "worst residual of a unit cell",
        lambda judged: max(float(values.max()) for values in judged.values("unit_cell_residual")),
    ),
    Finding(
        "unit_cell_failures", PURE, "unit cells that failed",
        lambda judged: sum(int(values.sum()) for values in judged.values("unit_cell_failed")),
    ),
    Finding(
        "energies", JOULES, "every entry of the ledger at the end, by name",
        lambda judged: dict(judged.run.frame.energies),
    ),
    Finding("notes", PURE, "what was found about the input", lambda judged: list(judged.run.info.notes)),
    Finding("verdict", PURE, "trusted, doubtful, or do not use", lambda judged: judged.run.verdict),
    Finding(
        "doubts", PURE, "what speaks against the result: guard, level, text, advice, place on the flat blank, time",
        lambda judged: [doubt.as_dict() for doubt in judged.run.doubts()],
    ),
    Finding("warnings", PURE, "why the result may not be what it seems", lambda judged: list(judged.run.warnings)),
)  # fmt: skip


def summary(simulation: Simulation) -> dict[str, Any]:
    """Numbers of a run for summary.json; SI units unless the name says otherwise."""
    return found(RUN_FINDINGS, Judged(simulation))
