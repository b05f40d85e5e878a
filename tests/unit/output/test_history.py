"""Scalars of every frame, and their table."""

import csv
import dataclasses

import numpy as np
import pytest

from weavesim.output import History


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


def test_ratios_of_energies_are_sizes_where_there_is_something_to_compare(history):
    kinetic, internal = (history.energies[name] for name in ("kinetic", "internal"))
    ratio = history.energy_ratios["kinetic over internal energy"]
    there = np.isfinite(ratio)
    assert there.any() and not there[0]
    assert ratio[there] == pytest.approx(100.0 * kinetic[there] / internal[there])
    assert len(history.energy_ratios) == 4 and all(
        (each[np.isfinite(each)] > 0.0).all() for each in history.energy_ratios.values()
    )
