"""What all tests share: devices, precisions, and the reason why a GPU test is skipped."""

import pytest

from weavesim.device import Precision, initialise


def pytest_addoption(parser):
    parser.addoption(
        "--manual", metavar="DIRECTORY", help="write what the verification tests record here (scripts/verification.py)"
    )


def pytest_collection_modifyitems(items):
    gpu_tests = [item for item in items if item.get_closest_marker("gpu")]
    if not gpu_tests:
        return
    import warp as wp

    initialise()
    if not wp.is_cuda_available():
        for item in gpu_tests:
            item.add_marker(pytest.mark.skip(reason="this machine has no CUDA device that Warp can use"))


@pytest.fixture(scope="session", autouse=True)
def _warp():
    """Warp with the settings of a run: quiet, the same compiler flags, the same kernel cache."""
    initialise()


@pytest.fixture(params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def device(request) -> str:
    """Every device a test should pass on."""
    return request.param


@pytest.fixture(params=list(Precision), ids=str)
def precision(request) -> Precision:
    """Both precisions."""
    return request.param
