"""What all tests share: devices, precisions, builders, and the reason why a GPU test is skipped."""

import gc
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.support.browser import HeadlessBrowser, headless_browser
from tests.support.default_device import use_by_default
from tests.support.frames import Frames
from tests.support.made_run import made_run, made_stack
from tests.support.manual import Case
from tests.support.sampled_once import sampled_once
from tests.support.sheet import Sheet, plain_fabric
from weavesim.device import Precision, initialise
from weavesim.fabric.fabric import Fabric
from weavesim.sheet.blank import Blank
from weavesim.tools import sampling


def pytest_addoption(parser):
    parser.addoption(
        "--manual", metavar="DIRECTORY", help="write what the verification tests record here (scripts/verification.py)"
    )
    parser.addoption("--default-device", metavar="DEVICE", help="device of all runs that ask for none, such as cuda:0")


def pytest_configure(config):
    if device := config.getoption("--default-device"):
        use_by_default(device)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    if "PYTEST_XDIST_WORKER" in os.environ:
        # files with long tests first: workers then end together
        slow = {item.path for item in items if item.get_closest_marker("slow")}
        items.sort(key=lambda item: item.path not in slow)
    gpu_tests = [item for item in items if item.get_closest_marker("gpu")]
    if not gpu_tests:
        return
    import warp as wp

    initialise()
    if not wp.is_cuda_available():
        for item in gpu_tests:
            item.add_marker(pytest.mark.skip(reason="this machine has no CUDA device that Warp can use"))


def pytest_sessionfinish(session):
    """Collect once what is left, so that the five collections with which pytest ends are quick.

    Kernels and meshes leave so many objects that these take over five seconds. A worker of pytest-xdist that has not
    ended by then is interrupted, and prints the traceback of a KeyboardInterrupt below a suite that has passed.
    """
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _warp():
    """Warp with the settings of a run: quiet, the same compiler flags, the same kernel cache."""
    initialise()


@pytest.fixture(scope="session", autouse=True)
def _own_fabrics(tmp_path_factory):
    """A folder without fabrics in the place of that of whoever runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WEAVESIM_FABRICS", str(tmp_path_factory.mktemp("fabrics")))
        yield


@pytest.fixture(params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def device(request) -> str:
    """Every device a test should pass on."""
    return request.param


@pytest.fixture(params=list(Precision), ids=str)
def precision(request) -> Precision:
    """Both precisions."""
    return request.param


@pytest.fixture
def manual(request) -> Callable[..., Case]:
    """``manual(chapter, title, known=...)``: a case of the verification manual, see ``Case``."""
    directory = request.config.getoption("--manual")
    test = request.node.nodeid.split("[")[0]

    def case(chapter: str, title: str, *, known: str) -> Case:
        return Case(Path(directory) if directory else None, chapter, title, known, test)

    return case


@pytest.fixture(scope="module")
def browser() -> Iterator[HeadlessBrowser]:
    """A headless browser: ``with browser.open(page) as opened``; skipped with a reason where there is none."""
    with headless_browser() as opened:
        yield opened


@pytest.fixture(scope="module")
def tools_sampled_once() -> Iterator[None]:
    """In modules that use this, equal meshes of tools are sampled once; what samples are is not their matter."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sampling, "_sample", sampled_once)
        yield


@pytest.fixture
def frames() -> Frames:
    """An observer that keeps all frames in ``frames.all``, and how the run ended in ``frames.outcome``."""
    return Frames()


@pytest.fixture
def sheet() -> Callable[..., Sheet]:
    """``sheet(blank, fabric)``."""
    return Sheet


@pytest.fixture
def fabric() -> Callable[..., Fabric]:
    """``fabric(bending=..., ...)``: the weak linear membrane with what is given."""
    return plain_fabric


@pytest.fixture(scope="session")
def curved_blank() -> Blank:
    """A distorted mesh on a saddle, yarns at 20 degrees to the edges."""
    flat = Blank.rectangle((0.0, 0.0), (0.02, 0.015), 0.005, yarn_angle=20.0, distortion=0.25)
    position = flat.node_position.copy()
    position[:, 2] = 3.0 * position[:, 0] ** 2 - 2.0 * position[:, 0] * position[:, 1]
    return Blank.from_mesh(position, flat.quads, yarn_angle=20.0)


@pytest.fixture(scope="session")
def deformed(curved_blank) -> tuple[np.ndarray, np.ndarray]:
    """Positions and unit directors of the curved blank, strained by 15 %, sheared, bent and turned."""
    rng = np.random.default_rng(1)
    gradient = np.eye(3) + 0.15 * rng.normal(size=(3, 3))
    gradient[0, 1] += 0.25
    gradient[:, 1] *= 0.85  # one family of yarns is pushed together
    position = curved_blank.node_position @ gradient.T + 2e-4 * rng.normal(size=curved_blank.node_position.shape)
    director = curved_blank.initial_director @ np.linalg.inv(gradient) + 0.2 * rng.normal(size=position.shape)
    return position, director / np.linalg.norm(director, axis=1)[:, None]


@pytest.fixture(scope="session")
def coarse_run():
    """Quarter at 15 mm with twelve frames: (info, frames)."""
    return made_run(0.015)


@pytest.fixture(scope="session")
def stack():
    """Two sheets with four frames: (info, frames)."""
    return made_stack()


@pytest.fixture(scope="session")
def fine_run():
    """Quarter at 5 mm with twelve frames: (info, frames)."""
    return made_run()
