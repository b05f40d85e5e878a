"""The sources of the site: a copy of ``docs/`` with its navigation, the pages of the root, and the reference."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from scripts.documentation import reference
from scripts.documentation.navigation import Section, sections

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
INDEX = "index.md"
# Files outside docs/ that are pages of the site, and where.
OUTSIDE = {
    "README.md": "overview.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "weavesim/fabric/data/README.md": "fabric_data.md",
}
LINK = re.compile(r"(?P<mark>!?)\[(?P<text>(?:[^\[\]]|\[[^\]]*\])*)\]\((?P<target>[^)\s]+)\)")


def page_of(path: Path) -> str | None:
    """Where a file of the checkout is in the site; None for what is no part of it."""
    name = path.relative_to(ROOT).as_posix()
    if path == DOCS / "README.md":
        return INDEX
    if name in OUTSIDE:
        return OUTSIDE[name]
    return path.relative_to(DOCS).as_posix() if path.is_relative_to(DOCS) and path.is_file() else None


def with_links_of_the_site(text: str, source: Path, page: str) -> str:
    """Text of ``source`` as ``page``: its links lead to pages; what is only in the checkout is named, not linked."""
    up = "../" * page.count("/")

    def replaced(match: re.Match[str]) -> str:
        target, _, anchor = match["target"].partition("#")
        if not target or re.match(r"[a-z]+:", target):
            return match[0]
        path = (source.parent / target).resolve()
        if path == DOCS / "decisions":
            return f"[{match['text']}]({up}{INDEX}#decisions)"
        there = page_of(path)
        if there is None:
            name = path.relative_to(ROOT).as_posix()
            return match["text"] if "`" in match["text"] else f"{match['text']} (`{name}`)"
        return f"{match['mark']}[{match['text']}]({up}{there}{'#' + anchor if anchor else ''})"

    blocks = re.split(r"(^```.*?^```$)", text, flags=re.DOTALL | re.MULTILINE)
    return "".join(block if block.startswith("```") else LINK.sub(replaced, block) for block in blocks)


def navigation(found: list[Section], listed: dict[str, list[str]]) -> str:
    """Hidden tables of contents, one per section; ``listed`` has those that are not in the list of documents."""
    sides = [(section.title, [f"{title} <{file}>" for title, file in section.pages]) for section in found]
    before = [side for side in sides if side[0] != "Decisions"]
    after = [side for side in sides if side[0] == "Decisions"]
    tables = [*before, *listed.items(), *after]
    return "".join(
        "\n```{toctree}\n:hidden:\n:caption: " + title + "\n\n" + "\n".join(pages) + "\n```\n"
        for title, pages in tables
    )


def titled(found: list[Section]) -> list[Section]:
    """The sections with files as pages of the site."""
    return [
        Section(one.title, tuple((title, page_of((DOCS / file).resolve()) or file) for title, file in one.pages))
        for one in found
    ]


def stage(folder: Path) -> None:
    """Write the sources of the site to ``folder``, which is emptied."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for source in sorted(DOCS.rglob("*")):
        page = page_of(source)
        if page is None or source.suffix == ".md":
            continue
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / page)
    for source in [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in OUTSIDE)]:
        page = page_of(source)
        assert page is not None
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        text = with_links_of_the_site(source.read_text(encoding="utf-8"), source, page)
        (folder / page).write_text(text, encoding="utf-8")
    pages = reference.write(folder / "reference")
    index = folder / INDEX
    found = titled(sections(DOCS / "README.md"))
    extra = {"Reference": [f"reference/{name}" for name in pages]}
    (folder / INDEX).write_text(index.read_text(encoding="utf-8") + navigation(found, extra), encoding="utf-8")
