"""CSV tables that a run leaves, and measured ones that a user gives."""

import csv
import dataclasses

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.measures.angles import shear_angle_at, ten_points
from weavesim.measures.border import outline
from weavesim.output import History, load_measured_angles, load_measured_outline
from weavesim.output.tables import write_draw_in, write_shear_angles


def read(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def history(coarse_run):
    info, frames = coarse_run
    result = History()
    result.start(info)
    for frame in frames:
        result.frame(frame)
    return result


def test_history_has_every_frame_tool_and_energy(tmp_path, history, coarse_run):
    frames = coarse_run[1]
    history.write(tmp_path / "history.csv")
    rows = read(tmp_path / "history.csv")
    assert len(rows) == len(frames)
    for row, frame in zip(rows, frames, strict=True):
        assert int(row["frame"]) == frame.index and int(row["step_count"]) == frame.step_count
        assert float(row["time_s"]) == pytest.approx(frame.time)
        assert float(row["stroke_m"]) == pytest.approx(frame.stroke)
        for k, name in enumerate(("punch", "die", "blank_holder")):
            assert float(row[f"{name}_displacement_m"]) == pytest.approx(frame.tool_displacement[k])
            force = [float(row[f"{name}_force_{axis}_n"]) for axis in "xyz"]
            assert force == pytest.approx(frame.tool_reaction[k])
        for name, value in frame.energies.items():
            assert float(row.get(f"{name}_j") or row[f"{name}_energy_j"]) == pytest.approx(value)


def test_history_of_a_run_without_tools(tmp_path, coarse_run):
    info, frames = coarse_run
    history = History()
    history.start(dataclasses.replace(info, tools=()))
    frame = frames[1]
    history.frame(type(frame)(**{**vars(frame), "tool_displacement": np.zeros(0), "tool_reaction": np.zeros((0, 3))}))
    history.write(tmp_path / "history.csv")
    assert list(read(tmp_path / "history.csv")[0])[:5] == [
        "frame", "step_count", "time_s", "stroke_m", "kinetic_energy_j",
    ]  # fmt: skip
    assert history.tool_reaction.shape == (1, 0, 3)


def test_a_new_start_forgets_the_former_run(history, coarse_run):
    assert history.frame_count == len(coarse_run[1]) and history.last_frame is coarse_run[1][-1]
    history.start(coarse_run[0])
    assert history.frame_count == 0 and history.last_frame is None and history.energies == {}


def test_shear_angle_table(tmp_path, coarse_run):
    info, frames = coarse_run
    points = ten_points(0.235, 0.135)
    angle = frames[-1].fields["shear_angle"]
    written = write_shear_angles(tmp_path / "t.csv", info.sheet.blank, angle, points, info.sheet.symmetry)
    rows = read(tmp_path / "t.csv")
    assert [int(row["point"]) for row in rows] == list(range(1, 11))
    assert [float(rows[0][name]) for name in ("material_x_mm", "material_y_mm")] == [235.0, 0.0]
    values = [float(row["shear_angle_deg"]) for row in rows]
    assert values == pytest.approx(shear_angle_at(info.sheet.blank, angle, points, info.sheet.symmetry))
    assert values == pytest.approx(written)
    assert values[0] < 1e-9 and values[-1] < 1e-9 and max(values) > 10.0


def test_draw_in_table_holds_the_free_border_in_order(tmp_path, coarse_run):
    info, frames = coarse_run
    blank, position = info.sheet.blank, frames[-1].position
    write_draw_in(tmp_path / "t.csv", blank, position, info.sheet.symmetry)
    rows = read(tmp_path / "t.csv")
    nodes = outline(blank, info.sheet.symmetry).node
    assert [int(row["node"]) for row in rows] == nodes.tolist()
    flat = np.array([[float(row["flat_x_mm"]), float(row["flat_y_mm"])] for row in rows])
    formed = np.array([[float(row[f"formed_{axis}_mm"]) for axis in "xyz"] for row in rows])
    assert flat == pytest.approx(1e3 * blank.material_coordinates[nodes])
    assert formed == pytest.approx(1e3 * position[nodes], rel=1e-6, abs=1e-6)
    assert float(rows[0]["draw_in_mm"]) == pytest.approx(flat[0, 0] - formed[0, 0], abs=1e-6)


def test_measured_angles_are_read(tmp_path):
    path = tmp_path / "angles.csv"
    path.write_text("\ufeffpoint, angle_deg, source\n3, 21.5, a\n1, 0\n\n", encoding="utf-8")
    numbers, angles = load_measured_angles(path)
    assert numbers.tolist() == [3, 1] and angles.tolist() == [21.5, 0.0]


def test_measured_outline_is_read_in_metres(tmp_path):
    path = tmp_path / "outline.csv"
    path.write_text("x_mm,y_mm\n200,0\n190.5,20\n")
    assert load_measured_outline(path) == pytest.approx(np.array([[0.2, 0.0], [0.1905, 0.02]]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no column point, angle_deg"),
        ("point,angle\n1,2\n", "no column angle_deg"),
        ("point,angle_deg\n", "no rows"),
        ("point,angle_deg\n1,ten\n", "line 2"),
        ("point,angle_deg\n1,2\n2\n", "line 3"),
        ("point,angle_deg\n1,nan\n", "not finite"),
        ("point,angle_deg\n1.5,3\n", "must be whole"),
        ("point,angle_deg\n1,3\n1,4\n", "each once"),
        ("point,angle_deg\n1,120\n", "below 90"),
    ],
)
def test_bad_measured_angles(tmp_path, text, message):
    path = tmp_path / "angles.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_measured_angles(path)
    assert str(path) in str(caught.value)


def test_unreadable_measured_files(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x80" * 20)
    (tmp_path / "single.csv").write_text("x_mm,y_mm\n1,2\n")
    (tmp_path / "metres.csv").write_text("x_mm,y_mm\n1e6,2\n1,3\n")
    for name, message in (
        ("missing.csv", "No such file"),
        ("binary.csv", "cannot be read"),
        ("single.csv", "one point only"),
        ("metres.csv", "give millimetres"),
        ("", "cannot be read"),
    ):
        with pytest.raises(InputError, match=message):
            load_measured_outline(tmp_path / name)
