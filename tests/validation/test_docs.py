"""The documents name what exists: files, modules, tests, identifiers of the code, and what their links point to."""

import ast
import importlib
import re
from functools import cache
from pathlib import Path

import pytest

from tests.support.paths import ROOT
from weavesim.measures.findings import SHEET_FINDINGS
from weavesim.run.verdict import RUN_FINDINGS

ROOMS = ("kernels", "weavesim", "scenes", "scripts", "tests", "docs")
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
PAGES = [*DOCUMENTS, ROOT / "CHANGELOG.md", *sorted((ROOT / "docs" / "decisions").glob("*.md"))]
# Files that a run writes or a user keeps may have any name.
RESULTS = (".csv", ".html", ".json", ".log", ".md", ".usdc")


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def code_spans(text: str) -> list[str]:
    """What is in single backticks, without the blocks of code and formulas."""
    return re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))


def named_files(text: str) -> list[str]:
    rooms = "|".join(ROOMS)
    found = re.findall(rf"(?<![\w/.-])((?:{rooms})/[\w./-]*\w)(?:::(\w+))?", text)
    return [f"{path}::{test}" if test else path for path, test in found if "NNNN" not in path]


def is_there(name: str) -> bool:
    path, _, test = name.partition("::")
    if not (ROOT / path).exists():
        return False
    return not test or re.search(rf"^def {test}\(", text_of(ROOT / path), flags=re.MULTILINE) is not None


def can_be_imported(name: str) -> bool:
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def anchors(text: str) -> set[str]:
    """The anchors that GitHub gives to the headings of a page."""
    heads = re.findall(r"^#+ (.+)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@cache
def words_of_the_code() -> frozenset[str]:
    # names of numbers are made of a name and a unit
    words = {finding.key for finding in (*SHEET_FINDINGS, *RUN_FINDINGS)}
    for room in (*ROOMS[:-1], "pyproject.toml", "Makefile"):
        place = ROOT / room
        for path in [place] if place.is_file() else place.rglob("*"):
            if path.suffix in (".py", ".toml", ".html", "") and path.is_file() and path != Path(__file__):
                words.update(re.findall(r"\w+", text_of(path)))
    return frozenset(words)


@pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)
def test_every_file_that_a_document_names_is_there(document):
    missing = [name for name in named_files(text_of(document)) if not is_there(name)]
    assert not missing


@pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)
def test_every_dotted_name_can_be_imported(document):
    names = set(re.findall(r"(?<![\w./-])weavesim(?:\.[A-Za-z_]\w*)+", text_of(document)))
    assert not [name for name in sorted(names) if not can_be_imported(name)]


@pytest.mark.parametrize("document", DOCUMENTS, ids=name_of)
def test_every_identifier_is_a_word_of_the_code(document):
    # columns of files are put together from parts; test_columns.py holds them against real ones
    spans = code_spans(text_of(document).partition("\n## Columns and entries\n")[0])
    names = {span for span in spans if re.fullmatch(r"[A-Za-z]\w*(?:\.\w+)*(?:\(\))?", span)}
    names = {name for name in names if not name.endswith(RESULTS)}
    assert not [name for name in sorted(names) if not words_of_the_code().issuperset(re.findall(r"\w+", name))]


def folders_in(place: Path) -> list[Path]:
    """The packages directly in a folder."""
    return [path for path in sorted(place.iterdir()) if (path / "__init__.py").is_file()]


def rooms_of(document: Path, heading: str) -> list[str]:
    """The first cells of the table under a heading, in their order."""
    table = text_of(document).partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    return [line.split("|")[1].strip() for line in table.splitlines() if line.startswith("| ")][1:]


def test_the_layout_names_every_folder():
    rows = rooms_of(ROOT / "CONTRIBUTING.md", "Layout")
    folders = [*folders_in(ROOT / "kernels"), *folders_in(ROOT / "weavesim")]
    assert folders and not [name_of(path) for path in folders if f"`{name_of(path)}/`" not in rows]


def test_the_rooms_of_the_architecture_name_every_folder():
    """Those of kernels and of the engine stand in rows below theirs, which begin with a dot."""
    rows, own = rooms_of(ROOT / "docs" / "architecture.md", "The rooms"), {}
    for row in rows:
        if not row.startswith("·"):
            below = own.setdefault(row, [])
        else:
            below += re.findall(r"`(\w+)/`", row)
    assert not [path.name for path in folders_in(ROOT / "weavesim") if f"`{name_of(path)}/`" not in own]
    for room in ("kernels", "weavesim/engine"):
        assert sorted(path.name for path in folders_in(ROOT / room)) == sorted(own[f"`{room}/`"])


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_leads_somewhere(page):
    dead = []
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        place = page.parent / path if path else page
        if not place.exists() or (anchor and anchor not in anchors(text_of(place))):
            dead.append(target)
    assert not dead


def pattern_of(text: ast.expr) -> str:
    """A regular expression of a string in a source; what an f-string inserts may be anything."""
    parts = text.values if isinstance(text, ast.JoinedStr) else [text]
    return "".join(re.escape(part.value) if isinstance(part, ast.Constant) else ".*?" for part in parts)


def test_the_manual_has_the_words_of_its_studies():
    """A study that is new or reworded needs ``make verify``, or the same words by hand."""
    manual = text_of(ROOT / "docs" / "verification.md")
    known = [
        pattern_of(keyword.value)
        for path in (ROOT / "tests" / "verification").rglob("test_*.py")
        for call in ast.walk(ast.parse(text_of(path)))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "manual"
        for keyword in call.keywords
        if keyword.arg == "known"
    ]
    assert len(known) > 30
    assert not [pattern for pattern in known if not re.search(f"^Known: {pattern}$", manual, flags=re.MULTILINE)]


def test_the_list_of_documents_is_complete():
    folder = ROOT / "docs"
    listed = set(re.findall(r"\]\(([\w./-]+\.md)\)", text_of(folder / "README.md")))
    pages = [*folder.glob("*.md"), *(folder / "decisions").glob("*.md")]
    assert {path.relative_to(folder).as_posix() for path in pages} <= listed | {"README.md"}


def test_stale_names_would_be_noticed():
    assert named_files("see `kernels/cell/newton.py`, docs/theory.md.") == ["kernels/cell/newton.py", "docs/theory.md"]
    assert not is_there("kernels/element.py")
    assert is_there("tests/validation/test_docs.py::test_stale_names_would_be_noticed")
    assert not is_there("tests/validation/test_docs.py::test_of_nothing")
    assert can_be_imported("weavesim.respond")
    assert not can_be_imported("weavesim.unit_cell.respond")
    assert not can_be_imported("weavesim.fabric.Nothing")
    assert "UnitCell" in words_of_the_code()
    assert "MotionParameters" not in words_of_the_code()
    assert anchors("## 7. Time integration & step\n") == {"7-time-integration--step"}
