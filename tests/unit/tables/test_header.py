"""Headers: found below a preamble, with their units, or not at all."""

import pytest

from weavesim.tables.header import find_header, fold
from weavesim.tables.text import TableFault


def test_names_are_compared_without_case_blanks_and_underscores():
    assert fold(" Machine_Force ") == fold("machine  force") == fold("MACHINE-FORCE") != fold("machineforce")


@pytest.mark.parametrize(
    ("lines", "line", "first_row", "separator"),
    [
        (["angle,force", "0,1"], 1, 2, ","),
        (["Force,5,N", "", "Time,Angle,Force", "(s),(deg),(N)", "0,0,1"], 3, 5, ","),
        (["force and angle", "angle;force", "0;1"], 2, 3, ";"),
        (["# made by hand", "# angle force", "0 1"], 2, 3, " "),
        (["# angle,force", "angle,force", "0,1"], 2, 3, ","),
        (["sep=,", "angle,force", "0,1"], 2, 3, ","),
    ],
)
def test_the_header_is_the_line_with_values_below_it(lines, line, first_row, separator):
    header = find_header(lines, ["angle", "force"])
    assert (header.line, header.first_row, header.separator) == (line, first_row, separator)


@pytest.mark.parametrize(
    ("lines", "notes"),
    [
        (["angle,force", "0,1"], ()),
        (["sep=,", "angle,force", "0,1"], ()),
        (["a test", "angle,force", "0,1"], ("header found in line 2",)),
        (["# angle,force", "0,1"], ("header taken from the comment in line 1",)),
    ],
)
def test_where_it_was_found_is_noted_unless_it_is_the_first_line(lines, notes):
    assert find_header(lines, ["angle", "force"]).notes == notes


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["hunter2", "12345"], "no column angle$"),
        (["user:hunter2", "other:secret"], "no table with the column angle: no line"),
        (["hunter2"], "no table"),
        ([], "empty"),
        ([",".join(f"column{k}" for k in range(50)), ",".join("0" for _ in range(50))], r"'column11', \.\.\."),
    ],
)
def test_little_is_shown_of_a_file_that_is_no_such_table(lines, message):
    with pytest.raises(TableFault, match=message) as raised:
        find_header(lines, ["angle"])
    assert "hunter2" not in str(raised.value) and "secret" not in str(raised.value)
