"""What every run of a scene is held to, whatever its test looks at; and the page of a made run, open in a browser."""

from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from tests.support.report_pages import DOUBTS, with_forces, write
from tests.support.summary_keys import keys_without_unit
from weavesim.output import files


@pytest.fixture(autouse=True)
def units_in_every_summary(monkeypatch) -> Iterator[None]:
    """Numbers that are written have their units in their names, also those that only a scene has."""
    found: list[str] = []
    text_of = files.summary_text

    def checked(summary: Mapping[str, Any]) -> str:
        found.extend(keys_without_unit(summary))
        return text_of(summary)

    monkeypatch.setattr(files, "summary_text", checked)
    yield
    assert not found


@pytest.fixture(scope="module")
def limits(tmp_path_factory):
    """Limits that the made part does not keep."""
    path = tmp_path_factory.mktemp("limits") / "limits.toml"
    path.write_text("locking_angle = 20.0\n")
    return path


@pytest.fixture(scope="module")
def finished(tmp_path_factory, coarse_run, limits):
    """Page of a run with a doubt, and its folder."""
    path = tmp_path_factory.mktemp("page")
    summary = {"doubts": DOUBTS, "verdict": "doubtful"}
    return write(path, with_forces(coarse_run), summary, options={"limits": str(limits)}), path


@pytest.fixture(scope="module")
def page(browser, finished):
    """That page, open, at rest; tests leave it as they like."""
    with browser.open(finished[0]) as opened:
        opened.page.evaluate("weavesim.ready")
        yield opened
