"""A forming or draping run: a set-up in; frames, energies and a verdict out."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from ..device import exclusive
from ..engine.model import Model
from ..engine.setup import Setup
from ..engine.state import State
from ..engine.stepper import Stepper
from ..errors import RunError
from .diagnosis import find_failure
from .frame import Frame, Observer, Outcome, RunInfo
from .guards import Doubt, Level, verdict_of
from .interruption import Interruption, interruption
from .ledger import Ledger
from .sheet_ledger import Penetration
from .start import Prepared, prepare
from .verdict import Judged, summary
from .watch.watch import Watch

logger = logging.getLogger(__name__)


class Simulation:
    """One run: ``prepare()`` makes it ready, ``run()`` executes it, ``frame`` is the last frame taken.

    Simulations in several threads wait for each other: Warp computes in one thread at a time. Use processes to compute
    several at once.

    Construction is cheap. The first access to device data, such as ``frame`` or ``state``, prepares the run, which
    compiles kernels that are not cached.

    Args:
        setup: of the run.

    Attributes:
        setup: as given.
        history: time, stroke and every entry of the ledger, of all frames of the run.
        outcome: how the run ended; None before its end.
        interrupted_by: name of the signal that ended it; None if none did.
        failure: why the state became non-finite; None if it did not.
        stepping_time, wall_time: of the run [s].
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.history: list[dict[str, float]] = []
        self.outcome: Outcome | None = None
        self.interrupted_by: str | None = None
        self.failure: str | None = None
        self.stepping_time = 0.0
        self.wall_time = 0.0
        self._prepared: Prepared | None = None
        self._frame: Frame | None = None
        self._watch: Watch | None = None

    @property
    def name(self) -> str:
        """Of the set-up; result files are named after it."""
        return self.setup.name

    # --- device data -------------------------------------------------------------------------------------------------

    def prepare(self) -> Prepared:
        """Make the run ready, once: constants and state on the device, kernels loaded, the start checked.

        Raises:
            InputError: bad input that can only be detected on the device, such as an unstable step.
        """
        if self._prepared is None:
            with exclusive():
                self._prepared = prepare(self.setup)
        return self._prepared

    @property
    def model(self) -> Model:
        """Constants."""
        return self.prepare().model

    @property
    def state(self) -> State:
        """Everything that changes in the run."""
        return self.prepare().state

    @property
    def stepper(self) -> Stepper:
        """Advances the state."""
        return self.prepare().stepper

    @property
    def ledger(self) -> Ledger:
        """Takes frames."""
        return self.prepare().ledger

    @property
    def info(self) -> RunInfo:
        """What observers receive."""
        return self.prepare().info

    @property
    def warnings(self) -> list[str]:
        """Warnings for the user; the run adds to them until it ends."""
        return self.info.warnings

    @property
    def frame(self) -> Frame:
        """The last frame taken."""
        return self._frame or self.prepare().frame

    @property
    def watch(self) -> Watch:
        """What the guards saw, whatever the frames were."""
        if self._watch is None:
            self._watch = Watch(self.prepare())
            self._watch.look(self.prepare().frame)
        return self._watch

    @property
    def penetration(self) -> Penetration:
        """The deepest penetration so far."""
        return self.watch.penetration

    # --- the run -----------------------------------------------------------------------------------------------------

    def run(self, observers: Sequence[Observer] = ()) -> Outcome:
        """Run until the end, until rest, until a signal, or until the state is no longer finite.

        Ctrl-C, SIGTERM and SIGHUP stop a run within about a tenth of a second on a CPU (or a block of steps, if that
        takes longer), and at the next frame on a GPU.

        Every observer receives all frames, and ``finish`` however the run ends. Doubts about the result are added to
        ``warnings``.

        Raises:
            InputError: see ``prepare``.
            RunError: the state became non-finite (the message names the element and the likely cause), or this
                simulation has been run before.
        """
        if self.history:
            raise RunError("this simulation has been run: make a new one, since runs start from the undeformed blank")
        self.prepare()
        started = time.perf_counter()
        with exclusive(), interruption() as interrupted, interrupted.held(), ExitStack() as at_end:
            self.outcome = Outcome.INTERRUPTED
            for observer in observers:
                observer.start(self.info)
                at_end.callback(self._finish, observer)
            self._publish(self.frame, observers)
            self.outcome = self._run_frames(observers, interrupted, started)
            try:
                self._report_doubts()
            except Exception as error:  # the results are still worth having
                self.warnings.append(f"the result could not be judged: {type(error).__name__}: {error}")
                logger.warning("%s", self.warnings[-1], exc_info=error)
            if self.failure:
                logger.info("%s", self.failure)
        self.wall_time = time.perf_counter() - started
        if self.failure:
            raise RunError(self.failure)
        return self.outcome

    def _run_frames(self, observers: Sequence[Observer], interrupted: Interruption, started: float) -> Outcome:
        setup, watch = self.setup, self.watch
        while True:
            index = self.frame.index + 1
            target = setup.duration * index / setup.frame_count
            running = self._advance_to(min(target, watch.next_time), interrupted)
            if self.failure:
                return Outcome.NOT_FINITE
            # a signal during a frame leaves no steps between it and the next one
            frame = self.frame
            if running or self.state.step_count > frame.step_count:
                frame = self.ledger.frame(index)
            if frame.time >= watch.next_time or not running:
                watch.look(frame, last=not running)
            if frame.time < target and running:
                continue
            if frame is not self.frame:
                self._publish(frame, observers)
            self.wall_time = time.perf_counter() - started
            if frame.time >= setup.duration or (setup.rest and setup.rest.reached(frame.time, frame.energies)):
                watch.look(frame, last=True)
                return Outcome.FINISHED
            if not running:
                self.interrupted_by = interrupted.signal.name if interrupted.signal else None
                return Outcome.INTERRUPTED

    def _finish(self, observer: Observer) -> None:
        observer.finish(self.outcome or Outcome.INTERRUPTED)

    def take_frame(self) -> Frame:
        """Take a frame of the current state and add it to ``history``, without notifying observers."""
        with exclusive():
            frame = self.ledger.frame(self.frame.index + 1)
            self.watch.look(frame, last=True)
            self._publish(frame, ())
        return self.frame

    def _publish(self, frame: Frame, observers: Sequence[Observer]) -> None:
        self._frame = frame
        self.history.append({"time": frame.time, "stroke": frame.stroke, **frame.energies})
        for observer in observers:
            observer.frame(frame)

    def _advance_to(self, target: float, interrupted: Interruption) -> bool:
        """Step until ``target`` [s]; False if interrupted by a signal."""
        started = time.perf_counter()
        self.stepper.advance_to(target, interrupted.is_set)
        self.failure = find_failure(self.model, self.state, self.frame)
        self.stepping_time += time.perf_counter() - started
        return not interrupted.is_set()

    # --- assessment --------------------------------------------------------------------------------------------------

    def summary(self) -> dict[str, Any]:
        """Numbers of the run for summary.json; SI units unless the name says otherwise."""
        return summary(self)

    def doubts(self) -> list[Doubt]:
        """What speaks against the result so far, the worst first; notes are among it."""
        return self.prepare().guards.after(Judged(self))

    @property
    def verdict(self) -> str:
        """ "trusted", "doubtful" or "do not use", by the worst of the doubts."""
        return verdict_of(self.doubts())

    @property
    def trusted(self) -> bool:
        """Whether there is no doubt beyond a note."""
        return all(doubt.level == Level.NOTE for doubt in self.doubts())

    def _report_doubts(self) -> None:
        """Add the doubts that are new since the start to ``warnings`` and the log."""
        known = set(self.prepare().guards.first)
        for doubt in self.doubts():
            if doubt in known:
                continue
            if doubt.level > Level.NOTE:
                self.warnings.append(doubt.message)
                logger.warning("%s", doubt.message)
            else:
                logger.info("%s", doubt.message)
