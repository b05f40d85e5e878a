"""Tables as laboratories write them: the right values, or a message with the line."""

import random
import re
import time

import numpy as np
import pytest

from tests.support.laboratory_tables import DEGREES, MACHINE, NEWTONS, READ, REFUSED, TAB_MACHINE, rows
from weavesim.errors import InputError
from weavesim.tables import Wanted, read_table, table
from weavesim.tables.text import text_lines


def read(path, content, *wanted):
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_table(path, "table").columns(*wanted)


@pytest.mark.parametrize("name", READ)
def test_what_laboratories_write_is_read(tmp_path, name):
    example = READ[name]
    wanted = Wanted(example.angle, "rad"), Wanted(example.force, "N")
    columns = read(tmp_path / "frame.csv", example.as_bytes, *wanted)
    np.testing.assert_allclose(columns.values[0], np.radians(DEGREES), rtol=1e-12)
    np.testing.assert_allclose(columns.values[1], NEWTONS, rtol=1e-12)
    last = text_lines(example.as_bytes)[0][columns.lines[-1] - 1]
    assert "102" in re.sub("[^0-9]", "", last) and len(columns.lines) == len(DEGREES)
    # a column alone is the same column
    for item, values in zip(wanted, columns.values, strict=True):
        assert np.array_equal(read_table(tmp_path / "frame.csv", "table").columns(item).values[0], values)


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_more_than_one_reading_is_refused(tmp_path, name):
    example = REFUSED[name]
    with pytest.raises(InputError, match=example.message) as raised:
        read(tmp_path / "frame.csv", example.as_bytes, Wanted(example.angle, "rad"), Wanted(example.force, "N"))
    assert str(raised.value).startswith(f"table {tmp_path / 'frame.csv'}") and "\n" not in str(raised.value)
    assert "secret" not in str(raised.value)


@pytest.mark.parametrize(
    ("content", "lines"),
    [
        ("angle,force\n0,0\n1,2\n", [2, 3]),
        ("\n\n# a\nangle,force\n\n0,0\n\n\n1,2", [6, 9]),
        ("angle,force\r\n0,0\r\n\r\n1,2\r\n", [2, 4]),
        ('"angle\n[rad]",force\n0,0\n\x0c\n1,2\n', [3, 5]),
        ("note \u2028 and \x85\nangle,force\n0,0\n1,2\n", [3, 4]),
    ],
)
def test_lines_are_counted_as_an_editor_counts_them(tmp_path, content, lines):
    assert read(tmp_path / "frame.csv", content, Wanted("angle"), Wanted("force")).lines.tolist() == lines


@pytest.mark.parametrize(
    ("column", "unit", "scale", "values"),
    [
        ("angle", "rad", None, np.radians([0.0, 10.0])),
        ("Angle [°]", "rad", None, np.radians([0.0, 10.0])),
        ("angle (deg)", "deg", None, [0.0, 10.0]),
        ("angle", "rad", 0.01745, [0.0, 0.1745]),
        ("angle", "rad", -np.pi / 180.0, -np.radians([0.0, 10.0])),
        ("force", "N", None, [0.0, 2500.0]),
        ("force", "", None, [0.0, 2500.0]),
        ("force", "kN", None, [0.0, 2.5]),
        ("force", "N", 1000.0, [0.0, 2500.0]),
        ("force", "N/m", 2.0, [0.0, 5.0]),
        ("plain", "N", 3.0, [0.0, 12.0]),
        ("plain", "N", None, [0.0, 4.0]),
        ("test_n", "rad", None, [0.0, 7.0]),
        ("odd [counts]", "N", 2.0, [0.0, 2.0]),
    ],
)
def test_units_are_converted_or_the_scale_is_taken(tmp_path, column, unit, scale, values):
    table = "angle [deg],force [kN],plain,odd [counts],test_n\n0,0,0,0,0\n10,2.5,4,1,7\n"
    columns = read(tmp_path / "frame.csv", table, Wanted(column, unit, scale))
    np.testing.assert_allclose(columns.values[0], values, rtol=1e-12)


@pytest.mark.parametrize(
    ("column", "unit", "scale", "message"),
    [
        ("angle", "rad", 1.0, "values times 0.0174532925 are wanted, but scale = 1 is given"),
        ("angle", "rad", 1000.0, "scale = 1000 is given"),
        ("force", "N", 1.0, "times 1000 are wanted, but scale = 1"),
        ("odd [counts]", "N", None, "'counts' is not known as a unit.*or give scale"),
        ("force [N]", "N", None, "no column force"),
        ("odd", "N", None, "'counts' is not known as a unit"),
    ],
)
def test_a_scale_must_not_contradict_the_header(tmp_path, column, unit, scale, message):
    table = "angle [deg],force [kN],plain,odd [counts]\n0,0,0,0\n10,2.5,4,1\n"
    with pytest.raises(InputError, match=message):
        read(tmp_path / "frame.csv", table, Wanted(column, unit, scale))


def test_a_needed_unit_must_be_there(tmp_path):
    with pytest.raises(InputError, match=r'does not say its unit; write it in the header, as in "angle \[deg\]"'):
        read(tmp_path / "frame.csv", "angle\n1\n2\n", Wanted("angle", "deg", needs_unit=True))


def test_what_was_not_obvious_is_noted(tmp_path):
    columns = read(tmp_path / "a.csv", MACHINE, Wanted("angle", "rad"), Wanted("force", "N"))
    assert columns.notes == ("header found in line 7", "column 'Angle' converted from deg to rad")
    german = read(tmp_path / "b.csv", "kraft [kN];x\n0,5;1\n".encode("utf-16"), Wanted("Kraft", "N"))
    assert german.notes == ("read as UTF-16", "column 'kraft [kN]' converted from kN to N", "decimal commas")
    assert read(tmp_path / "c.csv", "force\n1\n", Wanted("force", "N")).notes == ()


def test_rows_are_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "LARGEST_ROW_COUNT", 1000)
    (tmp_path / "long.csv").write_text("force\n" + "1\n" * 1000)
    assert len(read_table(tmp_path / "long.csv", "table").columns(Wanted("force")).lines) == 1000
    (tmp_path / "long.csv").write_text("force\n" + "1\n" * 1001)
    with pytest.raises(InputError, match="line 1002: more than 1000 rows; thin them out"):
        read_table(tmp_path / "long.csv", "table").columns(Wanted("force"))


@pytest.mark.parametrize(
    "content",
    ["\n" * 5_000_000, "a," * 10**6, 'force,"' + '"' * 99_998 + "\n1\n", "force\n" + "9" * 90_000,
     ("(" * 90_000 + "\n") * 50, "force " * 15_000 + "\n1\n", ("force,force_n\n" * 30_000),
     "# force\n" * 1000 + "#\n" * 1_000_000],
    ids=["lines", "long line", "quotes", "digits", "brackets", "names", "headers", "comments"],
)  # fmt: skip
def test_absurd_files_end_in_time(tmp_path, content):
    start = time.process_time()
    with pytest.raises(InputError):
        read(tmp_path / "absurd.csv", content, Wanted("force", "N"))
    assert time.process_time() - start < 20.0


def mutated(content: str, chance: random.Random) -> str:
    """``content`` with some characters changed, left out, doubled or inserted, or with lines moved."""
    text = list(content)
    for _ in range(chance.randint(1, 6)):
        place = chance.randrange(len(text))
        match chance.randrange(5):
            case 0:
                text[place] = chance.choice(",;\t .\"'#%-+eE0159[]()\n\r\u00a0\u2212xN°")
            case 1:
                del text[place : place + chance.randint(1, 4)]
            case 2:
                text[place:place] = text[place : place + chance.randint(1, 12)]
            case 3:
                text.insert(place, chance.choice(",;\t .\"'#%-+eE0159[]()\n\rxN°"))
            case 4:
                lines = "".join(text).split("\n")
                chance.shuffle(lines)
                text = list("\n".join(lines))
        text = text or [" "]
    return "".join(text)


@pytest.mark.parametrize("seed", range(8))
def test_mutated_tables_give_finite_numbers_or_a_message(tmp_path, seed):
    """And the digits of every number stand in its line."""
    chance = random.Random(seed)
    contents = ["angle,force\n" + rows(","), "angle;force\n" + rows(";", ","), MACHINE, TAB_MACHINE]
    wanted = [("angle", "force")] * 3 + [("Scherwinkel", "Standardkraft")]
    has_other_numbers = re.compile("[0-9.,][eEdD]|converted")
    start = time.process_time()
    for _ in range(150):
        which = chance.randrange(len(contents))
        content = mutated(contents[which], chance)
        try:
            columns = read(tmp_path / "frame.csv", content, *(Wanted(name) for name in wanted[which]))
        except InputError as error:
            assert "\n" not in str(error) and "Traceback" not in str(error)
            continue
        lines = re.split("\r\n|\n|\r", content)
        for values in columns.values:
            assert np.all(np.isfinite(values)) and len(values) == len(columns.lines)
        # every number stands in its line, with one of the two marks
        for line, *numbers in zip(columns.lines.tolist(), *columns.values, strict=True):
            digits = re.sub(r"[^0-9]", "", lines[line - 1].replace("\u2212", "-"))
            for number in numbers:
                mantissa = re.sub("[^0-9]", "", f"{abs(number):.9e}".split("e")[0]).rstrip("0")
                assert mantissa in digits or has_other_numbers.search(lines[line - 1] + str(columns.notes))
    assert time.process_time() - start < 30.0
