"""Arrays of lanes for tests of single formulas."""

import numpy as np
import warp as wp

from weavesim.engine.layout import lanes_view
from weavesim.kernels.lane_types import LaneTypes


def scalars(types: LaneTypes, values) -> wp.array:
    """Values in blocks of lanes, on the CPU; shape (..., blocks) of ``types.lanes``."""
    return lanes_view(wp.array(np.asarray(values), dtype=types.real, device="cpu"), types.lane_count)
