"""Where everything goes in a figure: found once, before it is drawn."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

# Of a line of a title above its axes, with its distance [points].
_TITLE_HEIGHT = 20.0
# Of axes whose labels may lie on each other [inches].
_NARROW = 2.0
# Of a title: where along its axes it begins, or has its middle.
_PLACES = {"left": 0.0, "center": 0.5}


def lay_out(figure: Figure, dots_per_inch: float) -> None:
    """Find the places of everything, once: savefig would draw everything twice for it.

    Args:
        figure: to be drawn; it gets a canvas, and its layout is fixed.
        dots_per_inch: of what is drawn.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    figure.set_dpi(dots_per_inch)
    if (engine := figure.get_layout_engine()) is not None:
        with _measured_once(figure):
            engine.execute(figure)
            if _titles_are_cut(figure):  # axes of equal scales took their final heights only while it was done
                engine.execute(figure)
            if _fit_texts(figure):  # wrapped titles need more height than the layout has left them
                engine.execute(figure)
                _fit_texts(figure)
        figure.set_layout_engine(None)


@contextmanager
def _measured_once(figure: Figure) -> Iterator[None]:
    """Inside this context axes are asked by ``_room`` how much room they take.

    Matplotlib itself measures every label of both axes six times for it, and makes each line of the axes look for all
    ticks: half the time of a chart.
    """
    own = "get_tightbbox"
    every = list(figure.axes)
    for axes in every:
        setattr(axes, own, partial(_room, axes))
    try:
        yield
    finally:
        for axes in every:
            delattr(axes, own)


def _room(axes: Axes, renderer: Any, **given: Any) -> Bbox | None:
    """What axes take of a figure with labels, title and legend [pixels].

    As ``Axes.get_tightbbox`` for a layout, but only the longest of the labels is measured, and of what is drawn only
    texts and the legend: the rest is within the axes.
    """
    from matplotlib.transforms import Bbox

    if not axes.get_visible():
        return None
    usual = axes.xaxis.get_label_position() == "bottom" and axes.yaxis.get_label_position() == "left"
    if not usual or _has_power(axes):
        return type(axes).get_tightbbox(axes, renderer, **given)
    locator: Any = axes.get_axes_locator()
    axes.apply_aspect(locator(axes, renderer) if locator else None)
    frame = axes.get_window_extent(renderer)
    boxes = [frame]
    if axes.axison:
        boxes += [box for axis in (axes.xaxis, axes.yaxis) if (box := _room_of_axis(axes, axis, renderer)) is not None]
    for title in _titles(axes).values():
        box = title.get_window_extent(renderer)
        middle = 0.5 * (box.x0 + box.x1)  # a layout cannot help where it is too long
        boxes.append(Bbox.from_extents(middle, box.y0, middle, box.y1))
    legend = axes.get_legend()
    if legend is not None and not np.array_equal(legend.get_bbox_to_anchor().extents, frame.extents):
        boxes.append(legend.get_window_extent(renderer))
    boxes += [text.get_window_extent(renderer) for text in axes.texts if text.get_visible() and text.get_in_layout()]
    return Bbox.union(boxes)


def _room_of_axis(axes: Axes, axis: Any, renderer: Any) -> Bbox | None:
    """Of the labels of an axis [pixels]."""
    from matplotlib.transforms import Bbox

    if not axis.get_visible():
        return None
    is_x = axis is axes.xaxis
    across, along = (1, 0) if is_x else (0, 1)
    places = np.asarray(axis.get_majorticklocs(), dtype=float)
    texts = axis.get_major_formatter().format_ticks(places)
    frame = axes.bbox.extents
    transform = axes.get_xaxis_transform() if is_x else axes.get_yaxis_transform()
    there = np.zeros((len(places), 2))
    there[:, along] = places
    pixels = transform.transform(there)[:, along]
    shown = np.flatnonzero((pixels > frame[along] - 1.0) & (pixels < frame[2 + along] + 1.0))
    shown = shown[[bool(texts[k]) for k in shown]] if len(shown) else shown
    tick, point = axis.get_major_ticks(1)[0], renderer.points_to_pixels(1.0)
    boxes, outer = [], float(frame[across])
    if len(shown) and tick.label1.get_visible():
        outer -= point * (tick.get_pad() + tick.get_tick_padding())
        ends = {shown[np.argmin(pixels[shown])], shown[np.argmax(pixels[shown])]}
        sizes = []
        for k in {*ends, max(shown, key=lambda k: len(texts[k]))}:
            tick.label1.set_text(texts[k])
            size = tick.label1.get_window_extent(renderer).size
            sizes.append(size[across])
            if k in ends:
                low, high = pixels[k] - 0.5 * size[along], pixels[k] + 0.5 * size[along]
                boxes.append((low, outer, high, outer) if is_x else (outer, low, outer, high))
        outer -= max(sizes)
    if axis.label.get_visible() and axis.label.get_text():
        outer -= point * axis.labelpad + axis.label.get_window_extent(renderer).size[across]
    middle = 0.5 * (frame[along] + frame[2 + along])
    boxes.append((middle, outer, middle, outer) if is_x else (outer, middle, outer, middle))
    return Bbox.union([Bbox.from_extents(*box) for box in boxes])


def _titles(axes: Axes) -> dict[str, Text]:
    """Titles that axes have, by their place; nothing moves them but a power of ten at the end of an axis."""
    y, every = None if _has_power(axes) else 1.0, list[Any](_PLACES)
    return {loc: axes.set_title(text, loc=loc, y=y) for loc in every if (text := axes.get_title(loc=loc))}


def _has_power(axes: Axes) -> bool:
    """Whether a power of ten stands at the end of an axis, for all of its labels; known once they have been made."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_major_formatter().format_ticks(np.asarray(axis.get_majorticklocs()).tolist())
        if axis.get_major_formatter().get_offset():
            return True
    return False


def _titles_are_cut(figure: Figure) -> bool:
    """Whether a title of axes of equal scales is not within the height of the figure."""
    for axes in figure.axes:
        if axes.get_aspect() == "auto":  # they have their place
            continue
        axes.apply_aspect()
        title = any(axes.get_title(loc=loc) for loc in ("left", "center"))
        above = _TITLE_HEIGHT / 72.0 * figure.dpi if title else 0.0
        if axes.bbox.y1 + above > figure.bbox.height:
            return True
    return False


def _fit_texts(figure: Figure) -> bool:
    """Move and wrap titles that are wider than their axes, and show fewer labels where they would lie on each other.

    Returns whether a title goes beyond the height of the figure.

    Axes of equal scales may become as narrow as a part is; a layout leaves the widths of titles out of account.
    """
    canvas: Any = figure.canvas
    renderer, is_cut = canvas.get_renderer(), False
    for axes in figure.axes:
        axes.apply_aspect()
        own = axes.get_window_extent(renderer)
        if own.width < _NARROW * figure.dpi:
            _thin_out(axes, renderer)
        spec, found = axes.get_subplotspec(), _titles(axes)
        if not found or spec is None:
            continue
        cell = spec.get_position(figure)
        left, right = cell.x0 * figure.bbox.width, min(cell.x1, 0.995) * figure.bbox.width
        loc, title = next(iter(found.items()))
        text = title.get_text().replace("\n", " ")
        title.set_text(text)
        title.set_x(_PLACES[loc])  # where it was before it was moved
        width = title.get_window_extent(renderer).width
        if width > right - left:
            letters = max(8, int(len(text) * (right - left) / width))
            title.set_text("\n".join(textwrap.wrap(text, letters)))
        box = title.get_window_extent(renderer)
        if box.x1 > right:
            title.set_x(title.get_position()[0] - (box.x1 - max(right, left + box.width)) / max(own.width, 1.0))
        is_cut |= box.y1 > figure.bbox.height
    return is_cut


def _thin_out(axes: Axes, renderer: Any) -> None:
    """Show fewer labels along x, where they would lie on each other."""
    labels = [label for label in axes.get_xticklabels() if label.get_text()]
    boxes = [label.get_window_extent(renderer) for label in labels]
    shown = [k for k, box in enumerate(boxes) if axes.bbox.x0 - 1.0 <= 0.5 * (box.x0 + box.x1) <= axes.bbox.x1 + 1.0]
    if all(boxes[a].x1 + 2.0 < boxes[b].x0 for a, b in zip(shown[:-1], shown[1:], strict=True)):
        return
    ticks = [axes.get_xticks()[k] for k in shown]
    both = len(ticks) > 1 and boxes[shown[0]].x1 + 2.0 < boxes[shown[-1]].x0
    axes.set_xticks([ticks[0], ticks[-1]] if both else [ticks[len(ticks) // 2]])
