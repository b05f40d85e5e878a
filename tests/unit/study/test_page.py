"""The page in a browser: all charts, nothing from the network, no complaints."""

import pytest

from tests.support.studies import bowl, conducted, ishigami, made, noisy
from weavesim.errors import InputError, RunError
from weavesim.study.factors import factor_of
from weavesim.study.page.charts import charts, log_axis, response
from weavesim.study.page.page import check_page, write_page
from weavesim.study.record import write_study
from weavesim.study.schema import MeasureTable, NoiseTable, VaryTable
from weavesim.study.subject import FunctionSubject

# How many charts are there to be seen.
DRAWN = "document.querySelectorAll('.js-plotly-plot:has(.main-svg)').length"


@pytest.fixture(scope="module")
def factorial(tmp_path_factory):
    study = made({"x": (0.0, 10.0)}, ["line", "chance"], counts={"x": 8}, noise=NoiseTable(repeats=4), name="A <study>")
    path = tmp_path_factory.mktemp("study") / "t.sqlite"
    return conducted(study, FunctionSubject(noisy, repeats=True), path)


@pytest.fixture(scope="module")
def optimised(tmp_path_factory):
    measures = [MeasureTable(name="depth", goal="least"), MeasureTable(name="across", goal="least")]
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, measures, method="optimise", budget=20)
    return conducted(study, FunctionSubject(bowl), tmp_path_factory.mktemp("study") / "t.sqlite")


def names(results):
    return [name for name, _, _ in charts(results)]


def test_a_study_has_the_charts_that_it_has_something_for(factorial, optimised, tmp_path):
    assert names(factorial) == ["parallel", "response-0", "response-1", "sensitivity"]
    assert names(optimised) == ["parallel", "response-0", "response-1", "pareto", "history", "sensitivity"]
    study = made({"x": (-3.0, 3.0), "y": (-3.0, 3.0), "z": (-3.0, 3.0)}, ["f"], method="sobol", samples=8)
    found = conducted(study, FunctionSubject(ishigami), tmp_path / "t.sqlite")
    (figure,) = [figure for name, _, figure in charts(found) if name == "sensitivity"]
    assert [bar.name for bar in figure.data] == ["f first", "f total"]
    assert figure.data[0].error_y.array is not None


def test_error_bars_are_the_noise(factorial):
    figures = {name: figure for name, _, figure in charts(factorial)}
    response, repeats = figures["response-0"].data
    assert len(response.x) == 8 and set(response.error_y.array) == {factorial.noise(factorial.measures[0]).deviation}
    assert repeats.name == "repeats" and len(repeats.x) == 12


def test_bars_of_a_robust_study_are_its_scatter(tmp_path):
    study = made({"x": (0.0, 10.0)}, [MeasureTable(name="depth", goal="least")], method="optimise", budget=4,
                 scatter=(VaryTable(key="y", range=(6.0, 8.0)),))  # fmt: skip
    found = conducted(study, FunctionSubject(bowl), tmp_path / "t.sqlite")
    figures = {name: figure for name, _, figure in charts(found)}
    assert figures["response-0"].data[0].error_y.array[0] > 0.0


def test_the_page_in_a_browser(factorial, optimised, browser, tmp_path):
    for results, count in ((factorial, 4), (optimised, 6)):
        path = tmp_path / "study.html"
        write_page(path, results, best="best/report.html")
        with browser.open(path) as opened:
            page = opened.page
            page.wait_for_function(f"{DRAWN} === {count}")
            assert page.locator("figure").count() == page.locator(".js-plotly-plot").count() == count
            assert page.locator("figure .plotly .main-svg").first.bounding_box()["height"] > 300
            rows = page.locator("#points tbody tr")
            assert rows.count() == len(results.points)
            heading = page.locator("#points th").nth(len(results.controlled) + 1)
            heading.click()
            low = float(rows.first.locator("td").nth(len(results.controlled) + 1).inner_text())
            heading.click()
            assert float(rows.first.locator("td").nth(len(results.controlled) + 1).inner_text()) >= low
            if results is optimised:
                assert page.locator("#best-run").get_attribute("href") == "best/report.html"
            else:
                assert page.title() == "A <study>" and page.locator(".errorbar").count() > 0
            assert not opened.errors and not opened.requests


def test_a_page_without_plotly_is_refused_before_anything_runs(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match="weavesim\\[study\\]"):
        check_page()


def fails(x):
    raise RunError("the press is closed today")


@pytest.mark.parametrize("given", [{"counts": {"x": 3}}, {"method": "optimise", "budget": 3}])
def test_a_study_without_a_finished_run_is_told_and_loses_nothing(tmp_path, given):
    measures = [MeasureTable(name="depth", goal="least", at_most=1.0)]
    results = conducted(made({"x": (0.0, 10.0)}, measures, **given), FunctionSubject(fails), tmp_path / "t.sqlite")
    assert results.best is None and [answer.status for answer in results.answers] == ["failed"] * 3
    write_page(tmp_path / "study.html", results)
    write_study(tmp_path, results)
    assert "the press is closed today" in (tmp_path / "study.html").read_text(encoding="utf-8")
    assert "the press is closed today" in (tmp_path / "runs.csv").read_text(encoding="utf-8")


def test_both_panels_of_two_parameters_have_their_own_series(tmp_path):
    study = made({"x": (0.0, 10.0), "y": (0.0, 10.0)}, ["depth"], counts={"x": 3, "y": 2})
    results = conducted(study, FunctionSubject(bowl), tmp_path / "t.sqlite")
    lines = [trace for trace in response(results, results.measures[0]).data if trace.mode == "lines+markers"]
    assert [line.name for line in lines] == ["y 0", "y 10", "x 0", "x 5", "x 10"]
    assert all(line.showlegend for line in lines)
    for line in lines:  # one value of the other parameter, so no sawtooth
        assert list(line.x) == sorted(set(line.x))


def test_a_log_axis_has_ticks_that_can_be_read(tmp_path):
    vary = [VaryTable(key="x", range=(0.2, 30.0), scale="log"), VaryTable(key="y", range=(1e-3, 1e4), scale="log")]
    few, many = (log_axis(factor_of(table)) for table in vary)
    assert few["ticktext"] == ["0.2", "0.5", "1", "2", "5", "10", "20"]
    assert many["tickvals"] == pytest.approx([10.0**k for k in range(-3, 5)])


@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_narrow_screens_and_paper(factorial, browser, tmp_path, width):
    path = tmp_path / "study.html"
    write_page(path, factorial)
    with browser.open(path, width=width) as opened:
        page = opened.page
        charts = page.locator(".plotly-graph-div")
        page.wait_for_function(f"{DRAWN} === {charts.count()}")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert all(charts.nth(k).bounding_box()["width"] >= 640 for k in range(charts.count()))
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        drawn = "[...document.querySelectorAll('.plotly .main-svg')]"
        widest = f"Math.max(...{drawn}.map(each => each.getBoundingClientRect().width))"
        page.wait_for_function(f"{widest} <= 681")
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        if width == 1280:
            page.wait_for_function(f"{widest} > 1000")


@pytest.mark.parametrize("ends", [(0.22, 0.45), (1.2, 1.9), (100.0, 150.0)])
def test_a_narrow_log_axis_has_numbers_too(ends):
    ticks = log_axis(factor_of(VaryTable(key="x", range=ends, scale="log")))
    assert len(ticks["tickvals"]) == len(ticks["ticktext"]) >= 2
