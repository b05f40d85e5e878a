"""Libraries that writers need later than a run's first step: loaded beside the steps, and missing ones told before."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from .writer import Writer

# While libraries load, the threads of this process take turns this often [s]: the usual 5 ms would hold the steps up.
SWITCH_INTERVAL = 5e-4

logger = logging.getLogger(__name__)

# What has returned in this process.
_done: set[Callable[[], object]] = set()


def check_packages(kinds: Iterable[type[Writer]]) -> None:
    """Check, without importing any, that the packages of writers are installed.

    Raises:
        InputError: one is not.
    """
    for kind in kinds:
        if missing := [name for name in kind.packages if name not in sys.modules and find_spec(name) is None]:
            raise InputError(
                f"{kind.title}: it needs the package {', '.join(missing)}, which is not installed: install weavesim "
                f"again, or leave out {kind.name}"
            )


class Loading:
    """Calls functions that import libraries, one after the other, in a thread of its own.

    What fails is logged only: whoever needs the library imports it again, and says why it cannot.

    Args:
        loads: the functions.
    """

    def __init__(self, loads: Sequence[Callable[[], object]]) -> None:
        self._loads = list(loads)
        self._thread: threading.Thread | None = None

    def begin(self) -> None:
        """Begin, once; not where this process has called all of them before."""
        if self._thread is None and not _done.issuperset(self._loads):
            self._thread = threading.Thread(target=self._load, name="loading")
            self._thread.start()

    def add(self, load: Callable[[], object]) -> None:
        """Call one more, before it has begun."""
        self._loads.append(load)

    def has(self, load: Callable[[], object]) -> bool:
        """Whether a function has returned in this process."""
        return load in _done

    def wait(self) -> None:
        """Wait until all have returned; nothing where it never began."""
        if self._thread is not None:
            self._thread.join()

    def _load(self) -> None:
        before = sys.getswitchinterval()
        sys.setswitchinterval(min(before, SWITCH_INTERVAL))
        try:
            for load in self._loads:
                try:
                    load()
                except Exception as error:
                    logger.info("%s: %s: %s", load.__qualname__, type(error).__name__, error)
                _done.add(load)
        finally:
            sys.setswitchinterval(before)
