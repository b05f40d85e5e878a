"""Results: names of files, numbers of a run, and points that are checked before it."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output import ResultFolder
from weavesim.output.files import file_endings
from weavesim.output.results import Wanted, run_summary, sheet_results


def test_numbers_of_the_run_go_before_findings_of_the_same_name(coarse_run):
    info, frames = coarse_run
    (sheet,) = sheet_results(info, Wanted(draw_in=False), frames[-1])
    summary = run_summary((sheet,), None, 12, {"max_stretch": 2.0, "outcome": "not run", "mine": 1})
    assert (summary["outcome"], summary["frame_count"], summary["max_stretch"]) == ("not run", 12, 2.0)
    assert list(summary)[:3] == ["outcome", "frame_count", "max_shear_angle_deg"] and list(summary)[-1] == "mine"


def test_a_sheet_has_the_tools_of_its_world_as_they_stand(stack):
    info, frames = stack
    upper, lower = sheet_results(info, Wanted(), frames[-1])
    assert [name for name, _, _ in lower.tools] == ["punch_2", "die_2", "blank_holder_2"]
    assert upper.tools[0][2] == frames[-1].tool_displacement[0] and lower.tools[0][2] == 0.5 * upper.tools[0][2]
    assert (upper.file("draw_in.csv"), lower.file("sections.png")) == ("draw_in_upper.csv", "sections_lower.png")


def test_endings_of_files(stack, coarse_run):
    assert file_endings(coarse_run[0]) == ("",)
    assert file_endings(stack[0]) == ("_upper", "_lower")


def test_points_outside_the_blank_are_found_before_the_run(tmp_path, coarse_run):
    folder = ResultFolder(tmp_path / "new", points=np.array([[0.5, 0.0]]))
    with pytest.raises(InputError, match=r"\(0.5, 0\) m lies outside the blank"):
        folder.start(coarse_run[0])
    assert not list((tmp_path / "new").iterdir())
