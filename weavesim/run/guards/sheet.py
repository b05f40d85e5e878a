"""Sheets that pass through themselves or each other, fold up, turn over, or leave their side of a symmetry plane."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ...errors import InputError
from ...measures.geometry.height import heights_over
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...engine.setup import Setup
    from ...sheet.sheet import Sheet
    from ..frame import Frame, SheetFrame, SheetInfo
    from ..ledger import Ledger
    from ..verdict import Judged
    from ..watch.condition import Tally

# Before the run, of the distance of two plies: overlap that is not doubted, and that is refused.
LARGEST_OVERLAP = 0.05
REFUSED_OVERLAP = 0.25
# Share of all elements from which on what is wrong with them is wrong with the result.
USELESS_SHARE = 0.01
# Angle between the mean directors at both diagonals of an element that is not doubted [degrees]; without a swing it is
# that of a crease that runs at an angle to the mesh.
LARGEST_SWING = 60.0
# Beyond a symmetry plane, of the thickness: what is not doubted, and from which on the sheet is in its mirror image.
LARGEST_BEYOND = 0.05
USELESS_BEYOND = 1.0
# Element size over thickness up to which nodes on facets keep every fold apart (contact of edges is not computed, and
# necks of folds that are as tight as two elements are not seen): see docs/decisions/0055-no-contact-of-edges.md.
LARGEST_SIZE = 1.5


class NotFinite(Guard):
    """A state that is no longer finite: the run stops, and what it wrote ends at its last good frame."""

    lasting = True
    name = "not_finite"
    watches = "whether the state is finite, after every turn of steps"

    def after(self, run: Judged) -> Iterable[Doubt]:
        """What became non-finite first, if anything did."""
        if (failed := run.run.failed) is not None:
            yield self.doubt(
                Level.DO_NOT_USE,
                failed.text,
                "the results end at the last good frame: look for the cause in the frames before it",
                sheet=failed.sheet,
                place=failed.place,
                time=failed.time,
            )


class _Counted(Guard):
    """What ``Condition`` counts."""

    lasting = True
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

    lasting = True
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
                        _advice(run, first, second),
                        sheet=first,
                        place=tally.place,
                        time=tally.time,
                        value=tally.most,
                        limit=0.0,
                    )


def _advice(run: Judged, first: str, second: str) -> str:
    if {first, second} in _interfaces(run.run.info.setup):
        return (
            "the result is wrong there: their contact did not hold them apart; refine the mesh, slow the tools down, "
            "or take a larger stiffness_share of the interface"
        )
    return "the result is wrong there: sheets of one world need an interface between them, and variants a world each"


def _interfaces(setup: Setup | None) -> list[set[str]]:
    """Names of the two sheets of every interface."""
    return [{each.lower, each.upper} for each in setup.interfaces] if setup is not None else []


class StartOfStack(Guard):
    """Plies that start inside each other, in another order than their interface says, or without one."""

    name = "start_of_stack"
    watches = "sheets that overlap each other before the run"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Small overlaps, and sheets that touch without an interface.

        Raises:
            InputError: sheets that overlap by more than a quarter of their distance, pass through each other, or lie in
                the other order.
        """
        setup = start.model.setup
        frames = {frame.name: frame for frame in start.frame.sheets}
        for world in setup.worlds:
            order = {frozenset((each.lower, each.upper)): (each.lower, each.upper) for each in world.interfaces}
            sheets = {sheet.name: sheet for sheet in world.sheets}
            for pair in combinations(sheets, 2):
                lower, upper = order.get(frozenset(pair), pair)
                distance = 0.5 * (sheets[lower].fabric.thickness + sheets[upper].fabric.thickness)
                found = _nearest(
                    sheets[lower], frames[lower], sheets[upper], frames[upper], distance, frozenset(pair) in order
                )
                if found is not None:
                    yield from self._judged(lower, upper, frozenset(pair) in order, distance, found)

    def _judged(self, lower: str, upper: str, meet: bool, distance: float, found: _Nearest) -> Iterator[Doubt]:
        """What a pair of sheets closer than ``distance`` [m] says."""
        x, y = found.place
        where = f"at ({x:.4g}, {y:.4g}) m on the flat blank of {upper}"
        between = f"{1e3 * found.height:.3g} mm between their middles"
        touching = f"they touch at {1e3 * distance:.3g} mm"
        if not meet:
            yield self.doubt(
                Level.WARNING,
                f"{lower} and {upper} start with {between}; {touching}",
                "nothing keeps them apart: give the world an interface between them, or each its own world",
                sheet=upper,
                place=found.place,
                value=found.height,
                limit=distance,
            )
            return
        if found.below > 0.5:
            raise InputError(
                f"interface {lower} / {upper}: {upper} starts below {lower}, {where}; the upper sheet lies on the "
                "side to which the directors of the lower one point: exchange the two names"
            )
        overlap = distance - found.height
        text = f"{lower} and {upper} start inside each other by {1e3 * overlap:.3g} mm, with {between}; {touching}"
        if overlap > REFUSED_OVERLAP * distance:
            raise InputError(f"{text}, {where}: place plies half the sum of their thicknesses apart, as LayUp does")
        yield self.doubt(
            Level.WARNING,
            text,
            "they stay so, since contact begins without a force: place them half the sum of their thicknesses apart",
            sheet=upper,
            place=found.place,
            value=overlap,
            limit=LARGEST_OVERLAP * distance,
        )


class _Nearest(NamedTuple):
    """Where two sheets are nearest: height of the upper over the lower [m], place on the flat upper blank [m], and the
    share of its nodes over the other sheet that lie below it."""

    height: float
    place: tuple[float, float]
    below: float


def _nearest(
    lower: Sheet, below: SheetFrame, upper: Sheet, above: SheetFrame, distance: float, ordered: bool
) -> _Nearest | None:
    """None where the sheets are not closer than ``distance`` [m], but for a small overlap."""
    if (below.position.min(axis=0) > above.position.max(axis=0) + distance).any():
        return None
    if (above.position.min(axis=0) > below.position.max(axis=0) + distance).any():
        return None
    up = heights_over(above.position, below.position, lower.blank.quads, below.director)
    down = -heights_over(below.position, above.position, upper.blank.quads, above.director)
    if not (np.isfinite(up).any() or np.isfinite(down).any()):
        return None
    every = np.concatenate([up, down])
    # a sheet that winds around the other lies on both sides of it: only where they are nearest tells the order
    far = np.abs(every) > np.nanmin(np.abs(every)) + distance
    up, down = (np.where(away, np.nan, each) for away, each in zip(np.split(far, [len(up)]), (up, down), strict=True))
    every = every[np.isfinite(every) & ~far]
    share = float((every < 0.0).mean())
    sizes, backward = (up, down) if ordered else (np.abs(up), np.abs(down))
    smallest = np.nanmin(np.concatenate([sizes, backward]))
    limit = (1.0 - LARGEST_OVERLAP) * distance if ordered else (1.0 + LARGEST_OVERLAP) * distance
    if not smallest < limit:
        return None
    if np.isfinite(sizes).any() and np.nanmin(sizes) == smallest:
        place = upper.blank.material_coordinates[int(np.nanargmin(sizes))]
    else:
        node = int(np.nanargmin(backward))
        nearest = int(np.argmin(np.linalg.norm(above.position - below.position[node], axis=1)))
        place = upper.blank.material_coordinates[nearest]
    return _Nearest(float(smallest), (float(place[0]), float(place[1])), share)


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


class SwingingDirectors(Guard):
    """Directors of neighbouring nodes that swing against each other, before elements turn over and fold.

    Elements that bend more than their stabilisation bears do that by themselves, whatever the tools do.
    """

    lasting = True
    name = "swinging_directors"
    watches = "directors of neighbouring nodes that swing against each other"

    def __init__(self) -> None:
        self._worst: dict[str, list[float]] = {}

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Keep the state with most of them: their number, share, largest angle, time and place."""
        for index, (sheet, own) in enumerate(zip(ledger.sheets, frame.sheets, strict=True)):
            apart = np.degrees(sheet.directors_apart(own))
            count, element = int((apart > LARGEST_SWING).sum()), int(apart.argmax())
            worst = self._worst.get(str(index))
            if count and (worst is None or count > worst[0]):
                place = sheet.place_of(element)
                share = count / (own.kept.sum() or len(apart))
                self._worst[str(index)] = [count, share, apart[element], frame.time, place[0], place[1]]

    def memory(self) -> Mapping[str, Any]:
        """The worst state of each sheet, by its number."""
        return {"worst": {index: [float(value) for value in worst] for index, worst in self._worst.items()}}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._worst = {index: list(worst) for index, worst in memory["worst"].items()}

    def after(self, run: Judged) -> Iterable[Doubt]:
        """The worst state of each sheet."""
        setup = run.run.info.setup
        for index, (count, share, angle, time, x, y) in self._worst.items():
            info = run.run.info.sheets[int(index)]
            borne = setup.sheets[int(index)].stabilisation if setup is not None else info.fabric.stabilisation
            twist, bend = (np.degrees(np.sqrt(factor * borne.director / 3.0)) for factor in (2.0, 4.0))
            yield self.doubt(
                Level.DO_NOT_USE if share > USELESS_SHARE else Level.WARNING,
                f"directors at the diagonals of {count:.0f} elements point apart by up to {angle:.0f} degrees",
                "their bending is meaningless, and they fold over next: with stabilisation.director = "
                f"{borne.director:g} an element may turn by {twist:.0f} degrees in a twist, {bend:.0f} in a bend; "
                f"refine the mesh, or {'take 1' if borne.director < 1.0 else 'bend it less sharply'}",
                sheet=info.name,
                place=(x, y),
                time=time,
                value=count,
                limit=0.0,
            )


class BeyondSymmetry(Guard):
    """Nodes on the side of the mirror image."""

    lasting = True
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
    """Elements so large that the neck of a tight fold may close through itself."""

    name = "self_contact_mesh"
    watches = "elements that are large for self-contact"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Sheets with self-contact whose elements are larger than 1.5 thicknesses."""
        for sheet, info in zip(start.model.sheets, start.model.setup.sheets, strict=True):
            if info.self_contact is None:
                continue
            size, thickness = sheet.geometry.largest_size, sheet.fabric.thickness
            if size > LARGEST_SIZE * thickness:
                yield self.doubt(
                    Level.NOTE,
                    f"self-contact with elements of {1e3 * size:.3g} mm, {size / thickness:.1f} times the thickness",
                    "nodes meet facets, and edges meet edges at creases only; the neck of a fold as tight as two "
                    f"elements may close through itself: there, take at most {1e3 * LARGEST_SIZE * thickness:.3g} mm",
                    sheet=sheet.name,
                    value=size,
                    limit=LARGEST_SIZE * thickness,
                )
