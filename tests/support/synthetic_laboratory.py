"""A laboratory whose fabrics are known: random fabrics, and their tests with noise as tables.

Every specimen differs from the fabric by a factor of its own, and every point by noise of its own.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from weavesim.calibration.readings import bias_factors
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.proportions import GRAVITY
from weavesim.fabric.response import respond
from weavesim.fabric.shear import MomentCurve, ShearFriction

RATIOS = ((1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (1.0, -0.4))
FRAME_SIDE, FABRIC_SIDE = 0.25, 0.2
BIAS_LENGTH, BIAS_WIDTH = 0.3, 0.1
LARGEST_ANGLE = 45.0


@dataclass(frozen=True)
class Laboratory:
    """How a laboratory tests: relative noise of points and of specimens, and how many of each."""

    noise: float = 0.01
    specimen: float = 0.02
    repeat_count: int = 4
    point_count: int = 60
    seed: int = 0

    def measured(self, values: np.ndarray, rng: np.random.Generator) -> list[np.ndarray]:
        """What is measured of true values (n,) or (n, 2), for every specimen."""
        size = float(np.abs(values).max())
        return [
            (1.0 + self.specimen * rng.standard_normal()) * values
            + self.noise * size * rng.standard_normal(values.shape)
            for _ in range(self.repeat_count)
        ]


def random_fabric(seed: int) -> Fabric:
    """A plain weave like glass/polypropylene, every property of which is multiplied by a factor of its own."""
    rng = np.random.default_rng(seed)

    def factor(reach: float) -> float:
        return float(np.exp(rng.uniform(-math.log(reach), math.log(reach))))

    base = glass_polypropylene()
    cell = PlainWeave.glass_polypropylene()
    modulus, height = cell.warp_modulus * factor(1.5), cell.crossover_height * factor(1.3)
    bending = cell.warp_modulus * cell.warp_second_moment * factor(1.5)
    cell = cell.model_copy(
        update={
            "warp_modulus": modulus, "weft_modulus": modulus, "crossover_height": height,
            "warp_second_moment": bending / modulus, "weft_second_moment": bending / modulus,
            "contact_modulus": cell.contact_modulus * factor(2.0),
        }
    )  # fmt: skip
    angle = np.radians(np.linspace(0.0, LARGEST_ANGLE + 5.0, 26))
    # slow at first, faster towards locking
    moment = 30.0 * factor(1.5) * angle + 60.0 * factor(2.0) * angle**2 + 250.0 * factor(2.0) * angle**5
    friction = ShearFriction(stiffness=(limit := 8.0 * factor(1.5)) / math.radians(1.0 * factor(1.5)), limit=(limit,))
    stiffness = base.bending.strip_stiffness("warp", base.thickness) * factor(3.0)
    return base.model_copy(
        update={
            "name": f"random fabric {seed}", "unit_cell": cell, "shear_friction": friction,
            "shear": MomentCurve(angle=tuple(angle.tolist()), moment_values=tuple(moment.tolist())),
            "bending": IsotropicBending(modulus=12.0 * stiffness / base.thickness**3),
            "provenance": (), "assumed": (), "source": "random numbers",
        }
    )  # fmt: skip


def given_fabric(true: Fabric, seed: int) -> Fabric:
    """What is known before the tests: the true fabric, with values that are off by up to a half; E I is known."""
    rng = np.random.default_rng(10_000 + seed)
    cell = true.unit_cell
    assert isinstance(cell, PlainWeave)
    off = np.exp(rng.uniform(-0.4, 0.4, 3))
    modulus = cell.warp_modulus * float(off[0])
    second_moment = cell.bending_stiffness[0] / modulus
    changed = cell.model_copy(
        update={
            "warp_modulus": modulus, "weft_modulus": modulus, "warp_second_moment": second_moment,
            "weft_second_moment": second_moment, "crossover_height": cell.crossover_height * float(off[1]),
            "contact_modulus": cell.contact_modulus * float(off[2]),
        }
    )  # fmt: skip
    return glass_polypropylene().model_copy(update={"unit_cell": changed, "provenance": ()})


def write_columns(path: Path, columns: dict[str, np.ndarray], separator: str = ",") -> Path:
    """A table with these columns."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, delimiter=separator, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([f"{value:.8g}" for value in row] for row in zip(*columns.values(), strict=True))
    return path


def loop(largest: float, count: int) -> np.ndarray:
    """Angles of a loading and an unloading [rad], (2 count - 1,), closer at the turns."""
    up = np.radians(largest) * np.concatenate([np.linspace(0.0, 0.08, count // 4, endpoint=False),
                                               np.linspace(0.08, 1.0, count - count // 4)])  # fmt: skip
    return np.concatenate([up, up[-1] - up[1:]])


def moment(fabric: Fabric, path: np.ndarray) -> np.ndarray:
    """Shear moment along a path [N/m]."""
    friction = fabric.shear_friction.moment_along(path) if fabric.shear_friction else 0.0
    return fabric.shear.moment(path, fabric.thickness) + friction


def picture_frame(fabric: Fabric, laboratory: Laboratory, folder: Path) -> Path:
    """Angles and machine forces of loops, specimens side by side."""
    rng = np.random.default_rng([laboratory.seed, 1])
    path = loop(LARGEST_ANGLE, laboratory.point_count)
    force = moment(fabric, path) * FABRIC_SIDE**2 / (FRAME_SIDE * np.sin(0.25 * math.pi - 0.5 * path))
    columns = {"angle [deg]": np.degrees(path)}
    columns |= {f"force {k + 1} [N]": y for k, y in enumerate(laboratory.measured(force, rng))}
    return write_columns(folder / "frame.csv", columns)


def bias_extension(fabric: Fabric, laboratory: Laboratory, folder: Path) -> Path:
    """Displacements and forces of strips, loading only."""
    rng = np.random.default_rng([laboratory.seed, 2])
    angle = np.radians(np.linspace(0.0, 35.0, laboratory.point_count))
    whole, half = bias_factors(angle, BIAS_LENGTH, BIAS_WIDTH)
    force = whole * moment(fabric, angle) + half * moment(fabric, 0.5 * angle)
    displacement = (BIAS_LENGTH - BIAS_WIDTH) * (math.sqrt(2.0) * np.cos(0.25 * math.pi - 0.5 * angle) - 1.0)
    columns = {"displacement [mm]": 1e3 * displacement}
    columns |= {f"force {k + 1} [N]": y for k, y in enumerate(laboratory.measured(force, rng))}
    return write_columns(folder / "bias.csv", columns)


def biaxial(
    fabric: Fabric, laboratory: Laboratory, folder: Path, ratios: Sequence[tuple[float, float]] = RATIOS,
    largest: float = 0.015,
) -> list[Path]:  # fmt: skip
    """Strains and forces, a table per ratio of strains."""
    paths = []
    for number, ratio in enumerate(ratios):
        rng = np.random.default_rng([laboratory.seed, 3, number])
        strain = np.linspace(0.0, largest, laboratory.point_count // 2)[:, None] * ratio
        force = respond(fabric.unit_cell, 1.0 + strain).force_per_width
        columns = {"warp strain [%]": 100.0 * strain[:, 0], "weft strain [%]": 100.0 * strain[:, 1]}
        for k, y in enumerate(laboratory.measured(force, rng)):
            columns |= {f"warp force {k + 1} [N/mm]": 1e-3 * y[:, 0], f"weft force {k + 1} [N/mm]": 1e-3 * y[:, 1]}
        paths.append(write_columns(folder / f"biaxial_{number}.csv", columns))
    return paths


def cantilever(fabric: Fabric, laboratory: Laboratory, folder: Path, count: int = 6) -> Path:
    """Overhangs at 41.5 degrees; the stiffness of the specimens scatters three times as much as other properties."""
    rng = np.random.default_rng([laboratory.seed, 4])
    weight = fabric.areal_density * GRAVITY
    stiffness = fabric.bending.strip_stiffness("warp", fabric.thickness)
    scattered = stiffness * (1.0 + 3.0 * laboratory.specimen * rng.standard_normal(count))
    return write_columns(folder / "cantilever.csv", {"overhang [mm]": 2e3 * (scattered / weight) ** (1.0 / 3.0)})
