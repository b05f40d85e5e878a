"""One run at a time in a folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...errors import InputError
from .record import RECORD_NAME

# Stays in the folder: removing it would let two processes lock different files of this name.
LOCK_NAME = ".weavesim.lock"


class FolderLock:
    """A lock on a folder. The operating system releases it when the process ends, however it ends.

    Args:
        folder: exists.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock: Any = None

    def acquire(self) -> None:
        """Take the lock; nothing happens if it is held already.

        Raises:
            InputError: another run has it, or the folder cannot be written to.
        """
        if self._lock is not None:
            return
        from filelock import FileLock, Timeout

        lock = FileLock(self._folder / LOCK_NAME, timeout=0, thread_local=False)
        try:
            lock.acquire()
        except Timeout:
            raise _taken(self._folder) from None
        except OSError as error:
            raise InputError(
                f"output folder {self._folder}: cannot be locked ({error.strerror or error}); give another folder"
            ) from None
        self._lock = lock

    def release(self) -> None:
        """Give the lock back; nothing happens if it is not held."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None


def check_unlocked(folder: Path) -> None:
    """Check that no run writes to a folder, before what it has written is taken for what an earlier run left.

    Raises:
        InputError: one does.
    """
    if is_locked(folder):
        raise _taken(folder)


def is_locked(folder: Path) -> bool | None:
    """Whether a run is writing to a folder; None where its lock cannot be looked at, as in a folder of another user."""
    from filelock import FileLock, Timeout

    path = folder / LOCK_NAME
    if not path.exists():
        return False
    lock = FileLock(path, timeout=0, thread_local=False)
    try:
        lock.acquire()
    except Timeout:
        return True
    except OSError:
        return None
    lock.release()
    return False


def _taken(folder: Path) -> InputError:
    return InputError(
        f"output folder {folder}: {_holder(folder)} is writing to it; wait until that has ended, or give another folder"
    )


def _holder(folder: Path) -> str:
    """The run that has the lock, from its record."""
    try:
        record = json.loads((folder / RECORD_NAME).read_text(encoding="utf-8"))
        return f"run {record['run_id']} (process {record['process']} on {record['host']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another run"  # it has not begun to write
