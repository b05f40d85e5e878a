"""``results.h5``: what a run wrote is what is read back, and what is not one is refused."""

import h5py
import numpy as np
import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.errors import InputError
from weavesim.measures.stresses import STRESS_FIELDS
from weavesim.output import ResultFolder
from weavesim.output.stored.file import FILE_NAME, read_results, recorded_summary
from weavesim.run.frame import Outcome
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small run with its folder: (simulation, folder)."""
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=30.0)
    setup = one_sheet_setup(name="small", blank=blank, fabric=plain_fabric(), duration=1e-5, frame_count=2)
    folder, run = tmp_path_factory.mktemp("run"), Simulation(setup)
    results = ResultFolder(folder, writers=["results", "summary"])
    run.run([results])
    results.write({})
    return run, folder


def test_what_is_read_is_the_last_frame_bit_for_bit(made):
    run, folder = made
    stored, frame, info = read_results(folder), run.frame.sheet, run.info.sheet
    sheet = stored.sheets[0]
    assert (stored.name, stored.run_id, stored.time, stored.outcome) == (
        "small", run.info.run_id, run.frame.time, "finished",
    )  # fmt: skip
    assert np.array_equal(sheet.position, frame.position) and np.array_equal(sheet.director, frame.director)
    assert sheet.blank == info.blank and sheet.thickness == info.fabric.thickness
    for name, values in frame.fields.items():
        assert sheet.fields[name] == pytest.approx(values, rel=1e-14, abs=1e-14)
    assert set(STRESS_FIELDS) <= set(sheet.values)
    assert stored.setup == run.setup
    assert recorded_summary(folder)["outcome"] == "finished"


def test_every_value_says_its_unit_and_what_it_is(made):
    sheet = read_results(made[1]).sheets[0]
    assert all(value.unit and value.description for value in sheet.values.values())


def test_several_sheets_and_their_tools(tmp_path, stack):
    info, frames = stack
    results = ResultFolder(tmp_path, writers=["results"])
    results.start(info)
    for frame in frames:
        results.frame(frame)
    results.finish(Outcome.INTERRUPTED)
    stored = read_results(tmp_path)
    assert [sheet.name for sheet in stored.sheets] == ["upper", "lower"]
    assert [sheet.symmetry.planes for sheet in stored.sheets] == [("x", "y"), ()]
    assert [sheet.tools for sheet in stored.sheets] == [(0, 1, 2), (3, 4, 5)]
    assert np.array_equal(stored.tool_displacement, frames[-1].tool_displacement)
    assert stored.outcome == "interrupted"


def test_a_folder_without_results_is_told(tmp_path):
    with pytest.raises(InputError, match="it has no results.h5.*run it again"):
        read_results(tmp_path)
    with pytest.raises(InputError, match="it is no folder"):
        read_results(tmp_path / "nothing")


def _text(path):
    path.write_text("not HDF5")


def _other(path):
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "something else"


def _cut(path):
    with h5py.File(path, "a") as file:
        del file["sheets/0/nodes/position"]


def _short(path):
    with h5py.File(path, "a") as file:
        values = file["sheets/0/elements/thickness"][:-1]
        del file["sheets/0/elements/thickness"]
        made = file.create_dataset("sheets/0/elements/thickness", data=values)
        made.attrs["unit"], made.attrs["description"] = "m", "x"


@pytest.mark.parametrize(
    ("damage", "message"),
    [(_text, "damaged"), (_other, "no file of this format"), (_cut, "damaged"), (_short, "not as many")],
)
def test_a_damaged_file_is_told(made, tmp_path, damage, message):
    path = tmp_path / FILE_NAME
    path.write_bytes((made[1] / FILE_NAME).read_bytes())
    damage(path)
    with pytest.raises(InputError, match=message):
        read_results(tmp_path)
