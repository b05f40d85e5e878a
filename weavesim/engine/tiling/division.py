"""A step of one sheet, divided among threads."""

from __future__ import annotations

from dataclasses import dataclass

from ..sheet_model import LARGE_SHEET, SheetModel
from .corner_places import CornerPlaces
from .corner_ring import CornerRing
from .tiles import TILE_SIZE, Part, divide_step

# A ring of more than this share of all records gains nothing: elements in no order, or nearly as many threads as tiles.
LARGEST_SHARE = 0.5


@dataclass(frozen=True)
class Division:
    """What each thread does, and where elements put their corner records.

    Attributes:
        parts: one for each thread.
        ring: of corner records; None for the arrays of the state.
    """

    parts: list[Part]
    ring: CornerRing | None

    @classmethod
    def of(cls, sheet: SheetModel, thread_count: int, by_entries: bool) -> Division:
        """Divide a step.

        Args:
            sheet: constants.
            thread_count: number of parts.
            by_entries: whether something else than nodes looks for corner records by their entries in the state:
                grippers, and contact between nodes.
        """
        parts = divide_step(sheet.element_nodes, sheet.lane_count, thread_count, TILE_SIZE, sheet.samples.window)
        if sheet.lane_count == 1 or sheet.element_count < LARGE_SHEET or by_entries:
            return cls(parts, None)
        places = CornerPlaces.of(sheet.element_nodes, sheet.lane_count, parts)
        fits = places.count <= LARGEST_SHARE * len(places.of_block)
        return cls(parts, CornerRing(sheet, places) if fits else None)
