"""Everything that a run knows is taken apart and put together again."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.run.checkpoint.container import DamageError, packed, unpacked
from weavesim.run.checkpoint.memory import memory_of, put_together, recall, taken_apart
from weavesim.run.guards import Guard, known_guards
from weavesim.run.guards import guard as guard_module


def test_arrays_come_out_and_go_in():
    memory = {"a": [np.arange(3), {"b": np.eye(2)}], "c": (1, None), "d": {}}
    arrays: dict[str, np.ndarray] = {}
    plain = unpacked(b"".join(packed({"m": taken_apart(memory, arrays)}, {}))).values["m"]
    again = put_together(plain, arrays)
    assert len(arrays) == 2 and again["c"] == [1, None] and again["d"] == {}
    assert (again["a"][0] == np.arange(3)).all() and (again["a"][1]["b"] == np.eye(2)).all()


def test_a_run_knows_again_what_it_knew():
    first = small_run(duration=4e-4)
    first.run()
    content = unpacked(b"".join(packed(*memory_of(first))))
    second = small_run(duration=4e-4)
    recall(second, content)
    again = unpacked(b"".join(packed(*memory_of(second))))
    assert again.values == content.values and list(again.arrays) == list(content.arrays)
    assert all(again.arrays[name].tobytes() == content.arrays[name].tobytes() for name in content.arrays)


def test_a_state_of_another_run_is_refused():
    content = memory_of(small_run())
    content.arrays.pop("state/clock")
    with pytest.raises(DamageError, match="clock is missing"):
        recall(small_run(), content)


@pytest.fixture
def forgetful():
    """A guard that watches, but has no memory; and one that has one."""
    known = dict(guard_module._known)

    class Forgetful(Guard):
        name, watches = "forgetful", "what it sees"

        def watch(self, frame, ledger):
            pass

    class Mindful(Guard):
        name = "mindful"
        seen = 0

        def watch(self, frame, ledger):
            self.seen += 1

        def memory(self):
            return {"seen": self.seen, "at": np.arange(2.0)}

        def recall(self, memory):
            self.seen = memory["seen"]

    yield
    guard_module._known.clear()
    guard_module._known.update(known)


def test_a_guard_without_a_memory_says_what_it_missed(forgetful):
    first = small_run(duration=4e-4)
    first.run()
    assert not [doubt for doubt in first.doubts() if doubt.guard == "forgetful"]
    second = small_run(duration=4e-4)
    recall(second, memory_of(first))
    doubts = {doubt.guard: doubt for doubt in second.doubts()}
    assert "knows nothing of the run before 0.00040" in doubts["forgetful"].message
    guards = {guard.name: guard for guard in second.prepare().guards._guards}
    assert guards["mindful"].seen > 1 and "mindful" not in doubts


def test_every_guard_of_weavesim_has_a_memory():
    kinds = known_guards().values()
    assert [kind.name for kind in kinds if kind.__module__.startswith("weavesim.") and kind().forgets] == []
