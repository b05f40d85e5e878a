"""Writers: each leaves one kind of result in the folder of a run, and is chosen by its name.

A writer is one file in ``writers/`` with a subclass of ``Writer``; defining the class registers it. It needs nothing
else: the command line offers it, and a run writes with it.
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
    """Base of all writers. A subclass defines what it needs of ``start``, ``frame``, ``finish`` and ``write``.

    What raises OSError, on a full disk for example, costs the writer or the file, but not the run: it is given up with
    a warning.

    Attributes:
        name: by which it is chosen; a class without one is no writer itself.
        title: in messages.
        rank: writers of a higher rank write later: what shows the work of others, such as the report, has a high one.

    Args:
        folder: of the run; it is there.
        failures: what could not be written, in words, is added to it.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    rank: ClassVar[int] = 0

    def __init_subclass__(cls) -> None:
        if not cls.name:
            return
        other = _known.get(cls.name)
        if other and (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
            raise TypeError(f"writer {cls.name}: {other.__module__} has one of this name")
        _known[cls.name] = cls

    def __init__(self, folder: Path, failures: list[str]) -> None:
        self.folder = folder
        self._failures = failures

    @classmethod
    def load(cls) -> None:
        """Import what takes long, before a run; nothing else may happen."""

    def start(self, info: RunInfo) -> None:
        """A run begins."""

    def frame(self, frame: Frame) -> None:
        """A frame of it."""

    def finish(self, outcome: Outcome) -> None:
        """It ended."""

    def discard(self) -> None:
        """Remove what is half written; called once, after ``start``, ``frame`` or ``finish`` failed."""

    def write(self, results: Results) -> None:
        """Leave what is made of the whole run."""

    def attempt(self, what: str, action: Callable[[], object]) -> bool:
        """Whether ``action`` could write what it should; if not, that is reported once."""
        try:
            action()
        except OSError as error:
            text = f"{what} could not be written and is given up: {error.strerror or error}"
            self._failures.append(text)
            logger.warning("%s", text)
            return False
        return True


def known_writers() -> dict[str, type[Writer]]:
    """All known writers by name, in the order in which they write."""
    from . import writers as folder  # which imports this module

    for module in iter_modules(folder.__path__):
        import_module(f"{folder.__name__}.{module.name}")
    return dict(sorted(_known.items(), key=lambda item: (item[1].rank, item[0])))


def chosen_writers(names: Iterable[str] | None = None, without: Iterable[str] = ()) -> tuple[type[Writer], ...]:
    """Writers by their names, all if None, but for those ``without``.

    Raises:
        InputError: a name that no writer has.
    """
    known = known_writers()
    left_out, wanted = set(without), set(known if names is None else names)
    if unknown := sorted((left_out | wanted) - set(known)):
        raise InputError(f"writer {', '.join(map(repr, unknown))}: choose from {', '.join(known)}")
    return tuple(writer for name, writer in known.items() if name in wanted - left_out)
