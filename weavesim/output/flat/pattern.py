"""Flat pattern, trim line and waste of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..claim.record import RECORD_NAME, SETUP_NAME
from ..claim.remains import SUMMARY_NAME
from ..files import check_writable, write_summary
from ..run_page.progress import PROGRESS_NAME
from ..stored.file import StoredRun
from .drawing import flat_drawing, trimmed_drawing, write_drawing
from .part_edge import PartEdge, opening_of, read_part_edge
from .trimming import FlatPattern, flat_pattern

# Files of a run, which may lie in the folder of the drawings.
OF_A_RUN = (RECORD_NAME, SETUP_NAME, SUMMARY_NAME, PROGRESS_NAME)


@dataclass(frozen=True)
class FlatWish:
    """Which drawings to write.

    Attributes:
        flat: drawing of the flat blanks with their trim lines; None for none.
        trim: drawing of what becomes the part; None for none.
        part_edge: file of the part's edge; None for the whole blank.
        layer: of it, if it is a drawing.
        metres_per_unit: of it; None takes what it says itself.
        opening: name of a tool whose opening is the part's edge, instead of a file.
    """

    flat: Path | None = None
    trim: Path | None = None
    part_edge: Path | None = None
    layer: str | None = None
    metres_per_unit: float | None = None
    opening: str | None = None

    def __post_init__(self) -> None:
        if self.part_edge is not None and self.opening is not None:
            raise InputError("edge of the part: a file and a tool's opening are given; give one of them")
        if self.trim is not None and self.part_edge is None and self.opening is None:
            raise InputError(
                "trim line: the edge of the part is needed: a closed curve as a DXF drawing, a table or the border of "
                "a mesh (--part-edge FILE), or the opening of a tool (--opening TOOL)"
            )
        if self.flat is None and self.trim is None and (self.part_edge is not None or self.opening is not None):
            raise InputError("edge of the part: it has an effect only with a drawing (--flat FILE, --trim FILE)")
        for path in (self.flat, self.trim):
            if path is not None and path.suffix.lower() != ".dxf":
                raise InputError(f"drawing {path}: a name that ends in .dxf is needed")
        if (numbers := self.numbers_path) is not None and numbers.name in OF_A_RUN:
            raise InputError(
                f"drawing {numbers.with_suffix('.dxf')}: its numbers would be written to {numbers.name}, a file of a "
                "run; give another name"
            )

    @property
    def numbers_path(self) -> Path | None:
        """Where the areas and masses go: beside the first drawing."""
        first = self.flat or self.trim
        return None if first is None else first.with_suffix(".json")


@dataclass(frozen=True, eq=False)
class FlatPatterns:
    """The flat patterns of a run.

    Attributes:
        run: whose they are.
        edge: of the part; None for the whole blanks.
        plies: in the order of the run.
    """

    run: StoredRun
    edge: PartEdge | None
    plies: tuple[FlatPattern, ...]

    def numbers(self) -> dict[str, Any]:
        """Areas, waste and masses, as the file beside the drawings has them."""
        plies = []
        for pattern, sheet in zip(self.plies, self.run.sheets, strict=True):
            weight = self.run.fabric(sheet).areal_density
            entry: dict[str, Any] = {
                "name": pattern.name, "blank_area_mm2": 1e6 * pattern.blank_area,
                "blank_mass_g": 1e3 * weight * pattern.blank_area,
            }  # fmt: skip
            if pattern.part_area is not None:
                entry |= {
                    "part_area_mm2": 1e6 * pattern.part_area,
                    "part_mass_g": 1e3 * weight * pattern.part_area,
                    "waste_area_mm2": 1e6 * (pattern.blank_area - pattern.part_area),
                    "waste_share": 1.0 - pattern.part_area / pattern.blank_area,
                    "largest_distance_of_edge_mm": 1e3 * pattern.largest_distance,
                }
            plies.append(entry)
        out: dict[str, Any] = {"run_id": self.run.run_id, "edge": self.edge and self.edge.name, "plies": plies}
        if self.edge is not None:
            blank, part = (sum(entry[key] for entry in plies) for key in ("blank_area_mm2", "part_area_mm2"))
            out["waste_share"] = 1.0 - part / blank
        return out

    def lines(self) -> list[str]:
        """What a user is told."""
        found = []
        for entry in self.numbers()["plies"]:
            text = f"{entry['name']}: blank {entry['blank_area_mm2'] / 100:.1f} cm2"
            if "part_area_mm2" in entry:
                text += (
                    f", part {entry['part_area_mm2'] / 100:.1f} cm2, waste {entry['waste_area_mm2'] / 100:.1f} cm2 "
                    f"({entry['waste_share']:.1%}); the edge lies up to "
                    f"{entry['largest_distance_of_edge_mm']:.2g} mm from the sheet's middle"
                )
            found.append(text)
        return found


def flat_patterns(run: StoredRun, wish: FlatWish) -> FlatPatterns:
    """The flat patterns of all sheets, whole ones where a part is cut at planes of symmetry.

    Raises:
        InputError: an edge that cannot be read, or that does not lie on the formed sheets.
    """
    edge = None
    if wish.part_edge is not None:
        edge = read_part_edge(wish.part_edge, metres_per_unit=wish.metres_per_unit, layer=wish.layer)
    elif wish.opening is not None:
        names = [tool.name for tool in run.tools]
        if wish.opening not in names:
            raise InputError(
                f"opening of {wish.opening}: there is no such tool; choose from {', '.join(names) or 'none'}"
            )
        place = names.index(wish.opening)
        edge = opening_of(run.tools[place], run.place(place))
    return FlatPatterns(run, edge, tuple(flat_pattern(sheet, edge) for sheet in run.sheets))


def write_flat(found: FlatPatterns, wish: FlatWish) -> list[Path]:
    """Write the drawings, and the numbers beside the first of them; returns the files."""
    files: list[Path] = []
    for path, drawing in ((wish.flat, flat_drawing), (wish.trim, trimmed_drawing)):
        if path is not None:
            check_writable(path.parent)
            write_drawing(path, drawing(found.plies))
            files.append(path)
    if wish.numbers_path is not None:
        files.append(wish.numbers_path)
        write_summary(wish.numbers_path, found.numbers())
    return files
