"""Constants, feet and lists of the contact between plies, against independent searches."""

import numpy as np
import pytest

from tests.support.stacked_plies import THICKNESS, ply, square, stack_setup
from weavesim import Plane, Simulation, Tool
from weavesim.engine.model import Model
from weavesim.engine.plies.connectivity import edge_neighbours, free_edge_distance, home_elements, rings
from weavesim.engine.plies.feet import find_feet
from weavesim.engine.plies.groups import compact_groups, groups_that_hang_together, nodes_at_cuts, nodes_of
from weavesim.kernels.pass_entries import PassEntry
from weavesim.kernels.plies.facet import FREE_EDGE, SYMMETRY_EDGE
from weavesim.process import Coulomb
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

BLANK = Blank.rectangle((0.0, 0.0), (0.04, 0.03), 0.01, distortion=0.2)


def test_neighbours_lie_beyond_the_edges_that_they_share():
    neighbours = edge_neighbours(BLANK, Symmetry(("x",)))
    quads = BLANK.quads
    for element in range(BLANK.element_count):
        for edge in range(4):
            nodes = {quads[element, edge], quads[element, (edge + 1) % 4]}
            sharing = [k for k in range(BLANK.element_count) if k != element and nodes <= set(quads[k])]
            if sharing:
                assert neighbours[element, edge] == sharing[0]
            else:
                on_plane = np.all(np.abs(BLANK.node_position[list(nodes), 0]) < 1e-9)
                assert neighbours[element, edge] == int(SYMMETRY_EDGE if on_plane else FREE_EDGE)


def test_rings_hold_all_that_share_a_node():
    quads = BLANK.quads
    for element, ring in enumerate(rings(quads)):
        expected = [k for k in range(len(quads)) if k != element and set(quads[k]) & set(quads[element])]
        assert list(ring[ring >= 0]) == [element, *expected]


def test_every_node_has_an_element_and_a_distance_from_the_edge():
    home = home_elements(BLANK)
    assert all(node in BLANK.quads[element] for node, element in enumerate(home))
    distance = free_edge_distance(BLANK, Symmetry())
    assert np.all(distance[BLANK.boundary_loop()] == 0.0) and distance.max() > 0.009
    assert free_edge_distance(BLANK, Symmetry(("x",))).max() > distance.max()


def test_nodes_near_a_free_edge_of_either_sheet_take_at_least_half_of_the_stiffness():
    """A coarse ply over a smaller fine one: its nodes take little inside, and a half along the fine one's edge."""
    lower, upper = square(0.02, 0.0025), square(0.05, 0.005, THICKNESS)
    run = Simulation(stack_setup([ply("lower", lower), ply("upper", upper)], Coulomb(0.2), duration=1e-4))
    (coarse,) = [each for each in run.model.passes if each.place.slave == 1]
    position = upper.node_position
    share = coarse.stiffness / (coarse.area_stiffness * 0.0025**2)
    middle = np.abs(position[:, :2]).max(axis=1)
    assert share[middle < 0.006] == pytest.approx(1.0 / 17.0)
    assert share[np.abs(middle - 0.02) < 1e-9] == pytest.approx(0.5)
    assert share[np.abs(middle - 0.03) < 0.002].max() < 0.2


def on_facet(feet) -> np.ndarray:
    """Which points stand on the sheet, (n,) bool."""
    return (np.maximum(np.abs(feet.xi), np.abs(feet.eta)) <= 1.0 + 1.0e-6) & (feet.way <= 0.0)


def test_feet_on_a_sphere_stand_at_the_right_height():
    """Known answer A: corners and normals on a sphere, the gap within 0.5 um (10 um with corners moved by 0.25 h)."""
    radius, height = 0.05, 5e-4
    for distortion, allowed in ((0.0, 5e-7), (0.25, 1e-5)):
        flat = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, distortion=distortion)
        position = flat.node_position.copy()
        position[:, 2] = np.sqrt(radius**2 - position[:, 0] ** 2 - position[:, 1] ** 2) - radius
        centre = np.array([0.0, 0.0, -radius])
        normal = (position - centre) / radius
        points = np.random.default_rng(1).uniform(-0.012, 0.012, (200, 3))
        points[:, 2] = np.sqrt((radius + height) ** 2 - points[:, 0] ** 2 - points[:, 1] ** 2) - radius
        feet = find_feet(points, position, normal, flat.quads, 0.001)
        assert on_facet(feet).all()
        assert np.abs(feet.height - height).max() < allowed


def test_points_beside_a_sheet_do_not_stand_on_it():
    feet = find_feet(
        np.array([[0.02, 0.015, 0.001], [-0.02, 0.01, 0.0], [0.02, 0.01, 0.2]]),
        BLANK.node_position, BLANK.initial_director, BLANK.quads, 0.001,
    )  # fmt: skip
    assert on_facet(feet).tolist() == [True, False, False]
    assert feet.height[0] == pytest.approx(0.001) and feet.way[2] > 0.15


def listed_without_search(model, own) -> dict[int, list[int]]:
    """Nodes that are pressed on each facet."""
    standing = own.standing.numpy()[: model.slave.blank.node_count]
    return {int(facet): np.flatnonzero(standing == facet).tolist() for facet in np.unique(standing[standing >= 0])}


@pytest.mark.parametrize("slot_count", [None, 2])
def test_no_pressed_node_is_missing_from_the_lists_while_plies_slide(slot_count, monkeypatch):
    """Also with too few slots, where all nodes are looked through: the same bits."""
    if slot_count:
        monkeypatch.setattr("weavesim.engine.plies.pass_model.SPARE_SLOTS", 0.5)
    sheets = [
        ply("lower", square(0.03, 0.006), pressure=2e4),
        ply("upper", square(0.02, 0.005, THICKNESS, 20.0), (4.0, 1.0, 0.0), pressure=-2e4),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=4e-3, solver={"precision": "float32"}))
    for _ in range(8):
        run.stepper.advance(8)
        for model, own in zip(run.model.passes, run.state.passes, strict=True):
            assert own.entry.numpy()[3] == 0.0  # never late
            listed, count = own.listed.numpy(), own.listed_count.numpy()
            for facet, nodes in listed_without_search(model, own).items():
                assert count[facet] < 0 or set(nodes) <= set(listed[: count[facet], facet])
            if slot_count:
                assert count.min() < 0
    moved = run.state.passes[0].read_rows(run.model.passes[0])
    assert moved["travel"].max() >= 0.0
    _ENDS[slot_count] = [sheet.motion.numpy().tobytes() for sheet in run.state.sheets]
    assert len({tuple(end) for end in _ENDS.values()}) == 1


_ENDS: dict = {}


@pytest.mark.parametrize("pressed", [True, False])
def test_a_node_that_is_taken_out_of_a_list_is_listed_again_and_told_if_it_was_pressed(pressed):
    """By hand, whatever made it missing."""
    height, pressure = (THICKNESS, 2e4) if pressed else (1.2 * THICKNESS, 0.0)
    sheets = [
        ply("lower", square(0.03, 0.006), pressure=pressure),
        ply("upper", square(0.02, 0.005, height, 20.0), pressure=-pressure),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=4e-3))
    run.stepper.advance(4)
    own = run.state.passes[0]
    place = own.standing.numpy() if pressed else own.facet.numpy()
    node = next(k for k in np.argsort(np.abs(sheets[1].blank.node_position).sum(axis=1)) if place[k] >= 0)
    listed, count = own.listed.numpy(), own.listed_count.numpy()
    facet = place[node]
    rest = listed[: count[facet], facet]
    assert node in rest and own.entry.numpy()[PassEntry.late] == 0.0
    listed[: count[facet], facet] = np.append(rest[rest != node], -1)
    count[facet] -= 1
    own.listed.assign(listed)
    own.listed_count.assign(count)
    run.stepper.advance(1)
    facet = own.facet.numpy()[node]
    assert node in own.listed.numpy()[: own.listed_count.numpy()[facet], facet]
    assert own.entry.numpy()[PassEntry.late] == pressed


def test_plies_that_come_from_far_away_meet():
    """Nodes without a foot find one in time, and blocks that slept wake up: a drop from 30 mm does not go through."""
    sheets = [
        ply("lower", square(0.03, 0.01), free=np.zeros((49, 6), dtype=bool)),
        ply("upper", square(0.02, 0.01, 0.03), (0.0, 0.0, -10.0)),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=4.5e-3, dynamics={"contact_damping_ratio": 0.3}))
    own = run.state.passes[0].read_rows(run.model.passes[0])
    assert (own["stray"] > 0.0).all()
    run.run()
    own = run.state.passes[0].read_rows(run.model.passes[0])
    assert run.state.passes[0].entry.numpy()[3] == 0.0
    assert run.frame.sheets[1].position[:, 2].min() > 0.5 * THICKNESS
    assert run.frame.sheets[1].position[:, 2].max() < 0.02 and own["largest_entry"].max() < 0.05 * THICKNESS
    assert run.history[-1]["kinetic"] < run.history[0]["kinetic"]


def test_groups_hold_every_node_once_and_know_their_neighbours():
    nodes = compact_groups(BLANK.material_coordinates, 4)
    facets = compact_groups(BLANK.material_coordinates[BLANK.quads].mean(axis=1), 4)
    assert sorted(nodes[nodes >= 0]) == list(range(BLANK.node_count))
    assert sorted(facets[facets >= 0]) == list(range(BLANK.element_count))
    corners = nodes_of(facets, BLANK.quads)
    flat, nowhere = BLANK.material_coordinates, np.zeros(BLANK.node_count, dtype=bool)
    touching = groups_that_hang_together(nodes, corners, flat, 0.0, nowhere)
    for group, column in enumerate(nodes.T):
        sharing = [k for k, other in enumerate(corners.T) if set(column[column >= 0]) & set(other[other >= 0])]
        assert [k for k in touching[:, group] if k >= 0] == sharing
    # the whole sheet hangs together, but for groups at a cut
    everything = groups_that_hang_together(nodes, corners, flat, 1.0, nowhere)
    assert (everything >= 0).all() and everything.shape == (corners.shape[1], nodes.shape[1])
    cut = nowhere.copy()
    cut[nodes[0, 0]] = True
    assert (groups_that_hang_together(nodes, corners, flat, 1.0, cut)[:, 0] == -1).all()


def test_nodes_of_a_slit_lie_on_each_other():
    flat = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert nodes_at_cuts(flat, np.ones(4, dtype=bool), 1.0).tolist() == [False, True, True, False]
    assert not nodes_at_cuts(flat, np.array([True, True, False, True]), 1.0).any()


def test_an_interface_only_adds_to_the_stable_step_of_sheets_that_meet_tools_between_nodes():
    plies = [ply("lower", square(0.02, 0.005)), ply("upper", square(0.02, 0.005, THICKNESS))]
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.5 * THICKNESS)))
    dynamics = {"contact_samples": "surface", "contact_allowance": 0.02}
    joined = stack_setup(plies, Coulomb(0.2), dynamics=dynamics, tools=(table,), duration=1e-4)
    apart = joined.model_copy(update={"worlds": (joined.worlds[0].model_copy(update={"interfaces": ()}),)})
    for alone, together in zip(Model(apart).sheets, Model(joined).sheets, strict=True):
        assert together.step_bounds.contact_frequency >= alone.step_bounds.contact_frequency > 0.0
        assert together.step_bounds.sample_frequency == alone.step_bounds.sample_frequency > 0.0
