"""A blank is one sheet: what a mesh must not be, and nodes that lie at the same place."""

import time

import numpy as np
import pytest

from tests.support.mesh_files import elements_of_deck, nodes_of_deck, obj_text, written
from weavesim.errors import InputError
from weavesim.sheet.blank import Blank
from weavesim.sheet.mesh_checks import close_pairs, merged_nodes

WHOLE = Blank.rectangle((0.0, 0.0), (0.1, 0.08), 0.01)


def seamed(cut: slice = slice(None), gap: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """The rectangle with the nodes of a line across it doubled, all or those of ``cut``."""
    position, quads = WHOLE.node_position, WHOLE.quads.astype(int)
    line = np.flatnonzero(np.isclose(position[:, 0], 0.05))[cut]
    twin = np.arange(len(position))
    twin[line] = len(position) + np.arange(len(line))
    right = position[quads].mean(axis=1)[:, 0] > 0.05
    doubled = np.concatenate([position, position[line] + (gap, 0.0, 0.0)])
    return doubled, np.where(right[:, None], twin[quads], quads)


@pytest.mark.parametrize(
    "cut", [slice(None), slice(0, 4), slice(3, 6), slice(5, None)], ids=["all", "left", "slit", "end"]
)
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-6])
def test_nodes_that_coincide_are_refused_or_merged(cut, gap):
    position, quads = seamed(cut, gap)
    with pytest.raises(InputError, match=r"nodes of its border lie at the same place.*merge_nodes=1e-05"):
        Blank.from_mesh(position, quads)
    merged = Blank.from_mesh(position, quads, merge_nodes=1e-5)
    assert merged.node_count == WHOLE.node_count
    assert np.array_equal(merged.quads, WHOLE.quads) and np.allclose(merged.node_position, WHOLE.node_position)
    count = len(position) - WHOLE.node_count
    assert merged.source_notes == (f"blank mesh: {count} nodes merged with another up to 1e-05 m away",)


def test_a_slit_may_be_meant():
    position, quads = seamed(slice(3, 6))
    blank = Blank.from_mesh(position, quads, merge_nodes=0)
    assert blank.node_count == len(position) and blank.source_notes == ()
    assert Blank.from_json(blank.to_json()) == blank


def test_two_loose_sheets_stay_refused():
    with pytest.raises(InputError, match="2 parts that share no node, of 40, 40 elements.*merge_nodes"):
        Blank.from_mesh(*seamed(), merge_nodes=0)
    with pytest.raises(InputError, match="2 parts that share no node"):
        Blank.from_mesh(*seamed(gap=1e-4))
    assert Blank.from_mesh(*seamed(gap=1e-4), merge_nodes=2e-4).node_count == WHOLE.node_count


def test_every_element_with_its_own_nodes():
    position = WHOLE.node_position[WHOLE.quads].reshape(-1, 3)
    quads = np.arange(len(position)).reshape(-1, 4)
    with pytest.raises(InputError, match="nodes of its border lie at the same place"):
        Blank.from_mesh(position, quads)
    merged = Blank.from_mesh(position, quads, merge_nodes=1e-6, material_coordinates=position[:, :2])
    assert merged.node_count == WHOLE.node_count and merged.element_count == WHOLE.element_count
    assert np.allclose(merged.material_coordinates, merged.node_position[:, :2])


@pytest.mark.parametrize("distance", [-1.0, np.nan, "wide", np.inf])
def test_a_distance_that_is_none(distance):
    with pytest.raises(InputError, match="merge_nodes.*(a distance in metres is needed, or 0|a finite number)"):
        Blank.from_mesh(*seamed(), merge_nodes=distance)


def test_a_distance_beyond_the_elements_is_refused():
    for distance in (0.01, 0.011, 1.0, 1e300):
        with pytest.raises(InputError, match=r"must be below 0.01 m, the shortest edge of an element"):
            Blank.from_mesh(*seamed(), merge_nodes=distance)


@pytest.mark.parametrize("merge", [None, 1e-6])
def test_many_elements_at_one_place_take_no_time(merge):
    """Twenty thousand times the same loose element."""
    quads = np.arange(80_000).reshape(-1, 4)
    position = np.tile(WHOLE.node_position[WHOLE.quads[0]], (20_000, 1))
    started = time.process_time()
    with pytest.raises(InputError, match="more than 64 nodes lie within"):
        Blank.from_mesh(position, quads, merge_nodes=merge)
    assert time.process_time() - started < 5.0


@pytest.mark.parametrize("place", [(0, 0), (5, 4), (8, 6)])
@pytest.mark.parametrize("removed", [[(0, 0), (1, 1)], [(1, 0), (0, 1)]])
def test_elements_that_meet_in_a_corner_are_refused(place, removed):
    """Two elements of a block of four are cut out; the mesh hangs together around them, or nearly."""
    cell = np.rint((WHOLE.element_centres()[:, :2] - 0.005) / 0.01).astype(int)
    out = [np.all(cell == np.add(place, shift), axis=1) for shift in removed]
    quads = WHOLE.quads[~np.any(out, axis=0)]
    used, quads = np.unique(quads, return_inverse=True)
    with pytest.raises(InputError, match="meet only in a corner at 1 node"):
        Blank.from_mesh(WHOLE.node_position[used], quads.reshape(-1, 4))


def test_two_sheets_joined_in_a_corner_are_refused():
    other = WHOLE.node_position + WHOLE.node_position.max(axis=0)
    last = int(np.argmax(WHOLE.node_position.sum(axis=1)))
    first = int(np.argmin(WHOLE.node_position.sum(axis=1)))
    number = np.arange(len(other)) + len(other)
    number[first] = last
    with pytest.raises(InputError, match=f"the first is node {last}: it would be a hinge"):
        quads = np.vstack([WHOLE.quads, number[WHOLE.quads]])
        position = np.vstack([WHOLE.node_position, other])
        used, quads = np.unique(quads, return_inverse=True)
        Blank.from_mesh(position[used], quads.reshape(-1, 4))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda q: np.where(np.arange(len(q))[:, None] == 7, q[:, ::-1], q),
            r"in the same direction \(\d+ and \d+\).*flip",
        ),
        (lambda q: np.vstack([q, q[[3, 5]]]), "2 elements given twice: elements 3 and 80 have the same nodes"),
        (lambda q: np.vstack([q, np.roll(q[3], 1)[::-1]]), "1 element given twice: elements 3 and 80"),
        (lambda q: np.vstack([q, q[[3]][:, [0, 1, 2, 2]]]), r"1 element degenerate, with a repeated node.*element 80"),
    ],
    ids=["flipped", "twice", "twice the other way", "repeated node"],
)
def test_elements_are_named(change, message):
    with pytest.raises(InputError, match=message):
        Blank.from_mesh(WHOLE.node_position, change(WHOLE.quads))


def deck(position, quads, first=1) -> str:
    return (
        "*NODE\n" + nodes_of_deck(1e3 * position, first) + "*ELEMENT, TYPE=S4\n" + elements_of_deck(quads, 1001, first)
    )


@pytest.mark.parametrize(
    ("quads", "message"),
    [
        (np.vstack([WHOLE.quads, WHOLE.quads[[3]]]), "elements 1004 and 1081 have the same nodes"),
        (np.vstack([WHOLE.quads, [[0, 1, 1, 2]]]), r"element 1081 with nodes \[501, 502, 502, 503\]"),
        (np.where(np.arange(80)[:, None] == 7, WHOLE.quads[:, ::-1], WHOLE.quads), r"node 5\d\d to node 5\d\d .*1008"),
    ],
)
def test_messages_have_the_numbers_of_the_file(tmp_path, quads, message):
    path = written(tmp_path, "sheet.inp", deck(WHOLE.node_position, quads, 501))
    with pytest.raises(InputError, match=f"sheet.inp: .*{message}"):
        Blank.from_file(path, unit_scale=0.001)


@pytest.mark.parametrize("cut", [slice(None), slice(2, 5)])
def test_a_seam_in_a_file_is_merged_with_a_word(tmp_path, cut):
    position, quads = seamed(cut)
    for path in (
        written(tmp_path, "sheet.inp", deck(position, quads)),
        written(tmp_path, "sheet.obj", obj_text(1e3 * position, quads.tolist())),
    ):
        with pytest.raises(InputError, match="lie at the same place.*merge_nodes=1e-05"):
            Blank.from_file(path, unit_scale=0.001)
        blank = Blank.from_file(path, unit_scale=0.001, merge_nodes=1e-5)
        assert blank.node_count == WHOLE.node_count
        assert f"{len(position) - WHOLE.node_count} nodes merged" in blank.source_notes[-1]


def test_nodes_are_dropped_with_a_word(tmp_path):
    position = np.vstack([WHOLE.node_position, [(0.0, 0.0, 0.5), (0.0, 0.0, 0.6)]])
    blank = Blank.from_file(written(tmp_path, "sheet.inp", deck(position, WHOLE.quads)), unit_scale=0.001)
    assert blank.node_count == WHOLE.node_count
    assert [note.partition(": ")[2] for note in blank.source_notes] == ["2 nodes left out: no element uses them"]


@pytest.mark.parametrize("seed", range(3))
def test_close_pairs_are_those_of_all_pairs(seed):
    random = np.random.default_rng(seed)
    position = random.random((300, 3)) * (1.0, 1.0, 0.01)
    distance = np.linalg.norm(position[:, None] - position, axis=2)
    expected = np.argwhere(np.triu(distance <= 0.05, 1))
    assert np.array_equal(close_pairs(position, 0.05), expected)
    assert len(close_pairs(position[:1], 0.05)) == len(close_pairs(position, 0.0)) == 0


def test_chains_are_merged_into_their_first_node():
    position = np.array([(0.0, 0, 0), (1.0, 0, 0), (0.01, 0, 0), (0.02, 0, 0), (1.01, 0, 0)])
    kept_position, quads, kept = merged_nodes(position, np.array([[0, 1, 2, 4], [4, 3, 1, 0]])[:, [0, 1, 2, 1]], 0.011)
    assert kept.tolist() == [0, 1] and quads.tolist() == [[0, 1, 0, 1], [1, 0, 1, 0]]
    assert np.array_equal(kept_position, position[:2])


def test_the_checks_of_a_large_blank_take_little_time():
    started = time.process_time()
    Blank.rectangle((0.0, 0.0), (3.0, 3.0), 0.01)
    assert time.process_time() - started < 5.0


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_a_sheet_that_faces_down_is_turned_over(tmp_path, tilt):
    """Otherwise the weft, and the sense of ``orientation``, would be mirrored without a word."""
    position = WHOLE.node_position + np.outer(WHOLE.node_position[:, 0], (0.0, 0.0, tilt))
    up = Blank.from_file(written(tmp_path, "up.inp", deck(position, WHOLE.quads)), unit_scale=0.001, yarn_angle=30.0)
    down = Blank.from_file(
        written(tmp_path, "down.inp", deck(position, WHOLE.quads[:, ::-1])), unit_scale=0.001, yarn_angle=30.0
    )
    assert up.source_notes == () and "wound clockwise as seen from above" in down.source_notes[0]
    assert np.all(down.initial_director[:, 2] > 0.0)
    assert np.allclose(down.weft_direction, up.weft_direction)


def test_elements_without_numbers_are_named_by_their_lines(tmp_path):
    quads = [*WHOLE.quads.tolist(), WHOLE.quads[3].tolist()]
    count = WHOLE.node_count
    with pytest.raises(InputError, match=f"elements of line {count + 4} and of line {count + 81} have the same nodes"):
        Blank.from_file(written(tmp_path, "sheet.obj", obj_text(1e3 * WHOLE.node_position, quads)), unit_scale=0.001)
