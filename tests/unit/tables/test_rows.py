"""Lines of tables: comments, cells, names."""

import pytest

from weavesim.tables.rows import comment_of, is_blank, split_line, split_names, trimmed
from weavesim.tables.text import TableFault


@pytest.mark.parametrize(
    ("line", "separator", "comment"),
    [
        ("# text", ",", " text"), ("  ## text", ",", " text"), ("% text", ";", " text"), ("// text", "\t", " text"),
        ("1,2 # text", ",", None), ("#,angle", ",", None), ("%;N;mm", ";", None), ("# ;N", ";", None),
        ("#DIV/0!;5", ";", None), ("#N/A\t5", "\t", None), ("#WERT!", ";", None), ("#####;5", ";", None),
        ("/5", ",", None), ("% N", " ", " N"), ("#", ",", ""), ("#####", ",", ""), ("### A", ",", " A"),
    ],
)  # fmt: skip
def test_comments(line, separator, comment):
    assert comment_of(line, separator) == comment


@pytest.mark.parametrize(
    ("line", "separator", "cells"),
    [
        ("1, 2 ,3", ",", ["1", "2", "3"]), ('"a,b";"c ""d"""', ";", ["a,b", 'c "d"']), ('"1" , "2" ', ",", ["1", "2"]),
        ("1\t\t3", "\t", ["1", "", "3"]),
        ('  1   "a b"  3', " ", ["1", "a b", "3"]), ('5" tube,2', ",", ['5" tube', "2"]),
    ],
)  # fmt: skip
def test_cells(line, separator, cells):
    assert split_line(line, separator, 1) == cells


@pytest.mark.parametrize("line", ['"1,2', '"1"2,3', '1,"2', '"' * 99])
def test_quotation_marks_must_match(line):
    with pytest.raises(TableFault, match="quotation mark"):
        split_line(line, ",", 3)


def test_names_may_contain_blanks_if_two_stand_between_them():
    assert split_names("Shear angle  Force [N]", " ", 1, 2) == ["Shear angle", "Force [N]"]
    assert split_names("angle [deg] force [N]", " ", 1, 2) == ["angle[deg]", "force[N]"]


def test_blank_lines_and_rules_are_empty():
    assert is_blank(" \t") and is_blank("\ufeff") and is_blank("----- ----") and is_blank("|===|===|")
    assert not is_blank("-;-") and not is_blank("1") and trimmed(["", "a", "", ""]) == ["", "a"]
