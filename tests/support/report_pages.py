"""Pages of made runs, and what a reader does with them in a browser."""

import io
from dataclasses import replace

import numpy as np
from PIL import Image

from weavesim.output import ResultFolder
from weavesim.run.frame import Outcome

DOUBTS = [
    {"guard": "test", "level": "warning", "text": "something at a place", "advice": "look there", "sheet": None,
     "place_m": [0.1, 0.05], "time_s": 0.01, "message": "something at a place: look there"},
]  # fmt: skip


def write(path, run, summary=None, outcome=Outcome.FINISHED, writers=("report", "results"), **options):
    """A folder of results of these frames."""
    info, frames = run
    folder = ResultFolder(path, writers=list(writers), **options)
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(outcome)
    folder.write(summary or {})
    assert not folder.warnings
    return path / "report.html"


def with_forces(run):
    """With the forces of the yarns in all frames, which the judgement of a part needs."""
    info, frames = run
    taut = {name: np.full(info.sheet.blank.element_count, 5.0) for name in ("warp_force", "weft_force")}
    return info, [replace(f, sheets=(replace(f.sheet, fields=f.sheet.fields | taut),)) for f in frames]


def nodes(page, sheet=0):
    """Positions of the drawn nodes, (node_count, 3) [m]."""
    return 1e-3 * np.array(page.page.evaluate(f"Array.from(weavesim.page.sheets[{sheet}].nodes)")).reshape(-1, 3)


def slide(page, frame):
    """Move the slider as a reader does, and wait until all of the frame is shown."""
    page.page.locator("#frame").fill(str(frame))
    page.page.wait_for_function(f"weavesim.page.frame === {frame}")
    settle(page)


def choose_field(page, field):
    """Choose it in the menu as a reader does, and wait until it is shown."""
    page.page.locator("#field").select_option(field)
    page.page.wait_for_function(f"weavesim.page.field.name === '{field}'")
    settle(page)


def settle(page):
    """Wait for values that a page unpacks after what the reader has done; they come in the order of the questions."""
    page.page.evaluate("weavesim.page.setFrame(weavesim.page.frame)")


def pixels(page):
    """The picture in three dimensions, (height, width, 3)."""
    page.page.evaluate("weavesim.page.view.drawNow()")
    return np.asarray(Image.open(io.BytesIO(page.picture(selector="#picture"))).convert("RGB")).astype(int)


def coloured(image):
    """How many pixels have a colour."""
    return int((np.ptp(image, axis=2) > 40).sum())
