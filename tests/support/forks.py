"""The command line in forks of one process that has loaded what it needs: processes of their own without their start.

A start takes three seconds of a core: imports, kernels to hash. What a test does to a process, by signals or by leaving
it, does not depend on how it began; whatever is about the start itself, or about the streams that a shell gives,
belongs in ``processes.run``. Programs that read one file are forked likewise from processes with their libraries, see
``run_program``: a hundred damaged files take a third of a second each for the start alone.
"""

from __future__ import annotations

import contextlib
import importlib
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

    def __init__(
        self, server: socket.socket, words: list[str], environment: dict[str, str], largest_file: int | None = None
    ) -> None:
        self._open = contextlib.ExitStack()
        self._streams = [self._open.enter_context(_nameless_file()) for _ in range(2)]
        reading, writing = os.pipe()
        asked = {"words": words, "environment": environment, "folder": os.getcwd(), "largest_file": largest_file}
        request = json.dumps(asked).encode()
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

    def contents(self, timeout: float | None = None) -> tuple[bytes, bytes]:
        """What it has written in the end, on standard output and error."""
        self.wait(timeout)
        for stream in self._streams:
            stream.seek(0)
        out, err = (stream.read() for stream in self._streams)
        self._open.close()
        return out, err

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """The same as text."""
        out, err = (content.decode(errors="surrogateescape") for content in self.contents(timeout))
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


def fork(words: list[str], environment: dict[str, str], largest_file: int | None = None) -> Fork:
    """Start ``weavesim`` with these words, in this folder.

    Args:
        words: of the command.
        environment: of its process.
        largest_file: to which a file of it can grow [bytes], as on a full disk; None for any.
    """
    return Fork(_server(), words, environment, largest_file)


def run_program(modules: tuple[str, ...], command: list[str], timeout: float) -> subprocess.CompletedProcess:
    """``python -P PROGRAM WORDS...`` to its end, in a fork of a process that has imported these modules.

    Raises:
        subprocess.TimeoutExpired: it still runs.
    """
    process = Fork(_server(modules), command[command.index("-P") + 1 :], dict(os.environ))
    try:
        out, err = process.contents(timeout)
    finally:
        process.kill()
    return subprocess.CompletedProcess(command, process.wait(), out, err)


@cache
def _server(modules: tuple[str, ...] = ()) -> socket.socket:
    """The end of a connection to the server; it ends when the connection does, with this process."""
    own, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with its:
        subprocess.Popen(
            [sys.executable, "-P", "-m", "tests.support.forks", *modules], stdin=its,
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
    if (size := asked["largest_file"]) is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    os.environ.clear()
    os.environ.update(asked["environment"])
    os.chdir(asked["folder"])
    return asked["words"]


if __name__ == "__main__":
    modules = sys.argv[1:]
    for module in modules:
        importlib.import_module(module)
    if not modules:
        _load()
    words = _serve(socket.socket(fileno=0))
    if modules:
        sys.argv = words
        runpy.run_path(words[0], run_name="__main__")
    else:
        sys.argv = ["weavesim", *words]
        runpy.run_module("weavesim", run_name="__main__", alter_sys=True)
