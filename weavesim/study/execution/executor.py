"""What computes the runs of a study: the contract, and this process."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

from ..subject import Task, compute
from ..table import Found


@dataclass(frozen=True)
class Result:
    """What became of a task.

    Attributes:
        key: of the run.
        found: what it brought home; None for an attempt that brought nothing.
        error: why it brought nothing.
        worker: that tried.
        final: whether it will not be tried again.
    """

    key: str
    found: Found | None
    error: str = ""
    worker: str = ""
    final: bool = True


class Executor(Protocol):
    """Computes tasks."""

    @property
    def width(self) -> int:
        """How many it computes at a time."""
        ...

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[Result]:
        """Compute tasks, each with its key, and yield what becomes of them in the order in which they end.

        Tasks are taken as there is room for them.
        """
        ...

    def close(self) -> None:
        """End its processes."""
        ...


class HereExecutor:
    """One run after the other, in this process."""

    width = 1

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[Result]:
        """See ``Executor``."""
        for key, task in tasks:
            found = compute(task)
            yield Result(key, found, worker=found.worker)

    def close(self) -> None:
        """It has none."""
