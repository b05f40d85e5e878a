"""Which module of the project imports which, read from the sources of any checkout without importing them."""

import ast
from functools import cached_property
from pathlib import Path

# Folders next to weavesim/ in a checkout that are installed inside it.
INSIDE = ("kernels", "scenes")


def imported_names(tree: ast.Module, package: str) -> set[str]:
    """Absolute names of all that ``tree`` imports, at its top or inside functions, but not for annotations alone."""
    names = set()
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            pending += node.orelse
            continue
        pending += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")
            parent = parts[: len(parts) + 1 - node.level] if node.level else []
            module = ".".join([*parent, *([node.module] if node.module else [])])
            names |= {f"{module}.{alias.name}" for alias in node.names}
    return names


class Sources:
    """The modules of a checkout.

    Args:
        root: of the checkout.

    Attributes:
        file_of: path of every module of kernels, weavesim, scenes and scripts by its name, as it is imported.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.file_of: dict[str, Path] = {}
        for folder in (*INSIDE, "weavesim", "scripts"):
            for file in sorted((root / folder).rglob("*.py")):
                parts = file.relative_to(root).with_suffix("").parts
                parts = ("weavesim", *parts) if folder in INSIDE else parts
                self.file_of[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file

    @cached_property
    def tree_of(self) -> dict[str, ast.Module]:
        """Of every module its syntax tree; reading them all takes seconds."""
        return {name: ast.parse(file.read_text()) for name, file in self.file_of.items()}

    def is_package(self, module: str) -> bool:
        """Whether ``module`` is the __init__.py of a folder."""
        return self.file_of[module].name == "__init__.py"

    def package_of(self, module: str) -> str:
        """Where the relative imports of ``module`` start."""
        return module if self.is_package(module) else module.rpartition(".")[0]

    def names_in(self, module: str) -> set[str]:
        """Absolute names of all that ``module`` imports."""
        return imported_names(self.tree_of[module], self.package_of(module))

    def imports(self) -> dict[str, set[str]]:
        """The modules of the project that each of them imports."""
        return {
            module: {found for name in self.names_in(module) if (found := self._module(name))}
            for module in self.file_of
        }

    def _module(self, name: str) -> str | None:
        """The module that an imported name is, or lies in."""
        while name and name not in self.file_of:
            name = name.rpartition(".")[0]
        return name or None


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import each other, directly or through others."""
    reached: dict[str, set[str]] = {}
    for start in imports:
        found, pending = set(), list(imports[start])
        while pending:
            module = pending.pop()
            if module not in found:
                found.add(module)
                pending += imports.get(module, ())
        reached[start] = found
    groups = {
        tuple(sorted(other for other in reached[module] if module in reached[other]))
        for module in imports
        if module in reached[module]
    }
    return [list(group) for group in sorted(groups)]
