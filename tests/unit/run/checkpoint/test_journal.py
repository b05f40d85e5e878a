"""The frames of a run on disk: all of them, with their bits, or a word."""

import dataclasses

import numpy as np
import pytest

from tests.support.made_run import made_run, made_stack
from weavesim.run.checkpoint.container import DamageError
from weavesim.run.checkpoint.journal import FrameJournal, frame_content, frame_of, memory_order


def same(a, b) -> bool:
    """Whether two frames have the same bits, in the same order in memory."""
    if isinstance(a, np.ndarray):
        alike = (a.dtype, a.shape, memory_order(a)) == (b.dtype, b.shape, memory_order(b))
        return alike and a.tobytes() == b.tobytes()
    if dataclasses.is_dataclass(a):
        return all(same(getattr(a, field.name), getattr(b, field.name)) for field in dataclasses.fields(a))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[name], b[name]) for name in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)


@pytest.fixture(scope="module")
def frames():
    return made_stack()[1]


def journal_of(folder, frames) -> FrameJournal:
    journal = FrameJournal(folder / "frames.bin")
    journal.begin()
    for frame in frames:
        journal.append(frame)
    return journal


def test_frames_come_back_with_their_bits(tmp_path, frames):
    journal = journal_of(tmp_path, frames)
    journal.sync()
    again = list(FrameJournal(journal.path).frames(journal.count, journal.size))
    assert len(again) == len(frames) and all(map(same, frames, again))


def test_the_order_of_an_array_in_memory_is_kept(frames):
    """A sum over an array depends on it."""
    sheet = dataclasses.replace(frames[0].sheets[0], position=np.asfortranarray(frames[0].sheets[0].position))
    frame = dataclasses.replace(frames[0], sheets=(sheet, frames[0].sheets[1]))
    assert same(frame, frame_of(frame_content(frame)))


def test_single_precision_takes_half_the_space(frames):
    sheet = frames[1].sheets[0]
    short = {name: values.astype(np.float32).astype(np.float64) for name, values in sheet.fields.items()}
    frame = dataclasses.replace(frames[1], sheets=(dataclasses.replace(sheet, fields=short),))
    content = frame_content(frame)
    assert all(content.arrays[f"frame/sheets/0/fields/{name}"].dtype == np.float32 for name in short)
    assert content.arrays["frame/sheets/0/position"].dtype == np.float64 and same(frame, frame_of(content))


@pytest.mark.parametrize("special", [np.nan, -np.nan, np.inf, -0.0, 1e-310, 5e-324, 1e300, 1e-42])
def test_special_numbers_keep_their_bits(frames, special):
    frame = dataclasses.replace(frames[0], tool_displacement=np.array([special]), time=float(special))
    assert same(frame, frame_of(frame_content(frame)))


def test_the_first_frames_are_enough_and_the_others_are_written_again(tmp_path, frames):
    """A killed run has written frames, and parts of one, after its last checkpoint."""
    journal = journal_of(tmp_path, frames[:2])
    count, size = journal.count, journal.size
    journal.append(frames[2])
    with open(journal.path, "ab") as file:
        file.write(b"half a frame")
    again = FrameJournal(journal.path)
    assert len(list(again.frames(count, size))) == 2
    again.append(frames[3])
    third = list(FrameJournal(journal.path).frames(again.count, again.size))
    assert all(map(same, [*frames[:2], frames[3]], third)) and journal.path.stat().st_size == again.size


def test_a_frame_that_had_no_room_is_written_at_its_place(tmp_path, frames, monkeypatch):
    journal = journal_of(tmp_path, frames[:1])
    size = journal.size
    monkeypatch.setattr("weavesim.run.checkpoint.journal.packed", lambda *content: [b"half", NotImplemented])
    with pytest.raises(TypeError):
        journal.append(frames[1])
    monkeypatch.undo()
    assert (journal.count, journal.size) == (1, size)
    journal.append(frames[1])
    assert all(map(same, frames[:2], journal.frames(journal.count, journal.size)))


@pytest.mark.parametrize("seed", range(40))
def test_damage_is_found(tmp_path, frames, seed):
    journal, rng = journal_of(tmp_path, frames[:3]), np.random.default_rng(seed)
    data = bytearray(journal.path.read_bytes())
    place = int(rng.choice([rng.integers(len(data)), rng.integers(8)]))  # also within the first length
    if seed % 2:
        data[place] ^= 1 << int(rng.integers(8))
    else:
        data = data[:place]
    journal.path.write_bytes(data)
    with pytest.raises(DamageError, match="damaged|cut off"):
        list(FrameJournal(journal.path).frames(journal.count, journal.size))


def test_a_promise_of_a_length_is_not_believed(tmp_path):
    info, frames = made_run(0.03, 3)
    journal = journal_of(tmp_path, frames)
    data = bytearray(journal.path.read_bytes())
    data[:8] = (2**62).to_bytes(8, "little")
    journal.path.write_bytes(data)
    with pytest.raises(DamageError, match="frame 0 of 3 is damaged"):
        list(FrameJournal(journal.path).frames(journal.count, journal.size))


def test_a_wrong_size_is_found(tmp_path, frames):
    journal = journal_of(tmp_path, frames)
    with pytest.raises(DamageError, match="instead of"):
        list(FrameJournal(journal.path).frames(2, journal.size))
