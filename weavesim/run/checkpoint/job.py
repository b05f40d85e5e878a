"""What is kept of a run so that it can go on without anything else: its set-up, options, and the files they name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...engine.setup import Setup
from ...errors import InputError
from .container import Content, DamageError, read_container, write_container

# Larger files that options name are not kept: a mesh is in the set-up already.
LARGEST_FILE = 50_000_000


@dataclass(frozen=True)
class Job:
    """A run as its user gave it.

    Attributes:
        setup: of the run.
        run_id: of the run, which all its parts share.
        options: given by the user, by name, as JSON has them.
        origin: what made the set-up, such as the name of a scene, for whoever resumes the run.
        writers: names of the writers of its results.
        order: among the runs of one command, which are resumed in this order.
        solver_fields: whether frames for ParaView have the fields of the solver too.
        stop_on: guards that end the run.
        passed: guards that have ended it, and after which its user has it go on.
    """

    setup: Setup
    run_id: str
    options: Mapping[str, Any] = field(default_factory=dict)
    origin: Mapping[str, Any] = field(default_factory=dict)
    writers: tuple[str, ...] = ()
    order: int = 0
    solver_fields: bool = False
    stop_on: tuple[str, ...] = ()
    passed: tuple[str, ...] = ()

    def write(self, path: Path) -> None:
        """Write it to one file, with the content of all files that options name.

        Raises:
            OSError: it cannot be written.
        """
        values = {
            "setup": self.setup.to_json(), "run_id": self.run_id, "options": dict(self.options),
            "origin": dict(self.origin), "writers": list(self.writers), "order": self.order,
            "solver_fields": self.solver_fields, "stop_on": list(self.stop_on), "passed": list(self.passed),
        }  # fmt: skip
        write_container(path, values, dict(_named_files(self.options)))

    @classmethod
    def read(cls, path: Path) -> tuple[Job, Content]:
        """A job, and the content with its files.

        Raises:
            OSError: it cannot be read.
            DamageError: it is damaged.
            InputError: its set-up is of a kind that this process does not know.
        """
        content = read_container(path)
        values = dict(content.values)
        try:
            setup = values.pop("setup")
            lists = {name: tuple(values.get(name, ())) for name in ("writers", "stop_on", "passed")}
            job = cls(Setup.from_json(setup), **{**values, **lists})
        except (KeyError, TypeError) as error:
            raise DamageError(f"it is not as weavesim writes it ({error})") from None
        return job, content


def going_on(job: Job, content: Content, path: Path, guard: str) -> Job:
    """A job whose user has it go on after ``guard`` has ended it; its file tells that from now on.

    Args:
        job, content: as read.
        path: of the file.
        guard: by its name.

    Raises:
        InputError: the file cannot be written.
    """
    job = replace(job, passed=tuple(dict.fromkeys((*job.passed, guard))))
    try:
        write_container(path, {**content.values, "passed": list(job.passed)}, content.arrays)
    except OSError as error:
        raise InputError(f"{path}: it cannot be written ({error.strerror or error})") from None
    return job


def unpacked_options(job: Job, content: Content, folder: Path) -> dict[str, Any]:
    """The options, with the files that they name as they were when the run began.

    Args:
        job: of the run.
        content: of its file.
        folder: for copies of the files.
    """
    options = dict(job.options)
    for number, (name, data) in enumerate(content.arrays.items()):
        option, path = name.split("\n", 1)
        copy = folder / str(number) / Path(path).name
        copy.parent.mkdir(parents=True)
        copy.write_bytes(data.tobytes())
        options[option] = _replaced(options.get(option), path, str(copy))
    return options


def _replaced(value: Any, old: str, new: str) -> Any:
    if isinstance(value, list | tuple):
        return [_replaced(entry, old, new) for entry in value]
    return new if value == old else value


def _named_files(options: Mapping[str, Any]) -> Iterator[tuple[str, np.ndarray]]:
    """Content of every file that an option names, by the option and the name."""
    for name, value in options.items():
        for entry in value if isinstance(value, list | tuple) else (value,):
            if isinstance(entry, str) and entry and name != "out":
                with suppress(OSError, ValueError):
                    path = Path(entry)
                    if path.is_file() and path.stat().st_size <= LARGEST_FILE:
                        yield f"{name}\n{entry}", np.frombuffer(path.read_bytes(), np.uint8)
