"""Libraries that writers need later than a run's first step: loaded beside the steps, and missing ones told before."""

from __future__ import annotations

import atexit
import gc
import logging
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ..engine.threads import beside_steps, soon
from ..errors import InputError

if TYPE_CHECKING:
    from .writer import Writer

# While libraries load, the threads of this process take turns this often [s]: the usual 5 ms would hold the steps up.
SWITCH_INTERVAL = 5e-4
# A library that takes longer, from when it is waited for [s], hangs: on a disk that does not answer, say.
LONGEST_WAIT = 120.0
# For which a process that ends waits for it [s]: one that ends within an import may crash.
LONGEST_WAIT_AT_EXIT = 10.0

logger = logging.getLogger(__name__)

# What has returned in this process.
_done: set[Callable[[], object]] = set()


def check_packages(kinds: Iterable[type[Writer]]) -> None:
    """Check, without importing any, that the packages of writers are installed.

    Raises:
        InputError: one is not.
    """
    for kind in kinds:
        check_installed(kind.title, kind.packages, f", or leave out {kind.name}")


def check_installed(what: str, packages: Iterable[str], instead: str = "") -> None:
    """Check, without importing any, that the packages are installed that something needs.

    Raises:
        InputError: one is not.
    """
    if missing := [name for name in packages if name not in sys.modules and find_spec(name) is None]:
        raise InputError(
            f"{what}: it needs the package {', '.join(missing)}, which is not installed: install weavesim "
            f"again{instead}"
        )


class Loading:
    """Calls functions that import libraries, one after the other, in a thread of its own, to which runs leave a core.

    What fails is logged only: whoever needs the library imports it again, and says why it cannot. What hangs keeps no
    process from ending.

    Args:
        loads: the functions.

    Attributes:
        hangs: the function that has been waited for in vain; None if none has.
    """

    def __init__(self, loads: Sequence[Callable[[], object]]) -> None:
        self._loads = list(loads)
        self._thread: threading.Thread | None = None
        self._called: Callable[[], object] | None = None
        self.hangs: Callable[[], object] | None = None

    def begin(self) -> None:
        """Begin, once; not where this process has called all of them before."""
        if self._thread is not None or _done.issuperset(self._loads):
            return
        meanwhile = ExitStack()
        # before the thread begins: the next step is done at once
        meanwhile.enter_context(beside_steps())
        meanwhile.enter_context(soon(SWITCH_INTERVAL))
        thread = threading.Thread(target=self._load, args=(meanwhile,), name="loading", daemon=True)
        try:
            thread.start()
        except RuntimeError:  # the system has no room for another one
            self._load(meanwhile)
        else:
            self._thread = thread
            atexit.register(self._wait_at_exit)

    def add(self, load: Callable[[], object]) -> None:
        """Call one more, before all others, and before it has begun."""
        self._loads.insert(0, load)

    def has(self, load: Callable[[], object]) -> bool:
        """Whether a function has returned in this process, or has to do without this, since another one hangs."""
        return load in _done or self.hangs not in (None, load)

    def wait(self) -> None:
        """Wait until all have returned, or one hangs; nothing where it never began."""
        if self._thread is None or self.hangs is not None:
            return
        self._thread.join(LONGEST_WAIT)
        if self._thread.is_alive():
            self.hangs = self._called
        atexit.unregister(self._wait_at_exit)

    def _wait_at_exit(self) -> None:
        if self._thread is not None:
            self._thread.join(LONGEST_WAIT_AT_EXIT)

    def _load(self, meanwhile: ExitStack) -> None:
        with meanwhile:
            for load in self._loads:
                self._called = load
                try:
                    load()
                except KeyboardInterrupt:
                    raise
                except BaseException as error:  # of a library that is broken, also what is no Exception
                    logger.info("%s: %s: %s", load.__qualname__, type(error).__name__, error)
                _done.add(load)
                if gc.get_freeze_count():  # within a run that searches for garbage only in what it makes itself
                    gc.freeze()
