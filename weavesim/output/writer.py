"""Writers: each writes one kind of result to the folder of a run, and is selected by name.

A writer is one file in ``writers/`` with a subclass of ``Writer``; defining the class registers it. Nothing else is
needed: the command line lists it, and runs use it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import ClassVar

from ..errors import InputError
from ..names import enter
from ..run.frame import Frame, Outcome, RunInfo
from .history import History
from .results import Results

logger = logging.getLogger(__name__)

_known: dict[str, type[Writer]] = {}


class Failures(list[str]):
    """Messages about what could not be written or computed.

    Attributes:
        names: of what is missing, in the same order.
    """

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []

    def add(self, what: str, error: Exception, verb: str = "written") -> None:
        """Note a failure, and say it at once; the log keeps the traceback of what is not the file system's fault."""
        reason = error.strerror or error if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
        self.note(what, f"{what} could not be {verb} and is given up: {reason}")
        if not isinstance(error, OSError):
            logger.info("%s", what, exc_info=error)

    def note(self, what: str, text: str) -> None:
        """Note that ``what`` is missing, for a reason, and say it at once."""
        self.append(text)
        self.names.append(what)
        logger.warning("%s", text)

    def clear(self) -> None:
        """Forget what failed."""
        super().clear()
        self.names.clear()


class Writer:
    """Base class of all writers. A subclass overrides what it needs of ``start``, ``frame``, ``finish``, ``precede``,
    ``begin``, ``write`` and ``conclude``.

    A writer that raises anything, for example on a full disk, is abandoned with a warning; the others and the run
    continue.

    Attributes:
        name: selects the writer; a class without a name is not a writer itself.
        title: for messages.
        rank: writers with a higher rank write later; those that show the output of others, such as the report, rank
            high.
        packages: that it imports when it needs them; a run does not begin without them.
        needs_load: whether it gets no message before ``load`` has returned.

    Args:
        folder: of the run; it exists.
        failures: what could not be written is added to it.
        history: scalars of all frames so far.
        solver_fields: whether frames for other programs have the fields of the solver too.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    rank: ClassVar[int] = 0
    packages: ClassVar[tuple[str, ...]] = ()
    needs_load: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        if cls.name:
            enter(_known, cls.name, cls, "writer")

    def __init__(self, folder: Path, failures: Failures, history: History, solver_fields: bool = False) -> None:
        self.folder, self.history, self.solver_fields = folder, history, solver_fields
        self._failures = failures
        self._said = False

    @classmethod
    def load(cls) -> None:
        """Do slow imports, and prepare what does not depend on the run; nothing else may happen here.

        Another thread does it beside the first steps.
        """

    def start(self, info: RunInfo) -> None:
        """Called when a run begins."""

    def frame(self, frame: Frame) -> None:
        """Called for every frame."""

    def finish(self, outcome: Outcome) -> None:
        """Called when the run has ended."""

    def discard(self) -> None:
        """Remove incomplete output; called once, after ``start``, ``frame`` or ``finish`` failed."""

    def precede(self, results: Results) -> None:
        """Write what must be there whatever happens to the rest; called before any ``write``."""

    def begin(self, results: Results, meanwhile: ExitStack) -> None:
        """Begin what goes on by itself, or needs no other writer; called after ``precede`` and before any ``write``.

        Args:
            results: of the run; no pictures are there yet.
            meanwhile: closed when all have written, or have been interrupted.
        """

    def write(self, results: Results) -> None:
        """Write the results of the whole run; not called where ``begin`` failed."""

    def conclude(self, results: Results) -> None:
        """Called when all have written, successfully or not."""

    def save(self, what: str, action: Callable[[], object]) -> None:
        """Run ``action``, which saves what there is so far; a failure is only logged, since the end tries again."""
        try:
            action()
        except Exception as error:
            text = "%s could not be saved during the run, and is tried again at its end: %s"
            logger.log(logging.INFO if self._said else logging.WARNING, text, what, error)
            self._said = True

    def attempt(self, what: str, action: Callable[[], object]) -> bool:
        """Run ``action`` and return whether it succeeded; a failure is reported once."""
        try:
            action()
        except Exception as error:  # another writer must not suffer from it
            self._failures.add(what, error)
            return False
        return True


def known_writers() -> dict[str, type[Writer]]:
    """All known writers by name, in order of writing."""
    from . import writers as folder  # which imports this module

    for module in iter_modules(folder.__path__):
        import_module(f"{folder.__name__}.{module.name}")
    return dict(sorted(_known.items(), key=lambda item: (item[1].rank, item[0])))


def chosen_writers(names: Iterable[str] | None = None, without: Iterable[str] = ()) -> tuple[type[Writer], ...]:
    """Writers by name, all if None, except those in ``without``.

    Raises:
        InputError: an unknown name.
    """
    for argument, given in (("writers", names), ("without", without)):
        if isinstance(given, str):
            raise InputError(f"{argument} = {given!r}: give a list, [{given!r}]")
    known = known_writers()
    left_out, wanted = set(without), set(known if names is None else names)
    if unknown := sorted((left_out | wanted) - set(known)):
        raise InputError(f"writer {', '.join(map(repr, unknown))}: choose from {', '.join(known)}")
    return tuple(writer for name, writer in known.items() if name in wanted - left_out)
