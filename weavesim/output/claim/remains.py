"""Results of an earlier run in a folder: found, and removed before a new run begins."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from ...errors import InputError
from ...run.checkpoint.checkpoints import FOLDER_NAME, has_job, remove_checkpoints
from .record import NUMBERED, RECORD_NAME

# Removed first: it alone would say that a run has finished.
SUMMARY_NAME = "summary.json"
# What versions without a record left, and what a reader would take for a result.
PATTERNS = (
    SUMMARY_NAME, RECORD_NAME, "setup.json", "results.h5", "history.csv", "report.html", "run.log", "draw_in*.csv",
    "sheets.csv",
    "shear_angle*.csv", NUMBERED, "paraview/final_state*.vt[um]",
    "paraview/series.pvd",
    "pictures/formed_sheet*.png", "pictures/energies.png",
)  # fmt: skip
# Of a version without a record: also these.
FURTHER_PATTERNS = ("pictures/*.png", "*.usdc", "bias_extension.csv", "cantilever.csv", "picture_frame.csv")
TEMPORARY = ".*.partial.*"
FOLDERS = ("pictures", "paraview", FOLDER_NAME)


def check_names(folder: Path) -> None:
    """Check that no folder has the name of a result, which could not be written then, and no file that of a folder.

    Raises:
        InputError: one does.
    """
    for name in (*(pattern for pattern in PATTERNS if "*" not in pattern and "/" not in pattern), *FOLDERS):
        path = folder / name
        if path.exists() and path.is_dir() != (name in FOLDERS):
            kind = "file" if name in FOLDERS else "folder"
            raise InputError(
                f"output folder {folder}: {name} in it is a {kind}; move it, or give another folder (--out)"
            )


def check_free(folder: Path) -> None:
    """Check that a folder holds no results.

    Raises:
        InputError: it does.
    """
    found = next((path for pattern in PATTERNS for path in sorted(folder.glob(pattern))), None)
    if has_job(folder):
        raise InputError(
            f"output folder {folder}: it has a run that was not finished; go on with it (weavesim resume {folder}), "
            "give another folder (--out), or replace it (--overwrite)"
        )
    if found is not None:
        raise InputError(
            f"output folder {folder}: it has results already ({found.relative_to(folder)} and perhaps more); give "
            "another folder (--out), or replace them (--overwrite)"
        )


def remove_results(folder: Path, *, kept: Sequence[str] = (), resumes: bool = False) -> None:
    """Remove the results of earlier runs, and nothing else: the files in their record, or known names without one.

    Args:
        folder: of the results.
        kept: names of files that stay.
        resumes: whether the checkpoints of the run stay.

    Raises:
        InputError: a file that cannot be removed.
    """
    check_names(folder)
    try:
        _remove(folder / SUMMARY_NAME)
        if not resumes:
            remove_checkpoints(folder)
        for name in _recorded(folder):
            if name not in kept:
                _remove(folder / name)
        for sub in (folder, *(folder / name for name in FOLDERS)):
            if sub.is_dir() and not (sub.is_symlink() and sub != folder):
                for path in sub.glob(TEMPORARY):
                    _remove(path)
        _remove(folder / RECORD_NAME)
    except OSError as error:
        raise InputError(
            f"output folder {folder}: its old results cannot be removed ({error.strerror or error}); give another "
            "folder (--out)"
        ) from None
    for name in FOLDERS:
        with suppress(OSError):  # not empty: something else is in it
            (folder / name).rmdir()


def _recorded(folder: Path) -> list[str]:
    """Names of the files of the run that a folder belonged to; only names below the folder."""
    try:
        names = json.loads((folder / RECORD_NAME).read_text(encoding="utf-8"))["files"]
        paths = [Path(name) for name in names if isinstance(name, str)]
    except FileNotFoundError:
        return [str(p.relative_to(folder)) for pattern in (*PATTERNS, *FURTHER_PATTERNS) for p in folder.glob(pattern)]
    except (OSError, ValueError, KeyError, TypeError):  # damaged: what the patterns name
        return [str(path.relative_to(folder)) for pattern in PATTERNS for path in folder.glob(pattern)]
    # a killed run has not recorded its last frames
    paths += [path.relative_to(folder) for path in folder.glob(NUMBERED)]
    inside = [path for path in paths if not path.is_absolute() and ".." not in path.parts and _plain(folder, path)]
    return list(dict.fromkeys(map(str, inside)))


def _plain(folder: Path, path: Path) -> bool:
    """Whether no link leads out of the folder on the way to a file."""
    return not any((folder / parent).is_symlink() for parent in path.parents if parent != Path("."))


def _remove(path: Path) -> None:
    if path.is_symlink() or path.is_file():
        path.unlink()
