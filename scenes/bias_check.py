"""Check of a calibrated fabric: its bias extension simulated, beside closed form and measurement."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from weavesim.fabric.fabric import Fabric

from .bias_extension import SMALLEST_ELEMENT_COUNT, BiasExtensionParameters, bias_extension, record

if TYPE_CHECKING:
    from weavesim.calibration import Calibration

FRAME_COUNT = 24


def check_bias_extension(
    fabric: Fabric, calibration: Calibration, mesh_count: int = SMALLEST_ELEMENT_COUNT
) -> dict[str, Any]:
    """Simulate the strip of a calibration's bias extension up to the largest angle that was fitted.

    Args:
        fabric: to simulate.
        calibration: with a bias extension.
        mesh_count: elements across the width.

    Returns:
        Curves by name, (frame_count + 1,) each, and their root mean square differences over the largest force.
    """
    from weavesim.run.simulation import Simulation

    options, part = calibration.options, calibration.shear
    assert part is not None and options.bias_length is not None and options.bias_width is not None
    largest = max(float(test.x.max()) for test in part.strips)
    parameters = BiasExtensionParameters(
        length=options.bias_length, width=options.bias_width, largest_angle=math.degrees(largest),
        mesh_size=options.bias_width / mesh_count, frame_count=FRAME_COUNT,
    )  # fmt: skip
    setup = bias_extension(parameters, fabric)
    curves = record(parameters, fabric, setup.sheet.blank)
    Simulation(setup).run([curves])
    c = curves.columns
    force = 0.5 * (c["force_n"] + c["fixed_clamp_force_n"])
    angle = c["kinematic_angle_deg"]
    measured = np.mean(
        [np.interp(np.radians(angle), *_rising(*test.loading), right=np.nan) for test in part.strips], axis=0
    )
    size = float(np.abs(c["closed_form_force_n"]).max())
    known = np.isfinite(measured)

    def distance(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.sqrt(np.mean((a - b) ** 2))) / size

    return {
        "mesh_size_mm": 1.0e3 * parameters.mesh_size,
        "simulation_from_closed_form": distance(force, c["closed_form_force_n"]),
        "simulation_from_measurement": distance(force[known], measured[known]),
        "zone_c_angle_deg": float(c["zone_c_angle_deg"][-1]),
        "kinematic_angle_deg": float(angle[-1]),
        "curves": {
            "kinematic_angle_deg": angle, "force_n": force, "closed_form_force_n": c["closed_form_force_n"],
            "measured_force_n": measured, "zone_c_angle_deg": c["zone_c_angle_deg"],
        },
    }  # fmt: skip


def _rising(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    order = np.argsort(x, kind="stable")
    return x[order], y[order]
