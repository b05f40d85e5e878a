"""How often stated intervals contain the true values of random fabrics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from weavesim.calibration import Calibration, Estimate, calibrate
from weavesim.fabric.fabric import Fabric

from .synthetic_laboratory import (
    BIAS_LENGTH,
    BIAS_WIDTH,
    FABRIC_SIDE,
    FRAME_SIDE,
    Laboratory,
    bias_extension,
    biaxial,
    cantilever,
    given_fabric,
    picture_frame,
    random_fabric,
)

KINDS = {"unit cell": "unit cell", "moment_at": "elastic moments", "friction": "friction", "slip": "friction",
    "bending": "bending"}  # fmt: skip


def true_value(fabric: Fabric, estimate: Estimate) -> float:
    """Of what was estimated."""
    cell, friction = fabric.unit_cell, fabric.shear_friction
    if estimate.name.startswith("moment_at_"):
        angle = math.radians(float(estimate.name.split("_")[2]))
        return float(fabric.shear.moment(np.array([angle]))[0])
    if estimate.name.startswith("friction_limit"):
        return friction.limit[0]
    return {
        "yarn_stiffness": lambda: cell.axial_stiffness[0],
        "yarn_bending": lambda: cell.bending_stiffness[0],
        "crossover_height": lambda: cell.crossover_height,
        "contact_stiffness": lambda: cell.contact_stiffness,
        "slip_angle": lambda: friction.limit[0] / friction.stiffness,
        "bending_stiffness": lambda: fabric.bending.strip_stiffness("warp", fabric.thickness),
    }[estimate.name]()


@dataclass
class Study:
    """Whether each interval contained the true value, by kind of value; and values that were held."""

    hits: dict[str, list[bool]] = field(default_factory=dict)
    held: dict[str, int] = field(default_factory=dict)
    bad_fits: int = 0

    @classmethod
    def run(cls, seeds: Iterable[int], folder: Path, laboratory: Laboratory | None = None) -> Study:
        """A fabric, its laboratory and its calibration for each seed."""
        study = cls()
        for seed in seeds:
            true = random_fabric(seed)
            study.add(true, calibrated(true, replace(laboratory or Laboratory(), seed=seed), folder))
        return study

    def add(self, true: Fabric, found: Calibration) -> None:
        for part, entries in found.estimates.items():
            for e in entries:
                if not e.has_interval:
                    self.held[e.name] = self.held.get(e.name, 0) + 1
                    continue
                kind = part if part == "unit cell" else next(k for n, k in KINDS.items() if e.name.startswith(n))
                self.hits.setdefault(kind, []).append(e.low <= true_value(true, e) <= e.high)
        self.bad_fits += sum("a bad fit" in warning for warning in found.warnings)

    @property
    def value_count(self) -> int:
        return sum(map(len, self.hits.values()))

    def coverage(self, kind: str | None = None) -> float:
        """Share of the intervals that contain the true value, of one kind or of all."""
        chosen = [hit for name, hits in self.hits.items() if kind in (None, name) for hit in hits]
        return float(np.mean(chosen))


def calibrated(true: Fabric, laboratory: Laboratory, folder: Path) -> Calibration:
    """All tests of a fabric, and the calibration with them."""
    given = folder / "given.json"
    given.write_text(given_fabric(true, laboratory.seed).to_json(), encoding="utf-8")
    return calibrate(
        given, biaxial=biaxial(true, laboratory, folder), picture_frame=picture_frame(true, laboratory, folder),
        bias_extension=bias_extension(true, laboratory, folder), cantilever=cantilever(true, laboratory, folder),
        frame_side=FRAME_SIDE, fabric_side=FABRIC_SIDE, bias_length=BIAS_LENGTH, bias_width=BIAS_WIDTH, starts=2,
    )  # fmt: skip
