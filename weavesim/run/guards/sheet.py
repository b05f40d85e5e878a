"""Sheets that pass through themselves or each other, fold up, turn over, or leave their side of a symmetry plane."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, ClassVar

from .guard import Doubt, Guard, Level

if TYPE_CHECKING:
    from ..frame import SheetInfo
    from ..verdict import Judged
    from ..watch.condition import Tally

# Share of all elements from which on what is wrong with them is wrong with the result.
USELESS_SHARE = 0.01
# Beyond a symmetry plane, of the thickness: what is not doubted, and from which on the sheet is in its mirror image.
LARGEST_BEYOND = 0.05
USELESS_BEYOND = 1.0


class _Counted(Guard):
    """What ``Condition`` counts."""

    what: ClassVar[str] = ""
    text: ClassVar[str] = ""
    advice: ClassVar[str] = ""

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The worst state of each sheet."""
        for info, tally in _tallies(run, self.what):
            if tally.most > 0.0:
                yield self.doubt(
                    Level.DO_NOT_USE if tally.share > USELESS_SHARE else Level.WARNING,
                    f"{tally.most:.0f} {self.text} ({tally.share:.2%} of the elements; {tally.last:.0f} at the end)",
                    self.advice,
                    sheet=info.name,
                    place=tally.place,
                    time=tally.time,
                    value=tally.most,
                    limit=0.0,
                )


class SelfIntersection(_Counted):
    """Parts of a sheet that pass through each other, which only self-contact prevents."""

    name = "self_intersection"
    watches = "parts of a sheet that pass through each other"
    what = "crossings"
    text = "pairs of triangles of the sheet pass through each other"
    advice = "the result is wrong there: give the sheet self_contact, refine the mesh, or stop earlier"


class SheetIntersection(Guard):
    """Sheets of one world that pass through each other."""

    name = "sheet_intersection"
    watches = "sheets that pass through each other"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The worst state of each pair of sheets."""
        for stack in run.stacks:
            for (first, second), tally in stack.crossings.items():
                if tally.most > 0.0:
                    yield self.doubt(
                        Level.DO_NOT_USE if tally.share > USELESS_SHARE else Level.WARNING,
                        f"{tally.most:.0f} pairs of triangles of {first} and {second} pass through each other "
                        f"({tally.share:.2%} of their elements; {tally.last:.0f} at the end)",
                        "the result is wrong there: sheets of one world need an interface between them, and variants "
                        "a world each",
                        sheet=first,
                        place=tally.place,
                        time=tally.time,
                        value=tally.most,
                        limit=0.0,
                    )


class FoldedElements(_Counted):
    """Elements folded along a diagonal, and neighbours folded onto each other."""

    name = "folded_elements"
    watches = "folded elements"
    what = "folded"
    text = "elements or neighbours are folded onto each other"
    advice = "the mesh is too coarse for the folds, or the sheet is pushed together; refine the mesh"


class InvertedElements(_Counted):
    """Elements turned over against the directors of their nodes."""

    name = "inverted_elements"
    watches = "elements that are turned over"
    what = "inverted"
    text = "elements are turned over against their directors"
    advice = "their bending is meaningless: refine the mesh, or move tools less far"


class BeyondSymmetry(Guard):
    """Nodes on the side of the mirror image."""

    name = "beyond_symmetry"
    watches = "nodes beyond a symmetry plane"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The node furthest beyond a plane."""
        for info, tally in _tallies(run, "beyond"):
            thickness = info.fabric.thickness
            if tally.most > LARGEST_BEYOND * thickness:
                yield self.doubt(
                    Level.DO_NOT_USE if tally.most > USELESS_BEYOND * thickness else Level.WARNING,
                    f"a node was {1e3 * tally.most:.3g} mm beyond a symmetry plane",
                    "the sheet is in its own mirror image: compute the whole blank, or stop earlier",
                    sheet=info.name,
                    place=tally.place,
                    time=tally.time,
                    value=tally.most,
                    limit=LARGEST_BEYOND * thickness,
                )


def _tallies(run: Judged, what: str) -> Iterator[tuple[SheetInfo, Tally]]:
    """Every sheet with one of its tallies."""
    for info, condition in zip(run.run.info.sheets, run.conditions, strict=True):
        yield info, getattr(condition, what)
