"""A user's own folder of fabrics, whose files are found by their names."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from ...errors import InputError
from ...input_files import shown
from .registry import PRESETS

# Names another folder.
VARIABLE = "WEAVESIM_FABRICS"
DEFAULT_FOLDER = Path("~/.weavesim/fabrics")
SUFFIXES = (".toml", ".json")


def fabric_folder() -> Path:
    """The user's folder of fabrics, which need not exist."""
    given = os.environ.get(VARIABLE, "").strip()
    folder = Path(given) if given else DEFAULT_FOLDER
    try:
        return folder.expanduser()
    except RuntimeError:  # a user without a home
        return folder


def kept_files() -> Mapping[str, tuple[Path, ...]]:
    """Fabric files in the user's folder, by the name of the fabric, in alphabetical order.

    A file is named as its fabric, with .toml or .json; hidden ones, other files and folders within are no fabrics. More
    than one file of a name is a mistake that ``kept_file`` tells.

    Raises:
        InputError: a folder that cannot be read, or one that the environment names and that is none.
    """
    folder = fabric_folder()
    try:
        files = sorted(folder.iterdir())
    except FileNotFoundError:
        if os.environ.get(VARIABLE, "").strip():
            raise InputError(f"{VARIABLE} = {shown(folder)}: there is no such folder; create it, or unset it") from None
        return {}
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"folder of fabrics {shown(folder)}: cannot be read ({shown(reason)})") from None
    result: dict[str, tuple[Path, ...]] = {}
    for file in files:
        if file.suffix.lower() in SUFFIXES and not file.name.startswith(".") and not file.is_dir():
            result[file.stem] = (*result.get(file.stem, ()), file)
    return result


def kept_file(name: str) -> Path | None:
    """The file of a fabric in the user's folder; None if there is none of this name.

    Raises:
        InputError: several files of this name, or as ``kept_files``.
    """
    files = kept_files().get(name, ())
    if len(files) > 1:
        raise InputError(
            f"fabric {name!r}: {' and '.join(shown(file.name) for file in files)} in {shown(fabric_folder())} have the "
            "same name; rename one, or give the path of the one that is meant"
        )
    return files[0] if files else None


def shadows() -> Mapping[str, Path]:
    """Files in the user's folder that are named like a preset, by its name.

    Raises:
        InputError: as ``kept_files``.
    """
    # some file systems do not tell capitals from small letters
    presets = {name.casefold(): name for name in PRESETS}
    return {
        presets[name.casefold()]: files[0] for name, files in kept_files().items() if name.casefold() in presets
    }  # fmt: skip


def check_no_shadow(preset: str) -> None:
    """Raise InputError if a file in the user's folder is named like this preset: which one is meant is not clear."""
    try:
        file = shadows().get(preset)
    except InputError:
        return  # no folder: nothing in it has this name
    if file is not None:
        raise InputError(
            f"fabric {preset!r}: this is a preset, and {shown(file)} has the same name; rename that file, or give its "
            "path if it is meant"
        )
