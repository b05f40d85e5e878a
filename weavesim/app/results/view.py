"""``weavesim view``: the page of a run in a browser; ``--live``: of a run in progress."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ..terminal import say


def view_command(
    run: Annotated[Path, typer.Argument(help="folder of a run, its --out", metavar="OUT")],
    live: Annotated[
        bool, typer.Option("--live", help="keep up with a run in progress, until Ctrl-C; the run may begin later")
    ] = False,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="of --live, on this machine only; 0 takes a free one")
    ] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open it in a browser")] = True,
) -> None:
    """Open the page of a run; with --live it shows how far the run is, and is renewed while it goes on."""
    if port and not live:
        raise InputError("--port: has no effect without --live; leave it out")
    if not run.is_dir():
        raise InputError(f"run {run}: it is no folder; give the folder of a run, its --out")
    if live:
        _serve(run, port, browser)
    else:
        _open_page(run, browser)


def _open_page(run: Path, browser: bool) -> None:
    import webbrowser

    from .live import PAGE_NAME

    page = run / PAGE_NAME
    if not page.is_file():
        others = sorted(str(found.parent) for found in run.glob(f"*/{PAGE_NAME}"))
        hint = f"; there is one in {', '.join(others[:8])}" if others else ""
        raise InputError(
            f"run {run}: it has no {PAGE_NAME}{hint}. A run writes it unless it is left out (--without report); "
            "one in progress is shown by --live"
        )
    say(str(page.absolute().as_uri()))
    if browser:
        webbrowser.open(page.absolute().as_uri())


def _serve(run: Path, port: int, browser: bool) -> None:
    import webbrowser

    from .live import LiveServer

    server = LiveServer(run, port)
    say(f"{server.address} shows {run} until Ctrl-C")
    if browser:
        webbrowser.open(server.address)
    try:
        server.serve()
    except KeyboardInterrupt:
        say("no longer shown")
    finally:
        server.close()
