"""Numbers in cells: one decimal mark for a table, or a refusal."""

import pytest

from weavesim.tables.numbers import DecimalMark, is_number, number
from weavesim.tables.text import TableFault


def mark_of(separator, *cells):
    mark = DecimalMark(separator)
    for line, cell in enumerate(cells, start=2):
        mark.see(cell, line)
    return mark.found()


@pytest.mark.parametrize(
    ("separator", "cells", "mark"),
    [
        (",", ["1.234"], "."),
        (" ", ["1.234"], "."),
        (";", ["1,234"], ","),
        (";", ["1.234", "0.5"], "."),
        ("\t", ["1,234", "12"], None),
        ("\t", ["1,234", "0,250"], ","),
        ("\t", ["1.234", "5.0"], "."),
        (" ", ["1,234"], None),
        (",", ["1,234"], None),
        (",", ["1,234", "1,2"], ","),
        (";", ["1.234", "123.456"], None),
        (";", ["1.234", "1234.567"], "."),
        (";", ["1.5", "1,5"], None),
        (";", ["0.500"], "."),
        (";", ["12", "a,b", "1.2.3"], "."),
        (",", ["5", "07"], None),
        (",", ["5.0", "07"], "."),
        (";", ["5", "07"], "."),
        (",", ["0", "10", "-5"], "."),
    ],
)
def test_the_mark_is_that_of_all_numbers(separator, cells, mark):
    if mark:
        assert mark_of(separator, *cells) == mark
    else:
        with pytest.raises(TableFault):
            mark_of(separator, *cells)


@pytest.mark.parametrize(
    ("cell", "mark", "value"),
    [
        (" 5 ", ".", 5.0), ("+.5", ".", 0.5), ("5.", ".", 5.0), ("\u22121,5E+3", ",", -1500.0), ("1d3", ".", 1000.0),
        ("0e5", ".", 0.0), ("007.5", ".", 7.5), ("-0", ".", 0.0),
    ],
)  # fmt: skip
def test_numbers_are_read(cell, mark, value):
    assert number(cell, mark, "x", 1) == value and is_number(cell)


@pytest.mark.parametrize(
    "cell",
    ["", "x", "nan", "inf", "1e999", "1e-999", "0x10", "1_0", "--5", "5-", "1e", "e5", "1,2,3", "1.2.3", "5 %", "1 N",
     "٣", "1e5.0", "1,5", "½", "²", "1/2", "12:30", "True", "1 2"],
)  # fmt: skip
def test_what_is_no_number_is_refused(cell):
    with pytest.raises(TableFault) as raised:
        number(cell, ".", "x", 7)
    assert raised.value.line == 7
