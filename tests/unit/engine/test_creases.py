"""Interior edges, creases and their lists, against NumPy, and what a flat sheet does about them."""

import numpy as np
import pytest

from tests.support.folded_strips import fold_blank
from tests.support.stacked_plies import FABRIC, THICKNESS
from weavesim import SelfContact, Setup, Sheet, Simulation, Solver
from weavesim.engine.creases.crease_model import free_edges, goes_on, interior_edges
from weavesim.engine.plies.connectivity import TURNING_OF_EDGES
from weavesim.kernels.creases.pair_rows import CreaseCount
from weavesim.kernels.creases.search import LEAST_TURN, WHOLE_TURN
from weavesim.run.diagnosis import find_failure
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

SIZE = 1.5 * THICKNESS


def searched(blank):
    """A run of a sheet that may touch itself, after a block of steps and its search."""
    sheet = Sheet(blank, FABRIC, name="sheet", self_contact=SelfContact())
    solver = Solver(precision="float64", threads=1)
    run = Simulation(Setup("creases", sheets=(sheet,), duration=1.0, accept_unusual=True, solver=solver))
    run.stepper.start()
    run.stepper.advance(1)
    return run


def test_edges_have_their_facets_on_either_side():
    blank = Blank.rectangle((0.0, 0.0), (3.0, 2.0), 1.0)
    nodes, at = interior_edges(blank.quads, blank.material_coordinates), blank.material_coordinates
    assert len(nodes) == 2 * 2 + 3 * 1  # across the length, and along it
    assert len({tuple(sorted(pair)) for pair in nodes[:, :2].tolist()}) == len(nodes)
    along = at[nodes[:, 1]] - at[nodes[:, 0]]
    for first, second in ((2, 3), (4, 5)):
        # beside each end lies a node of the facet, and these two are as far apart as the ends
        np.testing.assert_allclose(at[nodes[:, second]] - at[nodes[:, first]], along)
    one, other = (at[nodes[:, k]] - at[nodes[:, 0]] for k in (2, 4))
    np.testing.assert_allclose(one, -other)


def test_free_edges_come_first_and_go_on_where_they_are_straight():
    blank, plane = Blank.rectangle((0.0, 0.0), (3.0, 2.0), 1.0), Symmetry(planes=("x",))
    for symmetry, count, straight in ((Symmetry(), 10, 6), (plane, 8, 5)):
        free, at = free_edges(blank, symmetry), blank.material_coordinates
        assert len(free) == count
        np.testing.assert_array_equal(free[:, 4:], free[:, :2])
        along, beside = (at[free[:, k + 1]] - at[free[:, k]] for k in (0, 2))
        # the two other nodes lie beside the ends in the same order, two edges farther around the element
        np.testing.assert_allclose(at[free[:, 3]] - at[free[:, 2]], along)
        assert np.abs(beside).sum() > 0.0
        on = at[np.flatnonzero(goes_on(free[:, :2], at))]
        corners = {(x, y) for x in (0.0, 3.0) for y in (0.0, 2.0)}
        assert len(on) == straight and not corners & set(map(tuple, on.tolist()))


def test_a_flat_sheet_has_no_creases():
    """Nor pairs of its free edges, which are not looked at once nothing is near."""
    run = searched(Blank.rectangle((0.0, 0.0), (6.0 * SIZE, 4.0 * SIZE), SIZE))
    run.stepper.advance(40)
    (own,), (model,) = run.state.creases, run.model.creases
    assert not own.number.numpy().any() and not own.count.numpy().any()
    weight = own.weight.numpy()
    assert (weight[: model.free_count] == 1.0).all() and not weight[model.free_count :].any()


def test_creases_are_listed_with_those_that_are_near():
    """A strip in a sharp zigzag, against all pairs of edges."""
    blank = fold_blank(SIZE, 6.0 * SIZE, 1.2 * THICKNESS, 4)
    run = searched(blank)
    (own,), (model,), frame = run.state.creases, run.model.creases, run.frame.sheets[0]
    x = frame.position[model.nodes].astype(float)
    along = x[:, 1] - x[:, 0]

    def into(place):
        across = x[:, place] + x[:, place + 1] - x[:, 0] - x[:, 1]
        across -= ((across * along).sum(axis=1) / (along**2).sum(axis=1))[:, None] * along
        # none beyond a free edge
        return across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)

    turn = np.arccos(np.clip(-(into(2) * into(4)).sum(axis=1), -1.0, 1.0))
    share = (turn - float(LEAST_TURN)) / (float(WHOLE_TURN) - float(LEAST_TURN))
    np.testing.assert_allclose(own.weight.numpy(), np.clip(share, 0.0, 1.0), atol=1e-9)
    count = own.number.numpy()[CreaseCount.creases]
    sharp = np.flatnonzero(share > 0.0)
    assert count == len(sharp) > 8
    np.testing.assert_array_equal(own.crease.numpy()[:count], sharp)
    flat = blank.material_coordinates[model.nodes[:, :2]]
    share = np.linspace(0.0, 1.0, 21)[:, None, None]
    points, places = (share * (v[:, 1] - v[:, 0]) + v[:, 0] for v in (x, flat))

    def nearest(values, edge, other):
        return np.linalg.norm(values[:, None, edge] - values[None, :, other], axis=-1).min()

    listed = {tuple(pair) for pair in np.column_stack(own.pairs()[:2]).tolist()}
    for edge in sharp:
        for other in sharp[sharp > edge]:
            apart = nearest(places, edge, other)
            if apart < 1.9 * THICKNESS:
                assert (edge, other) not in listed
            elif apart > 2.1 * THICKNESS and nearest(points, edge, other) < THICKNESS:
                assert (edge, other) in listed


@pytest.mark.parametrize("name", ["partner", "rows", "works", "first", "count"])
def test_the_state_carries_what_has_memory(name):
    run = searched(Blank.rectangle((0.0, 0.0), (6.0 * SIZE, 4.0 * SIZE), SIZE))
    assert f"creases/0/{name}" in run.state.content()


def test_no_pair_is_listed_where_there_is_no_room_for_all(monkeypatch):
    """Not some of which one edge alone knows: momentum is kept, and the run ends with the reason."""
    room = {"ENTRIES_PER_EDGE": 1, "EDGES_OF_SMALL_SHEETS": 8, "ENTRIES_PER_EDGE_OF_LARGE_SHEETS": 0}
    for name, count in room.items():
        monkeypatch.setattr(f"weavesim.engine.creases.crease_model.{name}", count)
    run = searched(fold_blank(SIZE, 6.0 * SIZE, 1.2 * THICKNESS, 4))
    (own,) = run.state.creases
    number = dict(zip(CreaseCount.names(), own.number.numpy().tolist(), strict=True))
    assert number["creases"] > 1 and number["pairs"] == 0 and number["late"] == 1
    assert not own.count.numpy().any()
    failure = find_failure(run.model, run.state, run.frame)
    assert (
        failure is not None and "more edges of creases came near to each other than there is room for" in failure.text
    )


def test_a_sheet_at_rest_is_not_looked_at_again_until_it_could_have_creased():
    """The way that is left is that to 20 degrees; a sheet with creases is looked at every time."""
    flat, folded = (
        searched(Blank.rectangle((0.0, 0.0), (6.0 * SIZE, 4.0 * SIZE), SIZE)),
        searched(fold_blank(SIZE, 6.0 * SIZE, 1.2 * THICKNESS, 4)),
    )
    left = float(flat.state.creases[0].quiet.numpy()[0])
    assert left == pytest.approx(float(LEAST_TURN) * SIZE / TURNING_OF_EDGES, rel=1e-3)
    assert float(folded.state.creases[0].quiet.numpy()[0]) <= 0.0
