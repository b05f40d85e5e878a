"""The order of the rooms: a folder imports only what stands before it, and no room grows until nobody finds anything.

What is not so yet stands in a list of exceptions, each with its reason. An exception that is needed no longer fails
here too, so that the lists can only become shorter.
"""

import ast
import subprocess
import sys

import pytest

import weavesim
from tests.support.imports import Sources, circles, imported_names
from tests.support.paths import ROOT
from tests.support.rooms import ORDER, room_of

ALLOWED_IN_KERNELS = {"warp", "numpy"}

LARGEST_MODULE = 400
LONG_MODULES: dict[str, str] = {}
# About a dozen; a folder's __init__.py does not count.
LARGEST_FOLDER = 13
FULL_FOLDERS: dict[str, str] = {"scripts": "every scene has its script here, under the name that users know"}
CIRCLES: dict[tuple[str, ...], str] = {}
WITHOUT_WARP = (
    "weavesim", "weavesim.fabric", "weavesim.sheet", "weavesim.process", "weavesim.tools", "weavesim.measures",
    "weavesim.engine.setup",
)  # fmt: skip
# What loads no heavy package either; these first, for what is loaded stays.
LIGHT = ("weavesim", "weavesim.app.command_line", "weavesim.tools")
IN_ORDER = (*LIGHT, *(module for module in WITHOUT_WARP if module not in LIGHT))

SOURCES = Sources(ROOT)


def violations(names: set[str], room: str) -> list[str]:
    """Imports that a module of ``room`` must not have."""
    allowed = {"kernels"} if room == "kernels" else set(ORDER[: ORDER.index(room) + 1])
    if room == "scripts":
        allowed |= {"door", "tests"}
    wrong = {name for name in names if room_of(name) not in allowed | {None} and name != "weavesim.__version__"}
    if room == "kernels":
        wrong |= {
            name
            for name in names
            if (room_of(name) is None and name.split(".")[0] not in ALLOWED_IN_KERNELS | sys.stdlib_module_names)
            # Warp needs real annotations: a postponed one breaks its closures.
            or name == "__future__.annotations"
        }
    return sorted(wrong)


@pytest.mark.parametrize("room", ORDER)
def test_a_room_imports_only_what_stands_before_it(room):
    modules = [module for module in SOURCES.file_of if room_of(module) == room]
    assert modules
    found = {module: violations(SOURCES.names_in(module), room) for module in modules}
    assert {module: wrong for module, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    ("room", "source"),
    [
        ("kernels", "from __future__ import annotations"),
        ("kernels", "import scipy.linalg"),
        ("kernels", "from ..device import Precision"),
        ("kernels", "from weavesim import device"),
        ("base", "from .fabric import Fabric"),
        ("fabric", "from ..sheet.blank import Blank"),
        ("run", "def draw():\n    from ..output import pictures"),
        ("app", "def run():\n    from ..scenes.double_dome import run"),
        ("app", "from .. import scenes"),
        ("app", "from .. import Simulation"),
        ("scenes", "import scripts.double_dome"),
        ("output", "from tests.support import frames"),
    ],
)
def test_a_forbidden_import_is_found(room, source):
    package = "weavesim" if room == "base" else f"weavesim.{room}"
    assert violations(imported_names(ast.parse(source), package), room)


def test_no_modules_import_each_other():
    assert {tuple(circle) for circle in circles(SOURCES.imports())} == set(CIRCLES)


def test_a_circle_is_found():
    imports = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set(), "e": {"e"}}
    assert circles(imports) == [["a", "b", "c"], ["e"]]


def test_no_module_is_long():
    files = [*SOURCES.file_of.values(), *(ROOT / "tests").rglob("*.py")]
    long = {str(file.relative_to(ROOT)) for file in files if len(file.read_text().splitlines()) > LARGEST_MODULE}
    assert long == set(LONG_MODULES)


def test_no_folder_is_full():
    counts: dict[str, int] = {}
    for module, file in SOURCES.file_of.items():
        if not SOURCES.is_package(module):
            folder = str(file.parent.relative_to(ROOT))
            counts[folder] = counts.get(folder, 0) + 1
    assert {folder for folder, count in counts.items() if count > LARGEST_FOLDER} == set(FULL_FOLDERS)


@pytest.fixture(scope="module")
def loaded_after():
    """All modules that a fresh Python has after importing one of these after the other: none has loaded more alone."""
    code = (
        "import importlib, sys\nfor name in sys.argv[1:]:\n    importlib.import_module(name)\n    print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code, *IN_ORDER], cwd=ROOT, capture_output=True, text=True, check=True)
    return dict(zip(IN_ORDER, (set(line.split()) for line in done.stdout.splitlines()), strict=True))


@pytest.mark.parametrize("module", WITHOUT_WARP)
def test_import_loads_no_warp(loaded_after, module):
    assert "warp" not in loaded_after[module]


@pytest.mark.parametrize("module", LIGHT)
def test_import_leaves_heavy_modules_alone(loaded_after, module):
    heavy = {"warp", "matplotlib", "pxr", "meshio", "trimesh", "scipy", "jinja2", "pydantic.main"}
    if module != "weavesim":
        heavy.discard("pydantic.main")  # typer and the checked values use it
    assert heavy & loaded_after[module] == set()


@pytest.mark.parametrize("name", weavesim.__all__)
def test_exported_name_exists(name):
    assert getattr(weavesim, name) is not None


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Weave'"):
        weavesim.Weave  # noqa: B018
