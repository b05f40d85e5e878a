"""Pictures of a run."""

from .angles import point_angles
from .charts import chart_of, drive_forces, energies, tool_forces
from .draw_in import draw_in_picture
from .sections import sections
from .sheet import formed_sheet
from .stack import stack_picture
from .style import add_legend, colour_map, load, new_axes, new_figure, styled, words, write_picture

__all__ = [
    "add_legend",
    "chart_of",
    "colour_map",
    "draw_in_picture",
    "drive_forces",
    "energies",
    "formed_sheet",
    "load",
    "new_axes",
    "new_figure",
    "point_angles",
    "sections",
    "stack_picture",
    "styled",
    "tool_forces",
    "words",
    "write_picture",
]
