"""Containers: whole or refused."""

import errno
import hashlib
import os

import numpy as np
import pytest

from weavesim.run.checkpoint import container
from weavesim.run.checkpoint.container import (
    FORMAT_VERSION,
    DamageError,
    packed,
    read_container,
    unpacked,
    write_container,
)

VALUES = {"text": "ä", "numbers": [1, 0.1, float("inf"), -0.0], "none": None, "order": {"b": 1, "a": 2}}
ARRAYS = {
    "doubles": np.array([[0.1, -0.0], [np.nan, np.inf]]),
    "singles": np.arange(6, dtype=np.float32).reshape(2, 3)[:, ::2],
    "none": np.zeros((3, 0), dtype=np.int32),
    "scalar": np.array(7, dtype=np.int64),
}


def whole() -> bytes:
    return b"".join(packed(VALUES, ARRAYS))


def test_everything_comes_back_with_its_bits():
    values, arrays = unpacked(whole())
    assert repr(values) == repr(VALUES) and list(values["order"]) == ["b", "a"]
    assert list(arrays) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert (arrays[name].dtype, arrays[name].shape) == (array.dtype, array.shape)
        assert arrays[name].tobytes() == array.tobytes()


def test_every_flipped_bit_is_found():
    data = whole()
    for place in range(len(data)):
        damaged = bytearray(data)
        damaged[place] ^= 1 << (place % 8)
        with pytest.raises(DamageError):
            unpacked(bytes(damaged))


def test_every_truncation_is_found():
    data = whole()
    for length in range(len(data)):
        with pytest.raises(DamageError):
            unpacked(data[:length])
    with pytest.raises(DamageError):
        unpacked(data + b"\0")


def signed(data: bytes) -> bytes:
    """With a valid checksum, as somebody could write it on purpose."""
    return data + hashlib.sha256(data).digest()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"not JSON", "not as weavesim writes it"),
        (b"[]", "not as weavesim writes it"),
        (b'{"values": {}, "arrays": [["a", "<f8", [1000000000000]]]}', "not as weavesim writes it"),
        (b'{"values": {}, "arrays": [["a", "O", [1]]]}', "not as weavesim writes it"),
        (b'{"values": {}, "arrays": [["a", "nonsense", [1]]]}', "not as weavesim writes it"),
        (b"[" * 100_000, "not as weavesim writes it"),
    ],
)
def test_a_checksum_is_no_signature(text, message):
    head = container._HEADER.pack(container.MAGIC, FORMAT_VERSION, len(text))
    with pytest.raises(DamageError, match=message):
        unpacked(signed(head + text))


def test_another_version_is_named():
    head = container._HEADER.pack(container.MAGIC, FORMAT_VERSION + 1, 2)
    with pytest.raises(DamageError, match=f"version {FORMAT_VERSION + 1} of the format"):
        unpacked(signed(head + b"{}"))


def test_another_file_is_named():
    with pytest.raises(DamageError, match="no file of a checkpoint"):
        unpacked(signed(b"PK\x03\x04" + bytes(100)))


def test_numbers_of_numpy_are_numbers_and_others_are_refused():
    assert unpacked(b"".join(packed({"a": np.float32(0.5), "b": np.int64(3)}, {}))).values == {"a": 0.5, "b": 3}
    with pytest.raises(TypeError, match="object cannot be kept"):
        packed({"a": object()}, {})


@pytest.mark.parametrize("failing", ["fsync", "replace"])
def test_a_file_appears_whole_or_not_at_all(tmp_path, monkeypatch, failing):
    path = tmp_path / "a.bin"
    write_container(path, {"a": 1}, {})

    def fails(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, failing, fails)
        with pytest.raises(OSError, match="No space"):
            write_container(path, {"a": 2}, {})
    assert read_container(path).values == {"a": 1} and [p.name for p in tmp_path.iterdir()] == ["a.bin"]


def test_the_file_is_on_the_disk_before_its_name_and_its_name_before_the_end(tmp_path, monkeypatch):
    done = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda descriptor: done.append("fsync") or fsync(descriptor))
    monkeypatch.setattr(os, "replace", lambda *names: done.append("replace") or replace(*names))
    write_container(tmp_path / "a.bin", {}, {})
    assert done == ["fsync", "replace", "fsync"]
