"""Names that users give: of runs, which become names of files, of sheets, tools, supports and fabrics; of classes."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

from .errors import InputError

# Room for endings of file names, of which file systems allow 255 bytes.
LONGEST_FILE_NAME = 100
LONGEST_LABEL = 200
# Windows opens devices under these names, with any ending.
RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)
FORBIDDEN = '/\\:*?"<>|'


def _label(value: str) -> str:
    if not value.strip():
        raise ValueError("a name is needed")
    if not value.isprintable():
        raise ValueError("only printable characters are allowed, no line breaks or other control characters")
    if len(value) > LONGEST_LABEL:
        raise ValueError(f"at most {LONGEST_LABEL} characters are allowed, here are {len(value)}")
    return value


def _file_name(value: str) -> str:
    bytes_given = len(value.encode("utf-8", "surrogatepass"))
    bad = sorted(set(value) & set(FORBIDDEN))
    problem = ""
    if bad:
        problem = f"without {' '.join(bad)}"
    elif not value.strip(" ."):
        problem = "give letters"
    elif not value.isprintable():
        problem = "only printable characters are allowed, no line breaks or other control characters"
    elif value.startswith(".") or value != value.strip() or value.endswith("."):
        problem = "it may not begin with a dot or a space, nor end in one"
    elif RESERVED.fullmatch(value):
        problem = "some systems reserve this one for a device"
    elif bytes_given > LONGEST_FILE_NAME:
        problem = f"at most {LONGEST_FILE_NAME} bytes are allowed, here are {bytes_given}"
    if problem:
        raise ValueError(f"it becomes the name of files: {problem}")
    return value


# A name for outputs.
Label = Annotated[str, AfterValidator(_label)]
# A name that files begin with.
FileName = Annotated[str, AfterValidator(_file_name)]


def file_name(what: str, value: str) -> str:
    """``value`` if files may be named after it.

    Raises:
        InputError: a path, a device, control characters, too long, or empty.
    """
    try:
        return _file_name(value)
    except ValueError as error:
        raise InputError(f"{what} = {value[:LONGEST_LABEL]!r}: {error}") from None


def enter(known: dict[str, type], name: str, kind: type, what: str) -> None:
    """Enter a class among those ``known`` by name; one that is defined anew takes its own place.

    Raises:
        TypeError: another class has this name; ``what`` both are is in the message.
    """
    other = known.get(name)
    if other and (other.__module__, other.__qualname__) != (kind.__module__, kind.__qualname__):
        raise TypeError(f"{what} {name}: {other.__module__} already has one of this name")
    known[name] = kind
