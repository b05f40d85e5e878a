"""What a study runs: a job, or a function of one's own."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import socket
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import InputError, RunError, logged_from
from ..output.files import plain
from .factors import Factor
from .plans.trials import Trial
from .table import Found


class Task(Protocol):
    """A run that can be sent to another process."""

    def compute(self) -> Found:
        """Compute it.

        Raises:
            InputError, RunError: what would happen again; anything else may be tried again.
        """
        ...


@dataclass(frozen=True)
class Case:
    """A run of a study before it is computed.

    Attributes:
        key: of all that its numbers depend on: the hash of its set-up, and of what is measured beyond it.
        setup_hash: of its set-up.
        task: computes it.
    """

    key: str
    setup_hash: str
    task: Task


class Subject(Protocol):
    """What a study runs."""

    def case(self, factors: Sequence[Factor], trial: Trial) -> Case:
        """The run of a trial.

        Raises:
            InputError: its values are not allowed.
        """
        ...

    def known_numbers(self, case: Case) -> tuple[set[str], bool]:
        """Names of numbers that runs will have, and whether these are all of them; may prepare the run."""
        ...


def compute(task: Task) -> Found:
    """Compute a run; what would happen again is part of the result.

    Raises:
        Exception: what may go well another time: no memory, no room.
    """
    started = time.perf_counter()
    worker = f"{socket.gethostname()}:{os.getpid()}"
    try:
        with quiet():
            found = task.compute()
    except (InputError, RunError) as error:
        status = "refused" if isinstance(error, InputError) else "failed"
        return Found(status, error=str(error), seconds=time.perf_counter() - started, worker=worker)
    return Found(
        found.status, found.verdict, plain(found.numbers), found.error, found.fields,
        time.perf_counter() - started, worker,
    )  # fmt: skip


def quiet() -> AbstractContextManager[None]:
    """What each run says is in the table; a thousand of them would hide the progress."""
    return logged_from(logging.CRITICAL)


def digest(*parts: object) -> str:
    """SHA-256 of values as JSON, 64 hexadecimal digits."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()


@dataclass(frozen=True)
class FunctionTask:
    """A call of a function.

    Attributes:
        function: takes the values by name, returns numbers by name; importable where it is computed.
        inputs: values by name.
    """

    function: Callable[..., Mapping[str, float]]
    inputs: Mapping[str, Any]

    def compute(self) -> Found:
        """Call it."""
        return Found(numbers=dict(self.function(**self.inputs)))


@dataclass(frozen=True)
class FunctionSubject:
    """A function of the factors in place of a job, to try the machinery or one's own model.

    Args:
        function: takes the values of the factors by name, and with ``repeats`` also ``repeat``, a whole number; returns
            numbers by name. Importable by its module.
        repeats: whether it can be repeated for its noise.
    """

    function: Callable[..., Mapping[str, float]]
    repeats: bool = False

    def case(self, factors: Sequence[Factor], trial: Trial) -> Case:
        """A call."""
        inputs = {factor.name: value for factor, value in zip(factors, trial.values, strict=True)}
        if self.repeats:
            inputs["repeat"] = trial.repeat
        key = digest(self.function.__module__, self.function.__qualname__, inputs)
        return Case(key, key, FunctionTask(self.function, inputs))

    def known_numbers(self, case: Case) -> tuple[set[str], bool]:
        """Nothing is known of a function before it is called."""
        return set(), False
