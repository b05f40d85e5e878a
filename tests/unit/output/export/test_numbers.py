"""Numbers of exported nodes and elements: those of the mesh that a user gave, each once in a file."""

import numpy as np
import pytest

from tests.support.stored_runs import stored_run, stored_sheet
from weavesim.output.export.exporting import Export, export_run
from weavesim.output.export.formed import own_parts
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

ROWS = Blank.rectangle((0.0, 0.0), (0.04, 0.03), 0.01)


def numbered(first_node: int | None, first_element: int | None) -> Blank:
    """Numbers that fall by two from row to row, down to the first ones."""
    nodes, elements = 2 * np.arange(ROWS.node_count)[::-1], 2 * np.arange(ROWS.element_count)[::-1]
    return ROWS.model_copy(
        update={
            "node_number": None if first_node is None else first_node + nodes,
            "element_number": None if first_element is None else first_element + elements,
        }
    )


def sheet_of(blank: Blank, name: str = "sheet", **given):
    return stored_sheet(blank, blank.node_position, name=name, **given)


def test_those_of_the_mesh_are_kept():
    blank = numbered(301, 7001)
    (part,) = own_parts(stored_run(sheet_of(blank)))
    assert np.array_equal(part.mesh.node_labels, blank.node_number)
    assert np.array_equal(part.mesh.labels, blank.element_number) and part.notes == ()


def test_without_numbers_they_are_counted_from_one_through_all_sheets():
    first, second = own_parts(stored_run(sheet_of(ROWS, "a"), sheet_of(ROWS, "b")))
    assert first.mesh.node_labels.tolist() == list(range(1, 21)) and first.mesh.labels.tolist() == list(range(1, 13))
    assert second.mesh.node_labels.tolist() == list(range(21, 41)) and second.mesh.labels.tolist() == list(
        range(13, 25)
    )
    assert first.notes == second.notes == ()


def test_sheets_whose_numbers_do_not_meet_keep_them():
    blanks = numbered(301, 7001), numbered(302, 7002)
    parts = own_parts(stored_run(*(sheet_of(blank, name) for name, blank in zip("ab", blanks, strict=True))))
    for part, blank in zip(parts, blanks, strict=True):
        assert np.array_equal(part.mesh.node_labels, blank.node_number) and part.notes == ()
        assert np.array_equal(part.mesh.labels, blank.element_number)


def test_a_sheet_whose_numbers_are_taken_is_told_where_they_went(tmp_path):
    blanks = numbered(301, 7001), numbered(339, 7001)
    run = stored_run(*(sheet_of(blank, name) for name, blank in zip("ab", blanks, strict=True)))
    _, part = own_parts(run)
    assert np.array_equal(part.mesh.node_labels, blanks[1].node_number + 339)
    assert np.array_equal(part.mesh.labels, blanks[1].element_number + 7023)
    assert part.notes == ("sheet b: numbers of its mesh plus 339 (nodes) and 7023 (elements)",)
    done = export_run(run, Export(["abaqus"], tmp_path))
    assert any("plus 339" in note for note in done.notes) and "plus 339" in done.files[0].read_text()


@pytest.mark.parametrize("planes", [("x",), ("x", "y")])
def test_mirrored_copies_follow_the_sheet_itself(planes):
    blank = numbered(301, 7001)
    (part,) = own_parts(stored_run(sheet_of(blank, symmetry=Symmetry(planes))), whole=True)
    copies, mesh = 2 ** len(planes), part.mesh
    assert len(np.unique(mesh.node_labels)) == len(mesh.nodes) and len(np.unique(mesh.labels)) == 12 * copies
    assert np.array_equal(mesh.labels[:12], blank.element_number)
    assert np.array_equal(mesh.labels[12:24], blank.element_number + 7023)
    # nodes on the planes are those of the sheet itself
    place = {tuple(np.round(point, 6)): label for point, label in zip(mesh.nodes, mesh.node_labels, strict=True)}
    for point, number in zip(ROWS.node_position, blank.node_number, strict=True):
        assert place[tuple(np.round(point, 6))] == number
    mirrored = ROWS.node_position[:, 0] > 1e-9
    for point, number in zip(ROWS.node_position[mirrored], blank.node_number[mirrored], strict=True):
        assert (place[tuple(np.round(point * (-1.0, 1.0, 1.0), 6))] - number) % 339 == 0
