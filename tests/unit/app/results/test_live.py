"""A run in progress: how far it is, and what a browser on this machine gets of it."""

import json
import threading
import urllib.error
import urllib.request

import pytest
from filelock import FileLock

from tests.support.summary_keys import keys_without_unit
from weavesim.app.results.live import LiveServer, show_live, state_of
from weavesim.errors import InputError
from weavesim.output import ResultFolder
from weavesim.output.claim.lock import LOCK_NAME, is_locked
from weavesim.output.run_page.progress import ProgressRecord
from weavesim.run.frame import Outcome


@pytest.fixture
def served(tmp_path):
    server = LiveServer(tmp_path)
    thread = threading.Thread(target=server.serve, daemon=True)
    thread.start()
    yield server, tmp_path
    server.close()
    thread.join()


def answer(address, **headers):
    with urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=300) as given:
        return given.read().decode()


def test_progress_has_stroke_forces_of_the_whole_part_and_time_left(tmp_path, coarse_run, monkeypatch):
    info, frames = coarse_run
    clock = [100.0]
    monkeypatch.setattr("weavesim.output.run_page.progress.time.monotonic", lambda: clock[0])
    record = ProgressRecord(tmp_path, info)
    record.start()
    for frame in frames[:6]:
        clock[0] += 2.0
        record.frame(frame)
    state = json.loads((tmp_path / "progress.json").read_text())
    assert not keys_without_unit(state)
    assert state["run_id"] == info.run_id and state["state"] == "running" and state["frame"] == 5
    assert state["share"] == pytest.approx(frames[5].time / info.duration)
    assert state["tool_force_n"]["punch"] == pytest.approx(4.0 * abs(frames[5].tool_reaction[0, 2]))
    assert state["stroke_mm"] == pytest.approx(1e3 * frames[5].stroke)
    # ten seconds for five frames of eleven
    assert state["left_s"] == pytest.approx(12.0)
    record.finish(Outcome.INTERRUPTED)
    assert json.loads((tmp_path / "progress.json").read_text())["state"] == "interrupted"


def test_progress_is_not_written_for_every_frame(tmp_path, coarse_run, monkeypatch):
    monkeypatch.setattr("weavesim.output.run_page.progress.time.monotonic", lambda: 100.0)
    info, frames = coarse_run
    record = ProgressRecord(tmp_path, info)
    record.start()
    for frame in frames:
        record.frame(frame)
    assert json.loads((tmp_path / "progress.json").read_text())["share"] == 0.0
    record.finish(Outcome.FINISHED)
    assert json.loads((tmp_path / "progress.json").read_text())["share"] == 1.0


def test_the_server_shows_what_is_there(served, coarse_run):
    server, folder = served
    assert "waits for the run" in answer(server.address)
    assert json.loads(answer(server.address.replace("?live", "progress")))["state"] == "no run has begun yet"
    (folder / "report.html").write_text("<head></head>the page")
    shown = answer(server.address)
    # with its version: one that is written before the browser asks for the first time is another one
    assert shown.endswith("the page") and f'content="{state_of(folder)["page"]}"' in shown


def test_the_server_answers_this_machine_alone(served):
    server, folder = served
    (folder / "secret.txt").write_text("secret")
    assert server.address.startswith("http://127.0.0.1:")
    for path, headers in (("secret.txt", {}), ("../secret.txt", {}), ("", {"Host": "example.org"})):
        with pytest.raises(urllib.error.HTTPError) as refused:
            answer(server.address.replace("?live", path), **headers)
        assert refused.value.code in (403, 404)


def test_a_run_that_was_killed_is_told(tmp_path):
    (tmp_path / "progress.json").write_text('{"state": "running"}')
    with FileLock(tmp_path / LOCK_NAME):
        assert is_locked(tmp_path) and state_of(tmp_path)["state"] == "running"
    assert "weavesim resume" in state_of(tmp_path)["state"]


def test_a_lock_that_cannot_be_looked_at_says_nothing(tmp_path, monkeypatch):
    """As in a folder of another user: the run may be well."""
    (tmp_path / "progress.json").write_text('{"state": "running"}')
    (tmp_path / LOCK_NAME).touch()

    def refuse(*_, **__):
        raise PermissionError

    monkeypatch.setattr(FileLock, "acquire", refuse)
    assert is_locked(tmp_path) is None and state_of(tmp_path)["state"] == "running"


def test_a_port_that_is_taken_is_refused(served):
    with pytest.raises(InputError, match="give another one with --port"):
        LiveServer(served[1], int(served[0].address.rsplit(":", 1)[1].removesuffix("/?live")))


def test_a_run_leaves_its_progress_in_its_folder(tmp_path, coarse_run):
    folder = ResultFolder(tmp_path, writers=["report"])
    folder.start(coarse_run[0])
    assert state_of(tmp_path)["state"] == "running"
    for frame in coarse_run[1]:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    folder.write({})
    assert state_of(tmp_path)["state"] == "finished"
    assert "progress.json" in json.loads((tmp_path / "run.json").read_text())["files"]


def test_it_is_shown_until_ctrl_c(tmp_path, monkeypatch, capsys):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: bool(opened.append(address)))

    def serve(server):
        assert opened == [server.address]
        raise KeyboardInterrupt

    monkeypatch.setattr(LiveServer, "serve", serve)
    show_live(tmp_path, 0, opens=True)
    assert "until Ctrl-C" in capsys.readouterr().out and len(opened) == 1
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="it is no folder"):
        show_live(tmp_path / "file", 0, opens=False)


def test_a_folder_that_is_not_there_yet_is_waited_for(tmp_path, monkeypatch, capsys, coarse_run):
    folder, seen = tmp_path / "later", []

    def serve(server):
        """As long as the run needs to make its folder, and to write its page."""
        thread = threading.Thread(target=server._server.serve_forever, daemon=True)
        thread.start()
        seen.append(answer(server.address))
        write = ResultFolder(folder, writers=["report"])
        write.start(coarse_run[0])
        seen.append(json.loads(answer(server.address.replace("?live", "progress")))["state"])
        for frame in coarse_run[1][:2]:
            write.frame(frame)
        write.finish(Outcome.FINISHED)
        write.write({})
        seen.append(answer(server.address))
        server._server.shutdown()
        thread.join()

    monkeypatch.setattr(LiveServer, "serve", serve)
    show_live(folder, 0, opens=False)
    assert "is not there yet" in capsys.readouterr().out
    assert "waits for the run" in seen[0] and seen[1] == "running" and "Formed part" in seen[2]
