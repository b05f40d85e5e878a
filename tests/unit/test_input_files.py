"""Files that a user names: regular, bounded, and inside the folder that refers to them."""

import os
import socket

import pytest

from weavesim.errors import InputError
from weavesim.input_files import (
    _UNITS,
    IN_COMMAND,
    IN_JOB,
    check_bounded,
    path_of,
    read_bounded,
    shown,
    unit_wish,
    units_given_as,
    within_folder,
)
from weavesim.job.units import length_unit


def test_a_file_is_read_up_to_its_largest_size(tmp_path):
    path = tmp_path / "data"
    path.write_bytes(b"12345")
    assert read_bounded(path, "data file", 5) == b"12345" and check_bounded(path, "data file", 5) == 5
    for read in (read_bounded, check_bounded):
        with pytest.raises(InputError, match="data file .*data: .* MiB or more; at most"):
            read(path, "data file", 4)


@pytest.mark.parametrize("value", [None, 1, 2.5, b"x.toml", ["x"], {}, True, "", " "])
def test_what_is_no_path_is_refused(value):
    for read in (
        path_of,
        lambda path, what: read_bounded(path, what, 5),
        lambda path, what: check_bounded(path, what, 5),
    ):
        with pytest.raises(InputError, match="fabric file = .*the path of a file is needed"):
            read(value, "fabric file")


def test_a_huge_file_is_not_read(tmp_path):
    path = tmp_path / "huge"
    with path.open("wb") as file:
        file.truncate(10 * 2**30)  # holes: takes no room
    with pytest.raises(InputError, match="1.024e\\+04 MiB or more; at most 50 MiB"):
        read_bounded(path, "table", 50 * 2**20)


def make_folder(path):
    path.mkdir()


def make_socket(path):
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(os.path.relpath(path))  # the whole name may be too long for a socket


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        (make_folder, "it is a folder"),
        (os.mkfifo, "it is a pipe"),
        (make_socket, "it is a socket"),
        (lambda path: path.symlink_to("/dev/zero"), "it is a device"),
        (lambda path: path.symlink_to(path.name), "cannot be read"),
        (lambda path: None, "No such file"),
    ],
)
def test_what_is_no_regular_file_is_refused_without_waiting(tmp_path, make, kind):
    path = tmp_path / "it"
    make(path)
    for read in (read_bounded, check_bounded):
        with pytest.raises(InputError, match=kind):
            read(path, "table", 100)


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000])
def test_impossible_names_are_refused(name):
    with pytest.raises(InputError, match="cannot be read"):
        read_bounded(name, "table", 100)


def test_a_file_without_a_size_is_bounded_too():
    """/proc reports no sizes."""
    if not os.path.exists("/proc/cpuinfo"):
        pytest.skip("needs /proc")
    with pytest.raises(InputError, match="or more"):
        read_bounded("/proc/cpuinfo", "table", 10)


@pytest.mark.parametrize("reference", ["frame.csv", "./frame.csv", "data/frame.csv", "data/../frame.csv", "inner.csv"])
def test_references_inside_a_folder_are_followed(tmp_path, reference):
    (tmp_path / "data").mkdir()
    (tmp_path / "inner.csv").symlink_to(tmp_path / "data" / "frame.csv")
    assert within_folder(tmp_path, reference, "csv").is_relative_to(tmp_path.resolve())


@pytest.mark.parametrize(
    "reference",
    ["/etc/passwd", "../frame.csv", "data/../../frame.csv", "out.csv", "far/frame.csv", "C:\\frame.csv", "\\\\host\\x"],
)
def test_references_out_of_a_folder_are_refused(tmp_path, reference):
    home = tmp_path / "home"
    home.mkdir()
    (home / "data").mkdir()
    (tmp_path / "frame.csv").write_text("secret")
    (home / "out.csv").symlink_to("../frame.csv")
    (home / "far").symlink_to(tmp_path)
    with pytest.raises(InputError, match="leads out of the folder.*copy the data beside"):
        within_folder(home, reference, "csv")


@pytest.mark.parametrize("reference", [1, None, ["frame.csv"], {}, "", " ", "a\0b", True])
def test_a_reference_is_a_text(tmp_path, reference):
    with pytest.raises(InputError, match="the name of a file is needed"):
        within_folder(tmp_path, reference, "csv")


def test_a_unit_is_asked_for_as_the_user_gives_it():
    assert unit_wish(0.001) == "unit_scale=0.001"
    with units_given_as(IN_JOB):
        assert [unit_wish(size) for size in (0.001, 1.0, 0.0254)] == ['unit = "mm"', 'unit = "m"', 'unit = "inch"']
        with units_given_as(IN_COMMAND):
            assert unit_wish(0.001) == "--unit mm"
        assert unit_wish(0.002) == "unit_scale=0.002"  # it has no name
    assert unit_wish(0.3048) == "unit_scale=0.3048"


def test_every_name_of_a_unit_is_one_that_jobs_read():
    for metres, name in _UNITS.items():
        assert length_unit(name) == pytest.approx(metres, rel=1e-12)


def test_shown_text_stays_on_one_line():
    assert shown("a\nb\x1b[31m\u2028é\udcff") == r"a\nb\x1b[31m\u2028é\udcff"
