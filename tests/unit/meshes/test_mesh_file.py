"""What a mesh file gives to tools and to blanks."""

import numpy as np
import pytest

from tests.support.mesh_files import die, split
from weavesim.errors import InputError
from weavesim.meshes import Cells, MeshFile

NODES, QUADS = die()
ALL = Cells("quad", "quadrilaterals", QUADS, np.arange(1, 65))


def mesh(*cells, **more) -> MeshFile:
    return MeshFile("tool mesh a.xyz", "XYZ", NODES, cells, **more)


def test_quadrilaterals_keep_their_labels():
    quads, labels = mesh(ALL).quads()
    assert np.array_equal(quads, QUADS) and np.array_equal(labels, np.arange(1, 65))


@pytest.mark.parametrize("kind", ["triangle", "polygon", "triangle6", "quad8", "quad9"])
@pytest.mark.parametrize("count", [1, 3, 8])
def test_other_cells_are_no_elements_of_a_blank(kind, count):
    width = {"triangle": 3, "polygon": 5, "triangle6": 6, "quad8": 8, "quad9": 9}[kind]
    others = Cells(kind, kind, np.arange(count * width).reshape(count, width) % 81, np.arange(70, 70 + count))
    shown = "element 70" if count == 1 else "elements 70, 71, 72" + (", 73, 74, ..." if count == 8 else "")
    with pytest.raises(InputError, match=rf"{count} {kind} \({shown}\), beside 64 quadrilaterals"):
        mesh(ALL, others).quads()


@pytest.mark.parametrize("cells", [(), (Cells("quad", "quads", QUADS[:0], np.arange(0)),)])
def test_no_cells(cells):
    with pytest.raises(InputError, match="no triangles"):
        mesh(*cells).triangles()
    with pytest.raises(InputError, match="no quadrilaterals"):
        mesh(*cells).quads()


def test_notes_say_what_was_converted():
    halves = (Cells("quad", "quadrilaterals", QUADS[:32], np.arange(32)),)
    halves += (Cells("triangle", "triangles", split(QUADS[32:]), np.arange(64)),)
    triangles, notes = mesh(*halves, notes=("2 lines left out",)).triangles()
    assert len(triangles) == 128
    assert notes == ("2 lines left out", "32 quadrilaterals split into 64 triangles")
    assert mesh(halves[1]).triangles()[1] == ()


def test_a_crossed_outline_is_named():
    cells = Cells("quad", "S4 elements", np.array([QUADS[0], QUADS[1][[0, 2, 1, 3]]]), np.array([501, 502]))
    with pytest.raises(InputError, match=r"outline of element 502 \(S4 elements\) crosses itself"):
        mesh(cells).triangles()


@pytest.mark.parametrize(("scale", "good"), [(0.001, True), (1.0, False), (0.0254, False)])
def test_a_unit_in_the_file_must_agree(scale, good):
    file = mesh(ALL, metres_per_unit=0.001)
    if good:
        file.check_unit(scale)
    else:
        with pytest.raises(InputError, match=r"its unit is 0.001 m, but unit_scale=.* is given: give unit_scale=0.001"):
            file.check_unit(scale)
    mesh(ALL).check_unit(scale)
