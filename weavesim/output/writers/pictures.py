"""All pictures, as PNG."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from ...measures.findings import FormedSheet
from .. import pictures
from ..files import note, noting, world_endings
from ..results import Results, SheetResult
from ..sharing import Sharing
from ..writer import Writer


class Picture(NamedTuple):
    """A picture to draw.

    Attributes:
        file: its name.
        caption: below it in the report.
        draw: creates the figure.
        slow: whether it takes twice as long as most: drawn first, so that two processes end together.
    """

    file: str
    caption: str
    draw: Callable[[], Any]
    slow: bool = False


class PicturesWriter(Writer):
    """``pictures/*.png``: formed sheets, sections, forces, energies, and what the scene wants to show."""

    name = "pictures"
    title = "pictures"
    rank = 2
    packages = ("matplotlib",)

    @classmethod
    def load(cls) -> None:
        """Import Matplotlib."""
        pictures.load()

    def begin(self, results: Results, meanwhile: ExitStack) -> None:
        """Have a copy of this process begin to draw all pictures that apply to this run."""
        self._wanted: list[tuple[Picture, Path]] = []
        folder = self.folder / "pictures"
        if not self.attempt("pictures", lambda: folder.mkdir(exist_ok=True)):
            return
        self._wanted = [(picture, folder / picture.file) for picture in wanted_pictures(results)]
        self._order = sorted(range(len(self._wanted)), key=lambda number: not self._wanted[number][0].slow)
        for _, path in self._wanted:
            note(path)

        def there(turn: int) -> None:
            picture, path = self._wanted[self._order[turn]]
            with noting(lambda file: None):  # the record of the run is not the copy's
                _draw(picture, path, results.info.run_id)

        self._drawing = meanwhile.enter_context(Sharing(len(self._wanted), there))

    def write(self, results: Results) -> None:
        """Draw those that the copy has not drawn."""
        if not self._wanted:
            return
        drawn: set[int] = set()

        def here(turn: int) -> None:
            picture, path = self._wanted[number := self._order[turn]]
            if self.attempt(picture.file, partial(_draw, picture, path, results.info.run_id)):
                drawn.add(number)

        drawn |= {self._order[turn] for turn in self._drawing.finish(here)}
        results.pictures += [(path, picture.caption) for k, (picture, path) in enumerate(self._wanted) if k in drawn]


def _draw(picture: Picture, path: Path, run_id: str) -> None:
    with pictures.styled():
        pictures.write_picture(picture.draw(), path, run_id)


def wanted_pictures(results: Results) -> Iterator[Picture]:
    """In the order of the report."""
    yield from _formed_sheets(results)
    for curves in results.wanted.all_curves:
        for chart in curves.charts:
            yield Picture(f"{chart.name}.png", chart.caption, partial(pictures.chart_of, chart, curves.columns))
    yield from _point_angles(results)
    yield from _sections(results)
    yield from _charts(results)


def _caption(results: Results, name: str, text: str) -> str:
    return f"Sheet {name}. {text}" if len(results.sheets) > 1 else text


def _formed_sheets(results: Results) -> Iterator[Picture]:
    text = (
        "The formed sheet at the last frame. Each element has the colour of its own shear angle, without smoothing; "
        "the lines follow the yarns."
    )
    for sheet in results.sheets:
        caption = _caption(results, sheet.info.name, text)
        yield Picture(sheet.file("formed_sheet.png"), caption, partial(pictures.formed_sheet, sheet.formed), slow=True)
    for ending, sheets in _stacks(results):
        text = (
            "Sheets of one world: moved apart, in the colours of their shear angles, and as they lie, each in its own."
        )
        yield Picture(f"stack{ending}.png", text, partial(pictures.stack_picture, _named(sheets)))


def _stacks(results: Results) -> Iterator[tuple[str, list[SheetResult]]]:
    """Sheets of each world with several, from the bottom to the top, and the ending of their files."""
    level = dict(zip((sheet.name for sheet in results.info.sheets), results.info.levels, strict=True))
    for ending, infos in zip(world_endings(results.info), results.info.worlds, strict=True):
        if len(infos) > 1:
            own = [sheet for sheet in results.sheets if sheet.info.world == infos[0].world]
            yield ending, sorted(own, key=lambda sheet: level[sheet.info.name])


def _named(sheets: list[SheetResult]) -> list[tuple[str, FormedSheet]]:
    return [(sheet.info.name, sheet.formed) for sheet in sheets]


def _point_angles(results: Results) -> Iterator[Picture]:
    text = (
        "Shear angles at the material points: signed element values averaged to the nodes by area, mirrored elements "
        "included, then interpolated bilinearly; absolute values are shown."
    )
    for sheet in results.sheets if results.wanted.points is not None else ():
        draw = partial(pictures.point_angles, sheet.formed, results.wanted.measured_angles)
        yield Picture(sheet.file("point_angles.png"), _caption(results, sheet.info.name, text), draw)


def _sections(results: Results) -> Iterator[Picture]:
    stacked = []
    for ending, sheets in _stacks(results):
        stacked += [sheet.info.name for sheet in sheets]
        if all(sheet.formed.meets_both_lines for sheet in sheets):
            text = "Sections of the sheets of one world along the symmetry lines, drawn in their thickness."
            draw = partial(pictures.sections, _named(sheets), sheets[0].tools)
            yield Picture(f"sections{ending}.png", text, draw)
    for sheet in results.sheets:
        if not sheet.formed.meets_both_lines:
            continue
        if results.wanted.draw_in:
            text = "Draw-in: the outline before and after, and the plan movement of the border against its flat normal."
            draw = partial(pictures.draw_in_picture, sheet.formed, results.wanted.measured_outline)
            yield Picture(sheet.file("draw_in.png"), _caption(results, sheet.info.name, text), draw)
        if sheet.info.name in stacked:
            continue
        text = "Sections along the symmetry lines, sheet drawn in its thickness."
        draw = partial(pictures.sections, sheet.formed, sheet.tools)
        yield Picture(sheet.file("sections.png"), _caption(results, sheet.info.name, text), draw)


def _charts(results: Results) -> Iterator[Picture]:
    history, info = results.history, results.info
    if info.tools:
        yield Picture(
            "tool_forces.png",
            "Force between the whole part and each tool, along the tool's axis.",
            partial(pictures.tool_forces, history, info),
        )
    if history.drive_names:
        yield Picture(
            "drive_forces.png",
            "Force of the supports on the sheet along each prescribed motion: work per unit of its displacement.",
            partial(pictures.drive_forces, history, info),
        )
    yield Picture(
        "energies.png",
        "Energies of the ledger: the stack of stored and lost energies against the supplied work, each by itself, and "
        "the ratios by which a quasi-static run is judged.",
        partial(pictures.energies, history, info),
        slow=True,
    )
