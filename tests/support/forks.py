"""The command line in forks of one process that has loaded what it needs: processes of their own without their start.

A start takes three seconds of a core: imports, kernels to hash. What a test does to a process, by signals or by leaving
it, does not depend on how it began; whatever is about the start itself, or about the streams that a shell gives,
belongs in ``processes.run``.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path

from tests.support.paths import ROOT

# A request and its answer have few words [bytes].
_LONGEST = 1 << 16


class Fork:
    """A command that runs, with as much of ``subprocess.Popen`` as tests need.

    Attributes:
        pid: of its process.
        returncode: None as long as it runs; minus the number of the signal that killed it.
    """

    def __init__(self, server: socket.socket, words: list[str], environment: dict[str, str]) -> None:
        self._open = contextlib.ExitStack()
        self._streams = [self._open.enter_context(_nameless_file()) for _ in range(2)]
        reading, writing = os.pipe()
        request = json.dumps({"words": words, "environment": environment, "folder": os.getcwd()}).encode()
        socket.send_fds(server, [request], [*(stream.fileno() for stream in self._streams), writing])
        os.close(writing)
        self._told = self._open.enter_context(os.fdopen(reading, "rb"))
        self.pid = int(self._told.readline())
        self.returncode: int | None = None

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code.

        Raises:
            subprocess.TimeoutExpired: it still runs.
        """
        if self.returncode is None:
            if not select.select([self._told], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("weavesim", timeout or 0.0)
            self.returncode = int(self._told.readline())
        return self.returncode

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """What it has said in the end, on standard output and error."""
        self.wait(timeout)
        for stream in self._streams:
            stream.seek(0)
        out, err = (stream.read().decode(errors="surrogateescape") for stream in self._streams)
        self._open.close()
        return out, err

    def send_signal(self, number: int) -> None:
        """As long as it runs."""
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def kill(self) -> None:
        """SIGKILL."""
        self.send_signal(signal.SIGKILL)


def _nameless_file() -> io.BufferedRandom:
    descriptor, name = tempfile.mkstemp()
    os.unlink(name)
    return os.fdopen(descriptor, "w+b")


def fork(words: list[str], environment: dict[str, str]) -> Fork:
    """Start ``weavesim`` with these words, in this folder."""
    return Fork(_server(), words, environment)


@cache
def _server() -> socket.socket:
    """The end of a connection to the server; it ends when the connection does, with this process."""
    own, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with its:
        subprocess.Popen(
            [sys.executable, "-P", "-m", "tests.support.forks"], stdin=its,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )  # fmt: skip
    return own


# --- in the server ----------------------------------------------------------------------------------------------------


def _load() -> None:
    """What a coarse run loads, by making one; no thread is left, which a fork would not have."""
    from weavesim.app import command_line
    from weavesim.scenes import picture_frame

    assert command_line
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        picture_frame.SCENE.run(
            picture_frame.SCENE.parameters(
                out=Path(folder) / "out", mesh_size=0.05, threads=1, speed=2.0, frame_count=2, accept_unusual=True,
                write="film,tables,summary",
            )
        )  # fmt: skip
    assert threading.active_count() == 1


def _serve(requests: socket.socket) -> list[str]:
    """Fork for every request; returns its words in the fork, and never in the server."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the system takes keepers away
    while True:
        request, descriptors, _, _ = socket.recv_fds(requests, _LONGEST, 3)
        if not request:
            os._exit(0)
        if os.fork() == 0:
            break
        for descriptor in descriptors:
            os.close(descriptor)
    nowhere = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nowhere, requests.detach())  # standard input
    os.close(nowhere)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    out, err, telling = descriptors
    if child := os.fork():  # this process is the keeper, which tells how the command ends
        os.write(telling, b"%d\n" % child)
        for descriptor in (out, err):
            os.close(descriptor)
        os.write(telling, b"%d\n" % os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        os._exit(0)
    asked = json.loads(request)
    os.dup2(out, 1)
    os.dup2(err, 2)
    for descriptor in descriptors:
        os.close(descriptor)
    os.environ.clear()
    os.environ.update(asked["environment"])
    os.chdir(asked["folder"])
    return asked["words"]


if __name__ == "__main__":
    _load()
    sys.argv = ["weavesim", *_serve(socket.socket(fileno=0))]
    runpy.run_module("weavesim", run_name="__main__", alter_sys=True)
