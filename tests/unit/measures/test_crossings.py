"""Where a sheet passes through itself, against an exhaustive test of every pair by linear programming."""

import numpy as np
import pytest
from scipy.optimize import linprog

from weavesim.measures.crossings import Crossings, CrossingsBetween, _crosses
from weavesim.sheet.blank import Blank


def triangles_of(quads: np.ndarray) -> np.ndarray:
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def meet(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether there is a point that is a mean of the corners of both triangles: independent of any geometry."""
    scale = np.abs(np.concatenate([first, second])).max()
    equations = np.vstack([np.hstack([first.T, -second.T]) / scale, [[1, 1, 1, 0, 0, 0], [0, 0, 0, 1, 1, 1]]])
    return linprog(np.zeros(6), A_eq=equations, b_eq=[0, 0, 0, 1, 1], bounds=(0, 1)).status == 0


def meet_elsewhere(first: np.ndarray, second: np.ndarray, at: np.ndarray) -> bool:
    """Whether triangles with the corner ``at`` in common meet at a distance from it: near it, shrink both away."""
    away = [corners + 1e-4 * (corners.mean(axis=0) - at) for corners in (first, second)]
    return meet(*away)


def exhaustive(position: np.ndarray, quads: np.ndarray) -> set[tuple[int, int]]:
    """All pairs without a common node that meet."""
    triangles = triangles_of(quads)
    found = set()
    for a in range(len(triangles)):
        for b in range(a + 1, len(triangles)):
            p, q = position[triangles[a]], position[triangles[b]]
            boxes = (p.min(axis=0) <= q.max(axis=0)).all() and (q.min(axis=0) <= p.max(axis=0)).all()
            if boxes and not set(triangles[a]) & set(triangles[b]) and meet(p, q):
                found.add((a, b))
    return found


def pairs_of(position: np.ndarray, quads: np.ndarray) -> set[tuple[int, int]]:
    pairs = np.sort(Crossings(quads, len(position)).pairs(position), axis=1)
    return set(map(tuple, pairs.tolist()))


def apart(pairs: set[tuple[int, int]], quads: np.ndarray) -> set[tuple[int, int]]:
    """Those without a common node."""
    triangles = triangles_of(quads)
    return {(a, b) for a, b in pairs if not set(triangles[a]) & set(triangles[b])}


BLANK = Blank.rectangle((0.0, 0.0), (0.06, 0.03), 0.005)
X, Y = BLANK.node_position[:, :2].T


def crumpled(seed: int) -> np.ndarray:
    """Nodes moved by up to an element in any direction."""
    return BLANK.node_position + np.random.default_rng(seed).uniform(-1.0, 1.0, BLANK.node_position.shape) * 0.005


def rolled(radius: float, pitch: float) -> np.ndarray:
    """A spiral: without pitch its turns cross where they overlap."""
    angle = X / radius
    own = radius + pitch * angle
    return np.column_stack([own * np.sin(angle), Y, own * (1.0 - np.cos(angle))])


def loop() -> np.ndarray:
    """A loop whose ends cross at an angle."""
    angle = 1.7 * np.pi * (X / 0.06 - 0.5)
    return np.column_stack([0.012 * np.sin(angle) * np.cos(0.6 * angle), Y + 0.1 * X, 0.012 * np.cos(angle)])


def hairpin(gap: float) -> np.ndarray:
    """Folded back at the middle, the upper half ``gap`` above the lower."""
    back = X > 0.03
    return np.column_stack([np.where(back, 0.06 - X, X), Y, np.where(back, gap, 0.0)])


@pytest.mark.parametrize("seed", range(3))
def test_a_crumpled_sheet_is_counted_as_by_linear_programming(seed):
    position = crumpled(seed)
    found = pairs_of(position, BLANK.quads)
    wanted = exhaustive(position, BLANK.quads)
    assert len(wanted) > 10
    assert apart(found, BLANK.quads) == wanted


@pytest.mark.parametrize("position", [rolled(0.008, 0.0008), rolled(0.007, -0.0002), loop()], ids=["a", "b", "c"])
def test_sheets_that_cross_smoothly_are_counted_so_too(position):
    assert apart(pairs_of(position, BLANK.quads), BLANK.quads) == exhaustive(position, BLANK.quads)


def test_triangles_with_one_common_node_count_where_they_meet_elsewhere():
    """Of every pair around every node of a crumpled sheet."""
    for seed in range(2):
        position = crumpled(seed)
        found, triangles = pairs_of(position, BLANK.quads), triangles_of(BLANK.quads)
        wanted = set()
        for a in range(len(triangles)):
            for b in range(a + 1, len(triangles)):
                common = list(set(triangles[a]) & set(triangles[b]))
                if len(common) != 1 or a // 2 == b // 2:
                    continue
                if meet_elsewhere(position[triangles[a]], position[triangles[b]], position[common[0]]):
                    wanted.add((a, b))
        touching = {(a, b) for a, b in found if set(triangles[a]) & set(triangles[b])}
        assert touching == wanted and len(wanted) > 3


@pytest.mark.parametrize("gap", [1.0e-3, 1.0e-6, -1.0e-6])
def test_halves_that_do_not_touch_are_not_counted(gap):
    position = hairpin(gap)
    assert apart(pairs_of(position, BLANK.quads), BLANK.quads) == set() == exhaustive(position, BLANK.quads)


def test_halves_in_one_plane_are_counted():
    """They lie on each other; those that only touch at a corner may count or not, by rounding."""
    position = hairpin(0.0)
    found, touching = apart(pairs_of(position, BLANK.quads), BLANK.quads), exhaustive(position, BLANK.quads)
    triangles = triangles_of(BLANK.quads)

    def smaller(triangle: int) -> np.ndarray:
        corners = position[triangles[triangle]]
        return corners + 1e-3 * (corners.mean(axis=0) - corners)

    overlapping = {(a, b) for a, b in touching if meet(smaller(a), smaller(b))}
    assert overlapping <= found <= touching and len(overlapping) > 50


def test_a_flat_and_a_domed_sheet_have_none():
    assert pairs_of(BLANK.node_position, BLANK.quads) == set()
    domed = np.column_stack([X, Y, 0.05 * np.exp(-(((X - 0.03) ** 2 + (Y - 0.015) ** 2) / 1e-4))])
    assert pairs_of(domed, BLANK.quads) == set()


def test_two_sheets_that_cross_are_counted_along_the_line():
    """A sheet stands on edge in another one, 30 mm long and off its lines: every element that is cut is found."""
    lower = Blank.rectangle((0.0, 0.0), (0.03, 0.03), 0.005)
    upper = lower.node_position[:, [2, 1, 0]] + (0.0125, 0.0, -0.0123)
    position = np.concatenate([lower.node_position, upper])
    quads = np.concatenate([lower.quads, lower.quads + lower.node_count])
    found = pairs_of(position, quads)
    assert found == exhaustive(position, quads)
    assert len({a // 2 for a, _ in found}) == 6


def test_one_huge_element_is_compared_with_all():
    position = BLANK.node_position.copy()
    position[0] = (0.05, 0.02, 0.01)
    assert apart(pairs_of(position, BLANK.quads), BLANK.quads) == exhaustive(position, BLANK.quads)


def test_a_landscape_needs_no_search_and_is_one_only_if_its_border_is_simple():
    """A strip that winds like a spiral stair faces one way everywhere, and its border crosses itself in the plan."""
    crossings = Crossings(BLANK.quads, BLANK.node_count)
    hill = np.column_stack([X, Y, 0.01 * np.sin(150.0 * X) * np.cos(90.0 * Y)])
    assert crossings._has_a_plan(BLANK.node_position) and crossings._has_a_plan(hill)
    angle = 3.0 * np.pi * X / 0.06
    stair = np.column_stack([(0.005 + Y) * np.cos(angle), (0.005 + Y) * np.sin(angle), 0.0 * X])
    up = stair + np.column_stack([0.0 * X, 0.0 * X, 0.02 * angle])
    assert not crossings._has_a_plan(stair) and not crossings._has_a_plan(up)
    assert pairs_of(up, BLANK.quads) == set() != pairs_of(stair, BLANK.quads)
    for seed in range(3):
        position = crumpled(seed)
        assert not crossings._has_a_plan(position)


@pytest.mark.parametrize("seed", range(20))
def test_edges_of_a_border_cross_where_a_linear_programme_says_so(seed):
    """Random edges in the plan, some with a common node, in several rows at once."""
    rng = np.random.default_rng(seed)
    place, nodes = rng.uniform(0.0, 1.0, (12, 2)), rng.permutation(12).reshape(6, 2)
    if seed % 2:
        nodes[1, 0], place[nodes[2, 0]] = nodes[0, 0], 0.5 * place[nodes[3]].sum(axis=0)  # a common node, and a touch
    start, end = place[nodes[:, 0]], place[nodes[:, 1]]

    def cross(a: int, b: int) -> bool:
        if set(nodes[a]) & set(nodes[b]):
            return False
        equations = np.column_stack([end[a] - start[a], start[b] - end[b]])
        return linprog(np.zeros(2), A_eq=equations, b_eq=start[b] - start[a], bounds=(-1e-12, 1 + 1e-12)).status == 0

    for rows in (slice(0, 3), slice(3, 6)):
        wanted = any(cross(a, b) for a in range(6)[rows] for b in range(6))
        assert _crosses(start, end, nodes, rows) == wanted


def between(*sheets: tuple[np.ndarray, np.ndarray]) -> set[tuple[int, int, int, int]]:
    """Pairs that meet among sheets (positions, quads)."""
    pairs = CrossingsBetween([quads for _, quads in sheets]).pairs([position for position, _ in sheets])
    return set(map(tuple, pairs.tolist()))


def exhaustive_between(*sheets: tuple[np.ndarray, np.ndarray]) -> set[tuple[int, int, int, int]]:
    """The same by linear programming, every pair of triangles."""
    corners = [position[triangles_of(quads)] for position, quads in sheets]
    return {
        (a, i, b, j)
        for a in range(len(sheets))
        for b in range(a + 1, len(sheets))
        for i, p in enumerate(corners[a])
        for j, q in enumerate(corners[b])
        if (p.min(axis=0) <= q.max(axis=0)).all() and (q.min(axis=0) <= p.max(axis=0)).all() and meet(p, q)
    }


def test_sheets_of_different_meshes_that_cross_are_counted_as_by_linear_programming():
    """A wavy sheet, one through its waves, and one on edge; none of their meshes match."""
    wavy = np.column_stack([X, Y, 0.004 * np.sin(200.0 * X)])
    other = Blank.fitted(
        np.array([(0.005, 0.002), (0.05, 0.002), (0.05, 0.028), (0.005, 0.028)]), 0.006, mesh_angle=30.0
    )
    inclined = other.node_position + other.node_position[:, :1] * (0.0, 0.0, 0.05)
    edgewise = Blank.rectangle((-0.01, 0.0), (0.01, 0.03), 0.007)
    upright = edgewise.node_position[:, [2, 1, 0]] + (0.0311, 0.0, 0.0007)
    sheets = (wavy, BLANK.quads), (inclined, other.quads), (upright, edgewise.quads)
    found, wanted = between(*sheets), exhaustive_between(*sheets)
    assert found == wanted
    assert {(a, b) for a, _, b, _ in found} == {(0, 1), (0, 2), (1, 2)} and len(found) > 60


@pytest.mark.parametrize("gap", [1.0e-3, 1.0e-9, -1.0e-9])
def test_plies_that_lie_on_each_other_do_not_cross(gap):
    domed = np.column_stack([X, Y, 0.05 * np.exp(-(((X - 0.03) ** 2 + (Y - 0.015) ** 2) / 1e-4))])
    assert between((domed, BLANK.quads), (domed + (0.0, 0.0, gap), BLANK.quads)) == set()


def test_a_node_that_is_pushed_through_is_found():
    """By a millionth of the element."""
    upper = BLANK.node_position + (0.0021, 0.0012, 1.0e-3)
    middle = int(np.argmin(np.linalg.norm(BLANK.node_position - (0.03, 0.015, 0.0), axis=1)))
    upper[middle, 2] = 5.0e-9
    assert between((BLANK.node_position, BLANK.quads), (upper, BLANK.quads)) == set()
    upper[middle, 2] = -5.0e-9
    found = between((BLANK.node_position, BLANK.quads), (upper, BLANK.quads))
    assert found and all(middle in triangles_of(BLANK.quads)[j] for _, _, _, j in found)


def test_neighbours_on_the_flat_blank_can_be_left_out():
    """A wrinkle that closes: its flanks are 4 elements apart on the flat blank, and cross."""
    position = crumpled(0)
    crossings = Crossings(BLANK.quads, len(position))
    pairs, flat = crossings.pairs(position), BLANK.material_coordinates
    triangles = triangles_of(BLANK.quads)

    def gap(a: int, b: int) -> float:
        """Smallest distance of two flat triangles, from points along their edges."""
        share = np.linspace(0.0, 1.0, 41)[:, None]
        p, q = (
            np.concatenate([c[k] + share * (c[(k + 1) % 3] - c[k]) for k in range(3)])
            for c in (flat[triangles[a]], flat[triangles[b]])
        )
        return float(np.linalg.norm(p[:, None] - q, axis=2).min())

    limit = 0.0049
    wanted = {
        (a, b) for a, b in map(tuple, pairs.tolist())
        if not set(triangles[a]) & set(triangles[b]) and gap(a, b) > limit
    }  # fmt: skip
    found = set(map(tuple, crossings.distant(pairs, flat, limit).tolist()))
    assert found == wanted and 0 < len(found) < len(pairs)
    assert len(crossings.distant(pairs, flat, 0.0)) == len(apart(set(map(tuple, np.sort(pairs, axis=1))), BLANK.quads))
