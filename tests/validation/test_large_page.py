"""The page of 20,000 elements: every field in every frame, a size to be mailed, quick to go through."""

import json
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.support.made_run import dome_positions, made_frame, made_info
from tests.support.report_pages import choose_field, settle, slide, write
from weavesim.output.run_page.packing import COARSE_CODE
from weavesim.output.run_page.recorder import LEFT_OUT, MAIN_FIELDS, FrameRecorder
from weavesim.run.fields import FIELDS
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

FRAME_COUNT, FIELD_COUNT = 81, 19
# Of the page [bytes]; of a change of the frame [s], drawn by the processor, as in a browser without a graphics card.
LARGEST_SIZE, LONGEST_CHANGE = 22e6, 1.5


def frames_of(blank, names):
    """Every frame with these fields, which change everywhere and have as many digits as those of a run."""
    noise = 0.08 * np.random.default_rng(1).normal(size=blank.element_count)
    last = made_frame(blank, FRAME_COUNT - 1, 1.0, tool_count=0)
    for k in range(FRAME_COUNT):
        fields = {name: k + np.roll(noise, 7 * k * (place + 1)) for place, name in enumerate(names)}
        position = dome_positions(blank, k / (FRAME_COUNT - 1))
        sheet = replace(last.sheet, position=position, fields=fields)
        yield replace(last, index=k, time=1e-3 * k, stroke=1e-3 * k, sheets=(sheet,))


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """Its page, and the first and the twentieth frame."""
    blank = Blank.rectangle((0.0, 0.0), (0.235, 0.135), 0.00125)
    assert blank.element_count > 20_000
    names = [
        "shear_angle",
        "thickness",
        *(field.name for field in FIELDS if field.name not in (*MAIN_FIELDS, *LEFT_OUT)),
    ]
    names = names[:FIELD_COUNT]
    # without tools there is no judgement, which would take as long as the page
    info = made_info(blank, Symmetry(("x", "y")), frame_count=FRAME_COUNT - 1, tools=())
    info = replace(info, sheets=(replace(info.sheet, tools=()),))
    kept = {}

    def keeping():
        for frame in frames_of(blank, names):
            if frame.index in (20, 21):
                kept[frame.index] = frame
            yield frame

    return write(tmp_path_factory.mktemp("large"), (info, keeping()), writers=["report"]), kept, names


def test_it_has_every_frame_of_every_field_and_is_small(large):
    path, _, names = large
    assert path.stat().st_size < LARGEST_SIZE
    data = json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(encoding="utf-8"), re.DOTALL)[1])
    fields = {field["name"]: field for field in data["scene"]["sheets"][0]["fields"]}
    assert len(fields) == FIELD_COUNT and data["scene"]["frames"]["index"] == list(range(FRAME_COUNT))
    assert all(field["at"] is None for field in fields.values())
    assert {name for name, field in fields.items() if field["steps"] is None} == set(MAIN_FIELDS)


def test_it_is_quick_and_tells_how_it_is_rounded(browser, large):
    path, kept, names = large
    with browser.open(path) as opened:
        page = opened.page
        page.evaluate("weavesim.ready")
        assert opened.errors == []
        slide(opened, 21)
        shown = page.evaluate("Array.from(weavesim.page.sheets[0].nodes.slice(-3000))")
        assert np.abs(1e-3 * np.reshape(shown, (-1, 3)) - kept[21].sheet.position[-1000:]).max() < 1e-5
        seconds = page.evaluate(
            """async () => {
                const start = performance.now();
                for (let k = 0; k < 6; k += 1) {
                    await weavesim.page.setFrame(10 * k + 3);
                    weavesim.page.view.drawNow();
                }
                return (performance.now() - start) / 6000;
            }"""
        )
        assert seconds < LONGEST_CHANGE
        slide(opened, 21)
        choose_field(opened, names[-1])
        assert f"rounded to {COARSE_CODE} steps of its range" in page.locator("#controls").inner_text()
        values = kept[21].sheet.fields[names[-1]][:1000]
        shown = np.array(page.evaluate("Array.from(weavesim.page.shown[0].slice(0, 1000))"))
        # in the unit of readers, a power of ten
        factor = 10.0 ** np.round(np.log10(shown.mean() / values.mean()))
        assert np.abs(shown / factor - values).max() < 0.51 * (FRAME_COUNT + 1.0) / COARSE_CODE


def test_the_slider_stops_where_a_field_is(browser, coarse_run, tmp_path, monkeypatch):
    """Beyond what memory holds, fields are left out of frames, and no value of another frame is shown."""
    info, frames = coarse_run
    others = [name for name in frames[0].sheet.fields if name not in (*MAIN_FIELDS, *LEFT_OUT)]
    bound = 4 * len(others) * info.sheet.blank.element_count * (len(frames) // 2)
    monkeypatch.setattr("weavesim.output.writers.report.FrameRecorder", partial(FrameRecorder, other_limit=bound))
    with browser.open(write(tmp_path, coarse_run, writers=["report"])) as opened:
        page = opened.page
        page.evaluate("weavesim.ready")
        stops = page.evaluate("weavesim.page.fields.find((field) => field.name === 'warp_stretch').at")
        assert 2 < len(stops) < len(frames) and stops[1] > 1
        slide(opened, stops[1] - 1 if stops[1] > 2 else stops[1] + 1)
        page.locator("#field").select_option("warp_stretch")
        page.wait_for_function(f"{stops}.includes(weavesim.page.frame)")
        settle(opened)
        assert "slider stops" in page.locator("#controls").inner_text()
        slide(opened, stops[1])
        page.locator("#frame").press("ArrowRight")
        page.wait_for_function(f"weavesim.page.frame === {stops[2]}")
        page.locator("#frame").press("ArrowLeft")
        page.wait_for_function(f"weavesim.page.frame === {stops[1]}")
        assert page.locator("#frame").input_value() == str(stops[1])
