"""One table of quantities: unit, legal range, plausible range. Fields and arguments of all input refer to its rows.

A value outside the legal range is refused where it is given. One outside the plausible range is a question: a set-up
or a fabric file that contains it is refused unless its user says ``accept_unusual``. Both name the likely slip, such
as millimetres for metres. Ranges are of sizes without sign; whether zero or a sign makes sense is the field's matter.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from pydantic import GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from .checks import Parameters, types_within
from .documents import read_document
from .errors import InputError
from .input_files import shown
from .quantities import finite, positive

logger = logging.getLogger(__name__)

Range = tuple[float, float]
Kind = TypeVar("Kind", bound=Parameters)

# Units that are often given in place of ours, and the factor from them to ours, the likelier first.
SLIPS: dict[str, tuple[tuple[str, float], ...]] = {
    "m": (("mm", 1.0e-3), ("inch", 0.0254), ("cm", 1.0e-2), ("um", 1.0e-6)),
    "m^2": (("mm^2", 1.0e-6), ("cm^2", 1.0e-4)),
    "m^4": (("mm^4", 1.0e-12),),
    "1/m": (("1/mm", 1.0e3), ("1/cm", 1.0e2)),
    "rad": (("degrees", math.pi / 180.0),),
    "degrees": (("rad", 180.0 / math.pi),),
    "Pa": (("GPa", 1.0e9), ("MPa", 1.0e6)),
    "N/m": (("N/mm", 1.0e3),),
    "N m": (("N mm", 1.0e-3), ("mN mm", 1.0e-6)),
    "N": (("kN", 1.0e3), ("mN", 1.0e-3)),
    "kg": (("g", 1.0e-3),),
    "kg/m^2": (("g/m^2", 1.0e-3),),
    "kg/m^3": (("g/cm^3", 1.0e3), ("t/mm^3", 1.0e12)),
    "m/s": (("mm/s", 1.0e-3), ("mm/min", 1.0e-3 / 60.0)),
    "m/s^2": (("mm/s^2", 1.0e-3),),
    "s": (("ms", 1.0e-3), ("us", 1.0e-6)),
    "rad/s": (("degrees/s", math.pi / 180.0), ("rpm", math.pi / 30.0)),
    "1/s": (),
    "Pa s": (("mPa s", 1.0e-3),),
    "1": (("per cent", 1.0e-2),),
    "m/unit": (),
}
# Nobody writes 0.0001 km or 1e9 mN: sizes that are written in another unit, of which some are small by nature.
WRITTEN: Range = (1.0e-3, 1.0e5)
SMALLEST_WRITTEN = {"mm^4": 1.0e-13, "t/mm^3": 1.0e-10}
# Units of which both are likely; of the others only the first that fits is named.
TWO_WAYS = ("Pa", "m/s")
# Only what is thin is measured in micrometres.
THICKEST_IN_MICROMETRES = 0.05


class Row(NamedTuple):
    """One quantity.

    Attributes:
        meaning: for readers.
        unit: of all its values; "1" for a pure number.
        legal, plausible: smallest and largest size, zero apart. Where zero makes sense, no small size is illegal.
    """

    meaning: str
    unit: str
    legal: Range
    plausible: Range


_RIGHT_ANGLE = 0.5 * math.pi

QUANTITIES: dict[str, Row] = {
    # the sheet
    "sheet thickness": Row("thickness of a sheet", "m", (1.0e-6, 0.05), (2.0e-5, 0.02)),
    "areal density": Row("mass per area of a sheet", "kg/m^2", (1.0e-4, 50.0), (0.01, 20.0)),
    "fibre density": Row("density of fibres", "kg/m^3", (100.0, 3.0e4), (500.0, 9.0e3)),
    "sheet modulus": Row("modulus of a sheet in bending", "Pa", (0.0, 1.0e13), (1.0e3, 1.0e12)),
    "shear modulus": Row("modulus of a sheet in shear", "Pa", (0.0, 1.0e13), (1.0e3, 1.0e11)),
    "membrane stiffness": Row("yarn stiffness per width", "N/m", (0.0, 1.0e13), (1.0, 1.0e9)),
    "compressive stiffness": Row("stiffness in compression, per width", "N/m", (0.0, 1.0e13), (1.0e-3, 1.0e8)),
    "bending stiffness": Row("bending stiffness per width", "N m", (0.0, 1.0e6), (1.0e-8, 10.0)),
    "in-plane bending": Row("in-plane bending stiffness", "N m", (0.0, 1.0e6), (1.0e-9, 1.0)),
    "bending moment": Row("bending moment per width", "N", (0.0, 1.0e9), (1.0e-7, 1.0e4)),
    "curvature": Row("curvature of a sheet", "1/m", (1.0e-6, 1.0e7), (1.0, 1.0e4)),
    "shear angle": Row("shear angle of a sheet", "rad", (0.0, _RIGHT_ANGLE), (0.05, _RIGHT_ANGLE)),
    "locking width": Row("angle over which locking builds up", "rad", (1.0e-6, _RIGHT_ANGLE), (1.0e-3, 0.8)),
    "shear moment": Row("largest shear moment per area", "N/m", (0.0, 1.0e9), (0.2, 2.0e4)),
    "friction moment": Row("shear moment of friction or of noise", "N/m", (0.0, 1.0e9), (1.0e-3, 2.0e4)),
    "shear stiffness": Row("slope of the shear moment over the angle", "N/m", (0.0, 1.0e12), (1.0e-3, 1.0e8)),
    "friction length": Row("friction coefficient times contact radius", "m", (0.0, 0.02), (1.0e-7, 5.0e-3)),
    # yarns and crossovers
    "yarn modulus": Row("modulus of a yarn", "Pa", (1.0e-3, 1.0e18), (1.0e5, 1.5e12)),
    "contact modulus": Row("modulus of a crossover", "Pa", (1.0e-3, 1.0e18), (1.0e2, 1.5e12)),
    "cross-section": Row("cross-section of a yarn or a crossover", "m^2", (1.0e-20, 0.01), (1.0e-11, 1.0e-3)),
    "second moment": Row("second moment of area of a yarn", "m^4", (0.0, 1.0e-6), (1.0e-27, 1.0e-10)),
    "yarn spacing": Row("distance between yarns, or half of it", "m", (1.0e-6, 0.2), (2.0e-5, 0.05)),
    "crossover height": Row("distance of the yarn axes at a crossover", "m", (0.0, 0.05), (1.0e-6, 0.01)),
    "yarn stiffness": Row("E A of a yarn", "N", (0.0, 1.0e12), (1.0e-6, 1.0e8)),
    "contact stiffness": Row("force over approach of a crossover", "N/m", (1.0e-6, 1.0e15), (1.0, 1.0e11)),
    "strain": Row("strain", "1", (0.0, 1.0), (1.0e-6, 0.3)),
    # process
    "length": Row("size of a tool or specimen", "m", (0.0, 20.0), (2.0e-4, 5.0)),
    "position": Row("coordinate", "m", (0.0, 1.0e5), (0.0, 20.0)),
    "mesh size": Row("edge length of an element", "m", (1.0e-4, 0.5), (2.0e-4, 0.1)),
    "frame side": Row("side of a picture frame or its specimen", "m", (1.0e-3, 5.0), (0.01, 2.0)),
    "gap": Row("gap in addition to the thickness", "m", (0.0, 0.1), (0.0, 0.02)),
    "displacement": Row("displacement of a tool or support", "m", (0.0, 20.0), (0.0, 2.0)),
    "speed": Row("speed of a tool, a support or a sheet", "m/s", (0.0, 1.0e4), (1.0e-5, 30.0)),
    "acceleration": Row("gravity", "m/s^2", (0.0, 1.0e5), (0.0, 200.0)),
    "force": Row("force", "N", (0.0, 1.0e12), (0.0, 1.0e7)),
    "spring stiffness": Row("force over travel of a spring", "N/m", (1.0e-9, 1.0e12), (1.0e-2, 1.0e8)),
    "couple": Row("moment at a node", "N m", (0.0, 1.0e9), (0.0, 1.0e4)),
    "yarn tension": Row("tension of a yarn family per width", "N/m", (0.0, 1.0e9), (1.0e-3, 1.0e6)),
    "pressure": Row("pressure on a sheet", "Pa", (0.0, 1.0e10), (1.0, 1.0e8)),
    "holder pressure": Row("pressure of a tool that a force moves on a sheet", "Pa", (0.0, 1.0e10), (50.0, 2.0e6)),
    "strain ratio": Row("strain of the weft over that of the warp", "1", (0.0, 1.0e3), (0.0, 20.0)),
    "load factor": Row("force of a machine over that of its frame", "1", (1.0e-3, 1.0e3), (0.05, 20.0)),
    "mass": Row("mass that a force moves", "kg", (1.0e-9, 1.0e7), (1.0e-6, 1.0e4)),
    "friction": Row("Coulomb coefficient", "1", (0.0, 10.0), (0.0, 1.5)),
    "Hersey number": Row("viscosity times speed over pressure", "m", (0.0, 1.0e3), (0.0, 1.0)),
    "viscosity": Row("viscosity of a resin", "Pa s", (1.0e-6, 1.0e9), (1.0e-3, 1.0e6)),
    "film thickness": Row("thickness of a film between plies", "m", (1.0e-8, 0.01), (1.0e-7, 1.0e-3)),
    "contact allowance": Row("depth in a tool over the thickness", "1", (0.0, 0.5), (0.0, 0.2)),
    "stiffness share": Row("share of the largest contact stiffness", "1", (1.0e-6, 0.2), (1.0e-3, 0.2)),
    "damping rate": Row("mass-proportional damping rate", "1/s", (0.0, 1.0e9), (0.0, 1.0e6)),
    "damping ratio": Row("share of critical damping", "1", (0.0, 100.0), (0.0, 2.0)),
    "stabilisation": Row("share of the stiffness of an hourglass mode", "1", (0.0, 100.0), (0.0, 2.0)),
    "duration": Row("duration of a run", "s", (1.0e-12, 1.0e6), (1.0e-7, 300.0)),
    "time": Row("point in time", "s", (0.0, 1.0e7), (0.0, 600.0)),
    "wall time": Row("time on the clock on the wall", "s", (0.0, 1.0e8), (1.0, 1.0e6)),
    "time step": Row("time step", "s", (1.0e-15, 10.0), (1.0e-9, 0.01)),
    "energy share": Row("ratio of energies", "1", (0.0, 1.0e9), (0.0, 0.5)),
    "angle": Row("angle of yarns or of a test", "degrees", (0.0, 3600.0), (0.0, 180.0)),
    "angle error": Row("change of shear angles that is allowed", "degrees", (0.0, 90.0), (1.0e-3, 10.0)),
    "position error": Row("change of positions that is allowed", "m", (0.0, 1.0), (1.0e-6, 0.02)),
    "turn of a tool": Row("angle of a tool that turns", "degrees", (0.0, 1.0e7), (0.0, 36000.0)),
    "turning speed": Row("speed of a tool that turns", "rad/s", (0.0, 1.0e6), (1.0e-4, 1.0e3)),
    "turn": Row("angle of a rotation", "rad", (0.0, 2.0 * math.pi), (0.0, 2.0 * math.pi)),
    "unit scale": Row("metres per unit of a file", "m/unit", (1.0e-9, 1.0e3), (1.0e-7, 1.0)),
}


class Quantity:
    """Annotation of a number, a list or an array as a quantity of the table: ``Annotated[Positive, Quantity("mass")]``.

    Args:
        name: of the row.
        at_most: a largest size of this field alone.

    Raises:
        KeyError: no such row.
    """

    def __init__(self, name: str, *, at_most: float | None = None) -> None:
        self.name, self.at_most = name, at_most
        self.row  # noqa: B018

    @property
    def row(self) -> Row:
        """Of the table, with the field's own limit."""
        row, most = QUANTITIES[self.name], self.at_most
        if most is None:
            return row
        return row._replace(legal=(row.legal[0], most), plausible=(row.plausible[0], min(row.plausible[1], most)))

    def __repr__(self) -> str:
        return f"Quantity({self.name!r})"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def _checked(self, value: Any) -> Any:
        if problem := illegal(value, self.row):
            raise ValueError(problem)
        return value

    def unusual(self, value: Any) -> str | None:
        """Why a legal value is a question; None if it is none. Of a list its largest number counts."""
        size = largest_size(value)
        low, high = self.row.plausible
        if self.row.unit == "degrees" and size is not None and looks_like_radians(size):
            return f"{size:.6g} is {math.degrees(size):.4g} degrees in radians; if so, write {math.degrees(size):.4g}"
        # within rounding of a bound is at the bound
        if size is None or size == 0.0 or low * (1.0 - 1.0e-9) <= size <= high * (1.0 + 1.0e-9):
            return None
        return f"usual are {low:.4g} to {high:.4g}{unit_after(self.row)}{slip(size, self.row, '; ')}"


def looks_like_radians(angle: float) -> bool:
    """Whether an angle in degrees is a multiple of 5 degrees, up to a turn, in radians."""
    step = math.pi / 36.0
    count = round(angle / step)
    return 1 <= count <= 72 and abs(angle - count * step) <= 1.0e-3 * angle


def largest_size(value: Any) -> float | None:
    """The largest size of a number, a list or an array; None without a finite number."""
    if value is None or isinstance(value, str | Parameters):
        return None
    sizes = np.abs(np.asarray(value, dtype=float))
    sizes = sizes[np.isfinite(sizes)]
    return float(sizes.max()) if sizes.size else None


def illegal(value: Any, row: Row) -> str | None:
    """What is allowed, if a number, or the largest of several, is outside the legal range; None if it is legal."""
    if isinstance(value, float) and not math.isfinite(value):
        return "a finite number is needed"
    size = largest_size(value)
    if size is None or size == 0.0:
        return None
    low, high = row.legal
    # of several numbers, the largest; small ones among them are natural
    which = "" if isinstance(value, int | float) else f"the largest is {size:.4g}; "
    if size > high * (1.0 + 1.0e-9):
        return f"{which}at most {high:.4g}{unit_after(row)} is allowed{slip(size, row, ': ')}"
    if size < low:
        return f"{which}at least {low:.4g}{unit_after(row)} is needed{slip(size, row, ': ')}"
    return None


def slip(size: float, row: Row, before: str) -> str:
    """The likely slip behind a size, or two, as a clause that begins with ``before``."""
    if row.unit == "m/unit":
        return f"{before}it is 0.001 for a file in millimetres, 0.0254 for inches, 1 for metres"
    low, high = row.plausible
    likely = [
        f"{size * factor:.4g} for {size:.4g} {other}"
        for other, factor in SLIPS[row.unit]
        if low <= size * factor <= high
        and SMALLEST_WRITTEN.get(other, WRITTEN[0]) <= size <= WRITTEN[1]
        and (other != "um" or high <= THICKEST_IN_MICROMETRES)
    ]
    if likely:
        return f"{before}write {' or '.join(likely[: 2 if row.unit in TWO_WAYS else 1])}"
    return ""


def unit_after(row: Row) -> str:
    """The unit of a row behind a number: "" for a plain one."""
    return "" if row.unit == "1" else f" {row.unit.replace('m/unit', 'metres per unit')}"


def argument(name: str, value: Any, quantity: str, *, zero: bool = False, negative: bool = False) -> float:
    """An argument of a function as a float; an unusual one is logged as a warning.

    Args:
        name: of the argument, for messages.
        value: as given.
        quantity: row of the table.
        zero, negative: whether these are allowed.

    Raises:
        InputError: not a finite number in the legal range.
    """
    number = finite(name, value) if zero or negative else positive(name, value)
    if number < 0.0 and not negative:
        raise InputError(f"{name} = {value!r}: at least 0 is needed")
    row = QUANTITIES[quantity]
    if problem := illegal(number, row):
        raise InputError(f"{name} = {number:.6g}: {problem}")
    if question := Quantity(quantity).unusual(number):
        logger.warning("%s = %.6g%s is unusual: %s", name, number, unit_after(row), question)
    return number


def size_told(value: Any) -> str:
    """A number, or the largest of several, for a message."""
    return f"{value:.6g}" if isinstance(value, int | float) else f"up to {largest_size(value):.6g}"


def quantity_of(field: FieldInfo) -> Quantity | None:
    """The quantity of a field; None without one."""
    for part in (*field.metadata, *types_within(field.annotation)):
        if isinstance(part, Quantity):
            return part
    return None


def unusual_values(value: Any, place: str = "") -> Iterator[str]:
    """Every number within a value that is outside its plausible range, and every proportion, each as a sentence.

    Args:
        value: ``Parameters``, or a tuple of such.
        place: of the value, for the sentences.
    """
    if isinstance(value, tuple):
        for index, item in enumerate(value):
            yield from unusual_values(item, f"{place}[{getattr(item, 'name', index)}]")
    if not isinstance(value, Parameters):
        return
    for name, field in type(value).model_fields.items():
        item, where = getattr(value, name), f"{place}.{name}" if place else name
        quantity = quantity_of(field)
        if quantity is not None and (question := quantity.unusual(item)):
            yield f"{where} = {size_told(item)}{unit_after(quantity.row)}: {question}"
        yield from unusual_values(item, where)
    for sentence in value.disproportions():
        yield f"{place}: {sentence}" if place else sentence


ACCEPTING = "If this is meant, give accept_unusual=True (on the command line --accept-unusual)."
ACCEPTING_IN_FILE = "If this is meant, write accept_unusual = true in the file."
ACCEPTING_IN_JOB = "If this is meant, write accept_unusual = true at the top of the job."
# More are not listed.
LONGEST_LIST = 12


def check_usual(value: Any, place: str = "", answer: str = ACCEPTING) -> None:
    """Ask about every unusual number within a value.

    Args:
        value: a value or a tuple of them.
        place: of the value, in messages.
        answer: sentence that says how to answer.

    Raises:
        ValueError: there are some.
    """
    if found := list(unusual_values(value, place)):
        raise ValueError(question_of(found, answer))


def question_of(found: list[str], answer: str) -> str:
    """One message of sentences about unusual values, at least one, with how to answer."""
    listed = "\n  ".join(found[:LONGEST_LIST] + (["and more"] if len(found) > LONGEST_LIST else []))
    what = "a value is unusual, probably in another unit" if len(found) == 1 else f"{len(found)} values are unusual"
    return f"{what}:\n  {listed}\n{answer}"


def read_parameters(kind: type[Kind], path: str | Path, what: str) -> Kind:
    """Parameters from a TOML or JSON file with their names, and ``accept_unusual`` if unusual numbers are meant.

    Args:
        kind: of the parameters.
        path: of the file.
        what: name of such a file in messages, such as "lamina file".

    Raises:
        InputError: a file that cannot be read, or values that are not allowed or not usual.
    """
    values = dict(read_document(path, what).values)
    accepts = values.pop("accept_unusual", False)
    if not isinstance(accepts, bool):
        raise InputError(f"{what} {shown(path)}: accept_unusual = {accepts!r}: true or false is needed")
    try:
        result = kind(**values)
        if not accepts:
            check_usual(result, answer=ACCEPTING_IN_FILE)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} {shown(path)}: {error}") from None
    return result
