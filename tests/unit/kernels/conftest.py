"""Lanes as on a GPU and as on a CPU, in both precisions."""

import pytest

from weavesim.kernels.lane_types import lane_types


@pytest.fixture(params=[1, 16], ids=["one lane", "sixteen lanes"])
def types(request, precision):
    return lane_types(precision.real, request.param)
