"""Contact of two edges, against the closed form of two lines that cross, and where none is due."""

import numpy as np
import pytest
import warp as wp

from weavesim.kernels.creases.data import creases_struct, edges_struct
from weavesim.kernels.creases.meet import gather_creases_kernel, meet_creases_kernel
from weavesim.kernels.creases.pair_rows import CreaseCount, CreaseWorkRow, PairRow
from weavesim.kernels.rows import ClockEntry, MotionRow

THICKNESS, STEP, STIFFNESS, FRICTION = 1.0, 1e-3, 7.0, 0.3
# Ends of the first edge, along x, and of the second, across it and lower; the sheet lies away from the other edge.
FIRST, SECOND = ((-1.0, 0.2, 0.0), (3.0, 0.1, 0.1)), ((0.6, -2.0, -0.9), (0.4, 2.0, -0.95))


def met(
    real=wp.float64,
    first=FIRST,
    second=SECOND,
    speed=((0.0,) * 3,) * 4,
    weight=(1.0, 1.0),
    lower=-1.0,
    depth=1e-9,
    steps=1,
    free=None,
):
    """Everything that is kept of two edges with parts of the sheet on the far side of either, after ``steps``.

    ``free``: directions into the only facet of either, which then are free edges.
    """
    motion = np.zeros((MotionRow.row_count(), 4))
    motion[MotionRow.position.span] = np.array([*first, *second]).T
    motion[MotionRow.velocity.span] = np.array(speed).T

    def array(values, dtype=real):
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device="cpu")

    edges, creases, vec3 = edges_struct(real)(), creases_struct(real)(), wp.types.vector(3, real)
    edges.entry, edges.stride, edges.motion = array([[0, 2], [1, 3]] + [[0, 0]] * 4, wp.int32), 4, array(motion.ravel())
    edges.stiffness, edges.overlap = array([STIFFNESS, 2.0 * STIFFNESS]), array(np.full((2, 2), 0.1))
    edges.thickness, edges.tangential_ratio, edges.coefficient = THICKNESS, 0.5, array([FRICTION])
    creases.number, creases.crease = array([2, 2, 0], wp.int32), array([0, 1], wp.int32)
    creases.weight = array(weight)
    inward = np.tile([[[0, 0, 1.0], [0, 0, lower]]], (2, 1, 1))
    if free is not None:
        edges.free_count, inward = 2, np.array([free, np.zeros((2, 3))])
    creases.inward = wp.array(inward, dtype=vec3, device="cpu")
    creases.first, creases.count, creases.partner = (array(v, wp.int32) for v in ([0, 1], [1, 1], [1, 0]))
    rows = np.zeros((PairRow.row_count(), 2))
    rows[PairRow.depth] = depth  # above 0: they have touched before, without an entry
    creases.rows = array(rows)
    creases.works = wp.zeros((CreaseWorkRow.row_count(), 2), dtype=wp.float64, device="cpu")
    creases.force = wp.zeros((2, 2), dtype=vec3, device="cpu")
    creases.deepest, creases.largest_entry = array(np.zeros(2)), array(np.zeros(2))
    clock = np.zeros(ClockEntry.row_count())
    clock[ClockEntry.mean_step] = STEP
    inputs = [0, 1, edges, array(clock, wp.float64), creases]
    for _ in range(steps):
        wp.launch(meet_creases_kernel(real), dim=1, inputs=inputs, device="cpu")
    return creases


def closed_form():
    """Force on the first edge, and shares of its second end and of that of the other."""
    (a, b), (c, d) = np.array(FIRST), np.array(SECOND)
    normal = np.cross(b - a, d - c)
    normal /= np.linalg.norm(normal)
    s, r, height = np.linalg.solve(np.stack([a - b, d - c, normal], axis=1), a - c)
    return STIFFNESS * (THICKNESS - abs(height)) * np.sign(height) * normal, s, r


@pytest.mark.parametrize("real", [wp.float64, wp.float32])
def test_lines_that_cross(real):
    force, s, r = closed_form()
    own = met(real).force.numpy()
    tolerance = 1e-12 if real is wp.float64 else 1e-5
    np.testing.assert_allclose(own[:, 0], np.outer((1.0 - s, s), force), atol=tolerance)
    np.testing.assert_allclose(own[:, 1], -np.outer((1.0 - r, r), force), atol=tolerance)
    moments = np.cross([FIRST, SECOND], own.transpose(1, 0, 2))
    np.testing.assert_allclose(moments.sum(axis=(0, 1)), 0.0, atol=10.0 * tolerance)


def test_both_edges_keep_the_same():
    own = met(speed=np.random.default_rng(3).normal(size=(4, 3)), steps=5)
    rows = own.rows.numpy()
    np.testing.assert_array_equal(rows[:, 0], rows[:, 1])
    np.testing.assert_allclose(own.force.numpy().sum(axis=(0, 1)), 0.0, atol=1e-14)
    works = own.works.numpy()
    assert (works[:, 1] == 0.0).all() and works[CreaseWorkRow.friction_work, 0] != 0.0


def test_friction_slides_within_its_limit():
    """The upper edge is drawn along x: the spring grows with the way until its force is the limit."""
    force, s, _ = closed_form()
    for steps, slides in ((1, False), (400, True)):
        own = met(speed=((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0,) * 3, (0.0,) * 3), steps=steps)
        drag = own.force.numpy()[:, 0].sum(axis=0) - force
        n = force / np.linalg.norm(force)
        flat = np.array([1.0, 0.0, 0.0]) - n[0] * n
        expected = FRICTION * np.linalg.norm(force) if slides else 0.5 * STIFFNESS * STEP * np.linalg.norm(flat)
        assert np.linalg.norm(drag) == pytest.approx(expected, rel=1e-9) and drag @ flat < 0.0


@pytest.mark.parametrize(
    "given",
    [
        {"weight": (1.0, 0.0)},  # a flat sheet
        {"first": ((-1.0, 0.2, 0.2), (3.0, 0.1, 0.3))},  # beyond the thickness
        {"second": ((-1.0, 0.3, -0.9), (3.0, 0.2, -0.8))},  # along each other
        {"first": ((0.9, 0.2, 0.0), (4.0, 0.1, 0.1))},  # beyond an end
        {"lower": 1.0},  # over the facets of the other edge, whose matter it is
        {"depth": -1.0},  # deep at once: it begins without a force
    ],
)
def test_no_force(given):
    assert not met(**given).force.numpy().any()


@pytest.mark.parametrize(
    ("free", "share"),
    [
        (((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)), 1.0),  # edge-on, in planes at a right angle
        (((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), 0.0),  # one flat over the other, which nodes on facets see
        (((0.0, 0.0, -1.0), (0.0, 0.0, -1.0)), 0.0),  # over the facet of the first
    ],
)
def test_free_edges(free, share):
    force, *_ = closed_form()
    np.testing.assert_allclose(met(free=free).force.numpy()[:, 0].sum(axis=0), share * force, atol=1e-12)


def test_the_next_edge_takes_over():
    """At a node where one edge goes on in another, both together carry the whole contact, wherever it is."""
    along = np.array([1.0, 0.0, 0.0])
    for at in (-0.05, 0.0, 0.03):
        middle = np.array([0.5, 0.0, 0.0]) + at * 2.0 * along
        second = (middle + (0.0, -1.0, -0.9), middle + (0.0, 1.0, -0.9))
        ends = np.array([[-1.5, 0.0, 0.0], [0.5, 0.0, 0.0], [2.5, 0.0, 0.0]])
        pushes = [met(first=ends[k : k + 2], second=second).force.numpy()[:, 0].sum(axis=0)[2] for k in range(2)]
        assert sum(pushes) == pytest.approx(0.1 * STIFFNESS, rel=1e-12) and min(pushes) >= 0.0


def test_nodes_gather_their_edges():
    own = met()
    around = wp.array(np.array([[0, 1, 2, 3], [-1, 2, -1, -1]]), dtype=wp.int32, device="cpu")
    total = wp.ones((3, 4), dtype=wp.float64, device="cpu")
    wp.launch(gather_creases_kernel(wp.float64), dim=1, inputs=[0, 4, 1, around, own, total], device="cpu")
    force = own.force.numpy()
    known = np.stack([force[0, 0], force[1, 0] + force[0, 1], force[0, 1], force[1, 1]]) + 1.0
    np.testing.assert_allclose(total.numpy().T, known, atol=1e-15)
    assert own.number.numpy()[CreaseCount.pairs] == 2
