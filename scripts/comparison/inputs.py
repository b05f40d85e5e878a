"""Files that the cases read: a fabric, and the tools of a double dome as open meshes in millimetres."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

RUBBING_FABRIC = """\
# plain weave with friction of the crossovers, and yarns whose bending is a curve with a loop
based_on = "glass-polypropylene"
name = "rubbing fabric"

[shear_friction]
stiffness = 60.0
limit = [0.5, 0.8]
angle = [0.0, 0.6]
crossover_friction_length = 1e-4

[bending]
kind = "YarnBending"
twist = 1.4e-3
warp = {kind = "BendingCurve.from_kawabata", rigidity = 2.9e-3, hysteresis = 2.0e-2}

[bending.weft]
kind = "BendingCurve"
curvature = [0.0, 10.0, 50.0]
moment_values = [0.0, 0.023, 0.072]
friction_limit = 0.008
friction_stiffness = 0.0008
"""


def write_inputs(folder: Path) -> None:
    """Input files of the cases: a fabric, and the tools of a double dome as open meshes in millimetres.

    Existing files are kept, so that both versions read the same.
    """
    turn = np.linspace(0.0, 0.5 * np.pi, 25)
    punch = np.column_stack([60.0 * np.sin(turn), 60.0 * (1.0 - np.cos(turn))])
    wall = [(61.2, -30.0), (61.2, -20.0)]
    edge = np.column_stack([71.2 - 10.0 * np.cos(turn), -10.0 + 10.0 * np.sin(turn)])
    die = np.vstack([wall, edge, [(130.0, 0.0), (200.0, 0.0)]])
    files = {
        "rubbing.toml": RUBBING_FABRIC.encode(),
        "punch.stl": stl(punch),
        "die.stl": stl(die),
        "binder.stl": stl(die * (1.0, -1.0)),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        path = folder / name
        if path.exists() and path.read_bytes() != content:
            raise SystemExit(f"{path} differs from the current input of the cases: record the reference again")
        path.write_bytes(content)


def stl(profile: np.ndarray, half_length: float = 85.0, corner_count: int = 24) -> bytes:
    """A profile (k, 2) of radius and height, swept around a segment along x, as binary STL."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, corner_count + 1)
    angle = np.concatenate([angle, angle + np.pi])
    centre = np.repeat([half_length, -half_length], corner_count + 1)
    radius, height = profile[:, 0, None], profile[:, 1, None] + 0.0 * angle
    ring = np.stack([centre + radius * np.cos(angle), radius * np.sin(angle), height], axis=2)
    a, b = ring, np.roll(ring, -1, axis=1)
    corners = np.stack([a[:-1], b[:-1], b[1:], a[:-1], b[1:], a[1:]], axis=2).reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    corners = corners[area > 1e-6].astype("<f4")
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets["corners"] = corners
    return bytes(80) + struct.pack("<I", len(facets)) + facets.tobytes()
