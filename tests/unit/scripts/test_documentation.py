"""The site of the documentation: its list of pages, its formulas, its links, what checks it, the gallery."""

import re
import shlex

import pytest
from PIL import Image

from scripts.doc_tables import PAGES, text_of, text_with_tables
from scripts.documentation import built_pages, gallery, make_gallery, reference, staging
from scripts.documentation.formulas import markup
from scripts.documentation.navigation import sections
from tests.support.paths import ROOT

DOCS = ROOT / "docs"
WANTED = (
    "First run", "Your own part", "Your own fabric", "Process", "Results", "Theory", "Verification and validation",
    "Performance", "Reliability", "The project", "Decisions",
)  # fmt: skip


def formulas(text):
    """Formulas of a page: (LaTeX, whether it is a block)."""
    blocks = re.findall(r"```math\n(.*?)```", text, flags=re.DOTALL)
    rest = re.sub(r"`[^`\n]*`", "", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    return [(one, True) for one in blocks] + [(one, False) for one in re.findall(r"(?<![\\$])\$([^$]+)\$", rest)]


def test_every_page_is_in_one_section():
    found = sections(DOCS / "README.md")
    assert [one.title for one in found] == list(WANTED)
    files = [file for one in found for _, file in one.pages]
    assert len(files) == len(set(files))
    here = [*DOCS.glob("*.md"), *DOCS.glob("decisions/*.md"), *DOCS.glob("notebooks/*.ipynb")]
    listed = {(DOCS / file).resolve() for file in files}
    assert {path.resolve() for path in here} - listed == {DOCS / "README.md"}
    assert all(path.is_file() for path in listed)


def test_all_formulas_can_be_drawn():
    count = 0
    for path in sorted(DOCS.rglob("*.md")):
        for source, is_block in formulas(path.read_text(encoding="utf-8")):
            assert markup(source, is_block=is_block).endswith("</math>"), path
            count += 1
    assert count > 500


@pytest.mark.parametrize("source", [r"\frac{1}{", r"a + \nosuchcommand b"])
def test_a_formula_that_cannot_be_drawn_is_told(source):
    with pytest.raises(ValueError, match="known|read"):
        markup(source, is_block=False)


def test_formulas_look_as_in_print():
    assert "<mo>+=</mo>" in markup(r"F\mathrel{+}=x", is_block=False)
    assert markup(r"\lvert x\rvert", is_block=False).count('<mo stretchy="false" lspace="0" rspace="0">|</mo>') == 2
    assert '<mi>sin</mi><mspace width="0.167em" />' in markup(r"\sin x", is_block=False)
    assert "mspace" not in markup(r"\sin^2 x + \cos(x)", is_block=False)
    assert 'alttext="a &lt; b"' in markup("a < b", is_block=True)


def test_links_lead_to_pages_of_the_site():
    text = (
        "[a](job.md#blanks) [b](../CONTRIBUTING.md) [c](../weavesim/ranges.py) [d](decisions/0041-jobs.md) "
        "![e](images/check.png) [f](https://example.org) [`g`](../kernels/lanes.py)\n```\n[h](../README.md)\n```\n"
    )
    assert staging.with_links_of_the_site(text, DOCS / "meshes.md", "meshes.md") == (
        "[a](job.md#blanks) [b](contributing.md) c (`weavesim/ranges.py`) [d](decisions/0041-jobs.md) "
        "![e](images/check.png) [f](https://example.org) `g`\n```\n[h](../README.md)\n```\n"
    )
    below = staging.with_links_of_the_site(
        "[a](../README.md) [b](../theory.md)", DOCS / "decisions" / "x.md", "decisions/x.md"
    )
    assert below == "[a](../index.md) [b](../theory.md)"


def test_built_pages_are_followed(tmp_path):
    (tmp_path / "a.html").write_text(
        '<h1 id="top">A</h1><a href="b.html#there">b</a><a href="#top">up</a><a href="https://example.org">out</a>'
        "<code>$x$</code><math><mi>x</mi></math>"
    )
    (tmp_path / "b.html").write_text('<h1 id="there">B</h1><img src="c.png">')
    (tmp_path / "c.png").write_bytes(b"")
    assert built_pages.problems(tmp_path) == []
    (tmp_path / "b.html").write_text(
        '<script src="https://example.org/x.js"></script><img src="d.png"><a href="a.html#gone">a</a><p>$x$</p>'
    )
    assert built_pages.problems(tmp_path) == [
        "a.html: b.html#there has no such anchor",
        "b.html: loads https://example.org/x.js from a network",
        "b.html: a formula is left as text: $x$",
        "b.html: a.html#gone has no such anchor",
        "b.html: d.png is not there",
    ]


def test_every_public_name_has_a_page():
    rooms = {room for *_, of_rooms in reference.PAGES for room in of_rooms}
    assert set(reference.public_names()) == rooms


def test_every_command_is_in_the_reference():
    text = reference.command_page()
    for name in ("weavesim form", "weavesim double-dome", "weavesim fabric show", "weavesim docs"):
        assert f"\n{name}\n{'-' * len(name)}\n" in text
    assert "``--punch-speed``\n" in text and "``--picture-frame``\n" in text and "``--help" not in text


@pytest.mark.parametrize("page", PAGES)
def test_the_tables_of_a_page_are_those_of_the_code(page):
    assert text_with_tables(page) == text_of(page), "run python scripts/doc_tables.py"


def test_the_gallery_shows_what_its_commands_make():
    names = [one.name for one in gallery.EXHIBITS]
    assert len(set(names)) == len(names)
    for one in gallery.EXHIBITS:
        picture = Image.open(gallery.FOLDER / f"{one.name}.png").convert("RGB")
        assert make_gallery.coloured_share(picture) > make_gallery.LEAST_COLOURED, one.name
        assert one.after in ("", *names[: names.index(one.name)]), one.name
        assert one.commands or one.after, one.name


def test_a_picture_that_does_not_show_what_its_text_says_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(gallery, "FOLDER", tmp_path)
    monkeypatch.setattr(make_gallery, "FOLDER", tmp_path)
    (verdict,) = [one for one in gallery.EXHIBITS if one.name == "verdict"]
    folder = tmp_path / "verdict"
    folder.mkdir()
    Image.new("RGB", (200, 100), "#d6d9e0").save(folder / "verdict.png")
    (folder / "verdict.json").write_text('{"sheets": [{"regions": []}]}')
    with pytest.raises(SystemExit, match="its text is not true"):
        make_gallery.write(verdict, tmp_path)
    (folder / "verdict.json").write_text('{"sheets": [{"regions": [{"kind": "wrinkle"}, {"kind": "bridging"}]}]}')
    with pytest.raises(SystemExit, match="shows next to nothing"):
        make_gallery.write(verdict, tmp_path)
    Image.new("RGB", (200, 100), "#d1495b").save(folder / "verdict.png")
    assert make_gallery.write(verdict, tmp_path).is_file()


@pytest.mark.parametrize("command", [command for one in gallery.EXHIBITS for command in one.commands])
def test_every_command_of_the_gallery_exists(command):
    """Its options are known to the command; nothing runs."""
    import typer

    from weavesim.app.command_line import application

    program, *words = shlex.split(command)
    if program == "python":
        assert (ROOT / words[0]).is_file()
        return
    found, path = typer.main.get_command(application), "weavesim"
    while getattr(found, "commands", None):
        path += f" {words[0]}"
        found = found.commands[words.pop(0)]
    options = {name.split()[0].rstrip(",") for name, _ in reference.options_of(path, found)}
    assert {word for word in words if word.startswith("--")} <= options


def test_a_picture_brings_the_runs_that_it_needs():
    assert [one.name for one in make_gallery.with_those_before(["net"])] == ["formed_sheet", "net"]
    assert [one.name for one in make_gallery.with_those_before(["stack"])] == ["stack"]
