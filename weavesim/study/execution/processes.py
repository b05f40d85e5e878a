"""Processes of this machine. A process that dies costs one attempt of one run, and is replaced.

``concurrent.futures`` gives up all runs of a pool when one of its processes dies, and does not say whose fault it was.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from ..subject import Task, compute
from ..table import Found
from .executor import Result

# A worker that has nothing to do any more ends by itself; one that computes is ended.
PATIENCE = 2.0


def serve(connection: Connection) -> None:
    """Compute the tasks that come until there are no more: the work of a process."""
    # Ctrl-C goes to all processes of a terminal; the first of them ends the others
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a run that is ended by its conductor takes the signal itself
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while (task := connection.recv()) is not None:
            answer: Found | str
            try:
                answer = compute(task)
            except Exception as error:
                answer = f"{type(error).__name__}: {error}"
            connection.send(answer)


@dataclass
class _Worker:
    process: BaseProcess
    connection: Connection
    key: str = ""
    task: Task | None = None


class ProcessExecutor:
    """So many processes of this machine.

    Args:
        width: how many.
        retries: how often a run is tried again that brought nothing home.
    """

    def __init__(self, width: int, retries: int = 2) -> None:
        self.width = width
        self._retries = retries
        self._workers: list[_Worker] = []

    @property
    def process_ids(self) -> list[int]:
        """Of the workers that there are."""
        return [worker.process.pid or 0 for worker in self._workers]

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[Result]:
        """See ``Executor``."""
        coming, again = iter(tasks), deque[tuple[str, Task]]()
        attempts: dict[str, int] = {}
        while True:
            self._fill(coming, again)
            busy = {worker.connection: worker for worker in self._workers if worker.task is not None}
            if not busy:
                return
            for ready in wait(list(busy)):
                worker = busy[ready]  # type: ignore[index]
                key, task = worker.key, worker.task
                assert task is not None
                worker.key, worker.task = "", None
                name = f"process {worker.process.pid}"
                try:
                    answer = worker.connection.recv()
                except (EOFError, OSError):
                    answer = f"its process ended{self._buried(worker)}"
                if not isinstance(answer, str):
                    yield Result(key, answer, worker=name)
                    continue
                attempts[key] = attempts.get(key, 0) + 1
                final = attempts[key] > self._retries
                if not final:
                    again.append((key, task))
                yield Result(key, None, answer, name, final)

    def _fill(self, coming: Iterator[tuple[str, Task]], again: deque[tuple[str, Task]]) -> None:
        """Give every idle worker something to do."""
        idle = [worker for worker in self._workers if worker.task is None]
        while idle or len(self._workers) < self.width:
            following = again.popleft() if again else next(coming, None)
            if following is None:
                return
            worker = idle.pop() if idle else self._hire()
            worker.key, worker.task = following
            # one that has just died is found by the wait
            with suppress(OSError):
                worker.connection.send(worker.task)

    def _hire(self) -> _Worker:
        context = multiprocessing.get_context("spawn")
        own, its = context.Pipe()
        process = context.Process(target=serve, args=(its,), name="weavesim study", daemon=True)
        process.start()
        its.close()
        worker = _Worker(process, own)
        self._workers.append(worker)
        return worker

    def _buried(self, worker: _Worker) -> str:
        """Remove a dead worker; returns how it ended."""
        self._workers.remove(worker)
        worker.connection.close()
        worker.process.join(PATIENCE)
        code = worker.process.exitcode
        if code is None:
            worker.process.kill()
            return ""
        if code < 0:
            with suppress(ValueError):
                return f" by {signal.Signals(-code).name}"
        return f" with code {code}"

    def close(self) -> None:
        """End all processes."""
        for worker in self._workers:
            with suppress(OSError):
                if worker.task is None:
                    worker.connection.send(None)
                else:
                    worker.process.terminate()
            worker.connection.close()
        for worker in self._workers:
            worker.process.join(PATIENCE)
            if worker.process.is_alive():
                worker.process.kill()
        self._workers.clear()
