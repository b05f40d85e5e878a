"""Sections and pages of the documentation, read from ``docs/README.md``: one list for GitHub and for the site."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

# A page in the list: its title, its file relative to docs/, and what it is about.
ENTRY = re.compile(r"^(?:-|\d+\.) \[(?P<title>[^\]]+)\]\((?P<file>[\w./-]+\.(?:md|ipynb))\)", flags=re.MULTILINE)


@dataclass(frozen=True)
class Section:
    """What one kind of reader looks for: a title, and (title, file relative to docs/) of its pages in order."""

    title: str
    pages: tuple[tuple[str, str], ...]


def sections(index: Path) -> list[Section]:
    """Sections of the list of documents, those without pages left out."""
    _, *parts = re.split(r"^## ", index.read_text(encoding="utf-8"), flags=re.MULTILINE)
    found = []
    for part in parts:
        title, _, text = part.partition("\n")
        pages = tuple((entry["title"], entry["file"]) for entry in ENTRY.finditer(text))
        if pages:
            found.append(Section(title.strip(), pages))
    return found
