"""Work that a copy of this process shares: each piece once, and nothing lost with the copy."""

import fcntl
import os
import resource
import time
from contextlib import ExitStack

import pytest

from tests.support.processes import wait_for
from weavesim.output import sharing
from weavesim.output.sharing import Sharing, can_share, share

THIS = os.getpid()

pytestmark = pytest.mark.skipif(not can_share(), reason="this system has one core, or does not copy processes")


def written(folder, number, wait=0.02):
    """Write the number of the process to a file of the piece."""
    time.sleep(wait)
    (folder / f"{number}").write_text(str(os.getpid()))


def pieces(folder, count, here=None, there=None):
    """What ``share`` returns, and the process that did each piece."""
    found = share(
        count, here or (lambda number: written(folder, number)), there or (lambda number: written(folder, number))
    )
    return found, [int((folder / f"{number}").read_text()) for number in range(count)]


def after_the_copy(folder, work):
    """Work that this process begins when the copy has done a piece: both have their share, however busy the machine."""

    def here(number):
        wait_for(lambda: any(folder.iterdir()))
        work(number)

    return here


def test_every_piece_is_done_once_by_both(tmp_path):
    found, workers = pieces(tmp_path, 12, after_the_copy(tmp_path, lambda number: written(tmp_path, number)))
    assert len(set(workers)) == 2 and THIS in workers
    assert found == {number for number, worker in enumerate(workers) if worker != THIS}
    (copy,) = set(workers) - {THIS}
    with pytest.raises(ProcessLookupError):
        os.kill(copy, 0)


def test_the_copy_works_while_this_process_does_something_else(tmp_path):
    with Sharing(3, lambda number: written(tmp_path, number)) as begun:
        wait_for(lambda: len(list(tmp_path.iterdir())) == 3)
        assert begun.finish(lambda number: written(tmp_path, number)) == {0, 1, 2}
    assert THIS not in {int(path.read_text()) for path in tmp_path.iterdir()}


def test_what_is_begun_and_not_finished_leaves_no_copy(tmp_path):
    def there(number):
        written(tmp_path, "copy")
        time.sleep(60.0)

    with Sharing(2, there):
        wait_for(lambda: (tmp_path / "copy").exists() and (tmp_path / "copy").read_text())
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "copy").read_text()), 0)


def test_a_silent_copy_is_gone_before_its_piece_is_done_here(tmp_path, monkeypatch):
    monkeypatch.setattr(sharing, "LEAST_PATIENCE", 0.05)
    monkeypatch.setattr(sharing, "PATIENCE", 0.0)

    def there(number):
        written(tmp_path, "copy")
        time.sleep(60.0)

    def here(number):
        if number == 0:
            with pytest.raises(ProcessLookupError):
                os.kill(int((tmp_path / "copy").read_text()), 0)
        done.append(number)

    done = []
    with Sharing(2, there) as begun:
        wait_for(lambda: (tmp_path / "copy").exists() and (tmp_path / "copy").read_text())
        assert begun.finish(here) == set()
    assert done == [1, 0]


def test_what_fails_in_the_copy_is_done_here(tmp_path):
    def fails(number):
        raise ValueError("in the copy")

    found, workers = pieces(tmp_path, 6, there=fails)
    assert found == set() and set(workers) == {THIS}


def test_what_is_lost_with_the_copy_is_done_here(tmp_path):
    found, workers = pieces(tmp_path, 6, there=lambda number: os._exit(1))
    assert found == set() and set(workers) == {THIS}


def test_a_copy_that_hangs_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(sharing, "LEAST_PATIENCE", 0.2)
    found, workers = pieces(tmp_path, 4, there=lambda number: time.sleep(60.0))
    assert found == set() and set(workers) == {THIS}


def test_an_error_here_leaves_no_copy(tmp_path):
    def fails(number):
        while not (tmp_path / "copy").exists():
            time.sleep(0.01)
        raise OSError("here")

    def there(number):
        (tmp_path / "partial").write_text(str(os.getpid()))
        (tmp_path / "partial").rename(tmp_path / "copy")
        time.sleep(60.0)

    with pytest.raises(OSError, match="here"):
        share(4, fails, there)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "copy").read_text()), 0)


def test_the_copy_holds_no_file_and_no_lock(tmp_path):
    copied = tmp_path / "copied"
    copied.mkdir()
    with open(tmp_path / "lock", "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)

        def there(number):
            time.sleep(0.02)
            held = os.readlink(f"/proc/self/fd/{file.fileno()}")
            # a number that objects of this process hold is not given to another file
            with open(copied / f"{number}", "w") as own:
                own.write(held if own.fileno() != file.fileno() else "taken")

        found = share(8, after_the_copy(copied, lambda number: time.sleep(0.05)), there)
    assert found and {(copied / f"{number}").read_text() for number in found} == {os.devnull}


def test_without_room_for_a_copy_all_is_done_here(tmp_path, monkeypatch):
    def no_room():
        raise BlockingIOError("Resource temporarily unavailable")

    before = os.listdir("/proc/self/fd")
    monkeypatch.setattr(os, "fork", no_room)
    found, workers = pieces(tmp_path, 3)
    assert found == set() and set(workers) == {THIS}
    assert len(os.listdir("/proc/self/fd")) == len(before)


def test_many_open_files_do_not_matter(tmp_path):
    """More than ``select`` can count."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = 1200
    if hard != resource.RLIM_INFINITY and hard < wanted:
        pytest.skip("this system allows fewer open files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
    try:
        with ExitStack() as stack:
            for _ in range(1100):
                stack.enter_context(open(os.devnull))
            here = after_the_copy(tmp_path, lambda number: written(tmp_path, number))
            found, workers = pieces(tmp_path, 6, here)
        assert found and len(set(workers)) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.mark.parametrize("count", [0, 1])
def test_few_pieces_need_no_copy(tmp_path, count):
    found, workers = pieces(tmp_path, count)
    assert found == set() and set(workers) <= {THIS}


def test_one_core_does_all(tmp_path, monkeypatch):
    monkeypatch.setattr(sharing, "can_share", lambda: False)
    found, workers = pieces(tmp_path, 3)
    assert found == set() and set(workers) == {THIS}
