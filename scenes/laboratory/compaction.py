"""Compaction: how thick the fabric is under pressure between its yarns.

The sheet has no degree of freedom across its thickness. What flattens it is the pressure between warp and weft, which
plates cause from outside and tension from inside: here both families are pulled alike, until that pressure is reached.
Pulled yarns also widen the sheet; without that share the thickness is the one between plates.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from weavesim.checks import Positive
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.fabric import Fabric
from weavesim.output.curves import Chart, Curves
from weavesim.output.measured import Comparable, measured_differences
from weavesim.output.results import Wanted
from weavesim.ranges import Quantity
from weavesim.run.frame import Frame

from ..fabric_test import chosen_fabric, of_curves
from ..scene import Scene
from .biaxial import PulledSquareParameters, pulled_square

LARGEST_STRAIN = 0.1


class CompactionParameters(PulledSquareParameters):
    """Parameters of a compaction."""

    out: Path = Field(default=Path("out/compaction"), description="folder for the results")
    largest_pressure: Annotated[Positive, Quantity("pressure")] = Field(
        default=1.0e5, description="between the yarns, per area of the sheet [Pa]"
    )

    abscissas = (Comparable("pressure", "kPa", "pressure_kpa"),)
    ordinates = (
        Comparable("thickness", "mm", "plates_thickness_mm"),
        Comparable("fibre volume fraction", "%", "plates_fibre_volume_percent"),
    )


def pressure_at(fabric: Fabric, strain: np.ndarray) -> np.ndarray:
    """Pressure between the yarns (n,) [Pa] at equal strains (n,) of both families."""
    from weavesim.fabric.response import respond

    stretch = 1.0 + np.asarray(strain, dtype=float)
    force = respond(fabric.unit_cell, np.stack([stretch, stretch], axis=1)).crossover_force
    return force / fabric.unit_cell.crossover_area


def strain_at(fabric: Fabric, pressure: float) -> float:
    """Equal strain of both families at which the yarns press on each other with this pressure [Pa], by bisection.

    Raises:
        InputError: a cell that reports no pressure, or strains up to 10 % that do not give it.
    """
    if not fabric.unit_cell.has_crossovers or not np.isfinite(fabric.compaction.modulus(fabric.unit_cell)):
        raise InputError(
            f"compaction: {fabric.name!r} has no crossovers that flatten under pressure; take a cell with crossovers, "
            "or give compaction.crossover_modulus [Pa]"
        )

    reached = float(pressure_at(fabric, np.array([LARGEST_STRAIN]))[0])
    if reached < pressure:
        raise InputError(
            f"largest_pressure = {pressure:.4g} Pa: a strain of {LARGEST_STRAIN:.0%} in both families gives only "
            f"{reached:.4g} Pa; reduce it"
        )
    low, high = 0.0, LARGEST_STRAIN
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if pressure_at(fabric, np.array([middle]))[0] < pressure else (low, middle)
    return 0.5 * (low + high)


def compaction(parameters: CompactionParameters, fabric: Fabric | None = None) -> Setup:
    """The test; ``fabric`` replaces the preset and shear law in the parameters."""
    fabric = fabric or chosen_fabric(parameters)
    strain = strain_at(fabric, parameters.largest_pressure)
    return pulled_square("compaction", parameters, fabric, (strain, strain))


def record(fabric: Fabric, parameters: CompactionParameters) -> Curves:
    """Pressure, thickness and fibre content of every frame, with the law at the unit cell's own pressure."""
    law = fabric.compaction
    path = np.linspace(0.0, strain_at(fabric, parameters.largest_pressure), 101)
    pressures = pressure_at(fabric, path)

    def measure(state: Frame) -> dict[str, float]:
        pressure = float(state.fields["crossover_pressure"].mean())
        thickness = float(state.fields["thickness"].mean())
        area = float(state.fields["area_ratio"].mean())
        between_plates = thickness * area**law.thickening
        cell_pressure = float(np.interp(state.stroke / parameters.side, path, pressures))
        known = fabric.thickness / (1.0 + cell_pressure / law.modulus(fabric.unit_cell))
        fraction = law.fibre_volume_fraction(np.array([between_plates]), np.ones(1))
        share = float(fraction[0]) if fraction is not None else float("nan")
        return {
            "time_s": state.time,
            "pressure_kpa": 1.0e-3 * pressure,
            "thickness_mm": 1.0e3 * thickness,
            "plates_thickness_mm": 1.0e3 * between_plates,
            "closed_form_thickness_mm": 1.0e3 * known,
            "plates_fibre_volume_percent": 100.0 * share,
            "area_ratio": area,
        }

    return Curves("compaction", measure, [
        Chart(
            "thickness", "Thickness under pressure",
            "Of the pulled sheet, which is also wider, and as between plates; the law is t0 / (1 + p / E_c).",
            ("pressure_kpa", "pressure between the yarns [kPa]"), "thickness [mm]",
            {"plates_thickness_mm": "between plates", "thickness_mm": "pulled sheet"},
            {"closed_form_thickness_mm": "law of compaction"},
        ),
        Chart(
            "fibre_volume", "Fibre content under pressure", "Between plates; empty where the fabric gives no fibres.",
            ("pressure_kpa", "pressure between the yarns [kPa]"), "fibre volume fraction [%]",
            {"plates_fibre_volume_percent": "between plates"}, {},
        ),
    ], parameters.measured_curves())  # fmt: skip


def findings(curves: Curves) -> dict[str, Any]:
    """Summary entries at the last frame, and the largest deviation from the law."""
    c = curves.columns
    return {
        "pressure_pa": 1.0e3 * float(c["pressure_kpa"][-1]),
        "thickness_mm": float(c["thickness_mm"][-1]),
        "plates_thickness_mm": float(c["plates_thickness_mm"][-1]),
        "closed_form_thickness_mm": float(c["closed_form_thickness_mm"][-1]),
        "largest_thickness_error_ratio": float(
            np.abs(c["plates_thickness_mm"] / c["closed_form_thickness_mm"] - 1.0).max()
        ),
        **measured_differences(curves),
    }


def wanted(parameters: CompactionParameters, setup: Setup) -> Wanted:
    """Curves of thickness; no draw-in, since the border moves with the clamps."""
    return Wanted(curves=record(setup.sheet.fabric, parameters), draw_in=False)


SCENE = Scene(
    name="compaction",
    help="Press the yarns of a woven fabric on each other.",
    parameters=CompactionParameters,
    make=compaction,
    wanted=wanted,
    findings=of_curves(findings),
)
