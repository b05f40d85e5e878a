"""Names that users give: of runs, which become names of files, and of sheets, tools, supports and fabrics."""

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
    if bad := sorted(set(value) & set(FORBIDDEN)):
        raise ValueError(f"it becomes the name of files, in which {' '.join(bad)} is not allowed")
    _label(value)
    if value.startswith(".") or value != value.strip() or value.endswith("."):
        raise ValueError("it becomes the name of files: it may not begin with a dot, nor end in one, nor with spaces")
    if RESERVED.fullmatch(value):
        raise ValueError("it becomes the name of files, and some systems reserve this one for a device")
    if (size := len(value.encode())) > LONGEST_FILE_NAME:
        raise ValueError(f"it becomes the name of files: at most {LONGEST_FILE_NAME} bytes, here are {size}")
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
