"""One name in site-packages, everything inside it, and the same modules from a checkout."""

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

import weavesim
from tests.support.paths import ROOT

FOLDERS = ("weavesim", "kernels", "scenes")
# Without code: listed, so that the texts in it are installed.
DOCUMENTS = "weavesim.docs"
NOT_SOURCE = shutil.ignore_patterns("__pycache__", "*.egg-info")


def source_files() -> list[Path]:
    """Every file of the package, relative to the root of the checkout."""
    files = [file for folder in FOLDERS for file in (ROOT / folder).rglob("*") if file.is_file()]
    return sorted(file.relative_to(ROOT) for file in files if "__pycache__" not in file.parts)


def documents() -> list[Path]:
    """Every document that is installed, relative to the root of the checkout."""
    files = [file for ending in ("md", "ipynb", "stl") for file in (ROOT / "docs").rglob(f"*.{ending}")]
    return sorted(file.relative_to(ROOT) for file in files)


def installed_name(path: Path) -> str:
    return path.as_posix() if path.parts[0] == "weavesim" else f"weavesim/{path.as_posix()}"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """A wheel built from a copy of the checkout, without network."""
    if int(version("setuptools").split(".")[0]) < 77:
        pytest.skip("building needs setuptools 77 or newer, which the test extra installs")
    copy, out = tmp_path_factory.mktemp("checkout"), tmp_path_factory.mktemp("wheel")
    for folder in (*FOLDERS, "docs"):
        shutil.copytree(ROOT / folder, copy / folder, ignore=NOT_SOURCE)
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, copy)
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", out, copy]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return next(out.glob("weavesim-*.whl"))


def test_packages_are_all_listed():
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    folders = {installed_name(file.parent).replace("/", ".") for file in source_files() if file.suffix == ".py"}
    assert listed == folders | {DOCUMENTS}


def test_wheel_holds_every_file_and_one_name(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert names == {installed_name(file) for file in [*source_files(), *documents()]}
    assert "weavesim/docs/job.md" in names and "weavesim/docs/decisions/0001-total-lagrangian-one-director.md" in names


def test_installed_wheel_works_alone(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        "import weavesim, weavesim.kernels.lanes, weavesim.scenes as scenes;"
        "from weavesim.app.docs_command import pages;"
        "print(weavesim.__version__, weavesim.__file__, weavesim.kernels.__file__, scenes.__file__, sep='\\n');"
        "print(pages()['job'])"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-P", "-c", code]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    found_version, *paths = done.stdout.splitlines()
    assert found_version == weavesim.__version__
    assert all(path.startswith(str(tmp_path / "weavesim")) for path in paths)


def test_checkout_hides_an_installed_copy(wheel, tmp_path):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = "import weavesim.kernels.lanes, weavesim.scenes as scenes; print(weavesim.kernels.__file__, scenes.__file__)"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(ROOT / "kernels" / "__init__.py"), str(ROOT / "scenes" / "__init__.py")]
