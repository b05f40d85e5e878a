"""A job as a set-up: plies on tools, tools that move."""

from __future__ import annotations

import numpy as np

from ..engine.setup import Setup, Solver
from ..errors import InputError
from ..fabric.fabric import Fabric
from ..input_files import IN_JOB, units_given_as
from ..process.dynamics import Dynamics
from ..process.friction import law_of
from ..process.interfaces import Interface
from ..process.self_contact import SelfContact
from ..sheet.sheet import Sheet
from ..sheet.symmetry import Symmetry
from ..tools.shapes import Shape
from ..tools.tool import Tool
from .blanks.plies import blank_of, fabric_of, outline_of, plies_of
from .friction import friction_of
from .loads import Loads
from .placing import Box, axis_of, motion_of, reach, start_shift
from .read import JobFile
from .segments.cutting import load_of, segments_of
from .stages.build import stages_of
from .surfaces import Surfaces

COLOURS = ((0.75, 0.76, 0.80), (0.45, 0.52, 0.62), (0.62, 0.55, 0.45), (0.55, 0.62, 0.50), (0.60, 0.50, 0.60))


def setup_of(file: JobFile) -> Setup:
    """The set-up of a job without a scene.

    Raises:
        InputError: files that cannot be read, plies and tools that do not fit together.
    """
    with units_given_as(IN_JOB):
        return Builder(file).setup()


class Builder:
    """Makes the parts of a set-up one after the other.

    Attributes:
        plies: place of its table, and the ply; those of a lay-up each on their own.
        fabrics: of the plies.
        outlines: of the plies, in their places.
        shapes: of the tools, where they are drawn.
        facing: "up" or "down" of each tool, towards the sheet; None where nobody says it.
        heights: of the middles of the plies [m].
        shifts: how far along its axis each tool is from where it is drawn, at the start [m].
    """

    def __init__(self, file: JobFile) -> None:
        self.file = file
        job = file.job
        self.plies = plies_of(file)
        self.fabrics: tuple[Fabric, ...] = tuple(fabric_of(file, index) for index, _ in self.plies)
        self.thickness = sum(fabric.thickness for fabric in self.fabrics)
        surfaces = Surfaces(file, self.thickness)
        self.shapes: tuple[Shape, ...] = tuple(surfaces.shape(k) for k in range(len(job.tool)))
        self.facing = tuple(surfaces.facing(k) for k in range(len(job.tool)))
        self.outlines = tuple(outline_of(file, index, ply) for index, ply in self.plies)
        boxes = [outline.box for outline in self.outlines]
        self.box = Box(np.min([b.lower for b in boxes], axis=0), np.max([b.upper for b in boxes], axis=0))
        self.heights = self._heights()
        self.shifts = tuple(self._shift(k) for k in range(len(job.tool)))

    def _check_symmetry(self) -> None:
        """Check that no ply is on both sides of a plane of symmetry."""
        for name in self.file.job.process.symmetry:
            for (index, _), outline in zip(self.plies, self.outlines, strict=True):
                low, high = (float(end["xy".index(name)]) for end in (outline.box.lower, outline.box.upper))
                if min(-low, high) > 1.0e-3 * (high - low):
                    self.file.refuse(
                        ["ply", index],
                        f"it goes from {name} = {1e3 * low:.4g} to {1e3 * high:.4g} mm, through the plane of symmetry "
                        f"{name} = 0 of [process]; draw the part on one side of it",
                    )

    def setup(self) -> Setup:
        """All of it."""
        job, solver, output = self.file.job, self.file.job.solver, self.file.job.output
        symmetry = Symmetry(job.process.symmetry)
        sheets = tuple(self._sheet(k) for k in range(len(self.plies)))
        made = [self._tools(k, symmetry.share) for k in range(len(job.tool))]
        tools = tuple(tool for own in made for tool in own)
        self._check_symmetry()
        places = np.cumsum([0, *map(len, made)]).tolist()  # of the first tool of each table
        strokes = {move.name for stage in job.stage for move in stage.move if move.stroke is not None}
        moving = [k for k, tool in enumerate(job.tool) if tool.stroke is not None]
        moving += [k for k, tool in enumerate(job.tool) if tool.name in strokes]
        moving += [k for k, tool in enumerate(job.tool) if tool.gaps is not None]
        by_table = dict(zip([tool.name for tool in job.tool], made, strict=True))
        drawn = {tool.name: self._back(k) - self.shifts[k] for k, tool in enumerate(job.tool)}
        stages = stages_of(self.file, sheets, by_table, symmetry.share, drawn)
        return Setup(
            job.name,
            sheets=sheets,
            tools=tools,
            symmetry=symmetry,
            interfaces=self._interfaces(),
            dynamics=Dynamics(
                gravity=(0.0, 0.0, -job.process.gravity if job.process.gravity else 0.0),
                damping=job.process.damping,
                director_damping=job.process.director_damping,
                contact_thickness=job.process.contact_thickness,
                contact_samples=job.process.contact_samples,
                contact_allowance=job.process.contact_allowance,
            ),
            stages=stages,
            duration=sum(stage.duration for stage in stages) if stages else self._duration(tools),
            frame_count=output.frame_count,
            leading_tool=places[moving[0]] if moving else 0,
            solver=Solver(
                device=solver.device,
                precision=solver.precision,
                threads=solver.threads,
                time_step=solver.time_step,
                target_step=solver.target_step,
            ),
            accept_unusual=job.accept_unusual,
        )

    def _heights(self) -> list[float]:
        """Of the middles of the plies: as given, or upon each other, the lowest on the tools."""
        result, floor = [], self._floor()
        for (index, ply), fabric in zip(self.plies, self.fabrics, strict=True):
            if ply.height is not None:
                height = ply.height
            elif floor is None:
                self.file.refuse(
                    ["ply", index, "height"], 'height: is required, since no tool with faces = "up" is under the ply'
                )
            else:
                height = floor + 0.5 * fabric.thickness
            result.append(height)
            floor = height + 0.5 * fabric.thickness
        return result

    def _floor(self) -> float | None:
        """Height of the tools under the plies, where they start [m]."""
        found: list[float] = []
        for k, tool in enumerate(self.file.job.tool):
            if self.facing[k] == "up" and tool.start == "drawn":
                top = reach(self.shapes[k], self.box, "up")
                if top is not None:
                    found.append(top - tool.clearance * float(np.sign(axis_of(tool, "up")[2])))
        return max(found, default=None)

    def _shift(self, k: int) -> float:
        tool, facing = self.file.job.tool[k], self.facing[k]
        reached = face = None
        if tool.start == "touching" and facing is not None:
            reached = reach(self.shapes[k], self.box, facing)
            face = self.bottom if facing == "up" else self.top
        try:
            return start_shift(tool, facing, reached, face or 0.0)
        except InputError as error:
            self.file.refuse(["tool", k, "start"], error)

    @property
    def bottom(self) -> float:
        """Height of the lower face of the lowest ply [m]."""
        return self.heights[0] - 0.5 * self.fabrics[0].thickness

    @property
    def top(self) -> float:
        """Height of the upper face of the highest ply [m]."""
        return self.heights[-1] + 0.5 * self.fabrics[-1].thickness

    def _sheet(self, k: int) -> Sheet:
        index, ply = self.plies[k]
        blank = blank_of(self.file, index, ply, self.outlines[k], self.heights[k])
        loads = Loads(self.file, [ply.name for _, ply in self.plies])
        return Sheet(
            blank,
            self.fabrics[k],
            name=ply.name,
            self_contact=self._self_contact() if ply.self_contact else None,
            pressures=loads.pressures(ply.name, blank),
            grippers=loads.grippers(ply.name, blank, self.outlines[k].loops.outline),
        )

    def _self_contact(self) -> SelfContact:
        value = self.file.job.interface.friction
        return SelfContact(law_of(friction_of(self.file, ["interface", "friction"], value, of_tool=False)))

    def _interfaces(self) -> tuple[Interface, ...]:
        """Between neighbours."""
        table, names = self.file.job.interface, [ply.name for _, ply in self.plies]
        usual = law_of(friction_of(self.file, ["interface", "friction"], table.friction, of_tool=False))
        found = {pair: Interface(*pair, usual, passes=table.passes) for pair in zip(names[:-1], names[1:], strict=True)}
        told: set[tuple[str, str]] = set()
        for index, own in enumerate(table.pair):
            keys, pair = ["interface", "pair", index], (own.lower, own.upper)
            if pair not in found:
                known = ", ".join(f"{lower} / {upper}" for lower, upper in found)
                self.file.refuse(
                    keys, f"lower = {own.lower!r}, upper = {own.upper!r}: no neighbours; there are {known}"
                )
            if pair in told:
                self.file.refuse(keys, f"lower = {own.lower!r}, upper = {own.upper!r}: this pair is given twice")
            told.add(pair)
            law = usual
            if own.friction is not None:
                law = law_of(friction_of(self.file, [*keys, "friction"], own.friction, of_tool=False))
            found[pair] = Interface(*pair, law, passes=own.passes or table.passes)
        return tuple(found.values())

    def _tools(self, k: int, share: float) -> tuple[Tool, ...]:
        """The tool of a table, or its segments."""
        whole, table = self._tool(k, share), self.file.job.tool[k]
        if table.segments is None:
            return (whole,)
        found = []
        try:
            if self.file.job.process.symmetry:
                raise InputError("segments: a plane of symmetry would cut them; leave symmetry out of [process]")
            for segment in segments_of(table, whole.shape, self.facing[k]):
                motion, back = load_of(table, segment, whole.motion)
                shape = segment.shape.placed(-back * np.array(whole.axis)) if back else segment.shape
                found.append(whole.model_copy(update={"name": segment.name, "shape": shape, "motion": motion}))
        except InputError as error:
            self.file.refuse(["tool", k, "segments"], error)
        return tuple(found)

    def _back(self, k: int) -> float:
        """How far a tool that moves by gaps starts behind where it is drawn [m]; segments have gaps of their own."""
        tool = self.file.job.tool[k]
        return tool.gaps[0] if tool.gaps is not None and tool.segments is None else 0.0

    def _tool(self, k: int, share: float) -> Tool:
        tool = self.file.job.tool[k]
        try:
            axis = np.array(axis_of(tool, self.facing[k]), dtype=np.float64)
            shape = self.shapes[k]
            if self.shifts[k] != self._back(k):
                shape = shape.placed((self.shifts[k] - self._back(k)) * axis / np.linalg.norm(axis))
            motion = motion_of(tool, self.shifts[k], share)
            return Tool(
                tool.name,
                shape,
                motion,
                friction=friction_of(self.file, ["tool", k, "friction"], tool.friction, of_tool=True),
                axis=(float(axis[0]), float(axis[1]), float(axis[2])),
                colour=COLOURS[k % len(COLOURS)],
            )
        except InputError as error:
            key = str(error).split(":")[0].split(" ")[0]
            self.file.refuse(["tool", k, key], str(error).removeprefix("Tool: "))

    def _duration(self, tools: tuple[Tool, ...]) -> float:
        process = self.file.job.process
        if process.duration is not None:
            return process.duration
        strokes = [tool.motion.travel_time for tool in tools]
        if not any(strokes):
            self.file.refuse(["process"], "duration: is required, since no tool has a stroke, a path or a rotation")
        return max(strokes) + process.hold
