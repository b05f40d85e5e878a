"""Films that the tests of this folder share."""

import pytest
from pxr import Usd

from tests.support.films import write_film


@pytest.fixture(scope="module")
def film_path(tmp_path_factory, coarse_run):
    return write_film(tmp_path_factory.mktemp("film") / "double_dome.usdc", coarse_run)


@pytest.fixture
def stage(film_path):
    return Usd.Stage.Open(str(film_path))


@pytest.fixture(scope="module")
def stack_path(tmp_path_factory, stack):
    return write_film(tmp_path_factory.mktemp("film") / "stack.usdc", stack)


@pytest.fixture(scope="module")
def stack_film(stack_path):
    return Usd.Stage.Open(str(stack_path))
