"""Cells in lanes against the same cells lane by lane, in sixteen lanes and in one, and what happens when they fail."""

import logging
from typing import Any

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st
from warp import float64 as real

from scripts.benchmarks.cuda.resources import dump_program, resources
from tests.support.registered_cells import CELLS, KnottedNet
from tests.support.runs import small_run
from weavesim.checks import Positive
from weavesim.device import initialise, resolve_precision
from weavesim.fabric.cell import EnergyCell
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.response import respond
from weavesim.kernels.cell import energy_lanes
from weavesim.kernels.cell.cell_formulas import cell_formulas
from weavesim.kernels.cell.energy_cell import CellFunctions
from weavesim.kernels.cell.law import cell_answer_struct
from weavesim.kernels.cell.response import unit_cell_response_kernel
from weavesim.kernels.formula.values import Unreadable
from weavesim.kernels.lane_types import lane_types
from weavesim.kernels.rows import CellReportRow
from weavesim.process.dynamics import Dynamics

# One of each set of functions.
NAMES = ("twill", "stitched-tape", "linear-membrane", "user's net")


def random_strains(count, seed=5):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.88, 1.06, (count, 2)), rng.uniform(-0.9, 0.9, count)


@pytest.fixture(scope="module")
def lane_by_lane():
    """Function (cell, ...) -> its response, computed by the functions that are differentiated by Warp."""

    def unreadable(*arguments):
        raise Unreadable("line 1: for this test")

    def response(cell, *arguments, **named):
        kept, energy_lanes.cell_formulas = energy_lanes.cell_formulas, unreadable
        energy_lanes.energy_law.cache_clear()
        try:
            assert cell.law().lane_by_lane
            return respond(cell, *arguments, **named)
        finally:
            energy_lanes.cell_formulas = kept
            energy_lanes.energy_law.cache_clear()

    return response


@pytest.mark.parametrize("name", NAMES)
def test_answers_are_those_of_differentiation_by_warp(name, lane_by_lane):
    cell = CELLS[name].make()
    stretch, angle = random_strains(200)
    new, old = respond(cell, stretch, angle), lane_by_lane(cell, stretch, angle)
    size = max(cell.yarn_stiffness_per_width)
    for field, unit in (("force_per_width", size), ("moment", size), ("energy", size), ("unknowns", 1.0)):
        np.testing.assert_allclose(getattr(new, field), getattr(old, field), rtol=1e-9, atol=1e-11 * unit)
    np.testing.assert_allclose(new.crossover_force, old.crossover_force, rtol=1e-9, atol=1e-11 * size)
    # differences across a kink are no derivative
    differ = np.abs(new.tangent - old.tangent).max(axis=(1, 2)) > 1e-6 * size
    assert differ.mean() < 0.02


def sixteen_kernel(law, precision):
    types = lane_types(precision, 16)
    lanes, Unknowns = types.lanes, wp.types.matrix((law.row_count, 16), precision)
    Answer, Cell, solve = (
        cell_answer_struct(precision, 16, law.row_count, law.slope_count),
        law.parameters(precision),
        law.solve,
    )

    @wp.kernel(module="unique", enable_backward=False)
    def sixteen(
        cell: Cell,
        strains: wp.array2d(dtype=lanes),
        start: wp.array(dtype=Unknowns),
        found: wp.array2d(dtype=lanes),
        unknowns: wp.array(dtype=Unknowns),
    ):
        i = wp.tid()
        answer = solve(cell, strains[0, i], strains[1, i], strains[2, i], start[i], Answer())
        found[0, i] = answer.warp_force
        found[1, i] = answer.weft_force
        found[2, i] = answer.moment
        found[3, i] = answer.energy
        found[4, i] = answer.residual
        unknowns[i] = answer.unknowns

    return sixteen


class Sixteen:
    """A cell in sixteen lanes, from rest in one step."""

    def __init__(self, cell, precision="float64"):
        initialise()
        self.cell, self.precision = cell, resolve_precision(precision)
        self.real, self.law = self.precision.real, cell.law()
        self.kernel = sixteen_kernel(self.law, self.real)

    def __call__(self, stretch, angle, start=None):
        """(n_1, n_2, m, energy, residual) of 16 k states, (5, 16 k), and unknowns (rows, 16 k)."""
        count = len(angle) // 16
        lanes, rows = lane_types(self.real, 16).lanes, self.law.row_count
        strains = np.stack([stretch[:, 0] - 1.0, stretch[:, 1] - 1.0, angle]).reshape(3, count, 16)
        given = np.zeros((rows, 16 * count)) if start is None else start
        given = given.reshape(rows, count, 16).transpose(1, 0, 2)
        Unknowns = wp.types.matrix((rows, 16), self.real)
        found = wp.zeros((5, count), dtype=lanes, device="cpu")
        unknowns = wp.zeros(count, dtype=Unknowns, device="cpu")
        kind = self.precision.numpy
        inputs = [
            self.cell.device_parameters(self.precision), wp.array(strains.astype(kind), dtype=lanes, device="cpu"),
            wp.array(np.ascontiguousarray(given).astype(kind), dtype=Unknowns, device="cpu"), found, unknowns,
        ]  # fmt: skip
        wp.launch(self.kernel, dim=count, inputs=inputs, device="cpu")
        return found.numpy().reshape(5, -1), unknowns.numpy().transpose(1, 0, 2).reshape(rows, -1)


@pytest.fixture(scope="module")
def twill():
    return Sixteen(CELLS["twill"].make())


def test_sixteen_lanes_are_sixteen_cells(twill):
    """Against one lane; and the bits of a lane do not depend on what the others have to do."""
    stretch, angle = random_strains(160)
    stretch[::7] = 1.0
    found, unknowns = twill(stretch, angle)
    alone = respond(twill.cell, stretch, angle, increment_count=1)
    size = max(twill.cell.yarn_stiffness_per_width)
    np.testing.assert_allclose(found[:2].T, alone.force_per_width, rtol=1e-9, atol=1e-11 * size)
    np.testing.assert_allclose(unknowns.T, alone.unknowns, rtol=0.0, atol=1e-9)
    assert found[4].max() <= 1e-11
    order = np.random.default_rng(1).permutation(160)
    again, unknowns_again = twill(stretch[order], angle[order])
    assert np.array_equal(again, found[:, order]) and np.array_equal(unknowns_again, unknowns[:, order])


@given(warp=st.floats(0.7, 1.15), weft=st.floats(0.7, 1.15), angle=st.floats(-1.0, 1.0), seed=st.integers(0, 999))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_any_state_and_any_start_reach_equilibrium(twill, warp, weft, angle, seed):
    rng = np.random.default_rng(seed)
    stretch = np.array([[warp, weft]]) + 1e-3 * rng.normal(size=(16, 2))
    start = rng.uniform(-0.3, 0.3, (4, 16))
    start[2:] *= 0.1
    found, unknowns = twill(stretch, np.full(16, angle), start)
    assert np.isfinite(found).all() and np.isfinite(unknowns).all()
    assert found[4].max() <= 1e-11
    for i in range(0, 16, 5):
        energy = CELLS["twill"].reference(twill.cell, stretch[i], angle, unknowns[:, i])
        assert found[3, i] == pytest.approx(energy, rel=1e-9)


def test_single_precision_only_rounds_what_goes_in_and_out():
    cell = CELLS["twill"].make()
    stretch, angle = random_strains(160)
    single, _ = Sixteen(cell, "float32")(stretch, angle)
    rounded = np.float32(stretch - 1.0).astype(float) + 1.0
    exact = respond(cell, rounded, np.float32(angle).astype(float), increment_count=1)
    floor = 1e-3 * max(cell.yarn_stiffness_per_width)
    error = np.abs(single[:2].T - exact.force_per_width) / (np.abs(exact.force_per_width) + floor)
    # a residual within the tolerance, times the ratio of stiffnesses
    assert error.max() < 1e-3 and single[4].max() <= 1e-5


@wp.func
def breaking_energy(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Not a number beyond a warp stretch of 1.05, and beyond a weft stretch of 1.05 as soon as the unknown moves."""
    warp, weft = warp_stretch - real(1.0), weft_stretch - real(1.0)
    pulled = wp.sqrt(real(0.05) - warp) + real(0.5) * warp / wp.sqrt(real(0.05))
    torn = wp.where(weft > real(0.05), wp.sqrt(-q[0] * q[0]), real(0.0))
    return p.thread * (pulled + weft * weft + (q[0] - weft) * (q[0] - weft) + torn)


class BreakingNet(KnottedNet):
    """Its energy is not defined everywhere."""

    unknown_count = 1
    energy = breaking_energy


def test_an_energy_that_is_not_a_number_is_reported_in_its_lane_alone():
    stretch = np.full((16, 2), 1.01)
    stretch[3, 0], stretch[8, 1] = 1.06, 1.06
    found, _ = Sixteen(BreakingNet())(stretch, np.zeros(16))
    broken = ~np.isfinite(found[4]) | (found[4] > 1e-11)
    assert np.flatnonzero(broken).tolist() == [3, 8]
    assert not np.isfinite(found[0, 3])
    assert np.isfinite(np.delete(found, [3, 8], axis=1)).all()


@wp.func
def looped_energy(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """A spring law by repeated halving: a loop whose length depends on the state."""
    warp, weft = warp_stretch - real(1.0), weft_stretch - real(1.0)
    size, steps = wp.abs(warp), real(0.0)
    while size > real(0.01):
        size = real(0.5) * size
        steps = steps + real(1.0)
    return real(0.5) * p.thread * (warp * warp + weft * weft) + real(0.0) * steps


class LoopedNet(EnergyCell):
    """Computed lane by lane: its energy has a loop that no formula has."""

    energy = looped_energy
    depends_on_shear = False

    thread: Positive = 1.0e5

    @property
    def yarn_stiffness_per_width(self):
        return self.thread, self.thread


def test_what_cannot_be_read_is_computed_lane_by_lane_and_said(caplog):
    energy_lanes.energy_law.cache_clear()
    with caplog.at_level(logging.WARNING):
        law = LoopedNet().law()
    assert law.lane_by_lane
    (record,) = [record for record in caplog.records if "lane by lane" in record.message]
    assert "LoopedNet" in record.message and "while" in record.message and "line" in record.message
    stretch, angle = random_strains(32)
    response = respond(LoopedNet(), stretch, angle)
    np.testing.assert_allclose(response.force_per_width, 1.0e5 * (stretch - 1.0), rtol=1e-12)
    np.testing.assert_allclose(response.tangent[:, 0, 0], 1.0e5, rtol=1e-6)


def test_every_built_in_cell_is_in_lanes():
    for name, registered in CELLS.items():
        assert not registered.make().law().lane_by_lane, name


@pytest.mark.skipif(dump_program() is None, reason="nvidia-cuda-cuobjdump is not installed")
@pytest.mark.parametrize("name", ["twill", "stitched-tape"])
def test_one_lane_builds_for_a_gpu(name):
    needs = resources(unit_cell_response_kernel(wp.float32, CELLS[name].make().law()), 90)
    assert 0 < needs.registers <= 255 and needs.stack <= 256


def thrown(name):
    """A small thrown sheet of sixteen elements in one block, with a cell of that name."""
    velocity = np.random.default_rng(3).normal(scale=0.3, size=(25, 3))
    base = glass_polypropylene()
    shear = base.shear.model_copy(update={"locking_stiffness": 0.0})
    fabric = base.model_copy(update={"unit_cell": CELLS[name].make(), "shear": shear})
    return small_run(
        lane_count=16, duration=1.0, initial_velocity=velocity, fabric=fabric,
        dynamics=Dynamics(gravity=(0.0, 0.0, 0.0)),
    )  # fmt: skip


def formulas_of(cell):
    fields = tuple((field, np.size(value)) for field, value in cell.parameters().items())
    functions = {label: function for label, function in cell.functions().items() if function is not None}
    return cell_formulas(fields, cell.unknown_count, CellFunctions(**functions))


@pytest.mark.parametrize("name", ["twill", "user's net"])
def test_the_next_start_follows_the_strains(name):
    """What a step leaves for the next start: the derivatives of the unknowns in equilibrium by the strains."""
    simulation, small = thrown(name), 1e-8
    cell = CELLS[name].make()
    simulation.stepper.advance(20)
    sheet = simulation.state.sheet
    report = dict(zip(CellReportRow.names(), sheet.cell_report.numpy()[:, :16], strict=True))
    strain = np.array([report["warp_strain"], report["weft_strain"]]).T
    # the angle is kept for those that depend on it
    angle = report["shear_angle"]
    unknowns, slopes = np.split(sheet.cell_unknowns.numpy()[:, :16], [cell.unknown_count])

    def in_equilibrium(change):
        found = respond(cell, 1.0 + strain + change[:2], angle + change[2], increment_count=1, start=unknowns.T)
        return found.unknowns.T

    followed = tuple(formulas_of(cell).follow)
    assert len(slopes) == len(followed) == cell.law().slope_count
    for row, (unknown, number) in zip(slopes, followed, strict=True):
        change = small * np.eye(3)[number]
        exact = (in_equilibrium(change)[unknown] - in_equilibrium(-change)[unknown]) / (2.0 * small)
        np.testing.assert_allclose(row, exact, rtol=1e-3, atol=1e-3)
    assert np.abs(slopes).max() > 0.1
    # the next step starts there
    ahead = simulation.stepper.look_ahead().sheets[0].cell_report.numpy()[:, :16]
    report = dict(zip(CellReportRow.names(), ahead, strict=True))
    strain = np.array([report["warp_strain"], report["weft_strain"]]).T
    from_last = respond(cell, 1.0 + strain, report["shear_angle"], increment_count=1, start=unknowns.T).iterations
    assert report["iterations"].sum() < from_last.sum()


def test_a_change_as_large_as_a_snap_is_not_followed():
    """Neither is what is not a number; and the other lanes are."""
    law = CELLS["user's net"].make().law()
    lanes, kinds = lane_types(wp.float64, 16).lanes, {"dtype": wp.float64}
    Slopes = wp.types.matrix((law.slope_count, 16), **kinds)
    Unknowns, follow = wp.types.matrix((law.row_count, 16), **kinds), law.follow
    Cell = law.parameters(wp.float64)

    @wp.kernel(module="unique", enable_backward=False)
    def start(cell: Cell, change: lanes, slopes: Slopes, last: Unknowns, found: wp.array(dtype=Unknowns)):
        found[0] = follow(cell, change, change, change, slopes, last)

    change = np.full(16, 1e-3)
    change[3], change[5] = 0.2, np.nan
    last = np.arange(16.0 * law.row_count).reshape(law.row_count, 16)
    found = wp.zeros(1, dtype=Unknowns, device="cpu")
    slopes = np.ones((law.slope_count, 16))
    wp.launch(
        start,
        dim=1,
        inputs=[Cell(), lanes(*change), Slopes(*slopes.ravel()), Unknowns(*last.ravel()), found],
        device="cpu",
    )
    moved = found.numpy()[0] - last
    still = np.isin(np.arange(16), (3, 5))
    assert np.all(moved[:, still] == 0.0) and np.all(moved[:, ~still] > 0.0)
