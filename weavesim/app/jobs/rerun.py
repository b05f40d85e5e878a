"""``weavesim rerun``: repeat a run from its folder, and say whether the result is the same to the bit."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...errors import InputError
from ...input_files import MEBIBYTE, read_bounded, shown
from ..ending import ExitCode
from ..session import announce_compilation, announced, interruptible
from ..terminal import say
from .arguments import Overwrite
from .folders import read_record

if TYPE_CHECKING:
    from ...engine.setup import Setup

LARGEST_SETUP = 2048 * MEBIBYTE


def rerun_command(
    out: Annotated[Path, typer.Argument(help="folder of a finished run", metavar="OUT")],
    into: Annotated[Path | None, typer.Option(help="folder for its results [default: none are written]")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Repeat a run from its folder, and say whether its result is the same to the bit."""
    from ...engine.compilation import side_by_side

    record = read_record(out)
    setup, expected = repeatable(out, record)
    for line in differences(record):
        say(line)
    with interruptible() as interrupted, side_by_side(partial(announce_compilation, setup.name)), announced():
        found = _run(setup, into, overwrite, record)
    if interrupted.signal is not None:
        raise typer.Exit(128 + interrupted.signal)
    if found == expected:
        say(f"The same to the bit: the final state of {out} and of this run is {expected[:16]}.")
        return
    say(f"Not the same: the final state of {out} is {expected[:16]}, that of this run {found[:16]}.")
    raise typer.Exit(int(ExitCode.RUN_ERROR))


def repeatable(out: Path, record: dict[str, Any]) -> tuple[Setup, str]:
    """The set-up of a run in a folder, and the hash of its final state.

    Raises:
        InputError: a run that cannot be repeated, or whose set-up is not the one that was run.
    """
    from ...engine.setup import Setup
    from ...output.claim.record import SETUP_NAME

    if record.get("outcome") != "finished":
        raise InputError(f"folder {shown(out)}: its run is {record.get('outcome') or 'not ended'}; only one that "
                         "finished can be repeated")  # fmt: skip
    expected = record.get("final_state")
    if not isinstance(expected, str):
        raise InputError(f"folder {shown(out)}: its run was made by a version that did not record the final state")
    setup = Setup.from_json(read_bounded(out / SETUP_NAME, "set-up", LARGEST_SETUP))
    if setup.content_hash != record.get("setup_hash"):
        raise InputError(f"folder {shown(out)}: {SETUP_NAME} is not the set-up that was run; it was changed since")
    return setup, expected


def differences(record: dict[str, Any]) -> list[str]:
    """What is different here from where a run was made, and may change its bits."""
    from ...device import cpu_features
    from ...output.claim.record import versions
    from ...output.claim.source import source_commit

    found = [
        f"Note: {name} was {then}, here it is {now}"
        for name, then in (record.get("versions") or {}).items()
        if (now := versions().get(name)) != then
    ]
    commit = record.get("commit")
    if commit and commit != (here := source_commit()):
        then, now = (f"{each[:12]}{each[40:]}" if each else "another copy" for each in (commit, here))
        found.append(f"Note: it was made by commit {then}, here is {now}")
    if record.get("processor_features") != cpu_features():
        found.append("Note: the processor is of another kind, on which compiled kernels may round differently")
    return found


def _run(setup: Setup, into: Path | None, overwrite: bool, record: dict[str, Any]) -> str:
    """Hash of the final state of a repeated run, with the fields that ``record`` has."""
    from ...output import ResultFolder
    from ...output.claim.record import frame_hash
    from ...run.simulation import Simulation
    from ..progress import ProgressBar
    from ..run_into_folder import run_into_folder

    options, fields = dict(record.get("options") or {}), record.get("final_fields")
    if into is not None:
        # scenes and jobs name it so in the record
        shows_solver = bool(options.get("solver_fields") or options.get("output.solver_fields"))
        folder = ResultFolder(into, overwrite=overwrite, options=options, solver_fields=shows_solver)
        run_into_folder(setup, folder, options=options)
        return "" if folder.history.last_frame is None else frame_hash(folder.history.last_frame, fields)
    simulation, bar = Simulation(setup), ProgressBar(stays=True)
    bar.listen()
    try:
        simulation.run([bar], every_field=False)
    finally:
        bar.close()
    return frame_hash(simulation.frame, fields)
