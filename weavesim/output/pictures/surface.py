"""Elements of a part, each in its own colour, seen obliquely and in plan: of any field, as notebooks ask for it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ...measures.findings import FormedSheet
from ...run.fields import FIELDS, Field
from ...run.frame import Frame, RunInfo
from ...run.staging.part import part_of
from ...sheet.topology import area_percentile, flat_areas
from .sheet import OBLIQUE, PLAN, formed_sheet, projection
from .style import INK, colour_map, fitting_height, new_axes, new_figure, ratio_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREY = (0.86, 0.87, 0.9, 1.0)
# Lengths are shown in millimetres.
_SHOWN = {"m": ("mm", 1.0e3)}


def draw_elements(axes: Axes, sheet: FormedSheet, colours: np.ndarray, direction: tuple[float, float]) -> None:
    """Draw the whole part.

    Args:
        axes: to draw on.
        sheet: formed.
        colours: of its elements, (element_count, 4).
        direction: azimuth and elevation of the viewer [degrees].
    """
    from matplotlib.collections import PolyCollection

    corners = sheet.symmetry.mirrored(sheet.position[sheet.blank.quads])
    colours = np.tile(colours, (len(sheet.symmetry.mirror_factors), 1)).copy()
    to_eye, right, screen = projection(direction)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300)
    colours[:, :3] *= (0.78 + 0.22 * np.abs(normal @ (to_eye + 0.5 * right) / 1.12).clip(0.0, 1.0))[:, None]
    order = np.argsort(corners.mean(axis=1) @ to_eye, kind="stable")
    polygons: Any = (corners @ screen)[order]
    axes.add_collection(PolyCollection(polygons, facecolors=colours[order], edgecolors=colours[order], linewidths=0.3))
    axes.autoscale_view()
    axes.set_aspect("equal")
    if direction == PLAN:
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
    else:
        axes.set_axis_off()


def scaled_colours(values: np.ndarray, largest: float) -> np.ndarray:
    """Colours of values from 0 to ``largest``; grey where there is none, (element_count, 4)."""
    colours = np.tile(np.array(GREY), (len(values), 1))
    known = np.isfinite(values)
    colours[known] = colour_map()(np.clip(values[known] / max(largest, 1.0e-300), 0.0, 1.0))
    return colours


def signed_colours(values: np.ndarray, largest: float) -> np.ndarray:
    """Blue to red from -``largest`` to ``largest``; grey where there is none, (element_count, 4)."""
    from matplotlib import colormaps

    colours = np.tile(np.array(GREY), (len(values), 1))
    known = np.isfinite(values)
    share = 0.5 + 0.5 * np.clip(values[known] / max(largest, 1.0e-300), -1.0, 1.0)
    colours[known] = colormaps["coolwarm"](share)
    return colours


def view(direction: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Unit vector to the eye, and the projection to the screen, (3, 2) [mm/m]."""
    to_eye, _, screen = projection(direction)
    return to_eye, screen


def picture_of(info: RunInfo, frame: Frame, field: str = "shear_angle", sheet: str | None = None) -> Figure:
    """A sheet of a frame in the colours of a field.

    Args:
        info: of the run.
        frame: to show.
        field: by its name in frames or in files.
        sheet: by name; not needed if there is only one.

    Raises:
        InputError: an unknown sheet or field.
    """
    names = [one.name for one in info.sheets]
    if sheet is None and len(names) > 1:
        raise InputError(f"this run has {len(names)} sheets: choose one of {', '.join(names)}")
    if sheet is not None and sheet not in names:
        raise InputError(f"sheet {sheet!r}: choose one of {', '.join(names)}")
    place = 0 if sheet is None else names.index(sheet)
    about, state = part_of(info.sheets[place], frame.sheets[place])
    formed = FormedSheet(about.blank, state.position, state.fields, about.fabric.thickness, about.symmetry)
    found = _field(field, state.fields)
    return formed_sheet(formed) if found.name == "shear_angle" else field_picture(formed, found)


def _field(name: str, fields: dict[str, np.ndarray]) -> Field:
    """A field of a frame by its name there or in files.

    Raises:
        InputError: there is none.
    """
    for field in FIELDS:
        if field.name in fields and name in (field.name, field.file_name):
            return field
    raise InputError(
        f"field {name!r}: choose one of {', '.join(field.name for field in FIELDS if field.name in fields)}"
    )


def field_picture(sheet: FormedSheet, field: Field) -> Figure:
    """The whole part, oblique and in plan; the largest value is ringed, and 98 % of the area has all colours."""
    unit, factor = _SHOWN.get(field.file_unit, (field.file_unit, 1.0))
    values = factor * field.in_file(sheet.fields[field.name])
    known = values[np.isfinite(values)]
    low, high = (
        (area_percentile(values, flat_areas(sheet.blank), share) for share in (1.0, 99.0)) if len(known) else (0.0, 1.0)
    )
    if not high - low > 1.0e-9 * max(abs(low), abs(high)):
        low, high = low - 0.5e-3 * max(abs(low), 1.0e-9), high + 0.5e-3 * max(abs(high), 1.0e-9)
    border = sheet.position[sheet.border.node, 2]
    turned = float(border.mean()) > float(sheet.position[:, 2].mean())
    oblique = (OBLIQUE[0], -OBLIQUE[1]) if turned else OBLIQUE
    corners = sheet.symmetry.mirrored(sheet.position).reshape(-1, 3)
    ratios = [ratio_of(corners @ projection(direction)[2]) for direction in (oblique, PLAN)]
    figure = new_figure(13.0, fitting_height(13.0, ratios, 1.5))
    grid = figure.add_gridspec(1, 2, width_ratios=[1.0 / ratio for ratio in ratios])
    colours = scaled_colours(values - low, high - low)
    titles = (f"{field.description}{', from below' if turned else ''}", "From above")
    axes = []
    for place, (direction, title) in enumerate(zip((oblique, PLAN), titles, strict=True)):
        axes.append(new_axes(figure, grid[0, place], title=title[:1].upper() + title[1:]))
        draw_elements(axes[-1], sheet, colours, direction)
    if len(known):
        element = int(np.nanargmax(values))
        middle = sheet.position[sheet.blank.quads[element]].mean(axis=0) @ projection(PLAN)[2]
        ring: Any = {"markersize": 11, "markerfacecolor": "none", "markeredgewidth": 1.4}
        axes[1].plot(*middle, "o", markeredgecolor=INK, zorder=6, **ring)
    _bar(figure, axes, field, unit, values, (low, high))
    return figure


def _bar(
    figure: Figure, axes: list[Any], field: Field, unit: str, values: np.ndarray, limits: tuple[float, float]
) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    mappable = ScalarMappable(Normalize(*limits), colour_map())
    bar = figure.colorbar(mappable, ax=axes, location="bottom", shrink=0.5, aspect=45, pad=0.02, extend="both")
    bar.outline.set_visible(False)
    name = field.name.replace("_", " ") + ("" if unit == "1" else f" [{unit}]")
    if np.isfinite(values).any():
        ends = f"smallest {np.nanmin(values):.4g}, largest {np.nanmax(values):.4g}"
        name = f"{name}, {ends}, 98 % between the ends of the scale"
    bar.set_label(name, color=INK, fontsize=9.5)
