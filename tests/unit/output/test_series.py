"""The ParaView series: read back by meshio, listed with its times, thinned out by time."""

import time
import xml.etree.ElementTree as xml

import meshio
import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output import Film, ParaViewSeries
from weavesim.run.frame import Outcome


def write_series(folder, run, every=None):
    info, frames = run
    series = ParaViewSeries(folder, every)
    series.start(info)
    for frame in frames:
        series.frame(frame)
    series.finish(Outcome.FINISHED)
    return folder


def listed(folder):
    entries = xml.parse(folder / "series.pvd").getroot().findall("./Collection/DataSet")
    return [(float(entry.get("timestep")), entry.get("file")) for entry in entries]


def test_final_state_is_that_of_the_run_in_double_precision(tmp_path, coarse_run):
    info, frames = coarse_run
    mesh = meshio.read(write_series(tmp_path, coarse_run) / "final_state.vtu")
    last = frames[-1]
    assert np.array_equal(mesh.points, last.position)
    assert np.array_equal(mesh.cells_dict["quad"], info.sheet.blank.quads)
    assert np.array_equal(mesh.point_data["displacement"], last.position - info.sheet.blank.node_position)
    assert np.array_equal(mesh.point_data["director"], last.director)
    assert mesh.cell_data["shear_angle_deg"][0] == pytest.approx(np.rad2deg(last.fields["shear_angle"]))
    for name in set(last.fields) - {"shear_angle"}:
        assert np.array_equal(mesh.cell_data[name][0], last.fields[name])
    sine = np.einsum("ei,ei->e", mesh.cell_data["warp_direction"][0], mesh.cell_data["weft_direction"][0])
    assert np.arcsin(sine) == pytest.approx(last.fields["shear_angle"])


def test_final_state_has_yarn_angles_in_the_frames_of_the_elements(tmp_path, coarse_run):
    mesh = meshio.read(write_series(tmp_path, coarse_run) / "final_state.vtu")
    warp, weft = (mesh.cell_data[f"{yarn}_angle_deg"][0] for yarn in ("warp", "weft"))
    # shear is what is missing to a right angle between them
    assert 90.0 - (weft - warp) == pytest.approx(mesh.cell_data["shear_angle_deg"][0], abs=1e-9)


def test_final_state_of_a_run_has_stresses(tmp_path):
    from tests.support.runs import one_sheet_run
    from tests.support.sheet import plain_fabric
    from weavesim.measures.stresses import STRESS_FIELDS
    from weavesim.sheet.blank import Blank

    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.06), 0.01)
    run = one_sheet_run(name="test", blank=blank, fabric=plain_fabric(), duration=1e-5, frame_count=1)
    series = ParaViewSeries(tmp_path)
    run.run([series])
    cells = meshio.read(tmp_path / "final_state.vtu").cell_data
    assert set(STRESS_FIELDS) <= set(cells)
    assert cells["stress_upper"][0].shape == (48, 3)


def test_every_listed_frame_exists_with_its_time_and_points(tmp_path, coarse_run):
    frames = {frame.time: frame for frame in coarse_run[1]}
    entries = listed(write_series(tmp_path, coarse_run))
    assert [time for time, _ in entries] == sorted(frames)
    for moment, name in entries:
        assert meshio.read(tmp_path / name).points == pytest.approx(frames[moment].position, abs=1e-7)


def test_about_thirty_frames_whatever_the_run_gives(tmp_path, coarse_run):
    info, frames = coarse_run
    duration, count = info.duration, 200
    many = [type(frames[0])(**{**vars(frames[0]), "index": i, "time": duration * i / count}) for i in range(count + 1)]
    entries = listed(write_series(tmp_path, (info, many)))
    assert 28 <= len(entries) <= 32
    assert entries[0][0] == 0.0 and entries[-1][0] == duration
    gaps = np.diff([moment for moment, _ in entries])
    assert gaps.max() < 1.5 * duration / 30


def test_every_nth_frame_and_the_last(tmp_path, coarse_run):
    names = [name for _, name in listed(write_series(tmp_path, coarse_run, every=4))]
    assert names == ["frame_0000.vtu", "frame_0004.vtu", "frame_0008.vtu", "frame_0011.vtu"]
    with pytest.raises(InputError, match="give 1 or more"):
        ParaViewSeries(tmp_path, 0)


def test_frames_of_a_former_run_do_not_mix_in(tmp_path, coarse_run):
    stale = tmp_path / "frame_9999.vtu"
    stale.write_text("old")
    other = tmp_path / "frame_notes.txt"
    other.write_text("mine")
    write_series(tmp_path, coarse_run)
    assert not stale.exists() and other.exists()


def test_streams_are_cheap(tmp_path, fine_run):
    """Film and series of 1269 elements: below 5 % of a run of 10 s with 60 frames, once the libraries are loaded."""
    info, frames = fine_run
    streams = [Film(tmp_path / "film.usdc"), ParaViewSeries(tmp_path)]
    for stream in streams:
        stream.start(info)
        stream.frame(frames[0])
    started = time.process_time()
    for i in range(60):
        frame = frames[i % len(frames)]
        frame = type(frame)(**{**vars(frame), "index": i + 1, "time": info.duration * (i + 1) / 60})
        for stream in streams:
            stream.frame(frame)
    for stream in streams:
        stream.finish(Outcome.FINISHED)
    assert time.process_time() - started < 0.5


def test_every_sheet_of_a_run_has_its_files_in_one_series(tmp_path, stack):
    info, frames = stack
    write_series(tmp_path, stack)
    entries = xml.parse(tmp_path / "series.pvd").getroot().findall("./Collection/DataSet")
    assert [entry.get("file") for entry in entries[:2]] == ["frame_0000.vtm", "frame_0001.vtm"]
    blocks = xml.parse(tmp_path / "frame_0001.vtm").getroot().findall("./vtkMultiBlockDataSet/DataSet")
    assert [(block.get("index"), block.get("name"), block.get("file")) for block in blocks] == [
        ("0", "upper", "frame_0001_upper.vtu"),
        ("1", "lower", "frame_0001_lower.vtu"),
    ]
    for sheet, state in zip(info.sheets, frames[-1].sheets, strict=True):
        mesh = meshio.read(tmp_path / f"final_state_{sheet.name}.vtu")
        assert np.array_equal(mesh.points, state.position)
        assert np.array_equal(mesh.cells_dict["quad"], sheet.blank.quads)
        assert np.array_equal(mesh.cell_data["thickness"][0], state.fields["thickness"])
    for entry in entries:
        assert (tmp_path / entry.get("file")).exists()


def test_vtk_reads_the_sheets_as_named_blocks(tmp_path, stack):
    """In ParaView and PyVista, which use it: every frame, with the positions of the run."""
    pyvista = pytest.importorskip("pyvista")
    info, frames = stack
    write_series(tmp_path, stack)
    reader = pyvista.get_reader(str(tmp_path / "series.pvd"))
    assert len(reader.time_values) == len(frames)
    for time_value, frame in zip(reader.time_values, frames, strict=True):
        reader.set_active_time_value(time_value)
        (blocks,) = reader.read()
        assert blocks.keys() == ["upper", "lower"]
        for sheet in frame.sheets:
            assert np.array_equal(blocks[sheet.name].points, sheet.position.astype(np.float32))
    final = pyvista.read(str(tmp_path / "final_state.vtm"))
    for name, place, level in (("upper", 0, 0), ("lower", 1, 1)):
        assert set(final[name].cell_data["sheet"]) == {place}
        exploded = final[name].warp_by_vector("exploded").points - final[name].points
        gap = 0.15 * max(sheet.blank.size for sheet in info.sheets)
        assert exploded == pytest.approx(np.tile([0.0, 0.0, level * gap], (len(exploded), 1)))


def test_one_sheet_has_no_blocks(tmp_path, coarse_run):
    write_series(tmp_path, coarse_run)
    assert not list(tmp_path.glob("*.vtm"))
    mesh = meshio.read(tmp_path / "final_state.vtu")
    assert "sheet" not in mesh.cell_data and "exploded" not in mesh.point_data


def test_frames_of_a_former_run_of_several_sheets_go_too(tmp_path, coarse_run, stack):
    write_series(tmp_path, stack)
    write_series(tmp_path, coarse_run)
    assert not list(tmp_path.glob("frame_*_upper.vtu")) and not list(tmp_path.glob("frame_*.vtm"))
