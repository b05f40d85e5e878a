"""The plies of a job: blanks with their fabrics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import InputError
from ..fabric.fabric import Fabric
from ..fabric.file import fabric_of_table, load_fabric, resolve_fabric
from ..sheet.blank import Blank
from .placing import Box
from .read import JobFile
from .schema import PlyTable

# Corners of a polygon that stands for a disc.
DISC_CORNERS = 360


def fabric_of(file: JobFile, index: int) -> Fabric:
    """The fabric of a ply.

    Raises:
        InputError: there is none of this name, or it has mistakes.
    """
    name, keys = file.job.ply[index].fabric, ["ply", index, "fabric"]
    if name in file.job.fabric:
        return fabric_of_table(
            file.document, file.values["fabric"][name], ("fabric", name), accept_unusual=file.job.accept_unusual
        )
    if name.lower().endswith((".toml", ".json")):
        return load_fabric(file.file(name, keys), accept_unusual=file.job.accept_unusual)
    try:
        return resolve_fabric(name, accept_unusual=file.job.accept_unusual)
    except InputError as error:
        file.refuse(keys, error)


def outline_of(ply: PlyTable) -> np.ndarray:
    """Corners of the outline of a ply that is given by numbers, (k, 2) [m], turned and in its place."""
    if ply.rectangle is not None:
        x, y = 0.5 * np.array(ply.rectangle)
        corners = np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    elif ply.disc is not None:
        angle = np.linspace(0.0, 2.0 * math.pi, DISC_CORNERS, endpoint=False)
        corners = 0.5 * ply.disc * np.column_stack([np.cos(angle), np.sin(angle)])
    else:
        corners = np.array(ply.polygon)
    return placed(corners, ply)


def box_of(file: JobFile, index: int) -> Box:
    """The box around the outline of a ply, in plan."""
    corners = outline_of(file.job.ply[index])
    return Box(corners.min(axis=0), corners.max(axis=0))


def placed(points: np.ndarray, ply: PlyTable) -> np.ndarray:
    """Points (n, 2) of an outline, turned and shifted as its ply says."""
    cosine, sine = math.cos(math.radians(ply.turn)), math.sin(math.radians(ply.turn))
    if ply.turn:
        points = points @ np.array([[cosine, sine], [-sine, cosine]])
    return points + np.array(ply.centre)


def blank_of(file: JobFile, index: int, height: float) -> Blank:
    """The mesh of a ply.

    Args:
        file: the job.
        index: of the ply.
        height: of its middle [m].

    Raises:
        InputError: an outline that cannot be meshed.
    """
    ply = file.job.ply[index]
    try:
        return _blank(file, index, ply, height)
    except InputError as error:
        text = str(error)
        if text.startswith(("job ", "--set")):
            raise
        given = next(name for name in ("rectangle", "disc", "polygon", "outline") if getattr(ply, name) is not None)
        file.refuse(["ply", index, given], error)


def _blank(file: JobFile, index: int, ply: PlyTable, height: float) -> Blank:
    angles: dict[str, Any] = {"yarn_angle": ply.angle, "height": height}
    corners = outline_of(ply)
    straight = ply.rectangle is not None and ply.turn % 90.0 == 0.0
    if straight and (ply.mesh_along == "outline" or ply.angle % 90.0 == 0.0):
        lower, upper = corners.min(axis=0), corners.max(axis=0)
        return Blank.rectangle(
            (float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1])), ply.mesh_size, **angles
        )
    side = np.roll(corners, -1, axis=0) - corners
    longest = side[int(np.argmax(np.linalg.norm(side, axis=1)))]
    along = math.degrees(math.atan2(longest[1], longest[0])) if ply.mesh_along == "outline" else ply.angle
    return Blank.fitted(corners, ply.mesh_size, mesh_angle=along, **angles)
