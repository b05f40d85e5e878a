"""Dependencies point down only: scripts and command line, then scenes, then weavesim, then kernels, then Warp."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import weavesim
from tests.support.paths import ROOT

# What each layer may use of the others; anything below its own line.
ALLOWED_LAYERS = {
    "kernels": {"kernels"},
    "weavesim": {"kernels", "weavesim"},
    "scenes": {"kernels", "weavesim", "scenes"},
}
ALLOWED_IN_KERNELS = {"warp", "numpy"}


def imported_modules(source: str, package: str) -> set[str]:
    """Absolute names of all modules that ``source`` imports, at its top or inside functions."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parent = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            module = ".".join([*parent, *([node.module] if node.module else [])])
            names |= {f"{module}.{alias.name}" for alias in node.names}
    return names


def layer_of(module: str) -> str | None:
    """Layer of a module of this project, None for all others."""
    parts = module.split(".")
    if parts[0] == "weavesim":
        return parts[1] if len(parts) > 1 and parts[1] in ("kernels", "scenes") else "weavesim"
    return parts[0] if parts[0] in ("kernels", "scenes", "scripts", "tests") else None


def violations(source: str, layer: str, package: str) -> list[str]:
    """Imports that a file of ``layer`` must not have."""
    modules = imported_modules(source, package)
    wrong = [name for name in modules if layer_of(name) not in ALLOWED_LAYERS[layer] | {None}]
    if layer == "kernels":
        outside = {name for name in modules if layer_of(name) is None}
        wrong += [
            name
            for name in outside
            if name.split(".")[0] not in ALLOWED_IN_KERNELS | sys.stdlib_module_names
            # Warp needs real annotations: a postponed one breaks its closures.
            or name == "__future__.annotations"
        ]
    return sorted(wrong)


def package_of(path: Path) -> str:
    relative = path.relative_to(ROOT).parent.parts
    return ".".join(relative if relative[0] == "weavesim" else ("weavesim", *relative))


@pytest.mark.parametrize("layer", ALLOWED_LAYERS)
def test_layer_imports_only_what_lies_below(layer):
    files = sorted((ROOT / layer).rglob("*.py"))
    assert files
    found = {str(file.relative_to(ROOT)): violations(file.read_text(), layer, package_of(file)) for file in files}
    assert {file: wrong for file, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(
    ("layer", "source"),
    [
        ("kernels", "from __future__ import annotations"),
        ("kernels", "import scipy.linalg"),
        ("kernels", "from ..device import Precision"),
        ("kernels", "from weavesim import device"),
        ("weavesim", "def run():\n    from .scenes.double_dome import run"),
        ("weavesim", "from . import scenes"),
        ("scenes", "import scripts.double_dome"),
    ],
)
def test_forbidden_import_is_found(layer, source):
    package = "weavesim" if layer == "weavesim" else f"weavesim.{layer}"
    assert violations(source, layer, package)


@pytest.mark.parametrize("module", ["weavesim", "weavesim.app.command_line", "weavesim.tools"])
def test_import_leaves_heavy_modules_alone(module):
    heavy = {"warp", "matplotlib", "pxr", "meshio", "trimesh", "scipy", "jinja2", "pydantic.main"}
    if module != "weavesim":
        heavy.discard("pydantic.main")  # typer and the checked values use it
    code = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert heavy & set(done.stdout.split()) == set()


@pytest.mark.parametrize("name", weavesim.__all__)
def test_exported_name_exists(name):
    assert getattr(weavesim, name) is not None


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Weave'"):
        weavesim.Weave  # noqa: B018
