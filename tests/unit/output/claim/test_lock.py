"""One run at a time in a folder, in one process and in several."""

import json
import subprocess
import sys

import pytest

from tests.support.processes import environment
from weavesim.errors import InputError
from weavesim.output import ResultFolder
from weavesim.output.claim.lock import FolderLock
from weavesim.run.checkpoint.checkpoints import job_path

HOLD = """
import sys, time
from pathlib import Path
from weavesim.output.claim.lock import FolderLock
lock = FolderLock(Path(sys.argv[1]))
lock.acquire()
print("held", flush=True)
time.sleep(60)
"""


def test_a_second_lock_is_refused_until_the_first_is_released(tmp_path):
    first, second = FolderLock(tmp_path), FolderLock(tmp_path)
    first.acquire()
    first.acquire()
    with pytest.raises(InputError, match="another run is writing to it; wait until that has ended, or give another"):
        second.acquire()
    first.release()
    first.release()
    second.acquire()
    second.release()


def test_the_holder_is_named(tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"run_id": "20260101T000000Z-01234567", "process": 7, "host": "h"}))
    lock = FolderLock(tmp_path)
    lock.acquire()
    with pytest.raises(InputError, match=r"run 20260101T000000Z-01234567 \(process 7 on h\) is writing to it"):
        FolderLock(tmp_path).acquire()
    lock.release()


@pytest.mark.parametrize("record", ["", "{", "[]", '{"run_id": 1}', "\0"])
def test_a_damaged_record_does_not_matter(tmp_path, record):
    (tmp_path / "run.json").write_text(record)
    lock = FolderLock(tmp_path)
    lock.acquire()
    with pytest.raises(InputError, match="another run is writing"):
        FolderLock(tmp_path).acquire()
    lock.release()


def test_a_killed_process_leaves_no_lock(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], env=environment(), stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "held\n"
    with pytest.raises(InputError, match="is writing to it"):
        FolderLock(tmp_path).acquire()
    process.kill()
    process.communicate()
    lock = FolderLock(tmp_path)
    lock.acquire()
    lock.release()


def test_a_run_in_progress_is_told_before_what_it_has_left_so_far(tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"run_id": "20260101T000000Z-01234567", "process": 7, "host": "h"}))
    job_path(tmp_path).parent.mkdir()
    job_path(tmp_path).write_bytes(b"")
    lock = FolderLock(tmp_path)
    lock.acquire()
    with pytest.raises(InputError, match=r"\(process 7 on h\) is writing to it; wait until that has ended"):
        ResultFolder(tmp_path)
    lock.release()
    with pytest.raises(InputError, match="it has a run that was not finished; go on with it"):
        ResultFolder(tmp_path)


def test_a_folder_that_is_claimed_twice(tmp_path):
    first, second = ResultFolder(tmp_path), ResultFolder(tmp_path)
    first.claim()
    with pytest.raises(InputError, match="is writing to it"):
        second.claim()
    first.release()
    second.claim()
    second.release()
