"""Reactions of nodes on facets, for single lanes as on a GPU and for blocks of sixteen, against NumPy."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.layout import RowLayout, lanes_view
from weavesim.kernels.pass_entries import PassEntry
from weavesim.kernels.plies.data import TOO_MANY, blocks_per_call
from weavesim.kernels.plies.reaction import push_facets_kernel, reaction_struct
from weavesim.kernels.rows import CORNER_ROW_COUNT, PLY_RECORD_LENGTH, ROWS_PER_CORNER, CornerRow, PlyRow

REAL = wp.float64
FACETS, NODES, SLOTS = 64, 48, 5
SIGNS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def expected(rows: np.ndarray, standing: np.ndarray, corners: np.ndarray) -> np.ndarray:
    result = corners.copy()
    for node, facet in enumerate(standing):
        for corner, (one, other) in enumerate(SIGNS if facet >= 0 else ()):
            weight = 0.25 * (1.0 + one * rows[PlyRow.xi, node]) * (1.0 + other * rows[PlyRow.eta, node])
            first = CornerRow.force + corner * ROWS_PER_CORNER
            result[first : first + 3, facet] -= weight * rows[PlyRow.force.span, node]
    return result


@pytest.mark.parametrize("lane_count", [1, 16])
@pytest.mark.parametrize("awake", [True, False])
def test_forces_are_shared_out_to_the_corners(lane_count, awake):
    rng = np.random.default_rng(5)
    rows, corners = rng.normal(size=(PlyRow.row_count(), NODES)), rng.normal(size=(CORNER_ROW_COUNT, FACETS))
    standing = rng.integers(-1, FACETS, NODES).astype(np.int32)
    standing[:3] = 7  # more than one on a facet
    listed = np.full((SLOTS, FACETS), -1, dtype=np.int32)
    count = np.zeros(FACETS, dtype=np.int32)
    for node in range(NODES):  # on its facet and on others, as nodes that may walk there
        for facet in {int(standing[node]), node % FACETS} - {-1}:
            if count[facet] < SLOTS:
                listed[count[facet], facet] = node
                count[facet] += 1
    in_block = count.reshape(-1, lane_count).max(axis=1).astype(np.int32)
    in_block[-1] = int(TOO_MANY)  # looks through all nodes
    nodes = RowLayout(PlyRow.row_count(), NODES, lane_count, PLY_RECORD_LENGTH)
    facets = RowLayout(CORNER_ROW_COUNT, FACETS, lane_count, CORNER_ROW_COUNT)
    reaction, entry = reaction_struct(REAL, lane_count)(), np.zeros(PassEntry.row_count())
    entry[PassEntry.watched] = float(awake)
    reaction.listed = lanes_view(wp.array(listed, device="cpu"), lane_count)
    reaction.count, reaction.standing = wp.array(in_block, device="cpu"), wp.array(standing, device="cpu")
    reaction.rows, reaction.stride = wp.array(nodes.flat(rows), device="cpu"), nodes.stride
    reaction.row_count, reaction.entry = nodes.row_count, wp.array(entry, device="cpu")
    forces = wp.array(facets.flat(corners), device="cpu")
    blocks = FACETS // lane_count
    wp.launch(
        push_facets_kernel(REAL, lane_count), dim=-(-blocks // blocks_per_call(lane_count)),
        inputs=[0, blocks, reaction], outputs=[facets.view(forces)], device="cpu",
    )  # fmt: skip
    known = expected(rows, standing, corners) if awake else corners
    np.testing.assert_allclose(facets.read(forces), known, rtol=1e-14, atol=1e-14)
