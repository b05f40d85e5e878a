"""``weavesim docs``: the documents that travel with the package, in the terminal."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError, did_you_mean
from .terminal import say

WIDTH = 100
INDEX = "README"


def documents() -> Path:
    """Folder of the documents: inside the package, or ``docs`` of a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "docs"
    return inside if inside.is_dir() else package.parent / "docs"


def pages() -> dict[str, Path]:
    """Every document by its name; those in folders with the folder, a decision also by its number."""
    folder = documents()
    found = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.md"))}
    numbers = {
        match[1].lstrip("0"): path for name, path in found.items() if (match := re.match(r"decisions/(\d+)", name))
    }
    return found | numbers


def docs_command(
    page: Annotated[str, typer.Argument(help="name of a page, such as job, or number of a decision")] = INDEX,
    path: Annotated[bool, typer.Option("--path", help="print where the page is, and not its text")] = False,
) -> None:
    """Read the documentation: a list of its pages, or the one that is named."""
    known = pages()
    if not known:
        raise InputError(f"{documents()}: there are no documents; install weavesim anew")
    name = page.removesuffix(".md").removeprefix("docs/")
    if name not in known:
        raise InputError(f"page {page!r} is unknown{did_you_mean(name, known)}; weavesim docs lists all pages")
    if path:
        say(str(known[name]))
        return
    show(known[name].read_text(encoding="utf-8"))


def show(text: str) -> None:
    """Write Markdown: rendered and in pages on a terminal, and as it is anywhere else."""
    if not sys.stdout.isatty():
        say(text.rstrip("\n"))
        return
    from rich.console import Console
    from rich.markdown import Markdown

    console = Console()
    with console.pager(styles=True):
        console.print(Markdown(text), width=min(console.width, WIDTH))
