"""Sheets that pass through themselves or each other, fold up, turn over, or leave their side of a symmetry plane."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, ClassVar

from ...kernels.rows import PassEntry
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ..frame import SheetInfo
    from ..verdict import Judged
    from ..watch.condition import Tally

# Share of all elements from which on what is wrong with them is wrong with the result.
USELESS_SHARE = 0.01
# Beyond a symmetry plane, of the thickness: what is not doubted, and from which on the sheet is in its mirror image.
LARGEST_BEYOND = 0.05
USELESS_BEYOND = 1.0
# Element size over thickness up to which nodes on facets keep every fold apart (contact of edges is not computed).
LARGEST_SIZE = 2.0
# Of the thickness: penetration that is not doubted. Beyond the largest one the run stops: see ``find_failure``.
USUAL_DEPTH = 0.1


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


class SelfContactMesh(Guard):
    """Elements so large that the crests of two folds may cross between their nodes, and symmetry planes."""

    name = "self_contact_mesh"
    watches = "elements that are large for self-contact"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Sheets with self-contact whose elements are larger than twice the thickness, or that are cut at a plane."""
        for sheet, info in zip(start.model.sheets, start.model.setup.sheets, strict=True):
            if info.self_contact is None:
                continue
            size, thickness = sheet.geometry.largest_size, sheet.fabric.thickness
            if size > LARGEST_SIZE * thickness:
                yield self.doubt(
                    Level.NOTE,
                    f"self-contact with elements of {1e3 * size:.3g} mm, {size / thickness:.1f} times the thickness",
                    "nodes meet facets; the crests of folds that cross each other may meet between nodes, deeper than "
                    f"they should: there, take elements of at most {1e3 * LARGEST_SIZE * thickness:.3g} mm",
                    sheet=sheet.name,
                    value=size,
                    limit=LARGEST_SIZE * thickness,
                )
            if sheet.symmetry.planes:
                yield self.doubt(
                    Level.NOTE,
                    f"self-contact beside the symmetry plane {' and '.join(sheet.symmetry.planes)} = 0",
                    "a sheet does not meet its own mirror image: a fold that closes on the plane passes through it, "
                    "which the guard beyond_symmetry tells; run the whole part if it does",
                    sheet=sheet.name,
                )


class SelfContactSearch(Guard):
    """Contacts that the search may have missed, and deep ones."""

    name = "self_contact_depth"
    watches = "how deep a sheet has been in itself, and whether its search was in time"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The worst of the passes of each sheet."""
        model, state = run.run.model, run.run.state
        for index, sheet in enumerate(model.sheets):
            own = [k for k, each in enumerate(model.passes) if each.is_own and each.place.slave == index]
            entries = [state.passes[k].entry.numpy() for k in own]
            if any(entry[PassEntry.late] for entry in entries):
                yield self.doubt(
                    Level.WARNING,
                    "a node in self-contact slid farther between two searches than they allow for",
                    "its reaction may have been missed, which the energy balance tells: take a smaller step_safety",
                    sheet=sheet.name,
                )
            deepest = max((float(entry[PassEntry.deepest]) for entry in entries), default=0.0)
            if deepest > USUAL_DEPTH * sheet.fabric.thickness:
                yield self.doubt(
                    Level.WARNING,
                    f"the sheet has been {1e3 * deepest:.3g} mm deep in itself, "
                    f"{deepest / sheet.fabric.thickness:.0%} of the thickness",
                    "raise stiffness_share of its self_contact, up to 0.2, or move the tools more slowly",
                    sheet=sheet.name,
                    value=deepest,
                    limit=USUAL_DEPTH * sheet.fabric.thickness,
                )
