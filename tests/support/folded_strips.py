"""Strips that are folded over, or rolled up, for tests of the contact of a sheet with itself."""

from __future__ import annotations

import numpy as np

from tests.support.stacked_plies import FABRIC, THICKNESS
from weavesim import Dynamics, SelfContact, Setup, Sheet, Solver, Tool
from weavesim.process.strokes import Fixed, Stroke
from weavesim.sheet.blank import Blank
from weavesim.tools import Plane, rotation_matrix


def zigzag(s: np.ndarray, leg: float, gap: float, legs: int) -> np.ndarray:
    """Points (n, 2) at arc lengths ``s`` (n,) of a zigzag: legs at heights 0, gap, ... and half turns between [m]."""
    radius, period = 0.5 * gap, leg + 0.5 * np.pi * gap
    k = np.minimum(np.floor(s / period), legs - 1)
    rest = s - k * period
    turn = np.clip((rest - leg) / radius, 0.0, np.pi)
    along = np.minimum(rest, leg) + radius * np.sin(turn)
    return np.column_stack([np.where(k % 2 == 0, along, leg - along), k * gap + radius * (1.0 - np.cos(turn))])


def spiral(s: np.ndarray, radius: float, gap: float) -> np.ndarray:
    """Points (n, 2) at about arc lengths ``s`` (n,) of a spiral whose turns are ``gap`` apart [m]."""
    rate = gap / (2.0 * np.pi)
    angle = (np.sqrt(radius**2 + 2.0 * rate * s) - radius) / rate
    return (radius + rate * angle)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def bent_strip(curve, length: float, size: float, width: int = 3) -> Blank:
    """A strip along ``curve``, from arc lengths to (x, z), free of stress, with its flat coordinates [m]."""
    s, y = np.meshgrid(
        np.linspace(0.0, length, max(8, round(length / size)) + 1), np.arange(width + 1) * size, indexing="ij"
    )
    plan = curve(s.ravel())
    position = np.column_stack([plan[:, 0], y.ravel(), plan[:, 1]])
    node = np.arange(s.size).reshape(s.shape)
    quads = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    corner = position[quads]
    return Blank.from_mesh(
        position, quads, material_coordinates=np.column_stack([s.ravel(), y.ravel()]),
        warp_direction=corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3],
    )  # fmt: skip


def fold_blank(size: float, leg: float, gap: float, legs: int = 2) -> Blank:
    """A folded strip [m]."""
    length = legs * leg + (legs - 1) * 0.5 * np.pi * gap
    return bent_strip(lambda s: zigzag(s, leg, gap, legs), length, size)


def press(height: float, stroke: float, duration: float) -> tuple[Tool, ...]:
    """A floor under a fold and a plate over it, that comes down by ``stroke`` [m] until 70 % of ``duration`` [s]."""
    turned = rotation_matrix((1.0, 0.0, 0.0), np.pi)
    down = Stroke((0.0, 0.7 * duration, 2.0 * duration), (0.0, stroke, stroke))
    half = 0.5 * THICKNESS
    plate = Plane(origin=(0.0, 0.0, height + half), rotation=turned)
    return (
        Tool("floor", Plane(origin=(0.0, 0.0, -half)), Fixed(), friction=0.0),
        Tool("plate", plate, down, axis=(0.0, 0.0, -1.0), friction=0.0),
    )


def pressed_fold(size: float, legs: int = 2, duration: float = 0.01, **given) -> Setup:
    """Legs of 20 thicknesses, 4 thicknesses apart, pressed until they touch, and 10 um more."""
    gap = 4.0 * THICKNESS
    blank = fold_blank(size, 20.0 * THICKNESS, gap, legs)
    sheet = Sheet(blank, FABRIC, name="strip", self_contact=SelfContact())
    solver = Solver(**{"precision": "float64", "threads": 1, **given.pop("solver", {})})
    return Setup(**{
        "name": "fold", "sheets": (sheet,),
        "tools": press((legs - 1) * gap, (legs - 1) * (gap - THICKNESS) + 1e-5, duration),
        "dynamics": Dynamics(damping=500.0, contact_damping_ratio=0.3), "duration": duration, "frame_count": 10,
        "solver": solver, "accept_unusual": True, **given,
    })  # fmt: skip
