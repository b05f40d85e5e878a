"""``weavesim view`` opens the page of a run, or says where there is one."""

import webbrowser

import pytest

from weavesim.app.results.view import view_command
from weavesim.errors import InputError


def test_view_opens_the_page(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    with pytest.raises(InputError, match="it has no report.html"):
        view_command(tmp_path, live=False, port=0, browser=True)
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "report.html").write_text("page")
    with pytest.raises(InputError, match="there is one in .*case"):
        view_command(tmp_path, live=False, port=0, browser=True)
    view_command(tmp_path / "case", live=False, port=0, browser=True)
    assert opened == [(tmp_path / "case" / "report.html").as_uri()]
    with pytest.raises(InputError, match="it is no folder"):
        view_command(tmp_path / "nowhere", live=True, port=0, browser=False)
    with pytest.raises(InputError, match="without --live"):
        view_command(tmp_path / "case", live=False, port=80, browser=False)
