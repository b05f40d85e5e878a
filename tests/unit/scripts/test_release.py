"""A release: archives without what differs from build to build, and the same wheel from two places."""

import os
import shutil
import tarfile
import time
from importlib.metadata import version

import pytest

from scripts.releasing.release import build, digest, normalise
from tests.support.paths import ROOT


def archive(path, names, *, at, owner):
    """A source archive of files with a time and an owner."""
    folder = path.parent / f"of_{path.stem}"
    for name in names:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
        os.utime(file, (at, at))

    def owned(entry):
        entry.uname, entry.uid = owner, len(owner)
        return entry

    with tarfile.open(path, "w:gz") as new:
        for name in names:
            new.add(folder / name, f"package/{name}", filter=owned)
    return path


def test_times_owners_and_order_leave_nothing(tmp_path):
    one = archive(tmp_path / "one.tar.gz", ["a.py", "b/c.py"], at=1_000_000_000, owner="me")
    other = archive(tmp_path / "other.tar.gz", ["b/c.py", "a.py"], at=1_500_000_000.5, owner="somebody")
    assert digest(one) != digest(other)
    for path in (one, other):
        normalise(path, 1_700_000_000)
    assert digest(one) == digest(other)
    with tarfile.open(one) as read:
        assert [(entry.name, entry.mtime, entry.uname) for entry in read] == [
            ("package/a.py", 1_700_000_000, ""), ("package/b/c.py", 1_700_000_000, ""),
        ]  # fmt: skip
        assert read.extractfile("package/b/c.py").read() == b"b/c.py"


def test_another_content_is_another_archive(tmp_path):
    one = archive(tmp_path / "one.tar.gz", ["a.py"], at=1, owner="me")
    other = archive(tmp_path / "other.tar.gz", ["b.py"], at=1, owner="me")
    for path in (one, other):
        normalise(path, 0)
    assert digest(one) != digest(other)


def test_a_wheel_is_the_same_from_two_places(tmp_path):
    """A small package with the build system and the settings of this one; make release does it with the whole."""
    if int(version("setuptools").split(".")[0]) < 77:
        pytest.skip("building needs setuptools 77 or newer, which the test extra installs")
    made = []
    for place in ("first", "a_second_place"):
        folder = tmp_path / place
        (folder / "small").mkdir(parents=True)
        (folder / "small" / "__init__.py").write_text("value = 1\n")
        shutil.copy(ROOT / "LICENSE", folder)
        (folder / "pyproject.toml").write_text(
            '[build-system]\nrequires = ["setuptools>=77"]\nbuild-backend = "setuptools.build_meta"\n'
            '[project]\nname = "small"\nversion = "1.0"\nlicense = "Apache-2.0"\nlicense-files = ["LICENSE"]\n'
            '[tool.setuptools]\npackages = ["small"]\n'
        )
        made.append([digest(build(folder, kind, 1_700_000_000)) for kind in ("sdist", "wheel")])
        time.sleep(1.1)  # archives count seconds
    assert made[0] == made[1]
