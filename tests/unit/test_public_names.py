"""One place lists the public names, and the documentation imports no others.

That place is ``weavesim/__init__.py``. ``weavesim.measures`` and ``weavesim.output`` have more, to evaluate results.
"""

import ast
import re
from importlib import import_module

import pytest

import weavesim
from tests.support.paths import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def imports_of(page: str) -> set[tuple[str, str]]:
    """Module and name of all that the Python of a page imports from weavesim."""
    found = set()
    for code in re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL):
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == "weavesim":
                found |= {(node.module, alias.name) for alias in node.names}
    return found


def is_public(module: str, name: str) -> bool:
    """A name of weavesim, of one of its folders, or of a scene."""
    if module.startswith("weavesim.scenes."):
        return True
    return name in import_module(module).__all__ if module.count(".") < 2 else False


def test_the_documentation_imports_public_names():
    found = {str(page.relative_to(ROOT)): imports_of(page.read_text(encoding="utf-8")) for page in PAGES}
    assert sum(map(len, found.values())) > 10
    private = {name: {i for i in imports if not is_public(*i)} for name, imports in found.items()}
    assert {name: imports for name, imports in private.items() if imports} == {}


@pytest.mark.parametrize(
    "line", ["from weavesim.fabric.shear.linear import LinearShear", "from weavesim.tools import IDENTITY"]
)
def test_a_private_import_is_found(line):
    (found,) = imports_of(f"```python\n{line}\n```")
    assert not is_public(*found)


def test_type_checkers_see_the_same_names():
    """The imports under TYPE_CHECKING and the table that finds a name when it is used."""
    tree = ast.parse((ROOT / "weavesim" / "__init__.py").read_text(encoding="utf-8"))
    imports = {
        (node.module, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module != "version"
        for alias in node.names
    }
    assert imports == {(module, name) for name, module in weavesim._module_of.items()}


@pytest.mark.parametrize("room", ["fabric", "process", "sheet", "tools"])
def test_what_a_room_hands_on_is_in_the_list(room):
    inner = {"DeviceForm", "Tabulated", "PRESETS", "UNIT_CELLS"}  # for laws of one's own, and registries
    assert set(import_module(f"weavesim.{room}").__all__) <= set(weavesim.__all__) | inner
