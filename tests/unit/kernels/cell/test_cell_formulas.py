"""Formulas of every built-in cell against differences in double precision, and against matrices by NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.registered_cells import CELLS
from weavesim.fabric.cell import EnergyCell
from weavesim.fabric.cell.contract import by_component
from weavesim.kernels.cell.cell_formulas import STRAIN_COUNT, cell_formulas, newton_names, state_names
from weavesim.kernels.cell.energy_cell import CellFunctions
from weavesim.kernels.formula.graph import evaluated

NAMES = [name for name, registered in CELLS.items() if isinstance(registered.make(), EnergyCell)]
FLOOR = 1e3
SETTINGS = {"force_floor": FLOOR, "tolerance": 1e-11, "resolution": 1e-9}


@pytest.fixture(scope="module")
def made():
    """Each cell with its formulas, once."""
    found = {}
    for name in NAMES:
        cell = CELLS[name].make()
        fields = [(field, np.size(value)) for field, value in cell.parameters().items()]
        functions = {label: function for label, function in cell.functions().items() if function is not None}
        found[name] = cell, cell_formulas(fields, cell.unknown_count, CellFunctions(**functions))
    return found


def values(cell, formulas, outputs, state, **others):
    """Of some outputs at a state (strains, unknowns, and other values by name, else 0), as an array."""
    names = (*state_names(cell.unknown_count), *newton_names(cell.unknown_count))
    symbols = by_component(cell.parameters()) | SETTINGS | dict.fromkeys(names, 0.0) | {"active": 1.0}
    symbols |= dict(zip(names, state, strict=False)) | others
    return np.array([float(value) for value in evaluated(outputs, symbols)])


def slopes(cell, formulas, state):
    return values(cell, formulas, formulas.slopes, state)


def answers(cell, formulas, state, **others):
    """What an evaluation tells, by name."""
    found = values(cell, formulas, list(formulas.evaluation.values()), state, **others)
    return dict(zip(formulas.evaluation, found, strict=True))


def iterated(cell, formulas, state, **others):
    """Answers and state after an iteration by name."""
    told = answers(cell, formulas, state, **others)
    after = values(cell, formulas, list(formulas.advance.values()), state, **others | told)
    return told | dict(zip(formulas.advance, after, strict=True))


def unknowns_in(rows, kind="unknown"):
    return np.array([value for name, value in rows.items() if name.startswith(kind)])


def differences(function, state, change):
    columns = []
    for k in range(len(state)):
        ends = [function(state + sign * change * np.eye(len(state))[k]) for sign in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * change))
    return np.array(columns).T


def random_state(cell, seed):
    """Strains, and unknowns that need not be in equilibrium."""
    rng = np.random.default_rng(seed)
    strains = [*rng.uniform(-0.1, 0.08, 2), rng.uniform(-0.9, 0.9)]
    return np.array([*strains, *rng.uniform(-0.1, 0.1, cell.unknown_count)])


@pytest.mark.parametrize("name", NAMES)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_derivatives_are_those_of_the_energy(made, name, seed):
    cell, formulas = made[name]
    state = random_state(cell, seed)
    size = max(cell.yarn_stiffness_per_width)
    numerical = differences(lambda x: values(cell, formulas, [formulas.evaluation["energy"]], x), state, 1e-6)[0]
    np.testing.assert_allclose(slopes(cell, formulas, state), numerical, rtol=1e-6, atol=1e-7 * size)
    wanted = CELLS[name].reference(cell, 1.0 + state[:2], state[2], state[3:])
    told = answers(cell, formulas, state)
    assert told["energy"] == pytest.approx(wanted, rel=1e-12)
    forces = [told[name] for name in ("warp_force", "weft_force", "moment")]
    assert np.array_equal(forces, slopes(cell, formulas, state)[:STRAIN_COUNT])
    assert values(cell, formulas, formulas.parts, state).sum() == pytest.approx(wanted, rel=1e-12)


def matrices(cell, formulas, state, shift=0.0):
    """Second derivatives by differences, and those of the unknowns with a shift."""
    hessian = differences(lambda x: slopes(cell, formulas, x), state, 1e-7)
    inner = hessian[STRAIN_COUNT:, STRAIN_COUNT:]
    return hessian, inner + shift * np.diag(np.abs(np.diag(inner)))


@pytest.mark.parametrize("name", NAMES)
@given(seed=st.integers(0, 2**32 - 1), shift=st.sampled_from([0.0, 0.004]))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_newtons_step_and_the_condensed_tangent(made, name, seed, shift):
    """Where the matrix of the unknowns is positive definite; else the cell waits for a shift."""
    cell, formulas = made[name]
    state, n, size = random_state(cell, seed), cell.unknown_count, max(cell.yarn_stiffness_per_width)
    hessian, inner = matrices(cell, formulas, state, shift)
    if n and np.any(np.diag(inner) == 0.0):
        return
    *tangent, definite = values(cell, formulas, formulas.tangent, state, shift=shift)
    eigenvalues = np.linalg.eigvalsh(0.5 * (inner + inner.T)) if n else np.ones(1)
    if abs(eigenvalues).min() > 1e-4 * FLOOR:
        assert definite == float(eigenvalues.min() > 0.0)
    after = iterated(cell, formulas, state, shift=shift)
    moved = unknowns_in(after) - state[STRAIN_COUNT:]
    if definite == 0.0:
        assert np.all(moved == 0.0) and after["shift"] == max(2.0 * shift, 1e-3) and after["active"] == 1.0
        return
    if n:
        follow = np.zeros((n, STRAIN_COUNT))
        told = answers(cell, formulas, state)
        for place, value in zip(
            formulas.follow, values(cell, formulas, [*formulas.follow.values()], state, **told), strict=True
        ):
            follow[place] = value
        if shift == 0.0:
            exact = -np.linalg.solve(inner, hessian[STRAIN_COUNT:, :STRAIN_COUNT])
            np.testing.assert_allclose(follow, exact, rtol=1e-4, atol=1e-5 * (1.0 + np.abs(exact).max()))
        step = np.linalg.solve(inner, -slopes(cell, formulas, state)[STRAIN_COUNT:])
        step *= 0.25 / max(0.25, np.abs(step).max())
        np.testing.assert_allclose(moved, step, rtol=1e-4, atol=1e-6)
        np.testing.assert_allclose(unknowns_in(after, "change"), moved, rtol=1e-9, atol=1e-15)
        assert after["slope"] == pytest.approx(moved @ slopes(cell, formulas, state)[STRAIN_COUNT:], rel=1e-9)
        assert after["shift"] == shift / 4 and after["iterations"] == after["active"] == 1.0
    mixed = hessian[:STRAIN_COUNT, STRAIN_COUNT:]
    condensed = hessian[:STRAIN_COUNT, :STRAIN_COUNT] - (mixed @ np.linalg.solve(inner, mixed.T) if n else 0.0)
    entries = [condensed[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    np.testing.assert_allclose(tangent, entries, rtol=1e-4, atol=1e-5 * size)


@pytest.mark.parametrize("name", ["twill", "user's net"])
def test_a_step_that_overshoots_is_partly_undone(made, name):
    """By a Newton step along it; what is left of it has its share of the slope."""
    cell, formulas = made[name]
    state = random_state(cell, 3)
    force = slopes(cell, formulas, state)[STRAIN_COUNT:]
    _, inner = matrices(cell, formulas, state)
    change = 1e-3 * force / np.abs(force).max()
    rise = force @ change
    last = {f"change{k}": value for k, value in enumerate(change)}
    after = iterated(cell, formulas, state, slope=-1.5 * rise, before=1e9, **last)
    share = np.clip(rise / (change @ inner @ change), 1 / 16, 15 / 16)
    np.testing.assert_allclose(unknowns_in(after), state[STRAIN_COUNT:] - share * change, rtol=1e-9)
    np.testing.assert_allclose(unknowns_in(after, "change"), (1 - share) * change, rtol=1e-5)
    assert after["slope"] == pytest.approx(-1.5 * (1 - share) * rise, rel=1e-5) and after["before"] == 1e9
    # a slope that has lost half its size has not overshot
    kept = iterated(cell, formulas, state, slope=-2.5 * rise, before=1e9, **last)
    assert np.abs(unknowns_in(kept) - unknowns_in(after)).max() > 1e-6


def test_a_long_step_is_undone_where_the_energy_has_grown(made):
    cell, formulas = made["twill"]
    state = random_state(cell, 3)
    last = {f"change{k}": 0.01 for k in range(4)}
    energy = answers(cell, formulas, state)["energy"]
    far, near = (iterated(cell, formulas, state, slope=-1e9, before=energy * grown, **last) for grown in (0.9, 1.1))
    assert near["before"] == pytest.approx(energy) and far["before"] == pytest.approx(0.9 * energy)


def test_a_lane_in_equilibrium_is_held(made):
    cell, formulas = made["twill"]
    rest = np.zeros(STRAIN_COUNT + 4)
    after = iterated(cell, formulas, rest, iterations=3.0)
    assert after["active"] == 0.0 and after["iterations"] == 3.0 and np.all(unknowns_in(after) == 0.0)
    state = random_state(cell, 1)
    waiting = iterated(cell, formulas, state, active=0.0)
    assert waiting["active"] == 0.0 and np.array_equal(unknowns_in(waiting), state[STRAIN_COUNT:])


def test_residual_is_the_largest_force_over_what_it_is_compared_with(made):
    cell, formulas = made["twill"]
    state = random_state(cell, 2)
    slope = slopes(cell, formulas, state)
    _, inner = matrices(cell, formulas, state)
    stiffest = (np.abs(np.diag(inner)) * (1.0 + np.abs(state[STRAIN_COUNT:]))).max()
    for resolution in (1e-9, 1.0):
        size = np.abs(slope[:STRAIN_COUNT]).sum() + FLOOR + resolution * stiffest
        wanted = np.abs(slope[STRAIN_COUNT:]).max() / size
        found = answers(cell, formulas, state, resolution=resolution)["residual"]
        assert found == pytest.approx(wanted, rel=1e-6)


def test_an_unknown_without_stiffness_gets_one(made):
    """The strains of floats of no length."""
    cell, formulas = made["plain weave as floats of no length"]
    after = iterated(cell, formulas, np.array([0.01, 0.0, 0.0, -0.02, 0.02, 0.0, 0.0]))
    assert np.isfinite(list(after.values())).all()
    assert np.all(unknowns_in(after)[2:] == 0.0) and np.all(unknowns_in(after)[:2] != [-0.02, 0.02])


def test_a_gradient_by_hand_is_used(made):
    cell, formulas = made["linear-membrane"]
    c11, c12, c22, *others = values(cell, formulas, formulas.tangent, np.zeros(3))
    assert (c11, c12, c22) == (cell.warp_stiffness, cell.coupling_stiffness, cell.weft_stiffness)
    assert others == [0.0, 0.0, 0.0, 1.0]
