"""Judgement of a formed sheet by limits that its user sets: wrinkles, bridging, locking, gap, self-contact.

A shear angle alone predicts no wrinkle: what counts is how far the sheet deviates, where its yarns are pushed together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import Field, field_validator

from ...checks import NotNegative, Parameters, Positive
from ...ranges import Quantity
from ..angles import yarn_vectors
from ..findings import FormedSheet
from .regions import regions, with_neighbours
from .touching import distance_to_others
from .waves import LONGEST_WAVELENGTH, WRINKLE_COMPRESSION, waves

# (points (k, 3) [m]) -> distance to the nearest of the tools (k,) [m], negative inside.
Distance = Callable[[np.ndarray], np.ndarray]


class Limits(Parameters):
    """What is still good. A limit that is left out is not looked at; ``locking_angle`` is then the fabric's own."""

    wrinkle_amplitude: Annotated[Positive, Quantity("gap")] | None = Field(
        default=1.0e-3, description="amplitude of a wave, half its height from trough to crest [m]"
    )
    wrinkle_compression: Annotated[NotNegative, Quantity("strain")] = Field(
        default=WRINKLE_COMPRESSION, description="shortening of a yarn from which a wave is a wrinkle"
    )
    longest_wavelength: Annotated[Positive, Quantity("length")] = Field(
        default=LONGEST_WAVELENGTH, description="waves longer than this are the shape of the part [m]"
    )
    bridging_gap: Annotated[Positive, Quantity("gap")] | None = Field(
        default=0.5e-3, description="gap to the nearest tool under taut yarns, where the tool is concave [m]"
    )
    bridging_tension: Annotated[NotNegative, Quantity("yarn tension")] = Field(
        default=10.0, description="force per width from which a yarn is taut [N/m]"
    )
    locking_angle: Annotated[Positive, Quantity("angle")] | None = Field(
        default=None,
        description="largest shear angle [degrees]; by default that of the fabric's shear law, if it locks",
    )
    gap: Annotated[Positive, Quantity("gap")] | None = Field(
        default=None, description="largest gap to the nearest tool, anywhere [m]; not looked at by default"
    )
    self_contact_gap: Annotated[Positive, Quantity("gap")] | None = Field(
        default=1.0e-4, description="gap up to which parts of a sheet lie on each other, as in a fold [m]"
    )
    least_area: Annotated[NotNegative, Quantity("gap")] = Field(
        default=0.0, description="side of a square; smaller regions are left out [m]"
    )

    @field_validator("locking_angle")
    @classmethod
    def _is_in_degrees(cls, value: float | None) -> float | None:
        if value is not None and value <= 0.5 * math.pi:
            raise ValueError(f"more than 1.6 degrees is needed: write {math.degrees(value):.4g} for {value:g} rad")
        if value is not None and value > 90.0:
            raise ValueError("at most 90 degrees, where the yarns lie on each other, is allowed")
        return value


@dataclass(frozen=True)
class Region:
    """A connected part of a sheet beyond a limit.

    Attributes:
        kind: "wrinkle", "bridging", "locking", "gap" or "self-contact".
        elements: (k,).
        worst: of them, that farthest beyond the limit.
        area: current [m^2].
        place: centre of the worst element, formed (x, y, z) [m].
        flat_place: the same on the flat blank (x, y) [m].
        largest: amplitude or gap [m], or shear angle [degrees]; of self-contact the smallest gap, negative where the
            sheet passes through itself.
        severity: ``largest`` over its limit; of self-contact the distance at the limit over the smallest one.
        wavelength: of a wrinkle at its worst element [m].
        crest_count: crests of a wrinkle, at least half the limit high.
    """

    kind: str
    elements: np.ndarray
    worst: int
    area: float
    place: tuple[float, float, float]
    flat_place: tuple[float, float]
    largest: float
    severity: float
    wavelength: float | None = None
    crest_count: int | None = None

    def as_dict(self) -> dict[str, Any]:
        """For JSON and tables, with units in the names."""
        unit = ("shear_angle_deg", 1.0) if self.kind == "locking" else ("gap_mm", 1.0e3)
        name, factor = ("amplitude_mm", 1.0e3) if self.kind == "wrinkle" else unit
        out: dict[str, Any] = {
            "kind": self.kind,
            "place_mm": [1.0e3 * x for x in self.place],
            "flat_place_mm": [1.0e3 * x for x in self.flat_place],
            "area_mm2": 1.0e6 * self.area,
            name: factor * self.largest,
            "severity": self.severity,
            "element_count": len(self.elements),
        }
        if self.wavelength is not None:
            out |= {"wavelength_mm": 1.0e3 * self.wavelength, "crest_count": self.crest_count}
        return out


@dataclass(frozen=True, eq=False)
class Judgement:
    """A formed sheet, and what is beyond its limits.

    Attributes:
        sheet: formed.
        limits: that it has to keep.
        distance: to its tools; None for a sheet without tools.
        own_locking_angle: of the fabric's shear law [degrees]; None if it does not lock.
    """

    sheet: FormedSheet
    limits: Limits
    distance: Distance | None = None
    own_locking_angle: float | None = None

    @cached_property
    def fields(self) -> dict[str, np.ndarray]:
        """Per element: gap [m], amplitude and wavelength [m], compression, tension [N/m], curvature [1/m], angle.

        ``self_contact_gap`` [m] is infinite where nothing is near.
        """
        sheet, given = self.sheet, self.sheet.fields
        wave = waves(sheet.blank, sheet.position, self.limits.longest_wavelength, self._nodal_gap)
        out = {
            "wrinkle_amplitude": wave.amplitude,
            "wrinkle_wavelength": wave.wavelength,
            "deviation": wave.deviation[sheet.blank.quads].mean(axis=1),
            "yarn_compression": np.maximum(1.0 - np.minimum(given["warp_stretch"], given["weft_stretch"]), 0.0),
            "yarn_tension": np.maximum(given["warp_force"], given["weft_force"]),
            "shear_angle_deg": sheet.shear_angle_deg,
        }
        if (reach := self.limits.self_contact_gap) is not None:
            flat, thickness = sheet.blank.material_coordinates, sheet.thickness
            apart = distance_to_others(sheet.position, flat, sheet.blank.quads, thickness, thickness + reach)
            out["self_contact_gap"] = apart - thickness
        if self.distance is not None:
            middle, out["tool_curvature"] = self._tool_height()
            out["gap"] = middle - self.sheet.half_thickness
        return out

    @cached_property
    def _nodal_gap(self) -> np.ndarray | None:
        return None if self.distance is None else self.distance(self.sheet.position) - 0.5 * self.sheet.thickness

    def _tool_height(self) -> tuple[np.ndarray, np.ndarray]:
        """Distance at the centres [m], and its smallest curvature along the yarns [1/m], negative over a hollow.

        A difference over half an element, or over the distance itself if that is more: the distance to a convex tool
        curves upwards whatever the step, and that into a groove downwards only over the width of the groove.
        """
        assert self.distance is not None
        corner = self.sheet.position[self.sheet.blank.quads]
        centre, diagonal = corner.mean(axis=1), np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        middle = self.distance(centre)
        step = np.maximum(0.5 * np.sqrt(0.5 * np.linalg.norm(diagonal, axis=1)), middle)[:, None]
        warp, weft = (step * yarn for yarn in yarn_vectors(self.sheet.blank, self.sheet.position))
        # one call: a mesh is sampled anew in each
        beside = np.split(self.distance(np.concatenate([centre + v for v in (warp, -warp, weft, -weft)])), 4)
        along = [(a + b - 2.0 * middle) / step[:, 0] ** 2 for a, b in (beside[:2], beside[2:])]
        return middle, np.minimum(*along)

    @property
    def locking_angle(self) -> float | None:
        """The limit of the shear angle [degrees]."""
        return self.own_locking_angle if self.limits.locking_angle is None else self.limits.locking_angle

    def _beyond(self) -> Iterator[tuple[str, np.ndarray, float, np.ndarray]]:
        """Kind, value per element, its limit, and which elements count."""
        fields, limits = self.fields, self.limits
        every = np.ones(self.sheet.blank.element_count, dtype=bool)
        if limits.wrinkle_amplitude is not None:
            # a crease is an element or two wide: the yarns beside it count too
            counts = with_neighbours(self.sheet.blank.quads, fields["yarn_compression"] > limits.wrinkle_compression)
            yield "wrinkle", fields["wrinkle_amplitude"], limits.wrinkle_amplitude, counts
        if "gap" in fields and limits.bridging_gap is not None:
            counts = fields["yarn_tension"] > limits.bridging_tension
            yield "bridging", fields["gap"], limits.bridging_gap, counts
        if self.locking_angle is not None:
            yield "locking", fields["shear_angle_deg"], self.locking_angle, every
        if "gap" in fields and limits.gap is not None:
            yield "gap", fields["gap"], limits.gap, every
        if (most := limits.self_contact_gap) is not None:
            closeness = 1.0 / np.maximum(
                fields["self_contact_gap"] + self.sheet.thickness, 1.0e-3 * self.sheet.thickness
            )
            # a hair more: what is at the limit counts
            yield "self-contact", closeness, (1.0 - 1.0e-9) / (most + self.sheet.thickness), every

    def _of_wrinkle(self, elements: np.ndarray, worst: int, limit: float) -> tuple[float, int]:
        """Wavelength at the worst element [m], and number of crests."""
        high = np.zeros(self.sheet.blank.element_count, dtype=bool)
        high[elements] = self.fields["deviation"][elements] > 0.5 * limit
        return float(self.fields["wrinkle_wavelength"][worst]), len(regions(self.sheet.blank.quads, high))

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """All regions beyond a limit, the most severe first."""
        sheet, found = self.sheet, []
        corner = sheet.position[sheet.blank.quads]
        area = 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1)
        flat = sheet.blank.material_coordinates[sheet.blank.quads].mean(axis=1)
        for kind, value, limit, counts in self._beyond():
            for elements in regions(sheet.blank.quads, counts & (value > limit)):
                if area[elements].sum() < self.limits.least_area**2:
                    continue
                if kind == "bridging" and not (self.fields["tool_curvature"][elements] < 0.0).any():
                    continue
                worst = elements[int(np.argmax(value[elements]))]
                x, y, z = corner[worst].mean(axis=0).tolist()
                u, v = flat[worst].tolist()
                wavelength, crests = self._of_wrinkle(elements, worst, limit) if kind == "wrinkle" else (None, None)
                largest = self.fields["self_contact_gap"] if kind == "self-contact" else value
                found.append(
                    Region(kind, elements, int(worst), float(area[elements].sum()), (x, y, z), (u, v),
                           float(largest[worst]), float(value[worst] / limit), wavelength, crests)
                )  # fmt: skip
        return tuple(sorted(found, key=lambda region: -region.severity))
