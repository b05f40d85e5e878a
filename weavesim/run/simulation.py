"""A forming or draping run: sheet, tools and laws in; frames, energies and a verdict out."""

from __future__ import annotations

import logging
import math
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numpy as np

from ..device import initialise, resolve_device, resolve_thread_counts
from ..engine.compilation import MeshKernelSet, compile_missing
from ..engine.model import Model
from ..engine.setup import Setup
from ..engine.state import State
from ..engine.stepper import Stepper
from ..errors import InputError, RunError
from ..kernels.lanes import CPU_LANE_COUNT, GPU_LANE_COUNT
from ..process.device import build_device_supports
from ..process.supports import prescribe_start
from ..tools.device import build_device_tools
from ..tools.sampling import mesh_parts, sample_meshes
from .frame import Frame, Observer, Outcome, RunInfo, SheetInfo
from .ledger import Ledger, Penetration

logger = logging.getLogger(__name__)
# The balance of frames in which less than this share of the run's work is done is compared with that share.
LEAST_WORK = 1.0e-4
# Hourglass and kinetic over internal energy are judged from this share of the largest internal energy on.
LEAST_INTERNAL = 0.05
# Forces of the undeformed sheet above this share of the unit cell's stiffness are no rounding.
LARGEST_REST_FORCE = 1.0e-4


class Simulation:
    """One run, ready to go: ``run()`` does it, ``frame`` is the last frame taken.

    Raises:
        InputError: what would spoil the run and can only be seen on its device, such as a step that is not stable.
    """

    def __init__(self, setup: Setup) -> None:
        if len(setup.sheets) != 1:
            raise InputError(f"setup {setup.name}: it has {len(setup.sheets)} sheets; a run of one is possible so far")
        initialise()
        (world,), (sheet,), solver = setup.worlds, setup.sheets, setup.solver
        self.setup, self.name = setup, setup.name
        self.blank, self.fabric, self.tools = sheet.blank, sheet.fabric, world.tools
        self.symmetry, self.duration, self.frame_count = world.symmetry.planes, setup.duration, setup.frame_count
        self.precision, self.supports = solver.precision, sheet.supports
        warp_device = resolve_device(solver.device)
        self.device = str(warp_device)
        self.thread_counts = resolve_thread_counts(solver.threads) if warp_device.is_cpu else (1,)
        lane_count = solver.lane_count or (CPU_LANE_COUNT if warp_device.is_cpu else GPU_LANE_COUNT)
        self.free = sheet.freedom(world.symmetry)
        self.model = Model(
            self.blank, self.fabric, self.free, world.dynamics, precision=self.precision, device=warp_device,
            lane_count=lane_count, tool_count=len(self.tools), target_step=solver.target_step, loads=sheet.loads,
        )  # fmt: skip
        meshes = mesh_parts(self.tools)
        if meshes:
            compile_missing(MeshKernelSet(self.device))
        samples = sample_meshes(self.tools, self.device, self.fabric.thickness)
        device_tools = build_device_tools(self.tools, self.model.real, self.device, samples)
        device_supports = build_device_supports(
            self.supports, self.model.node_count, self.model.real, lane_count, warp_device
        )
        velocity = prescribe_start(self.supports, sheet.initial_velocity, self.blank.node_count)
        self.state = State.initial(self.model, velocity)
        self.warnings = [*self.fabric.unit_cell.warnings(), *self._tool_warnings()]
        self.notes = [
            note
            for mesh in meshes.values()
            for note in (*mesh.surface.notes(), samples[mesh.surface].note(mesh.surface.name))
        ]
        self.stepper = Stepper(
            self.model, self.state, device_tools, device_supports, thread_counts=self.thread_counts,
            largest_step=solver.time_step or math.inf, step_safety=solver.step_safety,
        )  # fmt: skip
        stable = self.stepper.stable_step()
        if solver.time_step is not None and solver.time_step > stable:
            raise InputError(
                f"time_step = {solver.time_step:.4g} s is unstable for this mesh and fabric: at most {stable:.4g} s "
                "is stable; take that, a coarser mesh, or mass scaling (target_step)"
            )
        self.ledger = Ledger(self.stepper, self.tools, setup.leading_tool, self.supports)
        self.info = self._describe()
        self.frame: Frame = self.ledger.frame(0)
        self._check_cell_at_rest()
        self.penetration: Penetration = self.ledger.penetration(self.frame)
        if self.penetration.at_nodes > 0.5 * self.fabric.thickness:
            raise InputError(
                f"a tool overlaps the blank by {1e3 * self.penetration.at_nodes:.3g} mm before the run starts; the "
                f"sheet is {1e3 * self.fabric.thickness:.3g} mm thick: move the tool half a thickness off the "
                "mid-surface"
            )
        self.history: list[dict[str, float]] = []
        self.outcome: Outcome | None = None
        self.failure: str | None = None
        self.stepping_time = 0.0
        self.wall_time = 0.0

    def _describe(self) -> RunInfo:
        """What the observers get; its warnings are those of the run, also later."""
        tools, supports = tuple(range(len(self.tools))), tuple(range(len(self.supports)))
        sheet = SheetInfo(
            self.setup.sheets[0].name, self.blank, self.fabric, self.setup.worlds[0].symmetry, tools, supports
        )
        return RunInfo(
            name=self.name, sheets=(sheet,), tools=self.tools, supports=self.supports, duration=self.duration,
            frame_count=self.frame_count, device=self.device, precision=self.precision.value,
            thread_counts=self.thread_counts, internal_energies=self.ledger.internal, warnings=self.warnings,
            notes=tuple(self.notes),
        )  # fmt: skip

    def _check_cell_at_rest(self) -> None:
        """The undeformed sheet carries no force; a unit cell of the user's own may be written otherwise."""
        cell, fields = self.fabric.unit_cell, self.frame.fields
        largest = LARGEST_REST_FORCE * max(*cell.yarn_stiffness_per_width, cell.shear_stiffness)
        found = max(float(np.abs(fields[name]).max()) for name in ("warp_force", "weft_force", "shear_moment"))
        if not found <= largest:
            raise InputError(
                f"unit cell {type(cell).__name__}: the undeformed sheet carries {found:.4g} N/m, but at stretches of "
                "1, a shear angle of 0 and its initial_unknowns a cell must be free of force: mend its energy or those"
            )

    def _tool_warnings(self) -> list[str]:
        size = float(np.sqrt(self.model.geometry.area.max()))
        return [
            f"{tool.name}: {tool.elements_per_quarter_turn(size):.1f} elements of {size * 1e3:.2g} mm along 90 degrees "
            f"of its {tool.smallest_radius * 1e3:.3g} mm radius; below five the sheet sags over the edge"
            for tool in self.tools
            if tool.elements_per_quarter_turn(size) < 5.0
        ]

    # --- the run -----------------------------------------------------------------------------------------------------

    def run(self, observers: Sequence[Observer] = ()) -> Outcome:
        """Run to the end, to rest, to Ctrl-C, or until the state is no longer finite.

        Ctrl-C stops a run on a CPU within about a tenth of a second (or a block of steps, if that is longer), on a GPU
        at the next frame.

        Every observer gets all frames and, however the run ends, its ``finish``. Doubts about the result are added to
        ``warnings``.

        Raises:
            RunError: the state became non-finite, and the message names the element and the likely cause; or this
                simulation has been run before.
        """
        if self.history:
            raise RunError("this simulation has been run: make a new one, a run starts from the undeformed blank")
        started = time.perf_counter()
        with ExitStack() as at_end, interruption() as interrupted:
            self.outcome = Outcome.INTERRUPTED
            for observer in observers:
                observer.start(self.info)
                at_end.callback(lambda observer=observer: observer.finish(self.outcome))
            self._publish(self.frame, observers)
            while True:
                running = self._advance_to(self.duration * (self.frame.index + 1) / self.frame_count, interrupted)
                if self.failure:
                    self.outcome = Outcome.NOT_FINITE
                    break
                self._publish(self.ledger.frame(self.frame.index + 1), observers)
                self.wall_time = time.perf_counter() - started
                if not running:
                    break
                rest = self.setup.rest
                if self.frame.time >= self.duration or (rest and rest.reached(self.frame.time, self.frame.energies)):
                    self.outcome = Outcome.FINISHED
                    break
            for doubt in self.doubts():
                self.warnings.append(doubt)
                logger.warning("%s", doubt)
            if self.failure:
                logger.info("%s", self.failure)
        self.wall_time = time.perf_counter() - started
        if self.failure:
            raise RunError(self.failure)
        return self.outcome

    def take_frame(self) -> Frame:
        """A frame of the present state, added to ``history``; no observer hears of it."""
        self._publish(self.ledger.frame(self.frame.index + 1), ())
        return self.frame

    def _publish(self, frame: Frame, observers: Sequence[Observer]) -> None:
        self.frame = frame
        penetration = self.ledger.penetration(frame)
        self.penetration = Penetration(
            max(self.penetration.at_nodes, penetration.at_nodes),
            max(self.penetration.at_element_centres, penetration.at_element_centres),
        )
        self.history.append({"time": frame.time, "stroke": frame.stroke, **frame.energies})
        for observer in observers:
            observer.frame(frame)

    def _advance_to(self, target: float, interrupted: threading.Event) -> bool:
        """Step until ``target`` [s]; False if Ctrl-C came."""
        started = time.perf_counter()
        self.stepper.advance_to(target, interrupted.is_set)
        self.failure = self._find_failure()
        self.stepping_time += time.perf_counter() - started
        return not interrupted.is_set()

    def _find_failure(self) -> str | None:
        motion = self.model.read_motion(self.state.motion)[:, : self.blank.node_count]
        if math.isfinite(self.state.step) and self.state.step > 0.0 and np.isfinite(motion).all():
            return None
        bad_node = ~np.isfinite(motion).all(axis=(0, 2))
        bad_element = bad_node[self.blank.quads].any(axis=1)
        last = self.frame
        strain = np.maximum(np.abs(last.fields["warp_stretch"] - 1.0), np.abs(last.fields["weft_stretch"] - 1.0))
        suspect = int(np.argmax(np.where(bad_element, strain, -1.0))) if bad_element.any() else int(np.argmax(strain))
        x, y = self.blank.element_centres()[suspect, :2]
        angle = math.degrees(last.fields["shear_angle"][suspect])
        if abs(angle) > 80.0:
            cause = "its shear angle is beyond any locking: give the shear law a locking branch, or a smaller stroke"
        elif strain[suspect] > 0.2:
            cause = "its yarns are stretched or compressed far beyond the fabric: a tool moves too far or too fast"
        else:
            cause = "it failed within one frame: a tool that moves too fast, or two tools that meet through the sheet"
        return (
            f"the state became non-finite after {self.stepper.step_count} steps, {self.state.time:.4g} s; the last "
            f"good frame is {last.index} at {last.time:.4g} s. Element {suspect}, at ({x:.4g}, {y:.4g}) m on the flat "
            f"blank, is the first suspect: shear angle {angle:.1f} degrees, stretches "
            f"{last.fields['warp_stretch'][suspect]:.3f} and {last.fields['weft_stretch'][suspect]:.3f}; {cause}"
        )

    @property
    def threads(self) -> int:
        """CPU threads that most steps were done on."""
        return self.stepper.thread_count

    # --- what is said of the run -------------------------------------------------------------------------------------

    def summary(self) -> dict[str, object]:
        """Numbers of the run for summary.json; SI units unless the name says otherwise."""
        from .. import __version__

        fields = self.frame.fields
        history = self.history or [{"time": self.frame.time, "stroke": self.frame.stroke, **self.frame.energies}]
        supplied = max(np.abs([entry["supplied"] for entry in history]).max(), 1.0e-300)
        stroke = abs(self.frame.stroke)
        # of the stroke; where no tool has one, of the time
        largest_internal = max(e["internal"] for e in history)
        last_quarter = [
            e
            for e in history
            if e["internal"] > LEAST_INTERNAL * largest_internal
            and (abs(e["stroke"]) >= 0.75 * stroke if stroke > 0.0 else e["time"] >= 0.75 * self.frame.time)
        ]
        stretch = np.concatenate([fields["warp_stretch"], fields["weft_stretch"]])
        return {
            "weavesim_version": __version__,
            "name": self.name,
            "fabric": self.fabric.name,
            "outcome": self.outcome.value if self.outcome else "not run",
            "device": self.device,
            "precision": self.precision.value,
            "threads": self.threads,
            "lane_count": self.model.lane_count,
            "element_count": self.blank.element_count,
            "node_count": self.blank.node_count,
            "step_count": self.stepper.step_count,
            "time_step_s": self.state.time / max(self.stepper.step_count, 1),
            "time_s": self.state.time,
            "wall_time_s": self.wall_time,
            "stepping_time_s": self.stepping_time,
            "output_time_s": max(self.wall_time - self.stepping_time, 0.0),
            "element_steps_per_second": self.blank.element_count
            * self.stepper.step_count
            / max(self.stepping_time, 1.0e-9),
            "max_shear_angle_deg": float(np.degrees(np.abs(fields["shear_angle"]).max())),
            "min_stretch": float(stretch.min()),
            "max_stretch": float(stretch.max()),
            "hourglass_energy_ratio": max(
                (e["hourglass"] / e["internal"] for e in history if e["internal"] > LEAST_INTERNAL * largest_internal),
                default=0.0,
            ),
            "kinetic_energy_ratio": max((e["kinetic"] / e["internal"] for e in last_quarter), default=0.0),
            "damping_loss_ratio": self.frame.energies["damping_loss"] / supplied,
            "gravity_work_ratio": abs(self.frame.energies["gravity_work"]) / supplied,
            "energy_balance_error": max(
                abs(e["balance_error"]) / max(abs(e["supplied"]), e["used"], LEAST_WORK * supplied) for e in history
            ),
            "added_mass_ratio": self.model.added_mass_ratio,
            "support_force_n": {
                support.name: force.tolist()
                for support, force in zip(self.supports, self.frame.support_force, strict=True)
            },
            "penetration_at_nodes_mm": 1e3 * self.penetration.at_nodes,
            "penetration_at_element_centres_mm": 1e3 * self.penetration.at_element_centres,
            "unit_cell_max_residual": float(fields["unit_cell_residual"].max()),
            "unit_cell_failures": int(fields["unit_cell_failed"].sum()),
            "energies_j": dict(self.frame.energies),
            "notes": list(self.notes),
            "warnings": list(self.warnings),
        }

    def doubts(self) -> list[str]:
        """Why the result of the run should not be trusted as it is; empty if nothing speaks against it."""
        summary = self.summary()
        # what falls comes to rest by damping alone
        damping_limit = 0.05 if summary["gravity_work_ratio"] < 0.5 else 1.0
        thickness = 1e3 * self.fabric.thickness
        doubts = [
            f"{text} is {value:.3g}, above {limit:g}: {advice}"
            for text, value, limit, advice in (
                ("the error of the energy balance over the work", summary["energy_balance_error"], 0.05, "energy is "
                 "made or lost, do not use the result; a smaller time step or float64 tells more"),
                ("kinetic over internal energy in the last quarter", summary["kinetic_energy_ratio"], 0.05,
                 "the run is not quasi-static, slow the tools down"),
                ("hourglass over internal energy", summary["hourglass_energy_ratio"], 0.05, "refine the mesh"),
                ("damping loss over supplied work", summary["damping_loss_ratio"], damping_limit, "lower the damping"),
                ("the added mass over the blank's", summary["added_mass_ratio"], 0.05, "it changes the dynamics"),
                ("the deepest node in a tool [mm]", summary["penetration_at_nodes_mm"], 0.05 * thickness,
                 "tools move too fast, or meet through the sheet"),
                ("the number of failed unit cells", summary["unit_cell_failures"], 0, "see unit_cell_failed"),
            )
            if not value <= limit
        ]  # fmt: skip
        if not 0.9 < summary["min_stretch"] <= summary["max_stretch"] < 1.1:
            doubts.append(
                f"yarn stretches range from {summary['min_stretch']:.3f} to {summary['max_stretch']:.3f}: yarns of a "
                "woven fabric do not bear that"
            )
        return doubts


@contextmanager
def interruption() -> Iterator[threading.Event]:
    """An event that Ctrl-C sets, so that a run stops between two turns of steps; a second Ctrl-C stops at once."""
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield event
        return
    previous = signal.getsignal(signal.SIGINT)

    def handle(signal_number: int, stack: object) -> None:
        event.set()
        signal.signal(signal.SIGINT, previous)

    signal.signal(signal.SIGINT, handle)
    try:
        yield event
    finally:
        signal.signal(signal.SIGINT, previous)
