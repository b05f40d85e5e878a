"""A scheduler of Dask and its workers as plain processes, each in its own folder, that a test kills and restarts."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.support.paths import ROOT


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Cluster:
    """A scheduler and so many workers with one thread each.

    Attributes:
        address: of the scheduler.
        scheduler: its process.
        workers: their processes.

    Args:
        folder: for their folders and what they say.
        count: of the workers.
    """

    def __init__(self, folder: Path, count: int) -> None:
        self._folder, self._port = folder, free_port()
        self.address = f"tcp://127.0.0.1:{self._port}"
        self.scheduler = self.start_scheduler()
        self.workers = [self.start_worker(f"worker-{k}") for k in range(count)]

    def start_scheduler(self) -> subprocess.Popen:
        """Start it at its address."""
        self.scheduler = self._start(
            "scheduler", "dask_scheduler", "--host", "127.0.0.1", "--port", str(self._port), "--no-dashboard",
            "--no-jupyter",
        )  # fmt: skip
        return self.scheduler

    def start_worker(self, name: str) -> subprocess.Popen:
        """Start one in a folder of its own."""
        return self._start(
            name, "dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--name", name,
            "--local-directory", str(self._folder / name), "--death-timeout", "300",
        )  # fmt: skip

    def _start(self, name: str, program: str, *arguments: str) -> subprocess.Popen:
        folder = self._folder / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        with open(self._folder / f"{name}.log", "ab") as log:
            return subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", *arguments], cwd=folder, stdout=log, stderr=log,
                env={**os.environ, "PYTHONPATH": str(ROOT)},
            )  # fmt: skip

    def kill(self, process: subprocess.Popen) -> None:
        """SIGKILL."""
        process.send_signal(signal.SIGKILL)
        process.wait()

    def restart(self) -> None:
        """Kill the scheduler, start it again, and replace the workers that ended with it, as a deployment does."""
        self.kill(self.scheduler)
        self.start_scheduler()
        for k, worker in enumerate(self.workers):
            self.kill(worker)
            self.workers[k] = self.start_worker(f"worker-again-{k}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in (*self.workers, self.scheduler):
            if process.poll() is None:
                self.kill(process)
