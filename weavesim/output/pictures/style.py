"""The common style of all pictures, and writing them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..colours import DISTINCT_COLOURS, colour_table, encoded
from ..drawing.layout import lay_out
from ..drawing.png import png_of
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
_RESOLUTION, _RESOLUTION_OF_NOTEBOOKS = 150, 100


_is_styled: ContextVar[bool] = ContextVar("_is_styled", default=False)


def load() -> None:
    """Import what draws, before it is needed, with what reads powers of ten."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: F401
    from matplotlib.font_manager import FontProperties
    from matplotlib.mathtext import MathTextParser

    _kind()
    MathTextParser("agg").parse("$10^{0}$", prop=FontProperties())


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
    with styled():
        lay_out(figure, _RESOLUTION)
    with replacing(Path(path)) as temporary:
        if Path(path).suffix == ".png":
            temporary.write_bytes(_png(figure, {"weavesim run": run_id} if run_id else {}))
        else:
            figure.savefig(temporary, dpi=_RESOLUTION, facecolor="white")


def _png(figure: Figure, texts: Mapping[str, str]) -> bytes:
    """A figure that is laid out, as a PNG file."""
    canvas: Any = figure.canvas
    figure.set_facecolor("white")
    canvas.draw()
    return png_of(np.asarray(canvas.buffer_rgba()), figure.dpi, {"Software": "weavesim", **texts})


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
            with styled():
                lay_out(self, _RESOLUTION_OF_NOTEBOOKS)
            return _png(self, {})

    return Picture


def new_axes(figure: Figure, *place: Any, **settings: Any) -> Axes:
    """Axes in the common style."""
    with styled():
        return figure.add_subplot(*place, **settings)


def add_legend(axes: Axes, **settings: Any) -> None:
    """A legend without a frame, if something on the axes has a label."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=9, **settings)


def colour_map() -> Any:
    """The colours of angles, as a colour map of Matplotlib."""
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
    """A name as words."""
    return name.replace("_", " ")
