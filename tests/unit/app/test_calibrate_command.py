"""``weavesim calibrate``: options as typed, exit codes, files."""

import json
import subprocess
import sys

import pytest

from tests.support.bad_tests import frame
from tests.support.paths import ROOT
from weavesim import load_fabric
from weavesim.device import kernel_cache_base


def run(*arguments, folder):
    command = [sys.executable, "-m", "weavesim", "calibrate", *map(str, arguments)]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(folder)}
    environment["WARP_CACHE_PATH"] = str(kernel_cache_base())  # else its home has a cache of its own
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("command")
    (folder / "p.csv").write_text(frame())
    options = ("--picture-frame", "p.csv", "--frame-side", 0.25, "--bending-length", 0.044, "--bending-length", 0.046)
    return folder, run("glass-polypropylene", *options, "--out", "fitted", folder=folder)


def test_one_command_gives_a_fabric_and_a_report(done):
    folder, process = done
    assert process.returncode == 0, process.stderr
    fabric = load_fabric(folder / "fitted" / "fabric.toml")
    assert fabric.shear.trusted_angle == pytest.approx(0.698, abs=0.001)
    assert (folder / "fitted" / "report.html").exists()
    record = json.loads((folder / "fitted" / "calibration.json").read_text())
    assert record["options"]["frame_side"] == 0.25 and record["options"]["bending_length"] == [0.044, 0.046]
    for text in ("moment_at_40_deg", "bending_stiffness", "Fabric: fitted/fabric.toml"):
        assert text in process.stdout


def test_mistakes_name_options_as_typed(done):
    folder, _ = done
    for options, message in (
        ((), "give at least one of --biaxial, --picture-frame|nothing to calibrate"),
        (("--picture-frame", "p.csv"), "give --frame-side"),
        (("--picture-frame", "p.csv", "--frame-side", "0.25", "--out", "fitted"), "or --overwrite"),
    ):
        process = run("glass-polypropylene", *options, folder=folder)
        assert process.returncode == 2 and any(part in process.stderr for part in message.split("|")), process.stderr
