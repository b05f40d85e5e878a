"""The report's page as its readers open it: in a browser, without a network, wide and narrow."""

import json
import threading
from dataclasses import replace
from itertools import islice

import h5py
import numpy as np
import pytest
from filelock import FileLock

from tests.support.report_pages import DOUBTS, choose_field, coloured, nodes, pixels, slide, write
from weavesim.app.results.live import LiveServer
from weavesim.output.claim.lock import LOCK_NAME
from weavesim.output.history import History
from weavesim.output.run_page.content import page_so_far
from weavesim.output.run_page.progress import ProgressRecord
from weavesim.output.run_page.recorder import FrameRecorder
from weavesim.output.run_page.writing import write_page
from weavesim.output.writers import pictures
from weavesim.run.frame import Outcome


@pytest.mark.parametrize("width", [1280, 390])
def test_it_opens_without_an_error_or_a_request(browser, finished, width):
    with browser.open(finished[0], width=width) as opened:
        opened.page.evaluate("weavesim.ready")
        assert opened.errors == [] and opened.requests == []
        image = pixels(opened)
        assert coloured(image) > 0.1 * image.shape[0] * image.shape[1]
        # nothing is wider than the window
        assert opened.page.evaluate("document.documentElement.scrollWidth") <= width
        charts = opened.page.locator(".chart canvas").count()
        assert charts >= 9


def test_the_slider_moves_the_nodes_to_those_of_the_frame(page, coarse_run, finished):
    _, frames = coarse_run
    with h5py.File(finished[1] / "results.h5") as file:
        last = file["sheets/0/nodes/position"][()]
    slide(page, len(frames) - 1)
    assert np.abs(nodes(page) - last).max() < 1e-5
    for frame in (0, 5):
        slide(page, frame)
        assert np.abs(nodes(page) - frames[frame].position).max() < 1e-5
        drawn = np.array(page.page.evaluate("Array.from(weavesim.page.sheets[0].geometry.attributes.position.array)"))
        quads = coarse_run[0].sheet.blank.quads
        assert np.abs(1e-3 * drawn.reshape(-1, 4, 3) - frames[frame].position[quads]).max() < 1e-5
    assert f"stroke {1e3 * frames[5].stroke:.2f}".rstrip("0") in page.page.locator("#frame-text").inner_text()
    # tools go with it
    punch = page.page.evaluate("weavesim.page.view.tools[0].mesh.position.toArray()")
    assert punch == pytest.approx([0.0, 0.0, -1e3 * frames[5].tool_displacement[0]], abs=1e-6)


def test_the_menu_recolours(page, coarse_run):
    slide(page, len(coarse_run[1]) - 1)
    images = {}
    for field in ("shear_angle", "thickness", "warp_stretch"):
        choose_field(page, field)
        images[field] = pixels(page)
        assert field.replace("_", " ") in page.page.locator("#legend").inner_text()
    assert all(coloured(image) > 10_000 for image in images.values())
    assert np.abs(images["shear_angle"] - images["warp_stretch"]).max() > 100
    # the middle of the colours of the table is the colour of the element
    values = coarse_run[1][-1].fields["warp_stretch"]
    shown = page.page.evaluate("Array.from(weavesim.page.shown[0])")
    assert shown == pytest.approx(values.tolist(), abs=1e-6)
    choose_field(page, "shear_angle")


def test_a_click_reads_the_value_of_the_file(page, coarse_run, finished):
    slide(page, len(coarse_run[1]) - 1)
    page.page.evaluate("weavesim.page.view.look('top')")
    element = int(np.argmax(np.abs(coarse_run[1][-1].fields["shear_angle"])))
    # where the centre of the element is on the screen
    place = page.page.evaluate(
        """(element) => {
            const { view, sheets } = weavesim.page;
            view.drawNow();
            const point = new THREE.Vector3(...sheets[0].centre(element)).project(view.camera);
            const area = view.canvas.getBoundingClientRect();
            return [area.left + (0.5 + 0.5 * point.x) * area.width, area.top + (0.5 - 0.5 * point.y) * area.height];
        }""",
        element,
    )
    page.page.mouse.click(*place)
    page.page.wait_for_function("(element) => weavesim.page.probe.last?.element === element", arg=element)
    read = page.page.evaluate("weavesim.page.probe.last")
    with h5py.File(finished[1] / "results.h5") as file:
        values = {name: item[element] for name, item in file["sheets/0/elements"].items()}
        flat = file["sheets/0/reference/material_coordinates"][()][coarse_run[0].sheet.blank.quads[element]]
    assert read["values"]["shear_angle"] == pytest.approx(values["shear_angle_deg"], abs=2e-3)
    assert read["values"]["thickness"] == pytest.approx(1e3 * values["thickness"], abs=1e-4)
    stretch = min(values["warp_stretch"], values["weft_stretch"])
    assert read["values"]["yarn_compression"] == pytest.approx(100.0 * max(1.0 - stretch, 0.0), abs=1e-3)
    lower, upper = 1e3 * flat.min(axis=0), 1e3 * flat.max(axis=0)
    assert np.all(read["flat"] >= lower) and np.all(read["flat"] <= upper)
    said = page.page.locator("#probe").inner_text()
    assert f"element {element}" in said and f"{abs(values['shear_angle_deg']):.1f}" in said
    page.page.get_by_role("button", name="Clear").click()


def test_a_mirrored_copy_tells_its_own_material_point(page, coarse_run):
    slide(page, 0)
    page.page.evaluate("weavesim.page.view.look('top')")
    area = page.page.locator("#picture").bounding_box()
    # the quarter is at the upper right; this is at the lower left
    page.page.mouse.click(area["x"] + 0.4 * area["width"], area["y"] + 0.6 * area["height"])
    page.page.wait_for_function("document.querySelector('#probe').innerText.includes('(mirrored)')")
    flat = page.page.evaluate("weavesim.page.probe.last.flat")
    assert flat[0] < 0.0 and flat[1] < 0.0
    page.page.get_by_role("button", name="Clear").click()


def test_a_region_of_the_verdict_is_one_click_away(page, finished, limits):
    assert page.page.locator("#verdict").inner_text().lower().startswith("verdict")
    button = page.page.locator("[data-region='0']")
    assert "locking" in button.inner_text()
    choose_field(page, "thickness")
    slide(page, 3)
    page.page.evaluate("weavesim.page.probe.last = undefined")
    button.click()
    page.page.wait_for_function("weavesim.page.probe.last?.element === weavesim.page.region?.worst")
    assert page.page.evaluate("weavesim.page.view.pin.visible && weavesim.page.view.regionLines.visible")
    assert page.page.locator("#field").input_value() == "shear_angle"
    read = page.page.evaluate("weavesim.page.probe.last")
    assert read["values"]["shear_angle"] == pytest.approx(
        page.page.evaluate("weavesim.page.extremes().most.value"), abs=1e-4
    )
    # a doubt with a place too
    page.page.locator("[data-element]").first.click()
    page.page.wait_for_function("Math.abs(weavesim.page.probe.last.flat[0] - 100) < 10")
    page.page.evaluate("weavesim.page.region = null; weavesim.page.probe.choose(null)")


def test_a_section_is_that_of_the_sheet(page, coarse_run):
    frames = coarse_run[1]
    slide(page, len(frames) - 1)
    page.page.locator("#cut").select_option("y")
    page.page.locator("#section svg path").first.wait_for(state="attached")
    cut = page.page.evaluate("weavesim.page.section.pieces[0].segments.flat()")
    cut = 1e-3 * np.array(cut)
    position = frames[-1].position
    on_line = position[np.abs(position[:, 1]) < 1e-9]
    order = np.argsort(on_line[:, 0])
    inside = cut[np.abs(cut[:, 0]) < on_line[:, 0].max()]
    height = np.interp(np.abs(inside[:, 0]), on_line[order, 0], on_line[order, 2])
    assert len(inside) > 20 and np.abs(inside[:, 2] - height).max() < 2e-5
    assert np.abs(cut[:, 1]).max() < 2e-5 and cut[:, 0].min() < -0.1
    # half of the picture is gone
    page.page.evaluate("weavesim.page.view.look('top')")
    half = coloured(pixels(page))
    page.page.locator("#cut").select_option("none")
    assert half < 0.7 * coloured(pixels(page))


def test_tools_and_mirrored_parts_can_be_switched(page, coarse_run):
    slide(page, len(coarse_run[1]) - 1)
    page.page.evaluate("weavesim.page.view.look('top')")
    whole = coloured(pixels(page))
    page.page.get_by_label("whole part, mirrored").uncheck()
    assert page.page.evaluate("weavesim.page.sheets[0].copies.filter((copy) => copy.visible).length") == 1
    page.page.get_by_label("whole part, mirrored").check()
    page.page.evaluate("weavesim.page.view.look('top')")
    assert coloured(pixels(page)) == pytest.approx(whole, rel=0.02)
    before = pixels(page)
    page.page.get_by_label("punch").check()
    assert np.abs(pixels(page) - before).max() > 20
    page.page.get_by_label("punch").uncheck()
    page.page.get_by_label("yarn directions").check()
    assert np.abs(pixels(page) - before).max() > 60
    page.page.get_by_label("yarn directions").uncheck()
    assert page.errors == []


def test_plies_can_be_taken_apart(browser, tmp_path, stack):
    with browser.open(write(tmp_path, stack)) as opened:
        opened.page.evaluate("weavesim.ready")
        assert opened.errors == [] and opened.page.evaluate("weavesim.page.sheets.length") == 2
        whole = coloured(pixels(opened))
        for sheet in stack[0].sheets:
            opened.page.get_by_label(sheet.name, exact=True).uncheck()
        assert coloured(pixels(opened)) < 0.02 * whole
        opened.page.get_by_label(stack[0].sheets[0].name, exact=True).check()
        assert coloured(pixels(opened)) > 0.2 * whole
        opened.page.get_by_label("sheets apart").fill("1")
        heights = opened.page.evaluate("weavesim.page.sheets.map((sheet) => sheet.group.position.z)")
        assert np.argsort(heights).tolist() == np.argsort(stack[0].levels).tolist() and max(heights) > 1.0


def test_a_run_that_was_stopped_at_once_has_a_page(browser, tmp_path, coarse_run):
    info, frames = coarse_run
    with browser.open(write(tmp_path, (info, frames[:1]), outcome=Outcome.INTERRUPTED)) as opened:
        opened.page.evaluate("weavesim.ready")
        assert opened.errors == [] and "did not reach its end" in opened.page.locator("#verdict").inner_text()


def test_without_webgl_there_are_pictures(browser, tmp_path, coarse_run, monkeypatch):
    drawn = pictures.wanted_pictures
    monkeypatch.setattr(pictures, "wanted_pictures", lambda results: islice(drawn(results), 1))
    path = write(tmp_path, coarse_run, writers=["pictures", "report"])
    text = path.read_text(encoding="utf-8")
    path.write_text(
        text.replace("<head>", "<head><script>HTMLCanvasElement.prototype.getContext = () => null;</script>", 1),
        encoding="utf-8",
    )
    with browser.open(path) as opened:
        opened.page.wait_for_selector("body.no-view")
        assert opened.page.locator(".fallback img").first.is_visible()


def test_names_of_a_run_are_texts(browser, tmp_path, coarse_run):
    info, frames = coarse_run
    name = "<img src=x onerror=alert(1)>"
    sheet = replace(info.sheet, fabric=info.sheet.fabric.model_copy(update={"name": name}), name=name)
    named = [replace(frame, sheets=(replace(frame.sheet, name=name),)) for frame in frames[:3]]
    doubts = [{**DOUBTS[0], "text": name, "advice": name}]
    page = write(tmp_path, (replace(info, sheets=(sheet,)), named), {"doubts": doubts, "verdict": "doubtful"})
    with browser.open(page) as opened:
        opened.page.evaluate("weavesim.ready")
        opened.page.evaluate("weavesim.page.probe.choose({ sheet: weavesim.page.sheets[0], element: 3 })")
        opened.page.locator("#cut").select_option("y")
        assert opened.page.locator("img[src=x]").count() == 0 and opened.errors == [] and opened.requests == []
        assert json.loads(opened.page.locator("#data").text_content())["scene"]["sheets"][0]["name"] == name


def test_a_run_in_progress_is_kept_up_with(browser, tmp_path, coarse_run):
    """The page grows while it is open, in the view that the reader has chosen."""
    info, frames = coarse_run
    recorder, history, record = FrameRecorder(), History(), ProgressRecord(tmp_path, info)
    for observer in (recorder, history, record):
        observer.start(*([] if observer is record else [info]))
    server = LiveServer(tmp_path)
    thread = threading.Thread(target=server.serve, daemon=True)
    thread.start()

    def go_on(some):
        for frame in some:
            recorder.frame(frame)
            history.frame(frame)
            record.frame(frame)
        write_page(tmp_path / "report.html", page_so_far(info, history, recorder, tmp_path))

    try:
        with browser.open(server.address) as opened, FileLock(tmp_path / LOCK_NAME):
            assert "waits for the run" in opened.page.content()
            go_on(frames[:3])
            opened.page.wait_for_function("typeof weavesim !== 'undefined' && weavesim.page !== undefined")
            opened.page.evaluate("weavesim.ready")
            assert opened.page.evaluate("weavesim.page.frameCount") == 3
            opened.page.locator("#field").select_option("thickness")
            opened.page.evaluate("weavesim.page.view.look('side')")
            opened.page.wait_for_function("document.getElementById('live').innerText.includes('running')")
            go_on(frames[3:8])
            # it is opened anew, at the end of which it gets the view of the old one
            opened.page.wait_for_function(
                "weavesim.page.frameCount === 8 && weavesim.page.frame === 7"
                " && weavesim.page.view.camera.position.x > 100"
            )
            assert np.abs(nodes(opened) - frames[7].position).max() < 1e-5
            assert opened.page.locator("#field").input_value() == "thickness"
            record.finish(Outcome.FINISHED)
            opened.page.wait_for_function("document.getElementById('live').innerText.includes('finished')")
            assert "punch" in opened.page.locator("#live").inner_text() and opened.errors == []
    finally:
        server.close()
        thread.join()
