"""Job files for tests, and a tray that is not ours: an open surface with fillets, in millimetres, as CAD exports it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

TRAY = """\
name = "tray"

[[ply]]
name = "ply"
fabric = "glass-polypropylene"
rectangle = ["200 mm", "160 mm"]
mesh_size = "10 mm"

[[tool]]
name = "die"
file = "die.stl"
unit = "mm"
faces = "up"

[[tool]]
name = "punch"
offset_of = "die"
gap = "1.2 mm"
start = "touching"
clearance = "1 mm"
stroke = "close"
speed = "1 m/s"

[[tool]]
name = "ring"
ring_of = "die"
force = "600 N"

[output]
frame_count = 10
"""


def changed(text: str, *changes: tuple[str, str], count: int = -1) -> str:
    """A job with other texts in it, which must be there; ``count`` of each, or all."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, count)
    return text


def section(half: float, fillet: float, entry: float, depth: float, draft: float, steps: int) -> np.ndarray:
    """Half of a tray's section from its middle to its rim: (k, 2) distances from the middle and heights.

    A flat bottom at -depth, a fillet, a wall with a draft [degrees], an entry radius, and the start of a rim at zero;
    ``half`` is where the straight wall meets the rim.
    """
    slope = np.radians(draft)
    turn = np.linspace(0.0, 0.5 * np.pi - slope, steps + 1)
    height = depth - fillet * (1.0 - np.cos(turn[-1])) - entry * (1.0 - np.cos(turn[-1]))
    out = half - entry * np.sin(turn[-1]) - height * np.tan(slope) - fillet * np.sin(turn[-1])
    lower = np.column_stack([out + fillet * np.sin(turn), -depth + fillet * (1.0 - np.cos(turn))])
    upper = np.column_stack([half - entry * np.sin(turn[::-1]), -entry * (1.0 - np.cos(turn[::-1]))])
    return np.concatenate([[[0.0, -depth]], lower, upper])


def tray_surface(
    length: float = 160.0, width: float = 120.0, depth: float = 25.0, fillet: float = 10.0, entry: float = 8.0,
    corner: float = 30.0, rim: float = 50.0, draft: float = 5.0, steps: int = 8,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """An open tray: vertices (n, 3) and triangles (m, 3), facing up; all lengths in millimetres.

    Rounded rectangles one inside the other, at the heights of ``section``.
    """
    profile = section(0.5 * width, fillet, entry, depth, draft, steps)[1:]
    inset = 0.5 * width - profile[:, 0]
    rings = [rounded_rectangle(0.5 * length - d, 0.5 * width - d, max(corner - d, 1.0), z, steps) for d, z in
             zip(inset, profile[:, 1], strict=True)]  # fmt: skip
    rings.append(rounded_rectangle(0.5 * length + rim, 0.5 * width + rim, corner + rim, 0.0, steps))
    count = len(rings[0])
    vertices = [np.array([[0.0, 0.0, -depth]]), *rings]
    faces = [[0, 1 + k, 1 + (k + 1) % count] for k in range(count)]
    for ring in range(len(rings) - 1):
        a, b = 1 + ring * count, 1 + (ring + 1) * count
        for k in range(count):
            n = (k + 1) % count
            faces += [[a + k, b + k, b + n], [a + k, b + n, a + n]]
    return np.concatenate(vertices), np.array(faces)


def rounded_rectangle(x: float, y: float, radius: float, height: float, steps: int) -> np.ndarray:
    """Corners of a rounded rectangle of half sides ``x`` and ``y``, counter-clockwise."""
    angle = np.linspace(0.0, 0.5 * np.pi, 2 * steps + 1)
    found = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        turn = angle + 0.5 * np.pi * quarter
        found.append(
            np.column_stack([
                sx * (x - radius) + radius * np.cos(turn), sy * (y - radius) + radius * np.sin(turn),
                np.full(len(turn), height),
            ])
        )  # fmt: skip
    return np.concatenate(found)


def write_stl(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Path:
    """A binary STL."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    record = np.zeros(len(faces), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    record["n"], record["v"] = normal, corners
    path.write_bytes(b"tray".ljust(80) + np.uint32(len(faces)).tobytes() + record.tobytes())
    return path


def write_tray(folder: Path, text: str = TRAY) -> Path:
    """A job with its die in a folder; returns the path of the job."""
    write_stl(folder / "die.stl", *tray_surface())
    path = folder / "tray.toml"
    path.write_text(text, encoding="utf-8")
    return path


def two_valleys(radius: float = 3.0, depth: float = 12.0) -> tuple[np.ndarray, np.ndarray]:
    """A die with two valleys and a ridge between them, and walls of 45 degrees, all in millimetres.

    A height over a grid: vertices (n, 3), triangles (m, 3). ``radius`` is that of the ridge and of the entries.
    """
    x, y = np.meshgrid(np.linspace(-90.0, 90.0, 181), np.linspace(-60.0, 60.0, 121), indexing="ij")
    tangent = radius * np.sqrt(0.5)
    across = np.abs(x)
    ridge = np.where(across < tangent, 2.0 * tangent - np.sqrt(np.maximum(radius**2 - across**2, 0.0)), across)

    def entry(inside: np.ndarray) -> np.ndarray:
        way = np.clip(inside + radius * np.tan(np.pi / 8), 0.0, tangent)
        return np.where(inside < radius - tangent, radius - np.sqrt(radius**2 - way**2), inside)

    z = -np.minimum.reduce([ridge, entry(70.0 - across), entry(40.0 - np.abs(y)), np.full(x.shape, depth)])
    vertices = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = index[:-1, :-1].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
