"""Writers: each writes one kind of result to the folder of a run, and is selected by name.

A writer is one file in ``writers/`` with a subclass of ``Writer``; defining the class registers it. Nothing else is
needed: the command line lists it, and runs use it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import ClassVar

from ..errors import InputError
from ..run.frame import Frame, Outcome, RunInfo
from .results import Results

logger = logging.getLogger(__name__)

_known: dict[str, type[Writer]] = {}


class Writer:
    """Base class of all writers. A subclass overrides what it needs of ``start``, ``frame``, ``finish`` and ``write``.

    After an OSError, for example on a full disk, the writer or the file is abandoned with a warning, and the run
    continues.

    Attributes:
        name: selects the writer; a class without a name is not a writer itself.
        title: for messages.
        rank: writers with a higher rank write later; those that show the output of others, such as the report, rank
            high.

    Args:
        folder: of the run; it exists.
        failures: messages about what could not be written are added to it.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    rank: ClassVar[int] = 0

    def __init_subclass__(cls) -> None:
        if not cls.name:
            return
        other = _known.get(cls.name)
        if other and (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
            raise TypeError(f"writer {cls.name}: {other.__module__} already has one of this name")
        _known[cls.name] = cls

    def __init__(self, folder: Path, failures: list[str]) -> None:
        self.folder = folder
        self._failures = failures

    @classmethod
    def load(cls) -> None:
        """Do slow imports before a run; nothing else may happen here."""

    def start(self, info: RunInfo) -> None:
        """Called when a run begins."""

    def frame(self, frame: Frame) -> None:
        """Called for every frame."""

    def finish(self, outcome: Outcome) -> None:
        """Called when the run has ended."""

    def discard(self) -> None:
        """Remove incomplete output; called once, after ``start``, ``frame`` or ``finish`` failed."""

    def write(self, results: Results) -> None:
        """Write the results of the whole run."""

    def attempt(self, what: str, action: Callable[[], object]) -> bool:
        """Run ``action`` and return whether it could write; a failure is reported once."""
        try:
            action()
        except OSError as error:
            text = f"{what} could not be written and is given up: {error.strerror or error}"
            self._failures.append(text)
            logger.warning("%s", text)
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
