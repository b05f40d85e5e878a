"""Simulations in several threads take turns, and compute what one would."""

import threading

import numpy as np
import pytest

from tests.support.runs import one_sheet_setup, small_run
from weavesim.device import exclusive
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.response import respond
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


def in_threads(count, work):
    """Results of ``work(index)``, one thread each; the first exception is raised."""
    results, errors, ready = [None] * count, [], threading.Barrier(count)

    def run(index):
        try:
            ready.wait()
            results[index] = work(index)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=run, args=(index,)) for index in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]
    return results


def simulation(size=0.005, threads=1):
    return Simulation(
        one_sheet_setup(
            name="small", blank=Blank.rectangle((0.0, 0.0), (0.02, 0.02), size), fabric=glass_polypropylene(),
            duration=1e-3, frame_count=5, threads=threads,
            initial_velocity=np.tile([0.0, 0.0, 1.0], ((round(0.02 / size) + 1) ** 2, 1)),
        )
    )  # fmt: skip


def bits(run):
    run.run()
    return run.frame.position.tobytes(), tuple(run.frame.energies.items())


@pytest.mark.parametrize("threads", [1, 2])
def test_four_threads_give_the_bits_of_one(threads):
    alone = [bits(simulation(size, threads)) for size in (0.005, 0.004)]
    together = in_threads(4, lambda index: bits(simulation((0.005, 0.004)[index % 2], threads)))
    assert together == [alone[index % 2] for index in range(4)]


def test_runs_that_were_prepared_before(device):
    runs = [small_run(device=device, duration=1e-3) for _ in range(3)]
    alone = bits(small_run(device=device, duration=1e-3))
    assert in_threads(3, lambda index: bits(runs[index])) == [alone] * 3


def test_responses_of_cells_beside_a_run():
    """A launch of one thread must not become part of what another records."""
    cell = glass_polypropylene().unit_cell

    def work(index):
        if index == 0:
            return bits(simulation())
        return [respond(cell, [[1.001, 1.002]]).force_per_width.tobytes() for _ in range(20)]

    run, *responses = in_threads(3, work)
    assert run == bits(simulation())
    assert {force for found in responses for force in found} == {
        respond(cell, [[1.001, 1.002]]).force_per_width.tobytes()
    }


def test_one_thread_may_nest():
    with exclusive(), exclusive():
        pass
