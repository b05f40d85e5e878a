"""From bytes to lines."""

import pytest

from weavesim.tables.text import TableFault, text_lines

TEXT = "angle [°],force\n0,1\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252", "latin-1"])
def test_encodings(encoding):
    assert text_lines(TEXT.encode(encoding))[0] == ["angle [°],force", "0,1", ""]


def test_all_line_ends_count_and_no_other_characters():
    assert text_lines("a\rb\r\nc\n\nd\u2028e\x85f\x0cg".encode())[0] == ["a", "b", "c", "", "d\u2028e\x85f\x0cg"]


def test_the_encoding_is_noted_where_it_was_guessed():
    assert text_lines(TEXT.encode("cp1252"))[1] == ("read as Windows-1252",)
    assert text_lines(b"\x81 [\xb0]\n")[1] == ("read as Latin-1",)
    assert text_lines(TEXT.encode("utf-16"))[1] == ("read as UTF-16",)
    assert text_lines(TEXT.encode())[1] == ()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"PK\x03\x04", "workbook"), (b"%PDF-1.4", "PDF"), (b"\x1f\x8b\x08", "unpack"), (b"a\0b\0", "UTF-16 without"),
        (b"\xff\xfe\x00\xd8", "begins like UTF-16"), (b"\xef\xbb\xbf\xff", "begins like UTF-8"),
        (b"\x1b[31m", "binary"),
        (b"a" * 200_000, "characters in a line"), (b"\n" * 5_000_000, "lines"), (b"\xd0\xcf\x11\xe0", "old Excel"),
    ],
)  # fmt: skip
def test_what_is_no_text_is_refused(content, message):
    with pytest.raises(TableFault, match=message):
        text_lines(content)
