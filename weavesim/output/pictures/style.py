"""The common style of all pictures, and writing them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..colours import DISTINCT_COLOURS, colour_table, encoded
from ..files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


INK, GREY, FAINT, ACCENT, MEASURED = "#23262d", "#6b7280", "#9aa1ad", "#5b3fb5", "#d1495b"
LINE_COLOURS = DISTINCT_COLOURS
_STYLE: Any = {
    "font.size": 9.5,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8ec",
    "grid.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
}
_RESOLUTION = 150
# Of PNG: half the time of the usual 6, and a tenth more space.
_COMPRESSION = 3
# Of a line of a title above its axes, with its distance [points].
_TITLE_HEIGHT = 20.0
# Of axes whose labels may lie on each other [inches].
_NARROW = 2.0


_is_styled: ContextVar[bool] = ContextVar("_is_styled", default=False)


def load() -> None:
    """Import what draws, before it is needed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: F401

    _kind()


@contextmanager
def styled() -> Iterator[None]:
    """The common style, for what is made inside; taking it is slow, so that within itself it does nothing."""
    if _is_styled.get():
        yield
        return
    from matplotlib import rc_context

    token = _is_styled.set(True)
    try:
        with rc_context(_STYLE):
            yield
    finally:
        _is_styled.reset(token)


def write_picture(figure: Figure, path: str | Path, run_id: str = "") -> None:
    """Write the figure with 150 dots per inch, in the format given by the extension of ``path``.

    PNG files tell the ``run_id`` in their text "weavesim run".
    """
    _lay_out(figure)
    with replacing(Path(path)) as temporary:
        is_png = Path(path).suffix == ".png"
        metadata = {"weavesim run": run_id} if run_id and is_png else None
        more: Any = {"pil_kwargs": {"compress_level": _COMPRESSION}} if is_png else {}
        figure.savefig(temporary, dpi=_RESOLUTION, facecolor="white", metadata=metadata, **more)


def _lay_out(figure: Figure) -> None:
    """Find the places of everything, once: savefig would draw everything twice for it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    figure.set_dpi(_RESOLUTION)
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        if _titles_are_cut(figure):  # axes of equal scales took their final heights only while it was done
            engine.execute(figure)
        if _fit_texts(figure):  # wrapped titles need more height than the layout has left them
            engine.execute(figure)
            _fit_texts(figure)
        figure.set_layout_engine(None)


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
        loc: Any = "left" if axes.get_title(loc="left") else "center"
        text, spec = axes.get_title(loc=loc).replace("\n", " "), axes.get_subplotspec()
        if not text or spec is None:
            continue
        cell = spec.get_position(figure)
        left, right = cell.x0 * figure.bbox.width, min(cell.x1, 0.995) * figure.bbox.width
        with styled():
            title = axes.set_title(text, loc=loc)
            title.set_x({"left": 0.0, "center": 0.5}[loc])  # where it was before it was moved
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


def new_figure(width: float, height: float) -> Figure:
    """An empty figure in the common style; sizes in inches."""
    with styled():
        return _kind()(figsize=(width, height), layout="constrained")


@cache
def _kind() -> type[Figure]:
    """The class of all figures, made when Matplotlib is needed."""
    from matplotlib.figure import Figure

    class Picture(Figure):
        """A figure that notebooks show by themselves: without pyplot they would print its name."""

        def _repr_png_(self) -> bytes:
            data = BytesIO()
            _lay_out(self)
            self.savefig(data, dpi=100, facecolor="white", format="png")
            return data.getvalue()

    return Picture


def new_axes(figure: Figure, *place: Any, **settings: Any) -> Axes:
    """Axes in the common style."""
    with styled():
        return figure.add_subplot(*place, **settings)


def add_legend(axes: Axes, **settings: Any) -> None:
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=9, **settings)


def colour_map() -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(encoded(colour_table()), name="shear angle")


def ratio_of(points: np.ndarray) -> float:
    """Height over width of what is drawn at points on the screen, (..., 2), within what a picture can show."""
    width, height = np.ptp(points.reshape(-1, 2), axis=0)
    return float(np.clip(height / width, 0.15, 6.0))


def fitting_height(width: float, ratios: Sequence[float], further: float = 0.0) -> float:
    """Height of a row of pictures that are drawn to scale, side by side in a width, all in inches.

    Args:
        width: of the row.
        ratios: height over width of each.
        further: height that titles and scales take besides.
    """
    wanted = 0.92 * width / sum(1.0 / ratio for ratio in ratios)
    return float(min(max(wanted, 1.6), 6.0)) + further


def words(name: str) -> str:
    return name.replace("_", " ")
