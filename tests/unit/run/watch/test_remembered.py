"""Findings are kept for equal input, and for nothing else."""

from tests.support.runs import small_run
from weavesim.run.watch import remembered as module
from weavesim.run.watch.remembered import geometry_key, remembered
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool


def test_an_equal_key_is_asked_once(monkeypatch):
    monkeypatch.setattr(module, "_found", type(module._found)())
    asked = []

    def find():
        asked.append(1)
        return len(asked)

    assert [remembered(("a", 1), find), remembered(("a", 1), find), remembered(("a", 2), find)] == [1, 1, 2]
    assert [remembered(None, find), remembered(None, find)] == [3, 4]


def test_the_oldest_are_forgotten(monkeypatch):
    monkeypatch.setattr(module, "_found", type(module._found)())
    monkeypatch.setattr(module, "LARGEST_COUNT", 2)
    for key in ("a", "b", "a", "c"):
        remembered((key,), key.upper)
    assert [key for (key,) in module._found] == ["a", "c"]


def test_a_key_tells_what_distances_depend_on():
    def key(height=-0.01, friction=0.2, **given):
        tool = Tool("table", Plane(origin=(0.0, 0.0, height)), friction=friction)
        return geometry_key(small_run(tools=[tool], **given).model, (tool,))

    assert key() == key(friction=0.5)
    others = [key(height=-0.02), key(duration=2e-5), key(blank=Blank.rectangle((0.0, 0.0), (0.02, 0.021), 0.005))]
    assert len({key(), *others}) == 4
