"""Runs that are killed at random moments and resumed."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Lines of progress.
LINE_COUNT = 20


def kills(folder: Path, count: int, seed: int) -> bool:
    """Kill ``count`` runs of a tiny set-up, up to three times each, resume them, and compare their ends."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.support.kills", str(folder), str(count), str(seed)],
        cwd=ROOT, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    started, seen, failed = time.monotonic(), Counter[str](), 0
    for number, line in enumerate(process.stdout):
        found = json.loads(line)
        if number == 0:
            print(f"one run: {found}", flush=True)
            continue
        for death in found["deaths"]:
            where = "between" if death["operation"] is None else "while writing"
            seen[where if death["ended"] == "killed" else "not killed"] += 1
        if found.get("error") or found.get("different"):
            failed += 1
            print(f"FAILED: {line.rstrip()}", flush=True)
        if number % max(1, count // LINE_COUNT) == 0:
            passed = time.monotonic() - started
            print(f"{number} of {count} runs, {dict(seen)}, {failed} failed, {passed:.0f} s", flush=True)
    return process.wait() == 0 and not failed
