"""Sizes of modules, functions, kernels and folders, and their imports, in this checkout and another commit.

    python scripts/sizes.py                      this checkout
    python scripts/sizes.py --commit 4add259     compared with that commit

The sources of kernels/, weavesim/, scenes/ and scripts/ are parsed: nothing is imported. A function's lines are counted
from its def to its end, including nested functions; self and cls do not count as arguments. An arrow is an import of
one module by another, at the top or inside a function; between folders, all in the same direction count once.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from scripts.shared.checkouts import checked_out, full_name  # noqa: E402
from scripts.shared.report import table  # noqa: E402
from tests.support.imports import Sources, circles  # noqa: E402

LISTED_COUNT = 10
DEVICE_DECORATORS = ("wp.kernel", "wp.func")


@dataclass(frozen=True)
class Function:
    """A function, method, kernel or device function.

    Attributes:
        name: with its module.
        lines: from ``def`` to the end.
        arguments: number, without self and cls.
        on_device: True for a kernel or device function.
    """

    name: str
    lines: int
    arguments: int
    on_device: bool


@dataclass(frozen=True)
class Sizes:
    """Counts of one checkout, each by name."""

    module_lines: dict[str, int]
    public_names: dict[str, int]
    functions: tuple[Function, ...]
    folder_files: dict[str, int]
    module_arrows: int
    folder_arrows: int
    levels: int
    circles: tuple[tuple[str, ...], ...]

    @classmethod
    def of(cls, root: Path) -> Sizes:
        """Count the checkout in ``root``."""
        sources = Sources(root)
        arrows = {module: found - {module} for module, found in sources.imports().items()}
        folder_of = {module: str(file.parent.relative_to(root)) for module, file in sources.file_of.items()}
        folders = [folder_of[module] for module in sources.file_of if not sources.is_package(module)]
        between = {(folder_of[a], folder_of[b]) for a, found in arrows.items() for b in found}
        return cls(
            module_lines={module: len(file.read_text().splitlines()) for module, file in sources.file_of.items()},
            public_names={module: _public_names(tree) for module, tree in sources.tree_of.items()},
            functions=tuple(found for module, tree in sources.tree_of.items() for found in _functions(tree, module)),
            folder_files={folder: folders.count(folder) for folder in sorted(set(folders))},
            module_arrows=sum(len(found) for found in arrows.values()),
            folder_arrows=sum(a != b for a, b in between),
            levels=_levels(arrows),
            circles=tuple(tuple(circle) for circle in circles(arrows)),
        )

    def lines(self, on_device: bool) -> dict[str, int]:
        """Lines of functions on the host, or on the device."""
        return {function.name: function.lines for function in self.functions if function.on_device == on_device}

    def arguments(self, on_device: bool) -> dict[str, int]:
        """Arguments of functions on the host, or on the device."""
        return {function.name: function.arguments for function in self.functions if function.on_device == on_device}


MEASURES: dict[str, Callable[[Sizes], dict[str, int]]] = {
    "lines of a module": lambda sizes: sizes.module_lines,
    "public names of a module": lambda sizes: sizes.public_names,
    "lines of a function": lambda sizes: sizes.lines(on_device=False),
    "arguments of a function": lambda sizes: sizes.arguments(on_device=False),
    "lines of a kernel or device function": lambda sizes: sizes.lines(on_device=True),
    "arguments of a kernel or device function": lambda sizes: sizes.arguments(on_device=True),
    "files of a folder": lambda sizes: sizes.folder_files,
}
COUNTS: dict[str, Callable[[Sizes], int]] = {
    "modules": lambda sizes: len(sizes.module_lines),
    "functions": lambda sizes: len(sizes.lines(on_device=False)),
    "kernels and device functions": lambda sizes: len(sizes.lines(on_device=True)),
    "imports of one module by another": lambda sizes: sizes.module_arrows,
    "imports between folders": lambda sizes: sizes.folder_arrows,
    "levels of imports": lambda sizes: sizes.levels,
    "circles of imports": lambda sizes: len(sizes.circles),
}


def _public_names(tree: ast.Module) -> int:
    names = set()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names |= {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    return sum(not name.startswith("_") for name in names)


def _functions(tree: ast.AST, place: str) -> Iterator[Function]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            given = node.args
            names = [argument.arg for argument in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
            names += [argument.arg for argument in (given.vararg, given.kwarg) if argument]
            yield Function(
                name=f"{place}.{node.name}",
                lines=(node.end_lineno or node.lineno) - node.lineno + 1,
                arguments=sum(name not in ("self", "cls") for name in names),
                on_device=any(ast.unparse(each).startswith(DEVICE_DECORATORS) for each in node.decorator_list),
            )
        named = isinstance(node, ast.FunctionDef | ast.ClassDef)
        yield from _functions(node, f"{place}.{node.name}" if named else place)


def _levels(arrows: dict[str, set[str]]) -> int:
    """Number of modules on the longest import chain; modules that import each other count as one."""
    one_of = {module: module for module in arrows}
    for circle in circles(arrows):
        one_of |= dict.fromkeys(circle, circle[0])
    below: dict[str, set[str]] = {}
    for module, found in arrows.items():
        below.setdefault(one_of[module], set()).update({one_of[other] for other in found} - {one_of[module]})
    known: dict[str, int] = {}

    def level(module: str) -> int:
        if module not in known:
            known[module] = 1 + max(map(level, below[module]), default=0)
        return known[module]

    return max(map(level, below))


def summary(checkouts: dict[str, Sizes]) -> str:
    """Medians, 90th percentiles, maxima and counts of each checkout."""
    rows: list[list[object]] = []
    for name, measure in MEASURES.items():
        row: list[object] = [name]
        for sizes in checkouts.values():
            values = list(measure(sizes).values())
            row += [f"{np.median(values):g}", f"{np.percentile(values, 90, method='higher'):g}", max(values)]
        rows.append(row)
    columns = [f"{label}{what}" for label in checkouts for what in (": median", ": 90 %", ": largest")]
    counts = [[name, *(count(sizes) for sizes in checkouts.values())] for name, count in COUNTS.items()]
    return table(["size", *columns], rows, right=True) + "\n\n" + table(["count", *checkouts], counts, right=True)


def largest(checkouts: dict[str, Sizes]) -> str:
    """The ten largest of each checkout, for each measure."""
    parts = []
    for name, measure in MEASURES.items():
        lists = []
        for sizes in checkouts.values():
            ordered = sorted(measure(sizes).items(), key=lambda item: -item[1])[:LISTED_COUNT]
            lists.append([f"{value} `{label}`" for label, value in ordered])
        longest = max(len(one) for one in lists)
        rows = [[one[index] if index < len(one) else "" for one in lists] for index in range(longest)]
        parts.append(f"### {name.capitalize()}\n\n" + table(list(checkouts), rows))
    return "\n\n".join(parts)


def main(commit: Annotated[str | None, typer.Option(help="another commit, to be shown first")] = None) -> None:
    """Sizes of modules, functions, kernels and folders, and their imports, as Markdown."""
    checkouts: dict[str, Sizes] = {}
    if commit:
        with checked_out(full_name(commit)) as folder:
            checkouts[commit] = Sizes.of(folder)
    checkouts["this checkout"] = Sizes.of(ROOT)
    print(summary(checkouts))
    print(f"\n{largest(checkouts)}")
    for label, sizes in checkouts.items():
        for circle in sizes.circles:
            print(f"\nCircle in {label}: {', '.join(circle)}")


if __name__ == "__main__":
    typer.run(main)
