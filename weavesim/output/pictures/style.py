"""The common style of all pictures, and writing them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

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
# By the computed share of the part.
PART_NAMES = {1.0: "the part", 0.5: "the computed half", 0.25: "the computed quarter"}
_RESOLUTION = 150


def write_picture(figure: Figure, path: str | Path, run_id: str = "") -> None:
    """Write the figure with 150 dots per inch, in the format given by the extension of ``path``.

    PNG files tell the ``run_id`` in their text "weavesim run".
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # layout is done here: savefig would draw everything twice for it
    FigureCanvasAgg(figure)
    figure.set_dpi(_RESOLUTION)
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    with replacing(Path(path)) as temporary:
        metadata = {"weavesim run": run_id} if run_id and Path(path).suffix == ".png" else None
        figure.savefig(temporary, dpi=_RESOLUTION, facecolor="white", metadata=metadata)


def new_figure(width: float, height: float) -> Figure:
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(_STYLE):
        return Figure(figsize=(width, height), layout="constrained")


def new_axes(figure: Figure, *place: Any, **settings: Any) -> Axes:
    from matplotlib import rc_context

    with rc_context(_STYLE):
        return figure.add_subplot(*place, **settings)


def add_legend(axes: Axes, **settings: Any) -> None:
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=9, **settings)


def colour_map() -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(encoded(colour_table()), name="shear angle")


def words(name: str) -> str:
    return name.replace("_", " ")
