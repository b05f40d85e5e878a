"""A forming or draping run: a set-up in; frames, energies and a verdict out."""

from __future__ import annotations

import logging
import time
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from importlib import import_module
from typing import Any

from ..device import exclusive
from ..engine.setup import Setup
from ..errors import RunError
from ..measures.findings import found
from ..notebook import shown, table
from .checkpoint.checkpoints import Checkpoints
from .checkpoint.job import Job
from .diagnosis import Failure, find_failure
from .frame import Frame, Observer, Outcome
from .guards import Doubt, Level, report_new, verdict_of
from .interruption import Interruption, interruption
from .sheet_ledger import Penetration
from .staging.advance import begin_stage
from .staging.course import Course
from .start import Prepared, PreparedOnce
from .verdict import RUN_FINDINGS, Judged, summary
from .watch.stops import Stops
from .watch.watch import STAGE_WATCH_COUNT, WATCH_COUNT, Watch, check_watch_count

logger = logging.getLogger(__name__)

CUT_OFF = (
    "the run was cut off: its last frame lacks pressures, friction and gaps of the tools and heights of wrinkles; "
    "write film, report or ParaView files to have them in every frame"
)


class Simulation(PreparedOnce):
    """One run: ``prepare()`` makes it ready, ``run()`` executes it, ``frame`` is the last frame taken.

    Simulations in several threads step side by side on a CPU; whatever else they do, such as taking frames, waits for
    each other. ``run_batch`` uses this.

    Construction is cheap. The first access to ``frame`` or ``state`` prepares the run, and compiles its kernels.

    Args:
        setup: of the run.
        run_id: of a run that is resumed; a new one by default.
        watch_count: states that the guards look at, evenly spaced in time; by default 80, or 100 of each stage.
        stop_on: guards that end the run, from a level on: see ``run.watch.stops``.

    Attributes:
        setup: as given.
        history: time, stroke and every entry of the ledger, of all frames of the run.
        outcome: how the run ended; None before its end.
        interrupted_by: name of the signal that ended it; None if none did.
        failed: what became non-finite, and where; None if nothing did.
        stepping_time, wall_time: of the run, all its parts together [s].
        stages: where it is in them.
        stops: the guards that end it, and the doubt that did.
    """

    def __init__(
        self, setup: Setup, *, run_id: str | None = None, watch_count: int | None = None, stop_on: Sequence[str] = ()
    ) -> None:
        super().__init__(setup, run_id)
        check_watch_count(watch_count)
        usual = STAGE_WATCH_COUNT if setup.stages else WATCH_COUNT
        self._watch_count = usual if watch_count is None else watch_count
        self.history: list[dict[str, float]] = []
        self.outcome: Outcome | None = None
        self.interrupted_by: str | None = None
        self.failed: Failure | None = None
        self.stepping_time = self.wall_time = 0.0
        self.stages, self.stops = Course(setup), Stops(stop_on)
        self._frame: Frame | None = None
        self._watch: Watch | None = None
        self._checkpoints: Checkpoints | None = None
        self._resumes, self._every_field, self._is_whole = False, True, True
        self._started = self._time_before = 0.0

    @property
    def name(self) -> str:
        """Of the set-up; result files are named after it."""
        return self.setup.name

    @property
    def failure(self) -> str | None:
        """Why the state became non-finite; None if it did not."""
        return self.failed.text if self.failed else None

    @property
    def warnings(self) -> list[str]:
        """Warnings for the user; the run adds to them until it ends."""
        return self.info.warnings

    @property
    def frame(self) -> Frame:
        """The last frame taken."""
        return self._frame or self.prepare().whole_frame

    @property
    def watch(self) -> Watch:
        """What the guards saw, whatever the frames were."""
        if self._watch is None:
            self._watch = Watch(self.prepare(), self._watch_count)
            self._watch.look(self.prepare().frame)
        return self._watch

    @property
    def penetration(self) -> Penetration:
        """The deepest penetration so far."""
        return self.watch.penetration

    def computed_on(self, device: str) -> None:
        """Tell observers and results that the steps are done on ``device``, not on that of the set-up."""
        prepared = self.prepare()
        self._prepared = replace(prepared, info=replace(prepared.info, device=device))

    # --- the run -----------------------------------------------------------------------------------------------------

    def resume(self, checkpoints: Checkpoints) -> None:
        """Go back to the checkpoint that ``checkpoints.find`` found: ``run`` then goes on from there.

        Observers receive the frames before it again, so that what they make is that of a run that never stopped.

        Raises:
            InputError: the checkpoint is of another version, precision or set-up.
        """
        if self.history:
            raise RunError("this simulation has been run: make a new one to resume a run")
        assert checkpoints.found is not None
        prepared = self.prepare()
        with exclusive():
            different = checkpoints.recall(self)
        values, warnings = checkpoints.found.content.values, list(prepared.info.warnings)
        part = (
            f"resumed at step {values['step_count']}, {values['time']:.6g} s, from a checkpoint of {values['written']}"
        )
        if different:
            warnings.append(
                f"{part}, but {', '.join(different)} changed since: the last digits of the result may be others than "
                "those of a run that was not interrupted"
            )
            logger.warning("%s", warnings[-1])
        parts = (*values["parts"], part)
        info = replace(prepared.info, warnings=warnings, notes=(*prepared.info.notes, *parts), parts=parts)
        self._prepared = replace(self.prepare(), info=info)
        self._checkpoints, self._resumes = checkpoints, True

    def checkpoint(self) -> bool:
        """Write a checkpoint now, between two steps, if the run keeps some; returns whether it did.

        A run writes them by itself from time to time, when a signal ends it, and at the end of one of some length.
        """
        if self._checkpoints is None:
            return False
        if self._started:
            self.wall_time = self._time_before + time.perf_counter() - self._started
        return self._checkpoints.save(self)

    def run(
        self, observers: Sequence[Observer] = (), *, checkpoints: Checkpoints | None = None, every_field: bool = True
    ) -> Outcome:
        """Run until the end, rest, a signal, or a guard of ``stop_on``, or until the state is no longer finite.

        Ctrl-C, SIGTERM and SIGHUP stop a run within about a tenth of a second on a CPU (or a block of steps, if that
        takes longer), and at the next frame on a GPU.

        Every observer receives all frames, and ``finish`` however the run ends. Doubts about the result are added to
        ``warnings``.

        Args:
            observers: of the run.
            checkpoints: where to write some; those of ``resume`` by default.
            every_field: whether an observer reads what is computed for frames alone, such as pressures of the tools; if
                not, only the last frame has it, and the last of every stage; the last one of a run that is cut off may
                lack it, which ``warnings`` then tells.

        Raises:
            InputError: see ``prepare``.
            RunError: the state became non-finite (the message names the element and the likely cause), or this
                simulation has been run before.
        """
        with closing(self.course(observers, checkpoints=checkpoints, every_field=every_field)) as course:
            try:
                target, interrupted = next(course)
                while True:
                    target, interrupted = course.send(self._advance_to(target, interrupted))
            except StopIteration as end:
                outcome: Outcome = end.value
                return outcome

    def course(
        self, observers: Sequence[Observer] = (), *, checkpoints: Checkpoints | None = None, every_field: bool = True
    ) -> Generator[tuple[float, Interruption], bool, Outcome]:
        """The run for whoever steps it, see ``run``: yields up to which time the state is to be advanced [s], and what
        notes the signals that stop it earlier. It wants to know whether the run goes on, and, if the state is no longer
        finite, ``failed``.
        """
        if self.history:
            raise RunError("this simulation has been run: make a new one, since runs start from the undeformed blank")
        self.prepare()
        self._started, self._time_before = time.perf_counter(), self.wall_time
        self._checkpoints = self._checkpoints or checkpoints
        self._every_field = every_field and len(observers) > 0
        with exclusive(), interruption() as interrupted, interrupted.held(), ExitStack() as at_end:
            self.outcome = Outcome.INTERRUPTED
            for observer in observers:
                observer.start(self.info)
                at_end.callback(self._finish, observer)
            if self._resumes and self._checkpoints is not None:
                for frame in self._checkpoints.frames():
                    self._publish(frame, observers, complete=False)
                self._is_whole = True  # nothing more can be known of them
            else:
                if self._checkpoints is not None:
                    self._checkpoints.begin(self._checkpoints.job or Job(self.setup, self.info.run_id))
                self._publish(self.prepare().frame, observers, self._every_field, kept=True)
            self.outcome = yield from self._run_frames(observers, interrupted)
            report_new(self.doubts, self.prepare().guards.first, self.warnings)
            if not self._is_whole:
                self.warnings.append(CUT_OFF)
                logger.warning("%s", CUT_OFF)
            if self.failure:
                logger.info("%s", self.failure)
        self.wall_time = self._time_before + time.perf_counter() - self._started
        if self.failure:
            raise RunError(self.failure)
        return self.outcome

    def _run_frames(
        self, observers: Sequence[Observer], interrupted: Interruption
    ) -> Generator[tuple[float, Interruption], bool, Outcome]:
        watch, stages = self.watch, self.stages
        while not self._ends():
            index = self.frame.index + 1
            target = stages.frame_time(index)
            running = yield min(target, watch.next_time), interrupted
            if self.failure:
                return Outcome.NOT_FINITE
            if not running:
                # before the frame of the interruption, which a run that goes on from here does not have
                self.checkpoint()
            # a signal during a frame leaves no steps between it and the next one
            frame = self.frame
            if running or self.state.step_count > frame.step_count:
                frame = self.ledger.frame(index)
            stops = False
            if frame.time >= watch.next_time or not running:
                if running:
                    stages.look(frame.energies, self.model)
                watch.look(frame, last=not running)
                stops = running and not stages.is_reached and self._stops_at(frame)
            ends_here = stages.is_reached and running
            if frame.time < target and running and not ends_here and not stops:
                continue
            if frame is not self.frame:
                complete = self._every_field or stops or not running or stages.is_over(frame)
                self._publish(frame, observers, complete, kept=frame.time >= target or ends_here)
            self.wall_time = self._time_before + time.perf_counter() - self._started
            if not running and not (stages.is_last and stages.is_over(self.frame)):
                self.interrupted_by = interrupted.signal.name if interrupted.signal else None
                return Outcome.INTERRUPTED
            if stops:
                watch.look(self.frame, last=True)
                return Outcome.STOPPED
        if self._checkpoints is not None and self._checkpoints.much_is_new:
            # before the last look, which a run that goes on from here takes again
            self.checkpoint()
        stages.finish(self.frame, self.model.setup)
        watch.look(self.frame, last=True)
        return Outcome.FINISHED

    def _stops_at(self, frame: Frame) -> bool:
        """Whether a guard ends the run at a state that has been looked at, and is not its last."""
        last = self.stages.is_last and self.stages.is_over(frame)
        if last or frame.step_count == 0 or not self.stops.look(self.prepare().guards, Judged(self)):
            return False
        # before its frame, which a run that goes on from here takes again, or does not have
        self.checkpoint()
        return True

    def _ends(self) -> bool:
        """Whether the last frame is the last of the run; where it is the last of a stage, the next one begins."""
        if not self.stages.is_over(self.frame):
            return False
        if self.stages.is_last:
            return True
        begin_stage(self)
        return False

    def enter(self, prepared: Prepared) -> None:
        """Go on in a stage, whose model is on the state of this run."""
        watch = self.watch  # made now at the latest: it looks at the start of the run with the ledger of then
        self._prepared = prepared
        watch.begin_stage(self.model, self.ledger, self.stages.begin, self.stages.duration)

    def _finish(self, observer: Observer) -> None:
        observer.finish(self.outcome or Outcome.INTERRUPTED)

    def take_frame(self) -> Frame:
        """Take a frame of the current state and add it to ``history``, without notifying observers."""
        with exclusive():
            watch = self.watch
            frame = self.ledger.frame(self.frame.index + 1)
            watch.look(frame, last=True)
            self._publish(frame, (), True)
        return self.frame

    def _publish(self, frame: Frame, observers: Sequence[Observer], complete: bool, kept: bool = False) -> None:
        """Show a frame, ``complete`` with every field; ``kept`` if every run of this set-up has it."""
        self._frame, self._is_whole = self.ledger.completed(frame) if complete else frame, complete
        frame = self._frame
        if kept and self._checkpoints is not None:
            self._checkpoints.add(frame)
        self.stages.keep(frame)
        self.history.append({"time": frame.time, "stroke": frame.stroke, **frame.energies})
        for observer in observers:
            observer.frame(frame)

    def _advance_to(self, target: float, interrupted: Interruption) -> bool:
        """Step until ``target`` [s], and write checkpoints that are due; False if interrupted by a signal."""

        def due() -> bool:
            return self._checkpoints is not None and self._checkpoints.due(self.state.step_count)

        for part in self.stages.targets(target):
            while True:
                started = time.perf_counter()
                self.stepper.advance_to(part, lambda: interrupted.is_set() or due())
                self.failed = find_failure(self.model, self.state, self.frame)
                self.stepping_time += time.perf_counter() - started
                if self.failure or interrupted.is_set():
                    return not interrupted.is_set()
                if not due():
                    break
                self.checkpoint()
            if self.stages.check(self.state):
                break
        return True

    # --- assessment --------------------------------------------------------------------------------------------------

    def summary(self) -> dict[str, Any]:
        """Numbers of the run for summary.json; SI units unless the name says otherwise."""
        return summary(self)

    def doubts(self) -> list[Doubt]:
        """What speaks against the result so far, the worst first; notes are among it."""
        return self.prepare().guards.after(Judged(self))

    @property
    def verdict(self) -> str:
        """ "trusted", "doubtful" or "do not use", by the worst of the doubts; "not run" before the run."""
        return verdict_of(self.doubts()) if self.history else "not run"

    @property
    def trusted(self) -> bool:
        """Whether it has been run, and there is no doubt beyond a note."""
        return bool(self.history) and all(doubt.level == Level.NOTE for doubt in self.doubts())

    # --- notebooks ---------------------------------------------------------------------------------------------------

    def plot(self, field: str = "shear_angle", sheet: str | None = None) -> Any:
        """A picture of the last frame, which notebooks show: a Matplotlib figure.

        Args:
            field: of the elements, such as "thickness".
            sheet: by name; not needed if there is only one.

        Raises:
            InputError: an unknown field or sheet.
        """
        # drawing stands above this room, which only looks it up
        return import_module("weavesim.output.pictures.surface").picture_of(self.info, self.frame, field, sheet)

    def _repr_html_(self) -> str:
        if not self.history:
            return table(f"Simulation {self.name}", [("setup", shown(self.setup), "")], "it has not been run")
        rows = [
            ("outcome", shown(self.outcome), ""), ("time", shown(self.frame.time), "s"),
            ("wall_time", shown(self.wall_time), "s"), ("verdict", shown(self.verdict), ""),
            *((doubt.level.label, shown(doubt.message), "") for doubt in self.doubts()),
        ]  # fmt: skip
        return table(f"Simulation {self.name}", rows) + found(RUN_FINDINGS, Judged(self))._repr_html_()
