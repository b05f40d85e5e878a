"""How a step is shared out to threads and tiles, and what it launches."""

import numpy as np
import pytest
import warp as wp

from weavesim import stepper as stepper_module
from weavesim.blank import Blank
from weavesim.fabric import glass_polypropylene
from weavesim.motion import Stroke
from weavesim.simulation import Simulation
from weavesim.stepper import REFRESH_INTERVAL, divide_step
from weavesim.support import Drive, Support

LANES = 16


def padded_corners(quads: np.ndarray, node_count: int) -> np.ndarray:
    """(4, padded elements) corner nodes, as the model lays them out."""
    result = np.empty((4, (len(quads) // LANES + 1) * LANES), dtype=np.int64)
    result[:] = node_count + np.arange(4)[:, None]
    result[:, : len(quads)] = quads.T
    return result


@pytest.mark.parametrize("thread_count", [1, 2, 3, 200])
@pytest.mark.parametrize("shuffled", [False, True])
def test_no_node_moves_before_its_elements_are_done(thread_count, shuffled):
    blank = Blank.rectangle((0.0, 0.0), (1.0, 1.0), 1.0 / 40.0)
    quads = np.random.default_rng(0).permutation(blank.quads) if shuffled else blank.quads
    corners = padded_corners(quads, blank.node_count)
    element_nodes = corners // LANES
    parts = divide_step(corners, LANES, thread_count, 256)
    assert len(parts) == thread_count
    done = np.zeros((thread_count, corners.shape[1] // LANES), dtype=int)
    moved = np.zeros(element_nodes.max() + 1, dtype=int)

    def check(nodes: tuple[int, int], finished: np.ndarray) -> None:
        blocks = np.arange(nodes[0], sum(nodes))
        needed = np.isin(element_nodes, blocks).any(axis=0).nonzero()[0] // LANES
        assert finished[needed].all()
        moved[blocks] += 1

    for own, part in zip(done, parts, strict=True):
        for (first, count), nodes in part.tiles:
            own[first : first + count] += 1
            # other threads may not have begun
            check(nodes, own)
    for part in parts:
        for nodes in part.shared:
            check(nodes, done.sum(axis=0))
    assert (done.sum(axis=0) == 1).all() and (moved == 1).all()
    waiting = sum(count for part in parts for _, count in part.shared)
    if thread_count == 1:
        assert waiting == 0
    elif thread_count < 4:
        # one row of nodes between two threads; without an order all have to wait
        assert waiting == len(moved) if shuffled else waiting <= 4 * (thread_count - 1)


def free_sheet(monkeypatch, **given) -> Simulation:
    """On a CPU, but launched as on a GPU: one lane, and tiles of the whole sheet."""
    monkeypatch.setattr(stepper_module, "TILE_SIZE", 10**9)
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.05), 0.005)
    settings = {"lane_count": 1, "threads": 1, "duration": 1.0}
    return Simulation(name="free", blank=blank, fabric=glass_polypropylene(), **(settings | given))


@pytest.mark.parametrize("driven", [False, True])
def test_a_step_is_three_launches(monkeypatch, driven):
    """Elements, nodes, tools and clock; one more where supports are driven, three every ``REFRESH_INTERVAL`` steps."""
    drive = Drive(Stroke((0.0, 1.0), (0.0, 0.01)), (1.0, 0.0, 0.0))
    supports = (Support("edge", np.arange(11), drives=(drive,)),) if driven else ()
    simulation = free_sheet(monkeypatch, supports=supports)
    launched = []
    monkeypatch.setattr(wp, "launch", lambda kernel, **given: launched.append(kernel.key))
    stepper = simulation.stepper
    stepper._block(stepper._parts(1), 0)
    assert len(launched) == (4 if driven else 3) * REFRESH_INTERVAL + 3
    assert len(set(launched)) == (7 if driven else 6)


def test_stepping_does_not_wait_for_the_device(monkeypatch):
    simulation = free_sheet(monkeypatch)
    replayed = []
    for name in ("launch", "copy", "synchronize", "synchronize_device", "synchronize_stream"):
        monkeypatch.setattr(wp, name, lambda *given, name=name, **more: pytest.fail(f"wp.{name} between two frames"))
    monkeypatch.setattr(wp.array, "numpy", lambda self: pytest.fail("an array was read between two frames"))
    monkeypatch.setattr(wp, "capture_launch", lambda graph: replayed.append(graph))
    simulation.stepper.advance(7)
    assert len(replayed) == 7 and simulation.stepper.step_count == 7 * REFRESH_INTERVAL
