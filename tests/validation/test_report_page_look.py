"""What the report's page looks like: legend, colours, lines on them, panel, numbers, and paper."""

import numpy as np
import pytest

from tests.support.report_pages import choose_field, coloured, pixels, slide
from weavesim.sheet.topology import area_percentile, flat_areas


def sheets_of(paper):
    """The sheets of a PDF as pictures, (height, width, 3) each, at 72 pixels per inch."""
    pdfium = pytest.importorskip("pypdfium2", reason="pypdfium2 draws the PDF: pip install pypdfium2")
    document = pdfium.PdfDocument(paper)
    try:
        return [np.asarray(sheet.render().to_pil().convert("RGB")).astype(int) for sheet in document]
    finally:
        document.close()


def first_sheet(opened):
    """The first sheet of paper of a page."""
    return sheets_of(opened.page.pdf(prefer_css_page_size=True, page_ranges="1"))[0]


def test_it_prints_with_the_part_on_it(browser, finished):
    """At the same size from whatever window, and as it is now: without the part there is none."""
    with browser.open(finished[0]) as opened:
        opened.page.evaluate("weavesim.ready")
        sheets = sheets_of(opened.page.pdf(prefer_css_page_size=True))
        assert 2 <= len(sheets) < 25
        # a part of the first paper, not only lines of charts
        least = 0.06 * sheets[0].shape[0] * sheets[0].shape[1]
        assert coloured(sheets[0]) > least
        opened.page.emulate_media(media="print")
        assert not opened.page.locator("#controls").is_visible() and opened.page.locator("#picture").is_visible()
        assert coloured(first_sheet(opened)) == pytest.approx(coloured(sheets[0]), rel=0.02)
        opened.page.evaluate("weavesim.page.sheets[0].group.visible = false; weavesim.page.view.drawNow()")
        assert coloured(first_sheet(opened)) < 0.25 * coloured(sheets[0])


def test_a_picture_of_another_size_is_drawn_at_once(page):
    """It is empty else until the screen is refreshed, which paper does not wait for."""
    share = page.page.evaluate(
        """() => {
            const { view } = weavesim.page;
            view.canvas.parentElement.style.height = "300px";
            view.resize();
            const copy = document.createElement("canvas");
            [copy.width, copy.height] = [view.canvas.width, view.canvas.height];
            const pen = copy.getContext("2d");
            pen.drawImage(view.canvas, 0, 0);
            const { data } = pen.getImageData(0, 0, copy.width, copy.height);
            let count = 0;
            for (let i = 0; i < data.length; i += 4) {
                const [red, green, blue, alpha] = data.slice(i, i + 4);
                if (alpha > 0 && Math.max(red, green, blue) - Math.min(red, green, blue) > 40) count += 1;
            }
            view.canvas.parentElement.style.height = "";
            view.resize();
            return (4 * count) / data.length;
        }"""
    )
    assert share > 0.05


@pytest.mark.parametrize(("width", "share"), [(1280, 0.1), (390, 0.0)])
def test_the_legend_hides_no_part(browser, finished, width, share):
    """It covers at most this share of the picture, and paints nothing behind its letters."""
    with browser.open(finished[0], width=width) as opened:
        opened.page.evaluate("weavesim.ready")
        stage, legend = (opened.page.locator(name).bounding_box() for name in (".stage", "#legend"))
        across, up = (
            max(min(stage[at] + stage[size], legend[at] + legend[size]) - max(stage[at], legend[at]), 0.0)
            for at, size in (("x", "width"), ("y", "height"))
        )
        assert across * up <= share * stage["width"] * stage["height"]
        background = opened.page.evaluate("getComputedStyle(document.getElementById('legend')).backgroundColor")
        assert background in ("rgba(0, 0, 0, 0)", "transparent")
        bar = opened.page.locator("#legend .bar").bounding_box()
        assert max(bar["width"], bar["height"]) > 100 and min(bar["width"], bar["height"]) < 20


def test_colours_span_the_last_frame_by_its_area(page, coarse_run):
    frames, blank = coarse_run[1], coarse_run[0].sheet.blank
    slide(page, 0)
    for field, factor in (("thickness", 1e3), ("warp_stretch", 1.0)):
        choose_field(page, field)
        drawn = page.page.evaluate("[weavesim.page.colours.low, weavesim.page.colours.high]")
        values = factor * frames[-1].fields[field]
        assert drawn == pytest.approx([area_percentile(values, flat_areas(blank), p) for p in (1.0, 99.0)], rel=1e-4)
        assert "last frame" in page.page.locator("#legend").inner_text()
    # of elements of different size a percentile is a share of their area
    areas, values = np.array([1.0, 5.0, 2.0, 1.0]), np.array([3.0, 1.0, 2.0, 4.0])
    found = page.page.evaluate(
        "([values, areas]) => weavesim.percentiles([Float32Array.from(values)], [areas], [0.3, 0.5, 0.9])",
        [values.tolist(), areas.tolist()],
    )
    assert found == pytest.approx([area_percentile(values, areas, p) for p in (30.0, 50.0, 90.0)])
    choose_field(page, "shear_angle")


def test_yarns_and_mesh_read_on_every_colour(page, coarse_run):
    """Bars and lines differ from the dark end of the colours and from the bright one."""
    slide(page, len(coarse_run[1]) - 1)
    page.page.evaluate("weavesim.page.view.look('top')")
    recolour = "(limits) => { weavesim.page.manual = limits; return weavesim.page.recolour(); }"
    for limits in ([100.0, 200.0], [-200.0, -100.0]):  # all dark, all bright
        page.page.evaluate(recolour, limits)
        plain = pixels(page).sum(axis=2)
        for label, count in (("yarn directions", 5000), ("mesh", 2000)):
            page.page.get_by_label(label).check()
            assert (np.abs(pixels(page).sum(axis=2) - plain) > 100).sum() > count, (label, limits)
            page.page.get_by_label(label).uncheck()
    page.page.evaluate("weavesim.page.manual = null; weavesim.page.recolour()")


def test_tools_are_as_opaque_as_their_slider_says(page):
    shown = float(page.page.get_by_label("opacity of the tools").input_value())
    drawn = page.page.evaluate("weavesim.page.view.tools.map((tool) => tool.mesh.material.opacity)")
    assert drawn == pytest.approx([shown] * 3)


def test_the_panel_shows_all_of_itself_or_says_that_there_is_more(page):
    cut = page.page.locator("#cut")
    within = "(node) => node.getBoundingClientRect().bottom <= node.closest('#controls').getBoundingClientRect().bottom"
    assert cut.evaluate(within)
    # entries of the menu fit
    text = page.page.evaluate(
        """() => {
            const menu = document.getElementById("field");
            const pen = document.createElement("canvas").getContext("2d");
            pen.font = getComputedStyle(menu).font;
            const widths = [...menu.options].map((one) => pen.measureText(one.text).width);
            return [Math.max(...widths), menu.clientWidth - 28];
        }"""
    )
    assert text[0] < text[1]
    page.page.evaluate("document.getElementById('controls').style.maxHeight = '200px'")
    page.page.wait_for_function("document.getElementById('controls').classList.contains('more')")
    page.page.evaluate("const panel = document.getElementById('controls'); panel.scrollTop = panel.scrollHeight")
    page.page.wait_for_function("!document.getElementById('controls').classList.contains('more')")
    page.page.evaluate("document.getElementById('controls').style.maxHeight = ''")


def test_values_are_written_as_readers_expect(page):
    say = page.page.evaluate
    assert say("weavesim.clock(59.5)") == "1:00" and say("weavesim.clock(3599.6)") == "1:00:00"
    assert say("[weavesim.clock(0.2), weavesim.clock(59.4), weavesim.clock(65)]") == ["0:00", "0:59", "1:05"]
    assert say("weavesim.withUnit(NaN, 'mm')") == "–" and say("weavesim.withUnit(2, 'mm')") == "2\u202fmm"
    assert say("weavesim.text(1e-5)") == "1·10⁻⁵"
    low, high = "1e-5", "100"
    assert say(f"weavesim.DECADES.splits(null, 1, {low}, {high})") == pytest.approx([1e-5, 1e-3, 0.1, 10.0])
    assert say(f"weavesim.DECADES.values(null, weavesim.DECADES.splits(null, 1, {low}, {high}))")[0] == "10⁻⁵"
    assert say("weavesim.DECADES.values(null, [0.01, 0.1, 1])") == ["0.01", "0.1", "1"]


def test_a_field_that_is_the_same_everywhere_has_no_largest_element(page):
    page.page.evaluate(
        """() => {
            weavesim.page.shown = [new Float32Array(weavesim.page.sheets[0].elementCount)];
            weavesim.page.controls.write();
        }"""
    )
    said = page.page.locator("#extremes").inner_text()
    assert "in every element" in said and "largest" not in said
    page.page.evaluate("weavesim.page.recolour()")
