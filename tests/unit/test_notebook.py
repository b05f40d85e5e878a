"""Tables for notebooks: every field with its meaning, and nothing of a name is taken for HTML."""

import html.parser

import numpy as np
import pytest

from weavesim.device import Precision
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.notebook import LONGEST_LIST, meanings_of, shown, table_of


class Reader(html.parser.HTMLParser):
    """Text of a page, and the elements that are open at its end."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(text: str) -> list[str]:
    reader = Reader(text)
    assert reader.open == []
    return reader.words


def test_a_fabric_is_a_table_of_its_fields_with_their_units():
    fabric = glass_polypropylene()
    words = read(fabric._repr_html_())
    assert words[0] == f"Fabric {fabric.name}"
    for name, field in Fabric.model_fields.items():
        assert name in words and field.description in words
    assert "0.743" in words and "PlainWeave" in words


def test_a_setup_tells_what_its_fields_mean_from_its_docstring():
    from tests.support.runs import one_sheet_setup
    from weavesim.sheet.blank import Blank

    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.06), 0.01)
    setup = one_sheet_setup(name="tray", blank=blank, fabric=glass_polypropylene(), duration=0.25)
    text = setup._repr_html_()
    words = read(text)
    assert "Setup tray" in words
    assert any(word.startswith("time at which the run ends [s]") for word in words) and "0.25" in words
    assert f"array of {blank.node_count} × 3" in words
    meanings = meanings_of(type(setup))
    assert set(meanings) == set(type(setup).model_fields) and all(meanings.values())


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "–"), (True, "yes"), (False, "no"), (1.23456789, "1.23457"), (3, "3"), (Precision.SINGLE, "float32"),
        (np.zeros((2, 3)), "array of 2 × 3"), (np.float64(2.5), "2.5"), ((), "none"), ({}, "none"),
        ((1, 2.5), "1, 2.5"), ("a & <b>", "a & <b>"),
        (tuple(range(LONGEST_LIST + 1)), "9 values, 0 to 8"), ("<i>", "<i>"), ({"a": 1.0}, "a: 1"),
    ],
)  # fmt: skip
def test_values_are_short_and_plain(value, words):
    assert "".join(read(shown(value))) == words


def test_a_name_is_no_html():
    fabric = glass_polypropylene().model_copy(update={"name": "<b>fine</b> & dry"})
    text = fabric._repr_html_()
    assert "<b>" not in text and "Fabric <b>fine</b> & dry" in read(text)


def test_long_texts_are_cut_and_many_values_folded():
    assert len(shown("x" * 1000)) == 300
    origins = glass_polypropylene().provenance
    assert len(origins) > LONGEST_LIST
    text = shown(origins)
    assert text.startswith(f"<details><summary>{len(origins)} values") and read(text)


def test_every_kind_of_value_can_be_shown():
    from tests.support.every_kind import every_kind

    for name, setup in every_kind().items():
        assert read(table_of(setup))[0].startswith("Setup"), name
