"""Shows the folder of a run in a browser on this machine, and keeps up with it."""

from __future__ import annotations

import json
from contextlib import suppress
from functools import cached_property
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from ...errors import InputError
from ..terminal import say

PAGE_NAME = "report.html"
# Other machines cannot reach it.
ADDRESS = "127.0.0.1"
_OWN_NAMES = (ADDRESS, "localhost")


class LiveServer:
    """Serves the page of a run, and how far the run is, to browsers of this machine. It changes nothing in the folder.

    ``/`` is the page, or a page that waits for it; ``/progress`` is ``progress.json`` with when the page was written.

    Args:
        folder: of the run.
        port: 0 takes a free one.

    Raises:
        InputError: the port is taken.
    """

    def __init__(self, folder: Path, port: int = 0) -> None:
        self.folder, self._serves = folder, False
        try:
            self._server = ThreadingHTTPServer((ADDRESS, port), _handler(folder))
        except OSError as error:
            raise InputError(
                f"port {port}: {error.strerror or error}; give another one with --port, or 0 for any that is free"
            ) from None
        self._server.daemon_threads = True

    @cached_property
    def address(self) -> str:
        """For a browser."""
        return f"http://{ADDRESS}:{self._server.server_address[1]}/?live"

    def serve(self) -> None:
        """Serve until ``close``."""
        self._serves = True
        self._server.serve_forever(poll_interval=0.2)

    def close(self) -> None:
        """Stop."""
        if self._serves:  # else it would wait for an end that never comes
            self._server.shutdown()
        self._server.server_close()


def show_live(folder: Path, port: int, opens: bool) -> None:
    """Serve the run of a folder until Ctrl-C.

    Args:
        folder: of the run, which may begin, and be made, later.
        port: 0 takes a free one.
        opens: open a browser.

    Raises:
        InputError: it is a file, or the port is taken.
    """
    import webbrowser

    if folder.exists() and not folder.is_dir():
        raise InputError(f"run {folder}: it is no folder; give the folder of a run, its --out")
    server = LiveServer(folder, port)
    waits = "" if folder.is_dir() else ", which is not there yet: it waits for the run to make it,"
    say(f"{server.address} shows {folder}{waits} until Ctrl-C")
    if opens and not webbrowser.open(server.address):
        say("No browser could be opened here: open that address yourself.")
    try:
        with suppress(KeyboardInterrupt):
            server.serve()
    finally:
        server.close()


def state_of(folder: Path) -> dict[str, Any]:
    """How far the run of a folder is: ``progress.json``, and ``page``, which changes whenever the page is written."""
    from ...output.claim.lock import is_locked
    from ...output.run_page.progress import PROGRESS_NAME

    try:
        state = json.loads((folder / PROGRESS_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        state = {"state": "no run has begun yet"}
    if state.get("state") == "running" and is_locked(folder) is False:
        state["state"] = "stopped without an end: weavesim resume goes on with it"
    state["page"] = _version(folder)
    return state


def _version(folder: Path) -> str | None:
    """Of the page as it is now; None for none."""
    try:
        page = (folder / PAGE_NAME).stat()
    except OSError:
        return None
    return f"{page.st_mtime_ns}-{page.st_size}"


def _handler(folder: Path) -> type[BaseHTTPRequestHandler]:
    """Answers for one folder."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:  # the name is that of the standard library
            # a page of another site must not read results by a name of its own for this machine
            if urlsplit(f"//{self.headers.get('Host', '')}").hostname not in _OWN_NAMES:
                self.send_error(403)
            elif (path := urlsplit(self.path).path) == "/progress":
                self._answer(json.dumps(state_of(folder)).encode(), "application/json")
            elif path == "/":
                self._answer(_page(folder), "text/html; charset=utf-8")
            else:
                self.send_error(404)

        def _answer(self, content: bytes, kind: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing of every answer."""

    return Handler


def _page(folder: Path) -> bytes:
    """The page of the run with its version, or one that waits for it."""
    # taken first: a page that is written meanwhile is looked at once more, not missed
    version = f'<meta name="weavesim-page" content="{_version(folder)}">\n</head>'
    try:
        return (folder / PAGE_NAME).read_bytes().replace(b"</head>", version.encode(), 1)
    except OSError:
        return files("weavesim.output.run_page").joinpath("waiting.html").read_bytes()
