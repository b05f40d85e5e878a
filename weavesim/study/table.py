"""The table of a study: one SQLite file that knows every run by the hash of its set-up, so that none is run twice."""

from __future__ import annotations

import io
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from ..errors import InputError
from ..input_files import shown
from ..output.files import plain
from ..version import __version__
from .factors import Factor
from .plans.trials import Answer, Trial

FILE_NAME = "study.sqlite"
FORMAT_VERSION = "1"

_TABLES = """
CREATE TABLE IF NOT EXISTS about (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS runs (
    key TEXT PRIMARY KEY, setup_hash TEXT NOT NULL, version TEXT NOT NULL, status TEXT NOT NULL,
    verdict TEXT NOT NULL, numbers TEXT NOT NULL, error TEXT NOT NULL, fields BLOB
);
CREATE TABLE IF NOT EXISTS attempts (
    number INTEGER PRIMARY KEY, key TEXT NOT NULL, ended TEXT NOT NULL, worker TEXT NOT NULL, seconds REAL,
    outcome TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS points (
    position INTEGER PRIMARY KEY, point INTEGER NOT NULL, role TEXT NOT NULL, repeat INTEGER NOT NULL,
    inputs TEXT NOT NULL, key TEXT NOT NULL
);
"""


@dataclass(frozen=True, eq=False)
class Found:
    """What a run brings home.

    Attributes:
        status: "finished", "failed" or "refused".
        verdict: of the run.
        numbers: of its summary, by name.
        error: why it did not finish.
        fields: values at common material points, by name; empty if nobody asked for them.
        seconds: that it took.
        worker: that computed it.
    """

    status: str = "finished"
    verdict: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""
    fields: Mapping[str, np.ndarray] = field(default_factory=dict)
    seconds: float = 0.0
    worker: str = ""


class RunTable:
    """The runs of a study, in a file; only one process writes to it.

    Args:
        path: of the file, which is made if it is not there.

    Raises:
        InputError: it is no table of a study, or one of another version of its format.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._connection = sqlite3.connect(path, isolation_level=None)
            self._connection.execute("PRAGMA journal_mode=WAL")
            # a killed process loses nothing so; a power failure may lose the last runs, which are then run again
            self._connection.execute("PRAGMA synchronous=NORMAL")
            self._connection.executescript(_TABLES)
            self._connection.execute("INSERT OR IGNORE INTO about VALUES ('format_version', ?)", (FORMAT_VERSION,))
            found = self.about("format_version")
        except sqlite3.Error as error:
            raise InputError(f"table {shown(path)}: it is no table of a study ({error}); give another folder") from None
        if found != FORMAT_VERSION:
            raise InputError(
                f"table {shown(path)}: its format is of version {found}, this weavesim writes {FORMAT_VERSION}; "
                "give another folder"
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; it is one file then."""
        with suppress(sqlite3.Error):  # somebody reads it
            self._connection.execute("PRAGMA journal_mode=DELETE")
        self._connection.close()

    def about(self, name: str) -> str | None:
        """A remark on the study."""
        row = self._connection.execute("SELECT value FROM about WHERE name = ?", (name,)).fetchone()
        return None if row is None else str(row[0])

    def remark(self, name: str, value: str) -> None:
        """Keep a remark on the study."""
        self._connection.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (name, value))

    def want_fields_at(self, points: str) -> None:
        """Forget fields that were taken at other material points than ``points``, a digest of those that are wanted."""
        with self._transaction():
            if self.about("field_points") != points:
                self._connection.execute("UPDATE runs SET fields = NULL")
                self.remark("field_points", points)

    # ------------------------------------------------------------------------------------------------------- runs

    def has(self, key: str, *, fields: bool = False) -> bool:
        """Whether a run is known, with its fields if these are wanted."""
        row = self._connection.execute(
            "SELECT status, fields IS NOT NULL FROM runs WHERE key = ? AND version = ?", (key, __version__)
        ).fetchone()
        return row is not None and (not fields or row[0] != "finished" or bool(row[1]))

    def store(self, key: str, setup_hash: str, found: Found) -> str:
        """Keep what a run found; returns a warning if the run was known with other numbers, else ""."""
        numbers = json.dumps(plain(found.numbers), sort_keys=True, allow_nan=False)
        blob = _packed(found.fields) if found.fields else None
        with self._transaction():
            self._attempt(key, found.worker, found.seconds, found.status)
            before = self._connection.execute(
                "SELECT numbers FROM runs WHERE key = ? AND version = ?", (key, __version__)
            ).fetchone()
            self._connection.execute(
                "INSERT OR REPLACE INTO runs VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (key, setup_hash, __version__, found.status, found.verdict, numbers, found.error, blob),
            )
        if before is not None and before[0] != numbers:
            return f"run {key[:12]}: it was computed twice, with other numbers; do its workers have other processors?"
        return ""

    def attempt(self, key: str, worker: str, seconds: float | None, outcome: str) -> None:
        """Note an attempt that brought nothing home."""
        with self._transaction():
            self._attempt(key, worker, seconds, outcome)

    def _attempt(self, key: str, worker: str, seconds: float | None, outcome: str) -> None:
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self._connection.execute(
            "INSERT INTO attempts (key, ended, worker, seconds, outcome) VALUES (?, ?, ?, ?, ?)",
            (key, now, worker, seconds, outcome),
        )

    def answer(self, trial: Trial, key: str) -> Answer:
        """What is known of a run; its status is "lost" if nothing is."""
        row = self._connection.execute(
            "SELECT status, verdict, numbers, error FROM runs WHERE key = ? AND version = ?", (key, __version__)
        ).fetchone()
        if row is None:
            return Answer(trial, key, "lost", error="no worker brought it home; run the study again")
        return Answer(trial, key, row[0], row[1], json.loads(row[2]), row[3])

    def fields(self, key: str) -> dict[str, np.ndarray]:
        """Fields of a run at the common material points; empty without them."""
        row = self._connection.execute("SELECT fields FROM runs WHERE key = ?", (key,)).fetchone()
        return {} if row is None or row[0] is None else _unpacked(row[0])

    def seconds(self) -> list[float]:
        """Time of all runs that finished [s]."""
        rows = self._connection.execute("SELECT seconds FROM attempts WHERE outcome = 'finished' ORDER BY number")
        return [float(row[0]) for row in rows]

    def attempts(self) -> list[tuple[str, str, str]]:
        """Key, worker and outcome of all attempts, in order."""
        return self._connection.execute("SELECT key, worker, outcome FROM attempts ORDER BY number").fetchall()

    # ----------------------------------------------------------------------------------------------------- points

    def clear_points(self) -> None:
        """Forget which runs belong to the study, but not the runs."""
        self._connection.execute("DELETE FROM points")

    def add_points(self, factors: Sequence[Factor], trials: Iterable[tuple[Trial, str]]) -> None:
        """Add runs to the study, in order."""
        rows = [
            (trial.point, trial.role, trial.repeat, json.dumps(_inputs(factors, trial), sort_keys=True), key)
            for trial, key in trials
        ]
        with self._transaction():
            self._connection.executemany(
                "INSERT INTO points (point, role, repeat, inputs, key) VALUES (?, ?, ?, ?, ?)", rows
            )

    def rows(self) -> Iterator[dict[str, Any]]:
        """Every run of the study in order: point, role, repeat, inputs, key, status, verdict, numbers, error."""
        query = (
            "SELECT point, role, repeat, inputs, p.key, status, verdict, numbers, error FROM points p "
            "LEFT JOIN runs r ON r.key = p.key AND r.version = ? ORDER BY position"
        )
        names = ("point", "role", "repeat", "inputs", "key", "status", "verdict", "numbers", "error")
        for row in self._connection.execute(query, (__version__,)).fetchall():
            values = dict(zip(names, row, strict=True))
            values["inputs"] = json.loads(values["inputs"])
            values["numbers"] = json.loads(values["numbers"]) if values["numbers"] else {}
            yield {**values, "status": values["status"] or "lost"}

    def any_numbers(self) -> set[str]:
        """Names of the numbers of a run that finished; empty without one."""
        row = self._connection.execute(
            "SELECT numbers FROM runs WHERE status = 'finished' AND version = ? LIMIT 1", (__version__,)
        ).fetchone()
        return set() if row is None else set(json.loads(row[0]))

    def run_count(self) -> int:
        """Different runs that are known."""
        return int(self._connection.execute("SELECT count(*) FROM runs").fetchone()[0])

    def _transaction(self) -> Any:
        return _Transaction(self._connection)


class _Transaction:
    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection

    def __enter__(self) -> None:
        self._connection.execute("BEGIN IMMEDIATE")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.execute("COMMIT" if kind is None else "ROLLBACK")


def _inputs(factors: Sequence[Factor], trial: Trial) -> dict[str, Any]:
    return {factor.name: value for factor, value in zip(factors, trial.values, strict=True)}


def _packed(fields: Mapping[str, np.ndarray]) -> bytes:
    with closing(io.BytesIO()) as stream:
        np.savez_compressed(stream, **dict[str, Any](fields))
        return stream.getvalue()


def _unpacked(blob: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(blob), allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}
