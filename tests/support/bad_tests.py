"""Tables of tests that no calibration may accept, with the message that each must give.

A message names file, line and, where there is one, the column.
"""

from __future__ import annotations

from typing import Any, NamedTuple

ANGLES = range(0, 41, 4)


def frame(header: str = "angle [deg],force [N]", change: dict[int, str] | None = None, scale: float = 1.0) -> str:
    """A picture frame whose rows ``change`` replaces, by their line."""
    rows = [f"{a},{scale * (0.5 * a + 0.02 * a**2):.6g}" for a in ANGLES]
    for line, row in (change or {}).items():
        rows[line - 2] = row
    return "\n".join([header, *rows]) + "\n"


def bias(change: dict[int, str] | None = None) -> str:
    rows = [f"{d},{0.2 * d + 0.01 * d**2:.6g}" for d in range(0, 30, 3)]
    for line, row in (change or {}).items():
        rows[line - 2] = row
    return "\n".join(["displacement [mm],force [N]", *rows]) + "\n"


def biaxial(header: str = "warp strain [%],weft strain [%],warp force [N/mm],weft force [N/mm]",
            change: dict[int, str] | None = None) -> str:  # fmt: skip
    rows = [f"{e / 10},{e / 10},{4 * e},{4 * e}" for e in range(8)]
    for line, row in (change or {}).items():
        rows[line - 2] = row
    return "\n".join([header, *rows]) + "\n"


class Bad(NamedTuple):
    """A table of a test, the options beside it, and the pattern of its message."""

    test: str
    text: str | bytes
    message: str
    options: dict[str, Any] = {}


STRIP = {"bias_length": 0.23, "bias_width": 0.115}
SIDES = {"frame_side": 0.25}
BAD = {
    "empty": Bad("picture_frame", "", "it is empty"),
    "no header": Bad("picture_frame", "0,0\n10,2\n20,5\n", "line 1: no header"),
    "a column is missing": Bad(
        "picture_frame", "angle [deg],moment [N]\n0,0\n", "line 1: no column force among 'angle"
    ),
    "neither angle nor displacement": Bad(
        "picture_frame", "time [s],force [N]\n0,0\n", "line 1: no column angle or disp"
    ),
    "no unit of the angle": Bad(
        "picture_frame", frame("angle,force [N]"), "line 1: column 'angle' does not say its unit"
    ),
    "no unit of the force": Bad(
        "picture_frame", frame("angle [deg],force"), "line 1: column 'force' does not say its unit"
    ),
    "unit of another quantity": Bad(
        "picture_frame", frame("angle [deg],force [mm]"), "line 1: column 'force .mm.' is in mm"
    ),
    "unknown unit": Bad(
        "picture_frame", frame("angle [deg],force [lumps]"), "line 1: column 'force .lumps.': its unit"
    ),
    "a text for a number": Bad(
        "picture_frame", frame(change={5: "12,slipped"}), "line 5: column 'force .N.': 'slipped'"
    ),
    "no value": Bad("picture_frame", frame(change={6: "16,"}), "line 6: no value in column 'force .N.'"),
    "not a number": Bad(
        "picture_frame", frame(change={6: "16,NaN"}), "line 6: column 'force .N.': 'NaN' is not a finite"
    ),
    "one value too many": Bad("picture_frame", frame(change={4: "8,5,28"}), "line 4: 3 values under 2 names"),
    "decimal commas between commas": Bad(
        "picture_frame", "angle [deg],force [N]\n0,0,0,0\n10,0,2,5\n", "line 2: 4 values under 2 names"
    ),
    "two readings of a number": Bad(
        "picture_frame",
        "angle [deg]\tforce [N]\n0\t0\n10\t1,234\n20\t2,345\n30\t3,456\n",
        "line 3: '1,234' has two readings",
    ),
    "comma and point": Bad("picture_frame", "angle [deg];force [N]\n0;0\n10,5;2.5\n", "line 3: a number with a comma"),
    "a second table below": Bad("picture_frame", frame() + frame(), "line 13: the header occurs again"),
    "binary": Bad("picture_frame", b"PK\x03\x04rest", "no text but an Excel workbook"),
    "force without side of the frame": Bad("picture_frame", frame(), "column 'force .N.' is a force: give frame_side"),
    "two specimens of one number": Bad(
        "picture_frame",
        "angle [deg],force 1 [N],force 1 [N],force 2 [N]\n0,0,0,0\n",
        "line 1: column force 1 occurs twice",
    ),
    "a gap in a specimen": Bad(
        "picture_frame",
        "angle [deg],force 1 [N],force 2 [N]\n0,0,0\n5,,1\n9,1,2\n",
        "line 3: no value in column 'force 1",
    ),
    "another number of specimens": Bad(
        "picture_frame",
        "angle 1 [deg],force 1 [N],angle 2 [deg],force 3 [N]\n0,0,0,0\n",
        "line 1: column .*same specimen",
    ),
    "too few rows": Bad("picture_frame", frame().split("12,")[0], "line 4: column 'angle .deg.': 3 rows", SIDES),
    "all zero": Bad("picture_frame", frame(scale=0.0), "line 2: column 'force .N.': all values are zero", SIDES),
    "nothing moves": Bad(
        "picture_frame", "angle [deg],force [N]\n" + "5,1\n5,2\n" * 5, "line 2: column 'angle .deg.': all values", SIDES
    ),
    "negative forces": Bad(
        "picture_frame", frame(scale=-1.0), "line 12: column 'force .N.': -52: .*change the sign", SIDES
    ),
    "a slip of the pen": Bad(
        "picture_frame", frame(change={7: "20,180"}), "line 7: column 'force .N.': 180 stands alone", SIDES
    ),
    "radians called degrees": Bad(
        "picture_frame",
        "angle [deg],force [N]\n" + "".join(f"{0.07 * k:.3f},{k * k}\n" for k in range(11)),
        "line 12: column 'angle .deg.': the largest angle is 0.7 deg",
        SIDES,
    ),
    "an angle beyond a right one": Bad(
        "picture_frame", frame(change={12: "95,60"}), "line 12: column 'angle .deg.': 95 degrees", SIDES
    ),
    "an angle far below zero": Bad(
        "picture_frame", frame(change={2: "-20,0"}), "line 2: column 'angle .deg.': -0.3491 is below zero", SIDES
    ),
    "kilonewtons called newtons": Bad(
        "picture_frame",
        frame("angle [deg],force [kN]", scale=10.0),
        "line 12: column 'force .kN.': a shear moment",
        SIDES,
    ),
    "an offset that may be friction": Bad(
        "picture_frame",
        frame("angle [deg],force [N/m]", {2: "0,6", 3: "4,8", 4: "8,10"}),
        "line 2: column 'force .N/m.': 6 at the start, 12% of the largest: .*offset",
    ),
    "unloading above loading": Bad(
        "picture_frame",
        "angle [deg],force [N],force unloading [N]\n"
        + "".join(f"{a},{0.5 * a:.3f},{0.6 * a + 1:.3f}\n" for a in ANGLES),
        "line 12: column 'force unloading .N.': 25 is above the loading",
        SIDES,
    ),
    "specimens of other units": Bad(
        "picture_frame",
        "angle [deg],force 1 [N/m],force 2 [N/m],force 3 [N/m]\n"
        + "".join(f"{a},{a * a},{1.1 * a * a:.6g},{1000 * a * a}\n" for a in ANGLES),
        "specimen 3, line 12: column 'force 3 .N/m.': up to",
    ),
    "specimens without a common range": Bad(
        "picture_frame",
        "angle 1 [deg],force 1 [N/m],angle 2 [deg],force 2 [N/m]\n"
        + "".join(f"{a},{a},{a + 50},{a}\n" for a in range(2, 24, 2)),
        "specimen 2, line 2: column 'angle 2 .deg.': it begins at",
    ),
    "beyond the strip": Bad("bias_extension", bias({11: "60,20"}), "line 11: column 'displacement .mm.': 60 mm", STRIP),
    "where is zero": Bad(
        "bias_extension",
        "displacement [mm],force [N]\n" + "".join(f"{d + 12},{3 + 0.5 * d}\n" for d in range(0, 24, 3)),
        "line 2: column 'displacement .mm.': it begins at 12 mm with 22%",
        STRIP,
    ),
    "beyond the frame": Bad(
        "picture_frame",
        "displacement [mm],force [N]\n" + "".join(f"{16 * k},{k * k}\n" for k in range(11)),
        "line 12: column 'displacement .mm.': 160 mm is more than a frame",
        SIDES,
    ),
    "per cent called a fraction": Bad(
        "biaxial",
        biaxial("warp strain [-],weft strain [-],warp force [N/mm],weft force [N/mm]"),
        "line 9: column 'warp strain .-.': a strain of 0.7",
    ),
    "biaxial forces without width": Bad(
        "biaxial",
        biaxial("warp strain [%],weft strain [%],warp force [N],weft force [N]"),
        "column 'warp force .N.' is a force: give biaxial_width",
    ),
    "no weft": Bad(
        "biaxial", "warp strain [%],warp force [N/mm]\n0,0\n1,3\n", "line 1: no column weft_strain, weft_force"
    ),
    "a negative overhang": Bad("cantilever", "overhang [mm]\n90\n-88\n", "line 3: column 'overhang ?.mm.': -88 mm"),
    "an overhang in another unit": Bad(
        "cantilever", "overhang [m]\n1.9\n", "line 2: column 'overhang ?.m.': a bending"
    ),
    "an upright strip": Bad(
        "cantilever", "overhang [mm],angle [deg]\n90,41\n91,1\n", "line 3: column 'angle .deg.': 1 degrees"
    ),
}
