"""Results of a formed sheet: each number once, with its name, unit and meaning.

Summary, tables, pictures and report read the same ``FormedSheet`` and the same ``SHEET_FINDINGS``. To add a number, add
a ``Finding`` to that tuple: it then appears in summary.json and in the report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..notebook import shown, table
from ..sheet.symmetry import AXES, WHOLE, Symmetry
from .angles import shear_angle_at
from .border import Outline, border_draw_in, draw_in, integrated_yarn_stretch, outline
from .defects.contact import half_thickness
from .proximity import close_pairs
from .units import DEGREES, MILLIMETRES, PURE, Unit, split_unit
from .zigzag import Checkerboard, checkerboard

if TYPE_CHECKING:
    from ..sheet.blank import Blank

# Yarns within this angle of a symmetry line count as parallel to it [degrees].
LARGEST_MISALIGNMENT = 1.0
# Of the area: what is beyond is a few elements.
_USUAL_SHARE = 0.99


@dataclass(frozen=True)
class Finding:
    """One number of a result.

    Attributes:
        name: without its unit.
        unit: of the number.
        description: for readers.
        compute: returns the number for a subject, in its unit; None where it has no meaning.
    """

    name: str
    unit: Unit
    description: str
    compute: Callable[[Any], Any]

    @property
    def key(self) -> str:
        """Name in summary.json, including the unit."""
        return self.unit.named(self.name)


class Numbers(dict[str, Any]):
    """Numbers of a result by key, which notebooks show as a table with their units."""

    def _repr_html_(self) -> str:
        rows = []
        for key, value in self.items():
            name, unit = split_unit(key)
            rows.append((name, shown(value), unit.symbol))
        return table("Numbers", rows)


def found(
    findings: tuple[Finding, ...], subject: Any, failed: Callable[[str, Exception], object] | None = None
) -> Numbers:
    """Numbers of ``subject`` by key, without those that have no meaning for it.

    Args:
        findings: to compute.
        subject: of which.
        failed: called with the key and the exception of a finding that fails, which then is left out; without it the
            exception is raised.
    """
    values = Numbers()
    for finding in findings:
        try:
            values[finding.key] = finding.compute(subject)
        except Exception as error:
            if failed is None:
                raise
            failed(finding.key, error)
    return Numbers({key: value for key, value in values.items() if value is not None})


@dataclass(frozen=True, eq=False)
class FormedSheet:
    """A sheet at one instant. Its measures are computed on first use, once.

    Attributes:
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        fields: one value per element by name, (element_count,), in SI units.
        thickness: initial thickness [m].
        symmetry: planes at which it is cut.
        points: material points at which the shear angle is of interest, (k, 2) [m]; None for none.
        has_draw_in: whether draw-in of the border is meaningful.
        follows_thickness: whether it meets tools at its current thickness instead of its initial one.
    """

    blank: Blank
    position: np.ndarray
    fields: Mapping[str, np.ndarray]
    thickness: float
    symmetry: Symmetry = WHOLE
    points: np.ndarray | None = None
    has_draw_in: bool = True
    follows_thickness: bool = False

    @cached_property
    def half_thickness(self) -> np.ndarray:
        """At which it meets tools, (element_count,) [m]."""
        current = np.broadcast_to(self.fields.get("thickness", self.thickness), self.blank.element_count)
        return half_thickness(self.thickness, current, self.follows_thickness)

    @cached_property
    def shear_angle_deg(self) -> np.ndarray:
        """Absolute shear angle of each element, (element_count,) [degrees]."""
        return np.abs(np.rad2deg(self.fields["shear_angle"]))

    @cached_property
    def usual_shear_angle_deg(self) -> float:
        """Absolute shear angle that 99 % of the area of the flat blank do not exceed [degrees]."""
        corner = self.blank.material_coordinates[self.blank.quads]
        (a, b), (c, d) = ((corner[:, k + 2] - corner[:, k]).T for k in (0, 1))
        area = 0.5 * np.abs(a * d - b * c)
        order = np.argsort(self.shear_angle_deg)
        share = np.cumsum(area[order]) / area.sum()
        return float(self.shear_angle_deg[order][np.searchsorted(share, _USUAL_SHARE)])

    @cached_property
    def point_angles_deg(self) -> np.ndarray:
        """``shear_angle_at`` at the points, (k,) [degrees]; empty without points."""
        if self.points is None:
            return np.zeros(0)
        return shear_angle_at(self.blank, self.fields["shear_angle"], self.points, self.symmetry)

    @cached_property
    def checkerboard(self) -> Checkerboard:
        """Zig-zag part of the shear angle."""
        return checkerboard(self.blank, self.fields["shear_angle"])

    @cached_property
    def border(self) -> Outline:
        """Free border of the computed part."""
        return outline(self.blank, self.symmetry)

    @cached_property
    def border_draw_in_mm(self) -> np.ndarray:
        """``border_draw_in`` of each node of the border, (k,) [mm]."""
        return 1.0e3 * border_draw_in(self.blank, self.position, self.border)

    @cached_property
    def draw_in_mm(self) -> dict[str, float]:
        """``draw_in`` along "x" and "y" [mm], for the lines that the blank crosses."""
        return self._along_lines(lambda along: 1.0e3 * draw_in(self.blank, self.position, along))

    @cached_property
    def yarn_stretch_mm(self) -> dict[str, float]:
        """``integrated_yarn_stretch`` along "x" and "y" [mm], of the yarns parallel to these lines."""
        return self._along_lines(self._yarn_stretch_along)

    @cached_property
    def meets_both_lines(self) -> bool:
        """Whether the flat blank reaches both axes."""
        lower, upper = (f(self.blank.material_coordinates, axis=0) for f in (np.min, np.max))
        return bool(np.all(lower <= 0.0) and np.all(upper >= 0.0))

    @cached_property
    def stretch(self) -> np.ndarray:
        """Stretch of both yarn families of each element, (2 element_count,)."""
        return np.concatenate([self.fields["warp_stretch"], self.fields["weft_stretch"]])

    def _along_lines(self, measure: Callable[[str], float | None]) -> dict[str, float]:
        values: dict[str, float] = {}
        for along in AXES if self.has_draw_in else ():
            try:
                value = measure(along)
            except InputError:  # the blank need not lie over the origin
                continue
            if value is not None:
                values[along] = value
        return values

    def _yarn_stretch_along(self, along: str) -> float | None:
        value = None
        for family in ("warp", "weft"):
            component = np.abs(getattr(self.blank, f"{family}_direction")[:, AXES[along]])
            if component.min() > np.cos(np.deg2rad(LARGEST_MISALIGNMENT)):
                value = 1.0e3 * integrated_yarn_stretch(self.blank, self.fields[f"{family}_stretch"], along)
        return value


def _extreme(
    name: str, which: Callable[[np.ndarray], Any], factor: float | None = None
) -> Callable[[FormedSheet], Any]:
    """Smallest or largest value of an optional field."""

    def compute(sheet: FormedSheet) -> float | None:
        if name not in sheet.fields:
            return None
        value = float(which(sheet.fields[name]))
        return value if factor is None else factor * value

    return compute


SHEET_FINDINGS = (
    Finding("max_shear_angle", DEGREES, "largest shear angle", lambda sheet: float(sheet.shear_angle_deg.max())),
    Finding("min_stretch", PURE, "smallest yarn stretch", lambda sheet: float(sheet.stretch.min())),
    Finding("max_stretch", PURE, "largest yarn stretch", lambda sheet: float(sheet.stretch.max())),
    Finding(
        "checkerboard_rms", DEGREES, "zig-zag part of the shear angle, root mean square",
        lambda sheet: sheet.checkerboard.rms,
    ),
    Finding(
        "checkerboard_max", DEGREES, "zig-zag part of the shear angle, largest",
        lambda sheet: sheet.checkerboard.maximum,
    ),
    Finding(
        "close_pair_count", PURE, "pairs of a node and an element closer than half the thickness",
        lambda sheet: close_pairs(sheet.position, sheet.blank.quads, 0.5 * sheet.thickness),
    ),
    Finding(
        "shear_angle_points", DEGREES, "shear angles at the material points",
        lambda sheet: None if sheet.points is None else sheet.point_angles_deg.tolist(),
    ),
    Finding("min_thickness", MILLIMETRES, "smallest thickness", _extreme("thickness", np.min, 1.0e3)),
    Finding("max_thickness", MILLIMETRES, "largest thickness", _extreme("thickness", np.max, 1.0e3)),
    Finding(
        "min_fibre_volume_fraction", PURE, "smallest fibre volume fraction", _extreme("fibre_volume_fraction", np.min)
    ),
    Finding(
        "max_fibre_volume_fraction", PURE, "largest fibre volume fraction", _extreme("fibre_volume_fraction", np.max)
    ),
    Finding("draw_in_long_axis", MILLIMETRES, "draw-in, long axis", lambda sheet: sheet.draw_in_mm.get("x")),
    Finding(
        "integrated_yarn_stretch_long_axis", MILLIMETRES, "elongation of the yarns along the long axis",
        lambda sheet: sheet.yarn_stretch_mm.get("x"),
    ),
    Finding("draw_in_short_axis", MILLIMETRES, "draw-in, short axis", lambda sheet: sheet.draw_in_mm.get("y")),
    Finding(
        "integrated_yarn_stretch_short_axis", MILLIMETRES, "elongation of the yarns along the short axis",
        lambda sheet: sheet.yarn_stretch_mm.get("y"),
    ),
)  # fmt: skip
