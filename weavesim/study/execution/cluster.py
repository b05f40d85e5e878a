"""A cluster of Dask: workers on any number of machines behind one scheduler, which may be restarted.

The scheduler knows nothing that the study's table does not know: after a restart, what has not come home is sent again.
"""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import Any

from ...errors import InputError, RunError
from ..subject import Task, compute
from .executor import Result

logger = logging.getLogger(__name__)

# Waits for a scheduler [s]: at the start, and for one that is restarted.
FIRST_WAIT, LONGEST_WAIT = 30.0, 600.0
# How often it is looked for results, and for a scheduler that is gone [s].
PERIOD, LONGEST_LOOK = 0.02, 1.0
# Tasks at the scheduler per thread of its workers, so that none waits for the next.
TASKS_PER_THREAD = 2


class ClusterExecutor:
    """The workers of a scheduler.

    Args:
        address: of the scheduler, such as "tcp://10.0.0.1:8786".
        retries: how often a run is tried again that brought nothing home.
        longest_wait: for a scheduler that is restarted [s].

    Raises:
        InputError: Dask is not installed, or no scheduler answers.
    """

    def __init__(self, address: str, retries: int = 2, longest_wait: float = LONGEST_WAIT) -> None:
        self._address, self._retries, self._longest_wait = address, retries, longest_wait
        try:
            import distributed  # noqa: F401
        except ImportError:
            raise InputError("--scheduler: it needs Dask: pip install 'weavesim[cluster]'") from None
        try:
            self._client = self._connected(FIRST_WAIT)
        except (OSError, ValueError) as error:
            raise InputError(
                f"--scheduler {address}: no scheduler answers ({error}); start one with: dask scheduler"
            ) from None

    def _connected(self, timeout: float) -> Any:
        from distributed import Client

        return Client(self._address, timeout=timeout, set_as_default=False, name="weavesim study")

    @property
    def width(self) -> int:
        """Threads of all workers; at least 1."""
        try:
            return max(1, sum(self._client.nthreads().values()))
        except Exception:  # it is being restarted
            return 1

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[Result]:
        """See ``Executor``."""
        coming = iter(tasks)
        again: deque[tuple[str, Task]] = deque()
        attempts: dict[str, int] = {}
        running: dict[str, tuple[Any, Task]] = {}
        while True:
            try:
                room = TASKS_PER_THREAD * self.width
                while len(running) < room:
                    following = again.popleft() if again else next(coming, None)
                    if following is None:
                        break
                    key, task = following
                    try:
                        # runs are repeatable, but a task that kills its workers must not be sent for ever
                        future = self._client.submit(compute, task, key=f"weavesim-{key}-{attempts.get(key, 0)}",
                                                     pure=False, retries=0)  # fmt: skip
                    except BaseException:
                        again.appendleft(following)
                        raise
                    running[key] = (future, task)
                if not running:
                    return
                self._wait([future for future, _ in running.values()])
                for key in [key for key, (future, _) in running.items() if future.done()]:
                    future, task = running[key]
                    status = future.status
                    if status == "finished":
                        found = future.result(timeout=self._longest_wait)
                        del running[key]
                        yield Result(key, found, worker=found.worker)
                        continue
                    if status in ("cancelled", "lost"):
                        raise OSError("the scheduler has forgotten it")
                    error = future.exception(timeout=self._longest_wait)
                    del running[key]
                    attempts[key] = attempts.get(key, 0) + 1
                    final = attempts[key] > self._retries
                    if not final:
                        again.append((key, task))
                    yield Result(key, None, f"{type(error).__name__}: {error}", "", final)
            except (OSError, TimeoutError, RuntimeError, _cancelled()) as error:
                if isinstance(error, RunError):
                    raise
                logger.warning("the scheduler %s does not answer (%s): waiting for it", self._address, error)
                again.extendleft((key, task) for key, (_, task) in reversed(running.items()))
                running.clear()
                self._reconnect()

    def _wait(self, futures: list[Any]) -> None:
        """Wait until one is done, or for a while."""
        end = time.monotonic() + LONGEST_LOOK
        while not any(future.done() for future in futures) and time.monotonic() < end:
            time.sleep(PERIOD)
        if self._client.status not in ("running", "newly-created"):
            raise OSError(f"its connection is {self._client.status}")

    def _reconnect(self) -> None:
        """Wait for the scheduler to come back.

        Raises:
            RunError: it does not.
        """
        with suppress(Exception):
            self._client.close(timeout=1.0)
        end = time.monotonic() + self._longest_wait
        while True:
            try:
                self._client = self._connected(5.0)
                return
            except (OSError, TimeoutError):
                if time.monotonic() > end:
                    raise RunError(
                        f"the scheduler {self._address} did not come back within {self._longest_wait:.0f} s; what is "
                        "done is kept: start it again, and the study with the same command"
                    ) from None
                time.sleep(LONGEST_LOOK)

    def close(self) -> None:
        """Leave the scheduler and its workers to others."""
        with suppress(Exception):
            self._client.close(timeout=2.0)


def _cancelled() -> type[BaseException]:
    from concurrent.futures import CancelledError

    return CancelledError
