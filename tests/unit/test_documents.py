"""TOML and JSON files of parameters: bounded, and refused with key and line."""

import os
import time

import pytest

from weavesim.documents import LARGEST_DOCUMENT, read_document
from weavesim.errors import InputError
from weavesim.fabric import Fabric


def read(tmp_path, text, name="own.toml"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_document(path, "fabric file")


def test_documents_are_read(tmp_path):
    assert read(tmp_path, "a = 1\n[b]\nc = [1.5, 'x']").values == {"a": 1, "b": {"c": [1.5, "x"]}}
    assert read(tmp_path, '{"a": 1, "b": null}', "own.json").values == {"a": 1, "b": None}
    assert read(tmp_path, b"\xef\xbb\xbfa = 1\r\n").values == {"a": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = 1\na = 2\n", "Cannot overwrite a value .*line 2"),
        ("a = \n", "line 1"),
        ("a = .5", "a digit before its point"),
        ("a = [0.1, .2]", "a digit before its point"),
        ("a = 1.\n", "a digit after its point"),
        ("a = 0,6", "decimals with a point"),
        ("a = 1.2 mm", "without its unit"),
        ("a = 2e-3m", "without its unit"),
        ("a = True", "write true or false"),
        ("kind = MomentCurve", "a text needs quotation marks"),
        ("a: 1", 'TOML has "name = value"'),
        ('{"a": 1}', "it looks like JSON: let its name end in .json"),
        (
            "a = 1e-3\na = 2e-3\n",
            "no valid TOML: Cannot overwrite a value .at line 2, column 9.; a is given twice, leave one of them out$",
        ),
        ("[[b]]\na = 1\nc.d = 2\nc.d = 3\n", "at line 4, column 8.; c.d is given twice, leave one of them out$"),
        ("[a]\nb = 1\n[a]\n", "Cannot declare .*; a is given twice, leave one of them out$"),
        ("a = [[[[[[[[[[[[[[1]]]]]]]]]]]]]]", "line 1: a: nested too deeply"),
        ("a = " + "[" * 50_000, "nested too deeply"),
        ("a = " + "{b=" * 20_000, "nested too deeply"),
        ("a = " + "1" * 5000, "a number of thousands of digits"),
        ("a = 0x" + "f" * 5000, "line 1: a: the whole number is too large"),
        ("a = 100000000000000000000", "line 1: a: the whole number is too large"),
        ("a = 1e999", "a: inf is given; a finite number is needed"),
        ("\n\n[b]\na = nan\n", "line 4: b.a: nan is given"),
        ("a = 2024-01-01", "a: 2024-01-01 is a date or a time"),
        ("a = 10:00:00", "a: 10:00:00 is a date or a time"),
        ("a = 2024-01-01T00:00:00Z", "is a date or a time"),
        ('"a\\nb" = 1', r"a\\nb: a key may contain printable characters only"),
        ('a = "x\\u001b[31m"', "a: a text may contain printable characters only"),
        ('a = "x\\u2028y"', "printable"),
        ("a." * 100_000 + "a = 1", "line 1: more than 60 points"),
        ("[" + "a." * 100_000 + "a]", "more than 60 points"),
        ("x = {" + "a." * 100_000 + "a = 1}", "more than 60 points"),
        ("a = 1\nb = '\xff'\n".encode("latin-1"), "line 2: not in UTF-8"),
        ("a = 1".encode("utf-16"), "line 1: not in UTF-8"),
        (b"\0\0", "fabric file"),
    ],
)
def test_bad_toml_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as raised:
        read(tmp_path, text)
    assert "\n" not in str(raised.value) and len(str(raised.value)) < 600


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1]", "a table of parameters is needed, not a list"),
        ("1", "not a number"),
        ("null", "not nothing"),
        ('"x"', "not a text"),
        ('{"a": 1, "a": 2}', "'a' occurs twice in one table"),
        ('{"b": {"a": 1, "a": 1}}', "'a' occurs twice"),
        ('{"a": NaN}', "NaN: a finite number is needed"),
        ('{"a": [1e999]}', "a: inf is given"),
        ('{"a": -Infinity}', "-Infinity: a finite"),
        ('{"a": ' + "9" * 5000 + "}", "thousands of digits"),
        ("[" * 100_000, "nested too deeply"),
        ('{"a":' * 100_000, "nested too deeply"),
        ('{"a": 1', "line 1 column"),
        ("", "line 1 column 1"),
    ],
)
def test_bad_json_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, text, "own.json")


@pytest.mark.parametrize("name", ["own.yaml", "own.tml", "own"])
def test_a_file_of_another_kind_is_told_how_it_was_read(tmp_path, name):
    with pytest.raises(InputError, match="no valid JSON: .*does not end in .toml is read as JSON"):
        read(tmp_path, "a: 1\n", name)


def test_a_file_without_end_is_refused(tmp_path):
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "large.toml").write_text("#" * (LARGEST_DOCUMENT + 1))
    for name, message in (
        ("zero", "a device"),
        ("pipe", "a pipe"),
        ("large", "at most 1 MiB"),
        ("none", "No such file"),
    ):
        with pytest.raises(InputError, match=message):
            read_document(tmp_path / f"{name}.toml", "fabric file")


@pytest.mark.parametrize(
    "text",
    ["a = '" + "." * 900_000 + "'", "a" * 900_000 + " = 1", '"' + "a." * 450_000 + '" = 1', "[a]\n" * 200_000,
     "a = [" + "1.5," * 200_000 + "]", "\n".join(f"a{k}.b.c = 1" for k in range(50_000)),
     "a = '''" + "x\n" * 400_000 + "'''", "#" + "." * 900_000],
    ids=range(8),
)  # fmt: skip
def test_large_files_end_in_time(tmp_path, text):
    start = time.process_time()
    try:
        read(tmp_path, text)
    except InputError as error:
        assert len(str(error)) < 600
    assert time.process_time() - start < 20.0


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (("a",), 1), (("b",), 3), (("b", "c"), 4), (("b", "d", "e"), 6), (("b", "d", "f"), 5), (("x",), 0),
        (("q r", "s"), 7), (("q r", "t", "u"), 8), (("q r", "t", "v"), 8),
    ],
)  # fmt: skip
def test_the_line_of_a_key_is_found(tmp_path, keys, line):
    text = 'a = 1\n# b\n[b]\nc = 2 # c\n[b.d]\n"e" = 3\n["q r"]\nt = {u = 1, v = 2}\n'
    assert read(tmp_path, text).line_of(keys) == line
    assert read(tmp_path, "{}", "own.json").line_of(keys) == 0


@pytest.mark.parametrize("value", [None, 3, ["{}"], {"name": "x"}])
def test_what_is_no_text_is_no_json(value):
    with pytest.raises(InputError, match="a text is needed"):
        Fabric.from_json(value)
