"""A run before it starts: sections through tools and plies, and what a mesh cannot follow, in plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...device import resolve_device
from ...tools.mesh_features import convex_radii
from ...tools.mesh_topology import directed_edges, edge_keys
from ...tools.sampling import DOUBTFUL_ERROR, sampled_distance
from ...tools.surfaces.flaws import forgotten_holes
from .sections import plane_cut
from .style import ACCENT, INK, LINE_COLOURS, MEASURED, new_axes, new_figure, words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from ...engine.setup import Setup
    from ...sheet.blank import Blank
    from ...tools.tool import Tool

# Faces that are drawn at most, and shares of an element's wish of five elements on a quarter turn.
LARGEST_FACE_COUNT = 60_000
ENOUGH, FEW = 5.0, 3.0
TOO_SHARP = "#d1495b"
TURNED = "#7fb069"
HOLE = "#e4572e"
WRONG = "#1d3557"
COARSE = "#e9b44c"
FINE = "#c9d3dc"


def before_run(setup: Setup, with_errors: bool = False) -> Figure:
    """Sections along x and y at the start, with the closed tools dashed; and each mesh tool from its side, in plan.

    Args:
        setup: of the run; its first world is drawn.
        with_errors: mark where the sampled distance to a mesh is wrong by more than is trusted; samples the meshes
            if that has not been done.
    """
    world = setup.worlds[0]
    meshes = [tool for tool in world.tools if any(part.surface is not None for part in tool.shape.parts())]
    figure = new_figure(14.0, 7.4 if meshes else 4.0)
    columns = max(1, min(3, len(meshes)))
    grid = figure.add_gridspec(2 if meshes else 1, 6, height_ratios=(1.0, 1.6) if meshes else (1.0,))
    for row, along in enumerate("xy"):
        axes = new_axes(figure, grid[0, 3 * row : 3 * row + 3], aspect="equal")
        _section(axes, setup, along)
        if row == 0:
            figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=6, frameon=False)
    size = max(float(np.sqrt(np.median(_areas(sheet.blank)))) for sheet in world.sheets)
    wide, found = 6 // columns, set[str]()
    for place, tool in enumerate(meshes[:columns]):
        axes = new_axes(figure, grid[1, wide * place : wide * (place + 1)], aspect="equal")
        found |= _plan(axes, setup, tool, size)
        if with_errors:
            found |= _errors(axes, setup, tool)
    if meshes:
        figure.legend(handles=_marks(found), loc="outside lower center", ncols=6, fontsize=9, frameon=False)
    return figure


def _areas(blank: Blank) -> np.ndarray:
    corner = blank.node_position[blank.quads]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1)


def _section(axes: Axes, setup: Setup, along: str) -> None:
    from matplotlib.collections import LineCollection

    row, world = "xy".index(along), setup.worlds[0]
    nodes = np.concatenate([sheet.blank.node_position for sheet in world.sheets])
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    if "yx"[row] in world.symmetry.planes:
        middle[1 - row] = 0.0
    axes.set(
        title=f"At the start, cut along {along} ({'yx'[row]} = {1e3 * middle[1 - row]:.4g} mm)",
        xlabel=f"{along} [mm]",
        ylabel="z [mm]",
    )
    heights: list[np.ndarray] = []
    for k, tool in enumerate(world.tools):
        vertices, faces = tool.display_triangles()
        if tool.motion.is_carried:
            vertices = tool.moved(vertices, tool.place_at(0.0))
        shift = np.zeros(3)
        shift[1 - row] = middle[1 - row]
        lines = plane_cut(vertices - shift, faces, 1 - row)
        if not len(lines):
            continue
        colour, pieces = LINE_COLOURS[k % len(LINE_COLOURS)], 1.0e3 * lines[:, :, [row, 2]]
        axes.add_collection(LineCollection(list(pieces), colors=colour, linewidths=1.5, label=words(tool.name)))
        heights.append(pieces[:, :, 1].ravel())
        travel = np.zeros(1) if tool.motion.by_force else tool.motion.curve()[1]
        if np.ptp(travel) > 0.0 and not tool.motion.is_carried:
            moved = pieces + 1.0e3 * float(travel[-1]) * np.asarray(tool.axis, dtype=float)[[row, 2]]
            axes.add_collection(LineCollection(list(moved), colors=colour, linewidths=0.9, linestyles="dashed"))
            heights.append(moved[:, :, 1].ravel())
        if tool.motion.is_carried:
            there = tool.moved(tool.display_triangles()[0], tool.place_at(tool.motion.duration))
            ends = 1.0e3 * plane_cut(there - shift, faces, 1 - row)[:, :, [row, 2]]
            axes.add_collection(LineCollection(list(ends), colors=colour, linewidths=0.9, linestyles="dashed"))
            heights.append(ends[:, :, 1].ravel())
    for sheet in world.sheets:
        low, high = (1.0e3 * bound(sheet.blank.node_position[:, row]) for bound in (np.min, np.max))
        z, half = 1.0e3 * sheet.blank.node_position[:, 2].mean(), 0.5e3 * sheet.fabric.thickness
        axes.fill_between([low, high], z - half, z + half, color=INK, linewidth=0.4, zorder=3, label=words(sheet.name))
        heights.append(np.array([z - half, z + half]))
    reach = 1.0e3 * np.array([nodes[:, row].min(), nodes[:, row].max()])
    margin = 0.08 * float(np.ptp(reach))
    z = np.concatenate(heights)
    low, high = float(z.min()), float(z.max())
    tall = 0.45 * float(np.ptp(reach))
    if high - low > tall:  # walls of built-in shapes may be drawn high
        high = low + tall
    axes.set(xlim=(reach[0] - margin, reach[1] + margin), ylim=(low - 4.0, high + 4.0))


def _plan(axes: Axes, setup: Setup, tool: Tool, size: float) -> set[str]:
    """A mesh tool in plan: radii by how many elements follow them, borders, holes, sharp edges, outlines of the plies.

    Returns:
        the labels of what is wrong with it.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    found = set[str]()
    axes.set(title=f"{words(tool.name)}: what elements of {1e3 * size:.3g} mm follow", xlabel="x [mm]", ylabel="y [mm]")
    for part in tool.shape.parts():
        surface = part.surface
        if surface is None:
            continue
        turn, origin = np.array(part.rotation).T, np.array(part.origin)
        vertices = surface.vertices @ turn + origin
        faces = surface.faces
        count = 0.5 * np.pi * convex_radii(surface.vertices, faces) / size
        shown = np.arange(len(faces))[:: max(1, -(-len(faces) // LARGEST_FACE_COUNT))]
        order = shown[np.argsort(-count[shown], kind="stable")]
        colours = np.where(count < FEW, TOO_SHARP, np.where(count < ENOUGH, COARSE, FINE))[order]
        corners = 1.0e3 * vertices[faces[order]][:, :, :2]
        axes.add_collection(PolyCollection(list(corners), facecolors=list(colours), edgecolors="face", linewidths=0.3))
        if len(surface.turned):
            corners = 1.0e3 * (surface.turned @ turn + origin)[:, :, :2]
            axes.add_collection(PolyCollection(list(corners), facecolors=TURNED, edgecolors=TURNED, linewidths=0.6))
            found.add("turned")
        border = _border(faces)
        if len(border):
            lines = 1.0e3 * vertices[border][:, :, :2]
            axes.add_collection(LineCollection(list(lines), colors=ACCENT, linewidths=1.2))
        if len(surface.sharp_edges):
            lines = 1.0e3 * vertices[surface.sharp_edges][:, :, :2]
            axes.add_collection(LineCollection(list(lines), colors=MEASURED, linewidths=1.6))
        for hole in forgotten_holes(part):
            lines = 1.0e3 * (hole.edges @ turn + origin)[:, :, :2]
            axes.add_collection(LineCollection(list(lines), colors=HOLE, linewidths=2.4, zorder=4))
            # a small one would not be seen
            middle = 1.0e3 * (hole.place @ turn + origin)
            axes.plot(*middle[:2], marker="o", markersize=14.0, fillstyle="none", color=HOLE, zorder=4)
            found.add("hole")
    for sheet in setup.worlds[0].sheets:
        loop = sheet.blank.boundary_loop()
        outline = 1.0e3 * sheet.blank.node_position[np.append(loop, loop[0])][:, :2]
        axes.plot(*outline.T, color=INK, linewidth=1.0, linestyle="dashed")
    axes.autoscale_view()
    axes.grid(False)
    return found


def _errors(axes: Axes, setup: Setup, tool: Tool) -> set[str]:
    """Marks where the sampled distance to a tool is wrong by more than is trusted; returns their label."""
    world, found = setup.worlds[0], set[str]()
    thickest = max(sheet.fabric.thickness for sheet in world.sheets)
    thinnest = min(sheet.fabric.thickness for sheet in setup.sheets)
    for part in tool.shape.parts():
        if part.surface is None:
            continue
        sampled = sampled_distance(part.surface, str(resolve_device(setup.solver.device)), thinnest, thickest)
        wrong = sampled.worst_points[sampled.worst_errors > DOUBTFUL_ERROR * thinnest]
        if len(wrong):
            points = 1.0e3 * (wrong @ np.array(part.rotation).T + np.array(part.origin))
            axes.plot(*points[:, :2].T, marker="x", markersize=4.0, linestyle="", color=WRONG, zorder=5)
            found.add("wrong")
    return found


def _marks(found: set[str]) -> list[Line2D]:
    """What the signs mean; those of faults only where some are ``found``."""
    from matplotlib.lines import Line2D

    faults = {
        "turned": Line2D([], [], marker="s", linestyle="", color=TURNED, label="faced the other way, turned"),
        "hole": Line2D([], [], marker="o", fillstyle="none", linestyle="", color=HOLE, label="hole in the surface"),
        "wrong": Line2D([], [], marker="x", linestyle="", color=WRONG, label="distance is wrong"),
    }

    squares = ((FINE, "five elements on 90°, or flat"), (COARSE, "three to five"), (TOO_SHARP, "fewer"))
    return [
        *(Line2D([], [], marker="s", linestyle="", color=colour, label=label) for colour, label in squares),
        Line2D([], [], color=ACCENT, label="border"),
        Line2D([], [], color=MEASURED, label="sharp edge"),
        Line2D([], [], color=INK, linestyle="dashed", label="ply"),
        *(mark for name, mark in faults.items() if name in found),
    ]


def _border(faces: np.ndarray) -> np.ndarray:
    """Edges that only one triangle has, (k, 2)."""
    edges = directed_edges(faces)
    _, first, count = np.unique(edge_keys(edges), return_index=True, return_counts=True)
    return edges[first[count == 1]]
