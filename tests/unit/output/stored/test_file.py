"""``results.h5``: what a run wrote is what is read back, and what is not one is refused."""

import json

import h5py
import numpy as np
import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.errors import InputError
from weavesim.measures.stresses import STRESS_FIELDS
from weavesim.output import ResultFolder
from weavesim.output.claim.record import file_hash
from weavesim.output.stored.file import FILE_NAME, read_results, recorded_summary
from weavesim.output.stored.sealed import seal
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
    if path.read_bytes().startswith(b"weavesim results"):
        seal(path)  # as if it had been written so
    with pytest.raises(InputError, match=message):
        read_results(tmp_path)


def _values(name, value):
    def change(path):
        with h5py.File(path, "a") as file:
            file[name][0] = value

    return change


@pytest.mark.parametrize(
    "damage",
    [
        _values("sheets/0/elements/thickness", np.nan), _values("sheets/0/elements/shear_angle_deg", np.inf),
        _values("sheets/0/nodes/director", np.nan), _values("sheets/0/elements/warp_angle_deg", -np.inf),
    ],
)  # fmt: skip
def test_values_that_are_not_finite_are_refused(made, tmp_path, damage):
    path = tmp_path / FILE_NAME
    path.write_bytes((made[1] / FILE_NAME).read_bytes())
    damage(path)
    seal(path)
    with pytest.raises(InputError, match="not finite"):
        read_results(tmp_path)


def test_every_flipped_bit_is_found(made, tmp_path):
    whole = (made[1] / FILE_NAME).read_bytes()
    path, random = tmp_path / FILE_NAME, np.random.default_rng(3)
    for place in [*range(0, 600, 7), *random.integers(len(whole), size=100)]:
        data = bytearray(whole)
        data[place] ^= 1 << int(random.integers(8))
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"damaged: it is not what was written.*weavesim rerun"):
            read_results(tmp_path)


def test_a_file_without_a_checksum_is_held_against_the_record(made, tmp_path):
    """As version 1 wrote it: HDF5 from its first byte on."""
    path = tmp_path / FILE_NAME
    with h5py.File(made[1] / FILE_NAME) as source, h5py.File(path, "w") as file:
        for name in source:
            source.copy(name, file)
        file.attrs.update({**source.attrs, "format_version": 1})
    assert read_results(tmp_path).name == "small"
    (tmp_path / "run.json").write_text(json.dumps({"files": {FILE_NAME: file_hash(path)}}))
    assert read_results(tmp_path).name == "small"
    data = bytearray(path.read_bytes())
    data[-100] ^= 4
    path.write_bytes(data)
    with pytest.raises(InputError, match="damaged: it is not what was written"):
        read_results(tmp_path)
