"""``weavesim resume``: go on with runs that were interrupted or killed."""

from __future__ import annotations

import json
import logging
import reprlib
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..documents import parse_json
from ..errors import InputError
from ..input_files import read_bounded

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..run.checkpoint.container import Content
    from ..run.checkpoint.job import Job

logger = logging.getLogger(__name__)

# Of an edited set-up, so many are named.
MOST_CHANGES = 3


def resume_folder(out: Path, *, threads: int | None = None, device: str | None = None) -> dict[str, Any]:
    """Go on with the run in a folder of results, or with all runs in the folders below it, one after the other.

    Args:
        out: folder of the results.
        threads, device: instead of those that the run began with.

    Returns:
        The summary; of several runs, the summaries by the name of their folder, and the outcome of the last one.

    Raises:
        InputError: there is nothing to resume, or it cannot be resumed here.
        RunError: a run had to stop; results up to its last good frame are written first.
    """
    from ..run.checkpoint.checkpoints import has_job, read_job

    if has_job(out) or not out.is_dir():
        return _resumed(out, *read_job(out), threads, device)
    jobs = {folder: read_job(folder) for folder in sorted(out.iterdir()) if has_job(folder)}
    if not jobs:
        read_job(out)  # says that there is none
    summaries: dict[str, Any] = {}
    for folder, (job, content) in sorted(jobs.items(), key=lambda item: item[1][0].order):
        summaries[folder.name] = _resumed(folder, job, content, threads, device)
        summaries["outcome"] = summaries[folder.name].get("outcome")
        if summaries["outcome"] != "finished":
            break
    return summaries


def _resumed(out: Path, job: Job, content: Content, threads: int | None, device: str | None) -> dict[str, Any]:
    from ..output import ResultFolder
    from ..output.run_page.provenance import record_of
    from ..run.checkpoint.checkpoints import job_path
    from ..run.checkpoint.job import going_on, unpacked_options
    from .run_into_folder import run_into_folder

    _check_unchanged(out, job.setup)
    if (guard := record_of(out).get("stopped_by")) is not None:
        job = going_on(job, content, job_path(out), str(guard))
    job = replace(job, setup=_elsewhere(job.setup, threads, device))
    if name := job.origin.get("scene"):
        scenes = import_module("weavesim.scenes.scene").known_scenes()
        if name not in scenes:
            raise InputError(f"folder {out}: its run is of the scene {name!r}, which this weavesim does not have")
        with tempfile.TemporaryDirectory(prefix="weavesim-") as inputs:
            return scenes[name].load().resume(job, unpacked_options(job, content, Path(inputs)), out)
    folder = ResultFolder(
        out, writers=job.writers or None, options=job.options, resumes=True, solver_fields=job.solver_fields
    )
    return run_into_folder(job.setup, folder, options=job.options, job=job, resumes=True, reads_frames=False)


def _check_unchanged(out: Path, setup: Setup) -> None:
    """Check that nobody has edited the set-up in a folder: a run goes on with the one that it began with.

    Args:
        out: the folder.
        setup: that the run began with.

    Raises:
        InputError: it was edited.
    """
    from ..output.claim.record import SETUP_NAME
    from .jobs.rerun import LARGEST_SETUP

    path, own = out / SETUP_NAME, setup.to_json()
    try:
        text = read_bounded(path, "set-up", LARGEST_SETUP)
        if text.strip() == own.encode():
            return
        found = parse_json(text)
    except (InputError, ValueError, RecursionError) as error:
        if path.exists():
            logger.warning("%s: %s: the run goes on with the set-up that it began with, written anew", path, error)
        return
    changed = list(islice(_changes(json.loads(own), found), MOST_CHANGES))
    if not changed:
        return
    raise InputError(
        f"folder {out}: {SETUP_NAME} is not the set-up that the run began with ({'; '.join(changed)}), and a run goes "
        f"on with that one; to go on, remove the file, which is written anew; for a run of the changed one, give it to "
        "Setup.from_json in Python"
    )


def _changes(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Where two values as JSON has them differ, but for what a resume may choose anew."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted({*before, *after}):
            own = f"{place}.{key}" if place else key
            if own not in ("solver.threads", "solver.device"):
                yield from _changes(before.get(key), after.get(key), own)
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from _changes(old, new, f"{place}[{index}]")
    elif before != after:
        old, new = (reprlib.repr(value) for value in (before, after))
        yield f"{place} was {old} and is {new}"


def _elsewhere(setup: Setup, threads: int | None, device: str | None) -> Setup:
    given: Mapping[str, Any] = {"threads": threads, "device": device}
    changes = {name: value for name, value in given.items() if value is not None}
    return setup.model_copy(update={"solver": setup.solver.model_copy(update=changes)}) if changes else setup
