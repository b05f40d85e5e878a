"""What computed a checkpoint."""

from weavesim.run.checkpoint.machine import differences, machine
from weavesim.version import __version__


def test_everything_that_bits_depend_on_is_told():
    here = machine("cpu")
    assert here["weavesim"] == __version__ and here["device"] == "cpu"
    assert all(isinstance(value, str) and value for value in here.values())
    assert list(differences(here, machine("cpu"))) == []


def test_differences_are_named_in_words():
    here = machine("cpu")
    there = {**here, "numpy": "0.1", "sources": "other", "processor": "x86_64 " + 50 * "avx "}
    assert list(differences(there, here)) == [
        "source text of weavesim", f"version of NumPy ({here['numpy']} instead of 0.1)", "processor",
    ]  # fmt: skip
    assert len(list(differences({}, here))) == len(here)
