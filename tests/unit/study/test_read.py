"""Study files: what they say, and what is wrong with them, with the line."""

import pytest

from tests.support.studies import made
from weavesim.errors import InputError
from weavesim.study.read import read_study, study_of_options
from weavesim.study.schema import MeasureTable, NoiseTable, VaryTable

GOOD = """\
job = "job.toml"
method = "latin-hypercube"
samples = 8

[[vary]]
key = "tools.ring.force"
range = ["100 N", "2 kN"]

[[measure]]
name = "max_shear_p99"
goal = "least"

[noise]
repeats = 3
"""


@pytest.fixture
def read(tmp_path):
    (tmp_path / "job.toml").write_text("name = 'job'\n", encoding="utf-8")

    def reader(text: str):
        path = tmp_path / "study.toml"
        path.write_text(text, encoding="utf-8")
        return read_study(path)

    return reader


def test_a_study_file_is_read(read):
    study = read(GOOD)
    assert study.factors[0].high == 2000.0 and study.table.noise.repeats == 3
    assert study.job.name == "job.toml"
    assert "line 5, [[vary]] tools.ring.force" in study.places[0]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("samples = 8", "sampels = 8", "line 3, sampels: unknown name; did you mean 'samples'"),
        ("range =", "rnage =", r"line 5, \[\[vary\]\] tools.ring.force: .*did you mean 'range'"),
        ('["100 N", "2 kN"]', '["2 kN", "100 N"]', r"\[\[vary\]\] tools.ring.force: range = .* it is empty"),
        ("samples = 8\n", "", "samples: is required"),
        ('goal = "least"', 'goal = "small"', "'least' or 'most' is needed"),
        ("samples = 8", "samples = 8\nbudget = 9", "budget: has no effect"),
        ("latin-hypercube", "sobel", "is needed"),
        ("job.toml", "other.toml", "there is no such file"),
        ("job.toml", "../job.toml", "leads out"),
        ("[[measure]]", "[measure]", r"write \[\[measure\]\]"),
        ("[noise]", "[[measure]]\nname = 'b'\nat_most = 1\nat_least = 2\n[noise]", "no run can be good; exchange them"),
        ("[noise]", "[[measure]]\nname = 'b'\n[[measure]]\nname = 'b'\n[noise]", "b is given twice; give each once"),
        ("repeats = 3", "repeats = 1", r"\[noise\]: repeats = 1"),
        ("[noise]", "[[vary]]\nkey = 'tools.ring.force'\nrange = [1, 2]\n[noise]", "another parameter has this name"),
    ],
)
def test_mistakes_are_told_with_their_place(read, old, new, text):
    with pytest.raises(InputError, match=text):
        read(GOOD.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('method = "latin-hypercube"\nsamples = 8', 'method = "sobol"\nsamples = 12', "power of two"),
        ('goal = "least"\n', "", "needs one with goal"),
        ("[noise]", "[[scatter]]\nkey = 'b'\nrange = [1, 2]\n[noise]", r"\[\[scatter\]\]: has no effect"),
    ],
)
def test_tables_that_do_not_fit_together_are_refused(read, old, new, text):
    if "goal" in old:
        given = GOOD.replace('method = "latin-hypercube"\nsamples = 8', 'method = "optimise"\nbudget = 8')
    else:
        given = GOOD
    with pytest.raises(InputError, match=text):
        read(given.replace(old, new))


def test_unusual_limits_are_asked_about(read):
    unusual = GOOD + "\n[limits]\nbridging_gap = 0.05\n"
    with pytest.raises(InputError, match=r"limits.bridging_gap = 0.05 m: .*(?s:.)*write accept_unusual = true"):
        read(unusual)
    assert read("accept_unusual = true\n" + unusual).table.limits.bridging_gap == 0.05


def test_options_are_a_study(tmp_path):
    study = study_of_options(tmp_path / "job.toml", ["a.b=1:2:3"], ["x"], ["y"], method="factorial")
    assert [m.goal for m in study.table.measure] == [None, "least"]
    assert study.factors[0].levels() == (1.0, 1.5, 2.0)


def test_options_without_a_measure_are_refused(tmp_path):
    with pytest.raises(InputError, match="--measure: at least one"):
        study_of_options(tmp_path / "job.toml", ["a.b=1:2:3"], [])


def test_noise_beside_scenarios_is_refused():
    with pytest.raises(InputError, match=r"\[noise\]: has no effect with \[\[scatter\]\]"):
        made(
            {"x": (0.0, 1.0)}, [MeasureTable(name="a", goal="least")], method="optimise", budget=4,
            scatter=(VaryTable(key="s", range=(0.0, 1.0)),), noise=NoiseTable(),
        )  # fmt: skip
