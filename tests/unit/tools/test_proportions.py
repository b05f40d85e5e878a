import math

import pytest

from weavesim.fabric import glass_polypropylene
from weavesim.process import ForceDriven, Stroke
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.sheet.symmetry import WHOLE, Symmetry
from weavesim.tools import Capsule, Plane, Sphere, Tool, Union, rotation_matrix
from weavesim.tools.proportions import disproportionate_tools, tool_size

SHEET = Sheet(Blank.rectangle((0.0, 0.0), (0.47, 0.27), 0.1), glass_polypropylene())


def sentences(shape, motion=None, symmetry=WHOLE):
    return list(
        disproportionate_tools(SHEET, [Tool("punch", shape, **({"motion": motion} if motion else {}))], symmetry)
    )


def test_size_is_that_of_the_box_around_all_parts():
    assert tool_size(Sphere(0.1)) == pytest.approx(0.2)
    assert tool_size(Plane()) is None
    assert tool_size(Union((Sphere(0.1), Plane()))) is None
    assert tool_size(Union((Sphere(0.1), Sphere(0.1, origin=(1.0, 0.0, 0.0))))) == pytest.approx(1.2)
    turned = Capsule(0.01, 0.09, rotation=rotation_matrix((0, 1, 0), 0.5 * math.pi))
    assert tool_size(turned) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("factor", "word"),
    [(39.37, "as large"), (1.0 / 25.4, "as small"), (1000.0 / 25.4, "as large"), (1e-3 * 5, "as small")],
)
def test_a_tool_in_another_unit_is_named(factor, word):
    (sentence,) = sentences(Sphere(0.2 * factor))
    assert word in sentence and "punch" in sentence and "inch" in sentence


@pytest.mark.parametrize("size", [0.02, 0.1, 0.5, 1.5])
def test_usual_tools_are_not_named(size):
    assert not sentences(Sphere(size))


@pytest.mark.parametrize(
    ("blank", "radius"), [(0.05, 0.5), (0.1, 1.0), (0.1, 1.5), (0.15, 1.9), (1.0, 0.025), (2.0, 0.02), (5.0, 0.1)]
)
def test_a_patch_on_a_mould_and_a_pin_under_a_sheet_are_only_warned_about(blank, radius, caplog):
    sheet = Sheet(Blank.rectangle((0.0, 0.0), (blank, blank), 0.1 * blank), glass_polypropylene())
    assert not list(disproportionate_tools(sheet, [Tool("mould", Sphere(radius))], WHOLE))
    assert "tool mould is" in caplog.text and "check both units" in caplog.text


def test_a_stroke_of_several_blanks_is_named():
    (sentence,) = sentences(Sphere(0.1), Stroke((0.0, 1.0), (0.0, -2.5)))
    assert "travels 2.5 m, 5.32 times" in sentence
    assert not sentences(Sphere(0.1), Stroke((0.0, 1.0), (0.0, 0.5)))
    assert not sentences(Sphere(0.1), ForceDriven.constant(600.0, 2.0))


def test_a_blank_that_is_cut_counts_as_a_whole():
    """4.4 m are 9 times the whole blank of 0.47 m, and 19 times the quarter that is computed."""
    quarter = Sheet(Blank.rectangle((0.0, 0.0), (0.235, 0.135), 0.1), glass_polypropylene())
    tools = [Tool("die", Sphere(2.2))]
    assert list(disproportionate_tools(quarter, tools, WHOLE))
    assert not list(disproportionate_tools(quarter, tools, Symmetry(("x", "y"))))
