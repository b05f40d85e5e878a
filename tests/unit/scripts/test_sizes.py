"""Sizes that are counted, on a tree small enough to count by hand."""

import subprocess
import sys

import pytest

from scripts.sizes import Sizes, summary
from tests.support.paths import ROOT

FILES = {
    "kernels/__init__.py": "",
    "kernels/step.py": """import warp as wp

def factory(real):
    @wp.kernel(enable_backward=False)
    def step(
        x: wp.array, v: wp.array,
    ):
        i = wp.tid()

    return step

@wp.func
def one(x: float):
    return 1.0
""",
    "weavesim/__init__.py": "",
    "weavesim/engine/__init__.py": "",
    "weavesim/engine/model.py": """from ..kernels import step

LARGEST = 1
_own = 2

class Model:
    def __init__(self, a, b, *, c=None, **others):
        def inner():
            from . import state
            return state
        self.inner = inner

    @classmethod
    def of(cls): ...
""",
    "weavesim/engine/state.py": "from .model import Model\n",
    "scenes/dome.py": "import numpy\nfrom weavesim.engine.state import Model\n",
    "scripts/dome.py": "from weavesim.scenes import dome\n",
}


@pytest.fixture
def sizes(tmp_path) -> Sizes:
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Sizes.of(tmp_path)


def test_lines_and_arguments_are_counted(sizes):
    model = "weavesim.engine.model.Model"
    assert sizes.lines(on_device=False) == {
        "weavesim.kernels.step.factory": 8, f"{model}.__init__": 5, f"{model}.__init__.inner": 3, f"{model}.of": 1,
    }  # fmt: skip
    assert sizes.arguments(on_device=False)[f"{model}.__init__"] == 4
    assert sizes.arguments(on_device=False)[f"{model}.of"] == 0
    assert sizes.lines(on_device=True) == {"weavesim.kernels.step.factory.step": 4, "weavesim.kernels.step.one": 2}
    assert sizes.arguments(on_device=True)["weavesim.kernels.step.factory.step"] == 2
    assert sizes.module_lines["weavesim.engine.model"] == 14
    assert sizes.public_names["weavesim.engine.model"] == 2


def test_folders_and_arrows_are_counted(sizes):
    assert sizes.folder_files == {"kernels": 1, "scenes": 1, "scripts": 1, "weavesim/engine": 2}
    # model to step and state, state to model, scene to state, script to scene
    assert sizes.module_arrows == 5
    assert sizes.folder_arrows == 3
    assert sizes.circles == (("weavesim.engine.model", "weavesim.engine.state"),)
    # script, scene, the two that import each other, step
    assert sizes.levels == 4


def test_medians_and_maxima_are_shown(sizes):
    assert "| files of a folder | 1 | 2 | 2 |" in summary({"here": sizes})


def test_another_commit_is_compared_with_this_checkout():
    if subprocess.run(["git", "rev-parse", "--verify", "HEAD"], cwd=ROOT, capture_output=True).returncode:
        pytest.skip("no repository")
    command = [sys.executable, "scripts/sizes.py", "--commit", "HEAD"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert "| size | HEAD: median |" in done.stdout and "### Lines of a module" in done.stdout
