"""The checksum at the start of an HDF5 file: the rest stays readable, and every change is found."""

import h5py
import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.output.claim.record import file_hash
from weavesim.output.stored.sealed import USER_BLOCK, check_seal, seal


@pytest.fixture
def path(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w", userblock_size=USER_BLOCK) as file:
        file["numbers"] = np.arange(1000.0)
    seal(tmp_path / "a.h5")
    return tmp_path / "a.h5"


def test_a_sealed_file_is_read_by_others(path):
    check_seal(path)
    assert path.read_bytes().startswith(b"weavesim results, SHA-256 of all bytes from 512 on: ")
    with h5py.File(path) as file:
        assert file.userblock_size == USER_BLOCK and np.array_equal(file["numbers"][()], np.arange(1000.0))


@pytest.mark.parametrize(
    "change", [lambda data: data[:-1], lambda data: data + b"\0", lambda data: b"", lambda data: data[1:]]
)
def test_a_changed_length_is_found(path, change):
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(InputError, match="damaged: it is not what was written, by its checksum; copy the folder again"):
        check_seal(path)


def test_without_a_seal_another_record_counts(tmp_path):
    path = tmp_path / "b.h5"
    with h5py.File(path, "w") as file:
        file["numbers"] = [1.0]
    check_seal(path)
    check_seal(path, file_hash(path))
    with pytest.raises(InputError, match="damaged"):
        check_seal(path, "0" * 64)
