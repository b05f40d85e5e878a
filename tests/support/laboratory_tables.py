"""Small tables as laboratories, machines and spreadsheets write them, with the values or the message they must give.

All that can be read hold one picture-frame test: shear angle in degrees, force in N.
"""

from __future__ import annotations

from typing import NamedTuple

DEGREES = (0.0, 10.0, 30.0, 50.0)
NEWTONS = (0.0, 2.5, 9.25, 1020.0)
ROWS = list(zip(DEGREES, NEWTONS, strict=True))


class Example(NamedTuple):
    """A table, the names of its columns of angle and force, and a message for one that is refused."""

    content: str | bytes
    angle: str = "angle"
    force: str = "force"
    message: str = ""

    @property
    def as_bytes(self) -> bytes:
        return self.content.encode() if isinstance(self.content, str) else self.content


def rows(
    separator: str, mark: str = ".", end: str = "\n", *, before: str = "", after: str = "", digits: int = 2
) -> str:
    """The test, one row per line."""
    lines = (separator.join(f"{value:.{digits}f}" for value in row).replace(".", mark) for row in ROWS)
    return "".join(f"{before}{line}{after}{end}" for line in lines)


def kilonewtons(separator: str, mark: str = ".") -> str:
    """The test with the force in kN, with five digits."""
    return "".join(f"{angle:.1f}{separator}{1e-3 * force:.5f}\n".replace(".", mark) for angle, force in ROWS)


MACHINE = (
    'Dimension : Width,250,mm\nForce,1000,N\nTest date,"2024-01-08 10:30"\n\nResults Table 1\n\n'
    'Time,Angle,Force\n(sec),(deg),(N)\n"0.000","0.00","0.00"\n"0.050","10.00","2.50"\n"0.100","30.00","9.25"\n'
    '"0.150","50.00","1020.00"\n'
)
TAB_MACHINE = (
    '"Prüfinstitut"\t"Labor 1"\n"Datum/Uhrzeit"\t44335.4\t""\n"Vorkraft"\t2\t"N"\n'
    '"Prüfzeit"\t"Scherwinkel"\t"Standardkraft"\n"s"\t"°"\t"N"\n'
    "0\t0\t0\n0.5\t10\t2.5\n1.0\t30\t9.25\n1.5\t50\t1020\n"
)
TWO_TESTS = "angle,force,angle,force\n0,0,0,0\n10,2.5,10,7.5\n30,9.25,30,28\n50,1020,50,3060\n"

# Read, with the right values.
READ = {
    "comma": Example("angle [deg],force [N]\n" + rows(",")),
    "semicolon and decimal comma": Example("angle [deg];force [N]\n" + rows(";", ",")),
    "semicolon and point": Example("angle [deg];force [N]\n" + rows(";")),
    "tab": Example("angle [deg]\tforce [N]\n" + rows("\t")),
    "tab and decimal comma": Example("angle [deg]\tforce [N]\n" + rows("\t", ",")),
    "blanks": Example("angle_deg   force\n" + rows("   ", before="  ")),
    "blanks and decimal comma": Example("angle_deg force\n" + rows(" ", ",")),
    "one blank within names, two between": Example("Shear angle (°)  Machine force (N)\n" + rows("     "),
        "shear angle", "machine force"),
    "brackets behind a blank": Example("angle [deg] force [N]\n" + rows(" ")),
    "quoted decimal commas": Example(
        'angle (deg),force (N)\n"0,0","0,0"\n"10,0", "2,5"\n"30,0","9,25" \n"50,0","1020,0"\n'),
    "kilonewtons": Example("angle [deg],force [kN]\n" + kilonewtons(",")),
    "kilonewtons, German": Example("Winkel [Grad];Kraft in kN\n" + kilonewtons(";", ","), "Winkel", "Kraft"),
    "slash": Example("angle / deg;force / kN\n" + kilonewtons(";")),
    "suffixes": Example("angle_deg,force_kn\n" + kilonewtons(","), "angle_deg", "force_kn"),
    "other case and blanks": Example("  ANGLE [Deg] ,FORCE (KN)\n" + kilonewtons(",")),
    "unit after a comma": Example("angle, deg;force, N\n" + rows(";")),
    "degree sign": Example("angle°;force\n" + rows(";")),
    "line of units": Example("angle;force\n°;N\n" + rows(";", ",")),
    "line of units in brackets": Example("angle,force\n[deg],[N]\n" + rows(",")),
    "line of units in a comment": Example("angle force\n# deg N\n" + rows(" ")),
    "line of units above": Example("°;N\nangle;force\n" + rows(";")),
    "machine with a preamble": Example(MACHINE),
    "machine with tabs": Example(TAB_MACHINE, "Scherwinkel", "Standardkraft"),
    "machine with tabs in Latin-1": Example(TAB_MACHINE.encode("latin-1"), "Scherwinkel", "Standardkraft"),
    "spreadsheet with sep=": Example("sep=;\nangle [deg];force [N]\n" + rows(";", ",", "\r\n")),
    "spreadsheet, Unicode text": Example(("angle [°]\tforce [N]\n" + rows("\t", ",", "\r\n")).encode("utf-16")),
    "UTF-16, big-endian": Example(b"\xfe\xff" + ("angle [°],force [N]\n" + rows(",")).encode("utf-16-be")),
    "byte order mark": Example(b"\xef\xbb\xbf" + ("angle [°],force [N]\n" + rows(",")).encode()),
    "Windows-1252": Example(("angle [°];force [N];Bemerkung\n" + rows(";", ",", after=";geprüft")).encode("cp1252")),
    "line ends of an old Mac": Example("angle [deg],force [N]\r" + rows(",", end="\r")),
    "empty columns at the end": Example("angle [deg],force [N],,\n" + rows(",", after=",,")),
    "a separator at the end": Example("angle [deg];force [N]\n" + rows(";", ",", after=";")),
    "index of a data frame": Example(
        ",angle_deg,force\n" + "".join(f"{i},{angle},{force}\n" for i, (angle, force) in enumerate(ROWS))),
    "column of line numbers": Example(
        "#;angle [deg];force [N]\n" + "".join(f"{i};{angle};{force}\n" for i, (angle, force) in enumerate(ROWS))),
    "comments and blank lines": Example(
        "# frame test\n\n// second\nangle [deg],force [N]\n\n0,0\n% slipped here\n10,2.5\n\n30,9.25\n50,1020\n\n"),
    "header in a comment": Example("# angle [deg] force [N]\n" + rows(" ", digits=3)),
    "header in a comment, digitised": Example('# angle_deg;force\n"0,0";"0,0"\n"10,0";"2,5"\n30;"9,25"\n50;1020\n'),
    "header with breaks": Example('"angle\n[deg]","force\n[N]"\n' + rows(",")),
    "rule below the header": Example("angle [deg]  force [N]\n-----------  ---------\n" + rows("   ")),
    "exponents": Example("angle [deg];force [N]\n0;0\n1E1;2,5E+00\n3,0e+1;925E-2\n5D1;1,02E+3\n"),
    "texts in other columns": Example("sample,angle [deg],force [N]\n" + rows(",", before="A-1,")),
    "radians": Example("angle [rad],force [N]\n0,0\n0.17453292519943295,2.5\n0.5235987755982988,9.25\n"
        "0.8726646259971648,1020\n"),
    "two tests with their own names": Example(
        "angle 1 [deg],force 1 [N],angle 2 [deg],force 2 [N]\n" + rows(",", after=",1.5,2.5"), "angle 1", "force 1"),
    "other columns with like names": Example(
        "angle [deg],force,force (filtered),force_m,force_s,Force / sample\n" + rows(",", after=",1,2,3,4")),
    "numbered columns": Example(
        "angle (1),force (1),angle (2),force (2)\ndeg,N,deg,N\n" + rows(",", after=",1,2"), "angle (1)", "force (1)"),
    "end of file of an old system": Example("angle_deg,force\r\n" + rows(",", end="\r\n") + "\x1a"),
    "no unit, which means SI": Example("angle,force [N]\n0,0\n0.17453292519943295,2.5\n0.5235987755982988,9.25\n"
        "0.8726646259971648,1020\n"),
}  # fmt: skip

# Refused, with a message that matches.
REFUSED = {
    "decimal commas between commas": Example("angle,force\n" + rows(",", ","),
        message="line 2: 4 values under 2 names: "
        ".*write a point, not a comma"),
    "decimal commas in one column": Example("angle,force\n0,0\n10,2,5\n30,9,25\n",
        message="line 3: 3 values under 2 names"),
    "decimal commas and unnamed columns": Example("angle,force,,\n" + rows(",", ","),
        message="line 2: 4 values under 2"),
    "decimal commas that fill the columns": Example("angle,force,travel,time\n" + rows(",", ",", digits=2),
        message="line 2: '00' looks like the end of a number that has a comma"),
    "doubled columns": Example(TWO_TESTS, message="line 1: column angle occurs twice.*column force occurs twice"),
    "doubled with blanks and case": Example("angle,force, Force \n0,0,0\n10,2.5,7\n",
        message="column force occurs twice"),
    "doubled with units": Example("angle;force [N];force [kN]\n0;0;0\n",
        message="column force occurs twice, as columns 2, 3"),
    "doubled with and without a unit": Example("angle;force_kn;force\n0;0;0\n", message="column force occurs twice"),
    "doubled with underscores": Example("angle,machine_force,Machine force\n0,0,0\n", force="machine force",
        message="column machine_force occurs twice"),
    "thousands with points": Example("angle;force\n0;0,5\n50;1.020,00\n",
        message="line 3: column 'force': '1.020,00' has "
        "separators of thousands"),
    "thousands with commas": Example('angle,force\n0,0.5\n50,"1,020.00"\n',
        message="line 3: .*'1,020.00' has separators"),
    "thousands with blanks": Example("angle;force\n0;0,5\n50;1 020,00\n",
        message="line 3: .*'1 020,00' has separators"),
    "thousands with narrow blanks": Example("angle;force\n0;0,5\n50;1\u202f020,00\n", message="line 3: .*separators"),
    "thousands with apostrophes": Example("angle;force\n0;0.5\n50;1'020.00\n", message="line 3: .*separators"),
    "millions": Example("angle;force\n0;0,5\n50;1.020.000\n", message="line 3: .*separators"),
    "two readings of a comma": Example("angle\tforce\n0\t0\n50\t1,020\n",
        message="line 3: '1,020' has two readings, 1.020 "
        "and 1020"),
    "two readings of a quoted comma": Example('angle,force\n0,0\n50,"1,020"\n', message="two readings"),
    "two readings of a point": Example("angle;force\n0;0\n50;1.020\n", message="two readings, 1.020 and 1020"),
    "commas and points": Example("angle;force\n0;0,5\n50;1.5\n",
        message="a comma .'0,5', line 2. and one with a point"),
    "no header": Example("0,0\n10,2.5\n", message="line 1: no header: write the names"),
    "no header, digitised": Example("0.0; 0.1\n10.0; 2.5\n", message="line 1: no header"),
    "empty": Example("", message="it is empty"),
    "blank": Example("\n \n\t\n", message="it is empty"),
    "header only": Example("angle,force\n\n", message="line 1: no rows below the header"),
    "missing cell": Example("angle,force\n0,0\n10,\n30,5\n", message="line 3: no value in column 'force'"),
    "missing first cell": Example("angle;force\n0;0\n;2\n", message="line 3: no value in column 'angle'"),
    "short row": Example("angle,force\n0,0\n10\n", message="line 3: no value in column 'force'"),
    "text in a cell": Example("angle,force\n0,0\n\n\n10,slipped\n",
        message="line 5: column 'force': 'slipped' is not a"),
    "not a number": Example("angle,force\n0,0\n10,NaN\n",
        message="line 3: column 'force': 'NaN' is not a finite number"),
    "infinite": Example("angle,force\n0,0\n10,-inf\n", message="'-inf' is not a finite number"),
    "too large": Example("angle,force\n0,0\n10,1e999\n", message="'1e999' is out of the range"),
    "too small": Example("angle,force\n0,0\n10,1e-999\n", message="'1e-999' is out of the range"),
    "hexadecimal": Example("angle,force\n0,0\n10,0x1F\n", message="'0x1F' is not a number"),
    "underscore": Example("angle,force\n0,0\n10,1_0\n", message="'1_0' is not a number"),
    "other digits": Example("angle,force\n0,0\n10,١٢\n", message="is not a number"),
    "unit in the cell": Example("angle,force\n0,0\n10,2.5 N\n",
        message="'2.5 N' is not a number: write its unit in the header"),
    "error of a spreadsheet": Example("angle;force\n0;0\n#DIV/0!;2\n", message="line 3: column 'angle': '#DIV/0!'"),
    "error of a German spreadsheet": Example("angle;force\n0;0\n#ZAHL!;2\n",
        message="line 3: column 'angle': '#ZAHL!'"),
    "header again": Example("angle,force\n0,0\nangle,force\n0,0\n", message="line 3: the header occurs again"),
    "another table": Example("angle,force\n0,0\n\ntime,load\n1,2\n", message="line 4: column 'angle': 'time' is not a"),
    "a line below": Example("angle;force\n0;0\nMaximum;2\n",
        message="line 3: column 'angle': 'Maximum' is not a number"),
    "wrong name": Example("angel,force\n0,0\n", message="line 1: no column angle among 'angel', 'force'; did you mean"),
    "unknown unit": Example("angle,force [lbs]\n0,0\n1,2\n", message="'lbs' is not known as a unit"),
    "unknown text in brackets": Example("angle,force (mean)\n0,0\n1,2\n", message="'mean' is not known as a unit"),
    "a unit of something else": Example("angle,force [mm]\n0,0\n1,2\n",
        message="is in mm, which cannot be converted to N"),
    "time in place of an angle": Example("angle [s],force\n0,0\n1,2\n",
        message="is in s, which cannot be converted to rad"),
    "unknown unit in the line of units": Example("angle;force\ngrad;N\n0;0\n", message="'grad' is not known as a unit"),
    "unknown unit in brackets below": Example("angle,force\n(deg),(lbs)\n0,0\n", message="'lbs' is not known"),
    "blanks above commas": Example("angle force\n0,0\n1,2\n", message="line 2: .*1 value under 2 names"),
    "an invisible difference": Example("angle,force,for\u200bce\n0,0,0\n", message="column force occurs twice"),
    "milli or mega": Example("angle,force_mn\n0,0\n1,2\n", message="'mn' is not known as a unit"),
    "numbers for names": Example("0,2.5\n10,3\n20,4\n", "0", "2.5", message="line 1: no header"),
    "a test of two": Example("angle (1),force (1),angle (2),force (2)\n0,0,0,0\n",
        message="no column angle, force among"),
    "two units": Example("angle,force [N]\n[rad],[kN]\n0,0\n", message="has another unit in the line of units"),
    "another separator below": Example("angle;force\n0,0\n1,2\n", message="line 2: .*separators are semicolons"),
    "open quotation mark": Example('angle,force\n0,0\n1,"2\n', message="line 3: a quotation mark that is not closed"),
    "text behind a quotation mark": Example('angle,force\n0,0\n1,"2"5\n', message="line 3: a quotation mark"),
    "a value under no name": Example("angle,,force\n0,1,2\n", message="line 2: 3 values under 2 names"),
    "columns between bars": Example("sep=|\nangle|force\n0|1\n", message="must be separated by"),
    "UTF-16 without a mark": Example("angle,force\n0,0\n".encode("utf-16-le"), message="UTF-16 without a mark"),
    "workbook": Example(b"PK\x03\x04\x14\x00", message="an Excel workbook .*save the sheet as CSV"),
    "compressed": Example(b"\x1f\x8b\x08\x00", message="compressed: unpack it"),
    "binary": Example(b"angle,force\n0,0\n\x01\x02", message="line 3: it contains characters that no text has"),
    "no table": Example("root:x:0:0:root\nuser:secret:1\n", message="no table with the columns angle, force: no line"),
}  # fmt: skip
