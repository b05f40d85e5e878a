"""Formulas of every built-in cell against differences in double precision, and against matrices by NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.registered_cells import CELLS
from weavesim.fabric.cell import EnergyCell
from weavesim.fabric.cell.contract import by_component
from weavesim.kernels.cell.cell_formulas import STRAIN_COUNT, cell_formulas
from weavesim.kernels.cell.energy_cell import CellFunctions
from weavesim.kernels.formula.graph import evaluated

NAMES = [name for name, registered in CELLS.items() if isinstance(registered.make(), EnergyCell)]
FLOOR = 1e3


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


def values(cell, formulas, outputs, state, shift=0.0):
    """Of some outputs at a state (strains, unknowns), as an array."""
    symbols = by_component(cell.parameters()) | {"force_floor": FLOOR}
    symbols |= dict(zip(formulas.state, (*state, shift), strict=True))
    return np.array([float(value) for value in evaluated(outputs, symbols)])


def slopes(cell, formulas, state):
    return values(cell, formulas, formulas.first, state)[1 : 1 + len(state)]


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
    numerical = differences(lambda x: values(cell, formulas, formulas.first[:1], x), state, 1e-6)[0]
    np.testing.assert_allclose(slopes(cell, formulas, state), numerical, rtol=1e-6, atol=1e-7 * size)
    wanted = CELLS[name].reference(cell, 1.0 + state[:2], state[2], state[3:])
    assert values(cell, formulas, formulas.first[:1], state)[0] == pytest.approx(wanted, rel=1e-12)
    assert values(cell, formulas, formulas.parts, state).sum() == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
@given(seed=st.integers(0, 2**32 - 1), shift=st.sampled_from([0.0, 0.004]))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_newtons_step_and_the_condensed_tangent(made, name, seed, shift):
    """Where the matrix of the unknowns is positive definite; else they must say that it is not."""
    cell, formulas = made[name]
    state, n = random_state(cell, seed), cell.unknown_count
    hessian = differences(lambda x: slopes(cell, formulas, x), state, 1e-7)
    inner = hessian[STRAIN_COUNT:, STRAIN_COUNT:] + shift * np.diag(np.abs(np.diag(hessian)[STRAIN_COUNT:]))
    *tangent, tangent_definite = values(cell, formulas, formulas.tangent, state, shift)
    newton = values(cell, formulas, formulas.newton, state, shift)
    step, definite = newton[1 + len(state) : 1 + len(state) + n], newton[-1]
    idle = n > 0 and np.any(np.diag(inner) == 0.0)
    if not idle:
        eigenvalues = np.linalg.eigvalsh(0.5 * (inner + inner.T)) if n else np.ones(1)
        assert definite == tangent_definite == float(eigenvalues.min() > 0.0) or abs(eigenvalues).min() < 1e-4 * FLOOR
    if definite == 0.0 or idle:
        return
    size = max(cell.yarn_stiffness_per_width)
    np.testing.assert_allclose(inner @ step, slopes(cell, formulas, state)[STRAIN_COUNT:], rtol=1e-5, atol=1e-6 * size)
    mixed = hessian[:STRAIN_COUNT, STRAIN_COUNT:]
    condensed = hessian[:STRAIN_COUNT, :STRAIN_COUNT] - (mixed @ np.linalg.solve(inner, mixed.T) if n else 0.0)
    entries = [condensed[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    np.testing.assert_allclose(tangent, entries, rtol=1e-4, atol=1e-5 * size)


def test_an_unknown_without_stiffness_gets_one(made):
    """The strains of floats of no length."""
    cell, formulas = made["plain weave as floats of no length"]
    newton = values(cell, formulas, formulas.newton, np.array([0.01, 0.0, 0.0, -0.02, 0.02, 0.0, 0.0]))
    assert newton[-1] == 1.0 and np.isfinite(newton).all()
    assert np.all(newton[-4:-2] == 0.0)


def test_a_gradient_by_hand_is_used(made):
    cell, formulas = made["linear-membrane"]
    assert formulas.state == ("strain0", "strain1", "strain2", "shift")
    c11, c12, c22, *others = values(cell, formulas, formulas.tangent, np.zeros(3))
    assert (c11, c12, c22) == (cell.warp_stiffness, cell.coupling_stiffness, cell.weft_stiffness)
    assert others == [0.0, 0.0, 0.0, 1.0]
