"""The page of a made run, open in a browser."""

import pytest

from tests.support.report_pages import DOUBTS, with_forces, write


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
