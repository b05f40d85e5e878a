"""Lines of drawings: their unit and heights, and pieces joined where just two ends meet."""

import numpy as np
import pytest

from weavesim.meshes.drawing import joined, read_lines

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def test_lines_in_space_come_in_metres(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new(units=5)
    document.modelspace().add_polyline3d([(0, 0, 0), (3, 0, 1), (3, 2, 2)])
    document.modelspace().add_point((1, 1))
    document.saveas(tmp_path / "lines.dxf")
    drawing = read_lines(tmp_path / "lines.dxf")
    assert len(drawing.lines) == 1
    assert np.allclose(drawing.lines[0], np.array([(0, 0, 0), (3, 0, 1), (3, 2, 2)]) / 100)


@pytest.mark.parametrize("shuffle", range(4))
def test_pieces_in_any_order_and_sense_make_a_closed_line(shuffle):
    random = np.random.default_rng(shuffle)
    pieces = [SQUARE[[k, (k + 1) % 4]] for k in range(4)]
    pieces = [pieces[k][:: random.choice([-1, 1])] for k in random.permutation(4)]
    (line,) = joined(pieces, 1e-6)
    assert len(line) == 5 and np.array_equal(line[0], line[-1])
    assert {tuple(point) for point in line.tolist()} == {tuple(point) for point in SQUARE.tolist()}


def test_lines_end_where_three_pieces_meet():
    middle = np.zeros(2)
    pieces = [np.array([middle, end]) for end in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))]
    assert len(list(joined(pieces, 1e-6))) == 3
    two = list(joined(pieces[:2], 1e-6))
    assert len(two) == 1 and len(two[0]) == 3
