"""A square of four elements that is sheared, stretched and bent along a path, and what its ledger says."""

import math

import numpy as np

from weavesim.fabric.shear import ShearFriction
from weavesim.sheet.blank import Blank

SQUARE = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.05)
UP = np.tile([0.0, 0.0, 1.0], (SQUARE.node_count, 1))
FRICTION = ShearFriction(stiffness=60.0, angle=(0.0, 0.8), limit=(1.5, 3.0))


def sheared(angle: float, stretch: float = 1.0) -> np.ndarray:
    """Positions of the square with unit warp and weft vectors at 90 degrees minus ``angle``."""
    gradient = stretch * np.array([[1.0, math.sin(angle), 0.0], [0.0, math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return SQUARE.node_position @ gradient.T


def rolled(curvature: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and directors of the square, bent along x into an arc of the curvature [1/m], chords kept."""
    x, y, _ = SQUARE.node_position.T
    size = np.ptp(x) / 2.0
    turn = curvature * x
    # nodes at equal chords of the element size, so that neither stretch nor transverse shear changes
    steps = np.unique(np.round(x / size).astype(int))
    middle = curvature * size * (steps[1:] - 0.5)
    along = np.concatenate([[0.0], np.cumsum(size * np.cos(middle))])
    height = np.concatenate([[0.0], np.cumsum(size * np.sin(middle))])
    index = np.round(x / size).astype(int)
    director = np.column_stack([-np.sin(turn), np.zeros_like(x), np.cos(turn)])
    return np.column_stack([along[index], y, height[index]]), director


def walk(shell, states) -> list[dict[str, float]]:
    """The ledger along a path of (position, director), with the work done on the nodes; histories are kept."""
    entries, work, last = [], 0.0, None
    for position, director in states:
        force, conjugate = shell.forces(position, director, fresh=last is None)
        if last is not None:
            moved, turned = position - last[0], director - last[1]
            work -= 0.5 * float(((force + last[2]) * moved).sum() + ((conjugate + last[3]) * turned).sum())
        last = (position, director, force, conjugate)
        frame = shell.simulation.ledger.frame(0)
        entries.append(frame.energies | {"work": work, "fields": frame.fields})
    return entries


def cycle(largest: float, count: int) -> np.ndarray:
    """0, up, down to the opposite, and back to 0."""
    corners = [0.0, largest, -largest, 0.0]
    return np.concatenate(
        [[0.0], *(np.linspace(a, b, count + 1)[1:] for a, b in zip(corners, corners[1:], strict=False))]
    )


def loop_figure(x, expected, found, x_label, y_label):
    """Known and computed loop."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 2.8))
    axes = figure.add_subplot()
    axes.plot(x, expected, "k-", lw=2.5, alpha=0.3, label="known")
    axes.plot(x, found, "tab:blue", lw=1.0, label="weavesim")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.legend(fontsize=7)
    axes.grid(lw=0.3)
    return figure
