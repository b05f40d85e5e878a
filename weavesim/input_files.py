"""Files that a user names: only regular ones, of bounded size, and what another file names stays in its folder."""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path, PureWindowsPath

from .errors import InputError

MEBIBYTE = 2**20
# What a name that is not a regular file stands for.
_KINDS = (
    (stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)  # fmt: skip


def shown(text: object) -> str:
    """``text`` for a message, on one line and printable: other characters are escaped, so that nobody forges lines."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(text))


# How a user gives the unit of a file: to a function, in a job, and to a command.
IN_PYTHON, IN_JOB, IN_COMMAND = "unit_scale={metres:g}", 'unit = "{name}"', "--unit {name}"
OF_EDGE_IN_COMMAND = "--edge-unit {name}"
_UNITS = {0.001: "mm", 0.01: "cm", 0.0254: "inch", 0.3048: "ft", 1.0: "m", 1.0e-6: "um"}
_units_given: ContextVar[str] = ContextVar("units_given", default=IN_PYTHON)


@contextmanager
def units_given_as(form: str) -> Iterator[None]:
    """Have messages say how to give the unit of a file in one of the forms above."""
    token = _units_given.set(form)
    try:
        yield
    finally:
        _units_given.reset(token)


def unit_name(metres: float) -> str | None:
    """Name of a unit of so many metres, such as "mm"; None of one without a usual name."""
    return next((name for size, name in _UNITS.items() if math.isclose(size, metres, rel_tol=1.0e-6)), None)


def unit_wish(metres: float) -> str:
    """What a user gives for a file whose unit is so many metres, as by ``units_given_as``."""
    name = unit_name(metres)
    return (IN_PYTHON if name is None else _units_given.get()).format(metres=metres, name=name)


def path_of(path: object, what: str) -> Path:
    """A path that a user gives.

    Raises:
        InputError: something else than a text or a path, or an empty one.
    """
    # an empty name would be the current folder
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str) or not str(path).strip():
        raise InputError(f"{what} = {shown(repr(path))[:80]}: the path of a file is needed, as a text or a Path")
    return Path(path)


def read_bounded(path: str | Path, what: str, largest: int) -> bytes:
    """The content of a regular file; never waits, and never reads more than ``largest`` bytes.

    Args:
        path: of the file.
        what: name of such a file in messages, such as "fabric file".
        largest: number of bytes that is still read.

    Raises:
        InputError: a file that is missing, is not regular (a folder, a device, a pipe), or is too large.
    """
    check_bounded(path, what, largest)
    try:
        # without waiting: the name may have become a pipe since the check
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with open(descriptor, "rb") as file:
            _check_regular(os.fstat(descriptor), path, what)
            content = file.read(largest + 1)
    except OSError as error:
        raise _unreadable(path, what, error) from None
    if len(content) > largest:  # it grew, or it is one whose size is not known before
        raise _too_large(path, what, len(content), largest)
    return content


def check_bounded(path: str | Path, what: str, largest: int) -> int:
    """Size in bytes of a regular file, for readers that open it by its name.

    Raises:
        InputError: a file that is missing, is not regular (a folder, a device, a pipe), or is too large.
    """
    path = path_of(path, what)  # not a number either: it would be the descriptor of an open file
    try:
        found = os.stat(path)
    except (OSError, ValueError) as error:
        raise _unreadable(path, what, error) from None
    _check_regular(found, path, what)
    if found.st_size > largest:
        raise _too_large(path, what, found.st_size, largest)
    return found.st_size


def within_folder(folder: Path, reference: object, what: str) -> Path:
    """The file that another one in ``folder`` refers to, which may be in that folder or below it.

    A file from somebody else must not be able to have other files of this machine read.

    Args:
        folder: of the file that contains the reference.
        reference: relative name, as written there.
        what: place of the reference in messages.

    Raises:
        InputError: a reference that is no name or leads out of the folder, also by a symbolic link.
    """
    if not isinstance(reference, str) or not reference.strip() or "\0" in reference:
        raise InputError(f"{what} = {reference!r}: the name of a file is needed, as a text")
    outside = InputError(
        f"{what} = {reference!r}: leads out of the folder of the file that refers to it; copy the data beside that "
        "file, and give its name there"
    )
    if Path(reference).is_absolute() or PureWindowsPath(reference).anchor:
        raise outside
    try:
        path, home = (folder / reference).resolve(), folder.resolve()
    except (OSError, RuntimeError) as error:  # links in a circle
        raise _unreadable(reference, what, error) from None
    if not path.is_relative_to(home):
        raise outside
    return path


def _check_regular(found: os.stat_result, path: str | Path, what: str) -> None:
    if not stat.S_ISREG(found.st_mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(found.st_mode)), "not a regular file")
        raise InputError(f"{what} {shown(path)}: cannot be read (it is {kind}); give a file")


def _too_large(path: str | Path, what: str, size: int, largest: int) -> InputError:
    return InputError(
        f"{what} {shown(path)}: {size / MEBIBYTE:.4g} MiB or more; at most {largest / MEBIBYTE:g} MiB are read. "
        "Is it the right file?"
    )


def _unreadable(path: str | Path, what: str, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{what} {shown(path)}: cannot be read ({shown(reason)})")
