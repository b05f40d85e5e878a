"""Blanks whose nodes and elements are put in another order keep the numbers of the mesh that was given."""

import meshio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.mesh_files import elements_of_deck, nodes_of_deck
from weavesim.errors import InputError
from weavesim.meshes.numbering import blocks_touched
from weavesim.sheet.blank import Blank

ROWS = Blank.rectangle((0.0, 0.0), (0.05, 0.04), 0.01)


def shuffled(blank: Blank, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements of a blank, numbered at random."""
    random = np.random.default_rng(seed)
    order = random.permutation(blank.node_count)
    return blank.node_position[order], random.permutation(np.argsort(order)[blank.quads])


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_everything_of_a_given_node_or_element_goes_with_its_number(seed):
    position, quads = shuffled(ROWS, seed)
    random = np.random.default_rng(seed + 1)
    given_values = {
        "material_coordinates": position[:, :2] + random.normal(size=(len(position), 2)),
        "warp_direction": np.column_stack([random.normal(size=(len(quads), 2)) + 2.0, np.zeros(len(quads))]),
    }
    kept = Blank.from_mesh(position, quads, **given_values)
    blank = Blank.from_mesh(position, quads, **given_values, numbering="neighbouring")
    assert kept.node_number is None and kept.element_number is None
    nodes, elements = blank.node_number - 1, blank.element_number - 1
    assert sorted(nodes) == list(range(30)) and sorted(elements) == list(range(20))
    for name in ("node_position", "material_coordinates", "initial_director"):
        assert np.array_equal(getattr(blank, name), getattr(kept, name)[nodes])
    for name in ("warp_direction", "weft_direction"):
        assert np.array_equal(getattr(blank, name), getattr(kept, name)[elements])
    # each with its corners in their sequence
    assert np.array_equal(nodes[blank.quads], quads[elements])
    assert np.array_equal(blank.node_position[blank.nodes_numbered(np.arange(1, 31))], position)
    assert np.array_equal(nodes[blank.quads[blank.elements_numbered(np.arange(1, 21))]], quads)


def test_a_large_mesh_in_no_order_is_told_and_mended():
    position, quads = shuffled(Blank.rectangle((0.0, 0.0), (0.7, 0.7), 0.01), 0)
    kept, mended = (Blank.from_mesh(position, quads, numbering=each) for each in ("kept", "neighbouring"))
    (note,) = kept.source_notes
    assert 'numbering = "neighbouring"' in note and mended.source_notes == ()
    assert blocks_touched(kept.quads) > 50.0 and blocks_touched(mended.quads) < 9.0


def test_merged_nodes_keep_the_number_of_the_first():
    corners = ROWS.node_position[ROWS.quads].reshape(-1, 3)
    quads = np.arange(len(corners)).reshape(-1, 4)
    for numbering in ("kept", "neighbouring"):
        blank = Blank.from_mesh(corners, quads, merge_nodes=1e-6, numbering=numbering)
        assert blank.node_count == 30 and np.array_equal(blank.node_position, corners[blank.node_number - 1])
        assert np.array_equal(blank.node_position[blank.quads], corners[quads[blank.element_number - 1]])


def deck_of(position: np.ndarray, quads: np.ndarray) -> str:
    """Nodes numbered 501, 502, ... and elements 1001, 1002, ..., in mm."""
    return f"*NODE\n{nodes_of_deck(1e3 * position, 501)}*ELEMENT, TYPE=S4\n{elements_of_deck(quads, 1001, 501)}"


@pytest.mark.parametrize("numbering", ["kept", "neighbouring"])
def test_numbers_of_a_deck_are_its_own(tmp_path, numbering):
    position, quads = shuffled(ROWS, 5)
    (tmp_path / "blank.inp").write_text(deck_of(position, quads))
    blank = Blank.from_file(tmp_path / "blank.inp", unit_scale=0.001, numbering=numbering)
    assert np.allclose(blank.node_position, position[blank.node_number - 501])
    assert np.array_equal(blank.node_number[blank.quads] - 501, quads[blank.element_number - 1001])
    rows = blank.nodes_numbered([530, 501])
    assert np.allclose(blank.node_position[rows], position[[29, 0]])
    with pytest.raises(InputError, match="the mesh has no node 1: give numbers of its own"):
        blank.nodes_numbered(1)
    part, nodes = blank.part(blank.element_centres()[:, 0] < 0.03)
    assert np.array_equal(part.node_number, blank.node_number[nodes])
    assert np.array_equal(part.node_number[part.quads] - 501, quads[part.element_number - 1001])
    again = Blank.from_json(blank.to_json())
    assert again == blank and np.array_equal(again.node_number, blank.node_number)


@pytest.mark.parametrize("ending", ["msh", "vtu"])
def test_nodes_of_other_files_are_counted_with_those_that_nothing_uses(tmp_path, ending):
    position, quads = shuffled(ROWS, 6)
    points = np.vstack([[(9.0, 9.0, 0.0)], position])
    kinds = {"file_format": "gmsh22"} if ending == "msh" else {}
    meshio.write(tmp_path / f"blank.{ending}", meshio.Mesh(points, [("quad", quads + 1)]), **kinds)
    blank = Blank.from_file(tmp_path / f"blank.{ending}")
    assert blank.node_number.tolist() == list(range(2, 32)) and blank.element_number.tolist() == list(range(1, 21))
    near = Blank.from_file(tmp_path / f"blank.{ending}", numbering="neighbouring")
    assert np.allclose(near.node_position, points[near.node_number - 1])
    assert np.array_equal(near.node_number[near.quads] - 2, quads[near.element_number - 1])


def test_numbers_that_are_there_twice_are_counted_anew(tmp_path):
    """Instances of one part have the same ones."""
    left, right = ROWS.node_position, ROWS.node_position + (0.05, 0.0, 0.0)
    part = f"*PART, NAME=A\n{deck_of(left, ROWS.quads)}*END PART\n"
    placed = "*ASSEMBLY, NAME=B\n*INSTANCE, NAME=C, PART=A\n*END INSTANCE\n*INSTANCE, NAME=D, PART=A\n50., 0., 0.\n"
    (tmp_path / "blank.inp").write_text(f"{part}{placed}*END INSTANCE\n*END ASSEMBLY\n")
    blank = Blank.from_file(tmp_path / "blank.inp", unit_scale=0.001, merge_nodes=1e-6, numbering="neighbouring")
    assert any("some numbers are there twice" in note for note in blank.source_notes)
    assert np.allclose(blank.node_position, np.vstack([left, right])[blank.node_number - 1])
    assert sorted(blank.element_number) == list(range(1, 41))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"node_number": [1, 2]}, r"node_number: shape \(2,\), but \(30,\) is needed"),
        ({"element_number": np.ones(20, dtype=int)}, "element_number: whole numbers from 1 on are needed, each once"),
        ({"element_number": np.arange(20)}, "each once"),
        ({"node_number": np.linspace(1.0, 30.0, 30)}, "an array of int64 is needed"),
    ],
)
def test_bad_numbers_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        ROWS.model_copy(update=change)


def test_a_bad_option_and_values_of_other_nodes_are_refused():
    with pytest.raises(InputError, match="numbering = 'along': one of 'kept', 'neighbouring' is needed"):
        Blank.from_mesh(ROWS.node_position, ROWS.quads, numbering="along")
    for wrong in (np.zeros((31, 2)), np.zeros((30, 3))):
        with pytest.raises(InputError, match=r"material_coordinates: shape .*, but \(30, 2\) is needed"):
            Blank.from_mesh(ROWS.node_position, ROWS.quads, material_coordinates=wrong, numbering="neighbouring")


def test_messages_name_the_elements_of_the_mesh():
    wrong = ROWS.model_copy(update={"element_number": 100 + np.arange(20)})
    flipped = np.array(wrong.quads)
    flipped[7] = flipped[7, [0, 1, 1, 2]]
    with pytest.raises(InputError, match="the first is element 107"):
        wrong.model_copy(update={"quads": flipped})
