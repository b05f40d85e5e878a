"""Lines of drawings: their unit and heights, and pieces joined where just two ends meet."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.meshes import drawing
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


@pytest.fixture
def write(tmp_path):
    """Writes a drawing in mm with one line and what is added, and returns its path."""
    ezdxf = pytest.importorskip("ezdxf")

    def writer(add=lambda document: None):
        document = ezdxf.new(units=4)
        document.modelspace().add_line((0, 0), (100, 0))
        add(document)
        document.saveas(tmp_path / "made.dxf")
        return tmp_path / "made.dxf"

    return writer


def test_a_drawing_that_is_cut_off_is_refused(write, caplog, capfd):
    path = write()
    whole = path.read_bytes()
    for share in (0.2, 0.5, 0.9):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match="no DXF drawing that can be read .*export it again"):
            read_lines(path)
    # the reader of the library throws RuntimeError at a tag without its value
    path.write_bytes(whole.replace(b"  2\nENTITIES\n", b"  2\n", 1))
    with pytest.raises(InputError, match="no DXF drawing that can be read"):
        read_lines(path)
    assert capfd.readouterr() == ("", "")


def _bomb(document):
    block = document.blocks.new("many")
    block.add_line((0, 0), (1, 1))
    grid = {"row_count": 30_000, "column_count": 30_000, "row_spacing": 1.0, "column_spacing": 1.0}
    document.modelspace().add_blockref("many", (0, 0), dxfattribs=grid)


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (lambda document: document.modelspace().add_circle((0, 0), 1e12), "m from the origin, more than 1000 m"),
        (lambda document: document.modelspace().add_line((0, 0), (1e7, 0)), r"a line lies 1e\+04 m from the origin"),
        (_bomb, "more than 1,000 entities"),
    ],
)
def test_a_drawing_without_end_is_refused(write, monkeypatch, add, message):
    monkeypatch.setattr(drawing, "MOST_ENTITIES", 1000)
    with pytest.raises(InputError, match=message):
        read_lines(write(add))


def test_curves_have_a_bounded_number_of_points(write, monkeypatch):
    monkeypatch.setattr(drawing, "MOST_POINTS", 20)
    with pytest.raises(InputError, match="its curves have more than 20 points"):
        read_lines(write(lambda document: document.modelspace().add_circle((0, 0), 100)))
