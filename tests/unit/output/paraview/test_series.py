"""The ParaView series: read back by PyVista, which uses VTK as ParaView does, and by meshio."""

import dataclasses
import time
import xml.etree.ElementTree as xml

import meshio
import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output import Film, ParaViewSeries
from weavesim.output.pace import Pace
from weavesim.run.fields import FIELDS
from weavesim.run.frame import Outcome


def write_series(folder, run, every=1, **options):
    info, frames = run
    series = ParaViewSeries(folder, every, **options)
    series.start(info)
    for frame in frames:
        series.frame(frame)
    series.finish(Outcome.FINISHED)
    return folder


@pytest.fixture(scope="module")
def written(tmp_path_factory, coarse_run):
    return write_series(tmp_path_factory.mktemp("series"), coarse_run)


def listed(folder):
    entries = xml.parse(folder / "series.pvd").getroot().findall("./Collection/DataSet")
    return [(float(entry.get("timestep")), entry.get("file")) for entry in entries]


def test_final_state_is_that_of_the_run_in_double_precision(written, coarse_run):
    info, frames = coarse_run
    mesh = meshio.read(written / "final_state.vtu")
    last = frames[-1]
    assert np.array_equal(mesh.points, last.position)
    assert np.array_equal(mesh.cells_dict["quad"], info.sheet.blank.quads)
    assert np.array_equal(mesh.point_data["displacement_m"], last.position - info.sheet.blank.node_position)
    assert np.array_equal(mesh.point_data["flat_coordinates_m"], info.sheet.blank.node_position)
    assert np.array_equal(mesh.point_data["director"], last.director)
    assert mesh.cell_data["shear_angle_deg"][0] == pytest.approx(np.rad2deg(last.fields["shear_angle"]))
    for name, in_file in (("thickness", "thickness_m"), ("warp_stretch", "warp_stretch")):
        assert np.array_equal(mesh.cell_data[in_file][0], last.fields[name])
    sine = np.einsum("ei,ei->e", mesh.cell_data["warp_direction"][0], mesh.cell_data["weft_direction"][0])
    assert np.arcsin(sine) == pytest.approx(last.fields["shear_angle"])


def test_final_state_has_yarn_angles_in_the_frames_of_the_elements(written):
    mesh = meshio.read(written / "final_state.vtu")
    warp, weft = (mesh.cell_data[f"{yarn}_angle_deg"][0] for yarn in ("warp", "weft"))
    # one convention: shear is what is missing to a right angle from warp to weft
    assert 90.0 - (weft - warp) == pytest.approx(mesh.cell_data["shear_angle_deg"][0], abs=1e-9)


def test_final_state_of_a_run_has_stresses(tmp_path):
    from tests.support.runs import one_sheet_run
    from tests.support.sheet import plain_fabric
    from weavesim.measures.stresses import STRESS_FIELDS
    from weavesim.sheet.blank import Blank

    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.06), 0.01)
    run = one_sheet_run(name="test", blank=blank, fabric=plain_fabric(), duration=1e-5, frame_count=1)
    run.run([ParaViewSeries(tmp_path)])
    cells = meshio.read(tmp_path / "final_state.vtu").cell_data
    endings = {"N/m": "n_per_m", "N": "n", "N/m^2": "pa"}
    assert {f"{name}_{endings[unit]}" for name, (unit, _) in STRESS_FIELDS.items()} <= set(cells)
    assert cells["stress_upper_pa"][0].shape == (48, 3)


def test_pyvista_reads_every_frame_with_the_whole_part_and_its_tools(written, coarse_run):
    pyvista = pytest.importorskip("pyvista")
    info, frames = coarse_run
    symmetry, count = info.sheet.symmetry, info.sheet.blank.element_count
    reader = pyvista.get_reader(str(written / "series.pvd"))
    assert reader.time_values == pytest.approx([frame.time for frame in frames])
    for moment, frame in zip(reader.time_values, frames, strict=True):
        reader.set_active_time_value(moment)
        (blocks,) = reader.read()
        assert blocks.keys() == ["sheet", "tools"] and blocks["tools"].keys() == list(info.tool_names)
        sheet = blocks["sheet"]
        assert sheet.n_cells == 4 * count
        assert sheet.points == pytest.approx(symmetry.mirrored(frame.position), abs=1e-7)
        flat = symmetry.mirrored(info.sheet.blank.node_position)
        assert sheet["flat_coordinates_m"] == pytest.approx(flat, abs=1e-7)
        assert sheet["displacement_m"] == pytest.approx(sheet.points - flat, abs=1e-6)
        for k in range(4):
            own = slice(k * count, (k + 1) * count)
            assert set(sheet["mirrored"][own]) == {int(k > 0)}
            assert sheet["shear_angle_deg"][own] == pytest.approx(np.rad2deg(frame.fields["shear_angle"]), abs=1e-5)
            assert np.array_equal(sheet["thickness_m"][own], frame.fields["thickness"].astype(np.float32))
        for name, tool, distance in zip(info.tool_names, info.tools, frame.tool_displacement, strict=True):
            moved = tool.display_triangles()[0] + distance * np.asarray(tool.axis)
            assert blocks["tools"][name].points == pytest.approx(moved, abs=1e-6)
    # a mirror turns elements over: all of the whole part face the same side
    corner = sheet.points[sheet.cells.reshape(-1, 5)[:, 1:]]
    assert np.all(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])[:, 2] > -1e-6)
    # mirrored yarns still run along their mirrored elements
    warp = sheet["warp_direction"].reshape(4, count, 3)
    for mirror, own in zip(symmetry.mirror_factors, warp, strict=True):
        assert own == pytest.approx(warp[0] * (*mirror, 1.0), abs=1e-6)


def test_names_tell_units_and_the_solver_is_left_out_unless_it_is_wanted(tmp_path, written, coarse_run):
    present = [field for field in FIELDS if field.name in coarse_run[1][0].fields]
    cells = set(meshio.read(written / "frame_0000_sheet.vtu").cell_data)
    assert {"shear_angle_deg", "thickness_m", "warp_stretch", "warp_direction"} <= cells
    assert len(cells) == sum(not field.diagnostic for field in present) + 3  # and directions, and what is mirrored
    fields = dict(coarse_run[1][0].fields, unit_cell_residual=np.zeros(coarse_run[0].sheet.blank.element_count))
    first = coarse_run[1][0]
    frame = dataclasses.replace(first, sheets=(dataclasses.replace(first.sheet, fields=fields),))
    for wanted in (False, True):
        folder = write_series(tmp_path / str(wanted), (coarse_run[0], [frame]), diagnostics=wanted)
        assert ("unit_cell_residual" in meshio.read(folder / "frame_0000_sheet.vtu").cell_data) == wanted
        assert "unit_cell_residual" in meshio.read(folder / "final_state.vtu").cell_data


def test_a_tool_is_written_again_only_when_it_has_moved(written, coarse_run):
    names = {path.name.split("_tool_")[1] for path in written.glob("frame_0000_tool_*.vtu")}
    assert names == {f"{name}.vtu" for name in coarse_run[0].tool_names}
    # the die stands still
    assert len(list(written.glob("*_tool_die.vtu"))) == 1
    assert len(list(written.glob("*_tool_punch.vtu"))) == len(coarse_run[1])


def test_every_nth_frame_and_the_last(tmp_path, coarse_run):
    names = [name for _, name in listed(write_series(tmp_path, coarse_run, every=4))]
    assert names == ["frame_0000.vtm", "frame_0004.vtm", "frame_0008.vtm", "frame_0011.vtm"]
    with pytest.raises(InputError, match="give 1 or more"):
        ParaViewSeries(tmp_path, 0)


def test_a_run_cut_short_leaves_what_can_be_opened(tmp_path, coarse_run, monkeypatch):
    info, frames = coarse_run
    series = ParaViewSeries(tmp_path)
    series.start(info)
    monkeypatch.setattr(Pace, "due", lambda pace: len(series._written) in (1, 2, 5))
    for count, frame in enumerate(frames, start=1):
        series.frame(frame)
        assert len(listed(tmp_path)) == (5 if count >= 5 else min(count, 2))
        for _, name in listed(tmp_path):
            for entry in xml.parse(tmp_path / name).iter("DataSet"):
                assert (tmp_path / entry.get("file")).exists()


def test_frames_of_a_former_run_do_not_mix_in(tmp_path, coarse_run):
    stale = tmp_path / "frame_9999.vtu"
    stale.write_text("old")
    other = tmp_path / "frame_notes.txt"
    other.write_text("mine")
    write_series(tmp_path, coarse_run)
    assert not stale.exists() and other.exists()


def test_streams_are_cheap(tmp_path, fine_run):
    """Film and series of 1269 elements, whole and with tools: below a tenth of a run of 6 s with 60 frames."""
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
    assert time.process_time() - started < 0.6


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
        assert np.array_equal(mesh.cell_data["thickness_m"][0], state.fields["thickness"])
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
        assert blocks.keys() == ["upper", "lower", "tools"]
        for sheet, about in zip(frame.sheets, info.sheets, strict=True):
            whole = about.symmetry.mirrored(sheet.position).astype(np.float32)
            assert np.array_equal(blocks[sheet.name].points, whole)
    for name, place, level in (("upper", 0, 0), ("lower", 1, 1)):
        assert set(blocks[name].cell_data["sheet"]) == {place}
        exploded = blocks[name].warp_by_vector("exploded_m").points - blocks[name].points
        gap = 0.15 * max(sheet.blank.size for sheet in info.sheets)
        assert exploded == pytest.approx(np.tile([0.0, 0.0, level * gap], (len(exploded), 1)), abs=1e-7)
    final = pyvista.read(str(tmp_path / "final_state.vtm"))
    assert final.keys() == ["upper", "lower"] and set(final["lower"].cell_data["sheet"]) == {1}


def test_frames_of_a_former_run_of_several_sheets_go_too(tmp_path, coarse_run, stack):
    write_series(tmp_path, stack)
    write_series(tmp_path, coarse_run)
    assert not list(tmp_path.glob("frame_*_upper.vtu"))
