"""What observers get: the only sheet of a run, names of tools in outputs."""

import dataclasses

import pytest

from weavesim.errors import InputError
from weavesim.run.frame import unique_names


def test_a_run_of_one_sheet_is_read_without_naming_it(coarse_run):
    info, frames = coarse_run
    assert info.sheet is info.sheets[0]
    assert frames[-1].position is frames[-1].sheets[0].position
    assert info.element_count == info.sheet.blank.element_count
    assert [info.tools[place] for place in info.sheet.tools] == list(info.tools)


def test_several_sheets_have_to_be_named(stack):
    info, frames = stack
    for part in (info, frames[0]):
        with pytest.raises(InputError, match="this run has 2 sheets"):
            _ = part.sheet
    assert info.element_count == sum(sheet.blank.element_count for sheet in info.sheets)
    assert [info.tools[place] for place in info.sheets[1].tools] == list(info.tools[3:])


def test_tools_of_the_same_name_are_distinguished_in_outputs(stack):
    names = ("punch", "die", "blank_holder")
    assert stack[0].tool_names == (*names, *(f"{name}_2" for name in names))


def test_unique_names():
    assert unique_names(["a", "b", "a", "a_2", "a"]) == ("a", "b", "a_2", "a_2_2", "a_3")


def test_warnings_are_live(coarse_run):
    info = dataclasses.replace(coarse_run[0], warnings=[])
    seen = info.warnings
    info.warnings.append("late")
    assert seen == ["late"]
