"""What is said of a run: its numbers, and why they should not be trusted as they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..version import __version__

if TYPE_CHECKING:
    from .simulation import Simulation

# The balance of frames in which less than this share of the run's work is done is compared with that share.
LEAST_WORK = 1.0e-4
# Hourglass and kinetic over internal energy are judged from this share of the largest internal energy on.
LEAST_INTERNAL = 0.05


def summary(simulation: Simulation) -> dict[str, Any]:
    """Numbers of a run for summary.json; SI units unless the name says otherwise."""
    setup, model, frame, state = simulation.setup, simulation.model, simulation.frame, simulation.state
    element_count = sum(sheet.blank.element_count for sheet in setup.sheets)
    step_count = state.step_count
    return {
        "weavesim_version": __version__,
        "name": setup.name,
        "fabric": ", ".join(dict.fromkeys(sheet.fabric.name for sheet in setup.sheets)),
        "outcome": simulation.outcome.value if simulation.outcome else "not run",
        "device": str(model.device),
        "precision": model.precision.value,
        "threads": simulation.stepper.thread_count,
        "lane_count": model.lane_count,
        "element_count": element_count,
        "node_count": sum(sheet.blank.node_count for sheet in setup.sheets),
        "step_count": step_count,
        "time_step_s": state.time / max(step_count, 1),
        "time_s": state.time,
        "wall_time_s": simulation.wall_time,
        "stepping_time_s": simulation.stepping_time,
        "output_time_s": max(simulation.wall_time - simulation.stepping_time, 0.0),
        "element_steps_per_second": element_count * step_count / max(simulation.stepping_time, 1.0e-9),
        **_of_fields([sheet.fields for sheet in frame.sheets]),
        **_of_energies(simulation),
        "added_mass_ratio": max(sheet.added_mass_ratio for sheet in model.sheets),
        "support_force_n": {
            support.name: force.tolist() for support, force in zip(setup.supports, frame.support_force, strict=True)
        },
        "penetration_at_nodes_mm": 1e3 * simulation.penetration.at_nodes,
        "penetration_at_element_centres_mm": 1e3 * simulation.penetration.at_element_centres,
        "unit_cell_max_residual": max(float(sheet.fields["unit_cell_residual"].max()) for sheet in frame.sheets),
        "unit_cell_failures": sum(int(sheet.fields["unit_cell_failed"].sum()) for sheet in frame.sheets),
        "energies_j": dict(frame.energies),
        "notes": list(simulation.info.notes),
        "warnings": list(simulation.warnings),
    }


def _of_fields(sheets: list[dict[str, np.ndarray]]) -> dict[str, float]:
    stretch = np.concatenate([fields[name] for fields in sheets for name in ("warp_stretch", "weft_stretch")])
    angle = max(float(np.abs(fields["shear_angle"]).max()) for fields in sheets)
    return {
        "max_shear_angle_deg": float(np.degrees(angle)),
        "min_stretch": float(stretch.min()),
        "max_stretch": float(stretch.max()),
    }


def _of_energies(simulation: Simulation) -> dict[str, float]:
    """Ratios by which a quasi-static run is judged."""
    frame = simulation.frame
    history = simulation.history or [{"time": frame.time, "stroke": frame.stroke, **frame.energies}]
    supplied = max(np.abs([entry["supplied"] for entry in history]).max(), 1.0e-300)
    stroke = abs(frame.stroke)
    largest_internal = max(e["internal"] for e in history)
    stored = [e for e in history if e["internal"] > LEAST_INTERNAL * largest_internal]
    # of the stroke; where no tool has one, of the time
    last_quarter = [
        e for e in stored if (abs(e["stroke"]) >= 0.75 * stroke if stroke > 0.0 else e["time"] >= 0.75 * frame.time)
    ]
    return {
        "hourglass_energy_ratio": max((e["hourglass"] / e["internal"] for e in stored), default=0.0),
        "kinetic_energy_ratio": max((e["kinetic"] / e["internal"] for e in last_quarter), default=0.0),
        "damping_loss_ratio": frame.energies["damping_loss"] / supplied,
        "gravity_work_ratio": abs(frame.energies["gravity_work"]) / supplied,
        "energy_balance_error": max(
            abs(e["balance_error"]) / max(abs(e["supplied"]), e["used"], LEAST_WORK * supplied) for e in history
        ),
    }


def doubts(found: Mapping[str, Any], thickness: float) -> list[str]:
    """Why the result of a run should not be trusted as it is; empty if nothing speaks against it.

    Args:
        found: the ``summary``.
        thickness: of the thinnest sheet [m].
    """
    # what falls comes to rest by damping alone
    damping_limit = 0.05 if found["gravity_work_ratio"] < 0.5 else 1.0
    result = [
        f"{text} is {value:.3g}, above {limit:g}: {advice}"
        for text, value, limit, advice in (
            ("the error of the energy balance over the work", found["energy_balance_error"], 0.05, "energy is made or "
             "lost, do not use the result; a smaller time step or float64 tells more"),
            ("kinetic over internal energy in the last quarter", found["kinetic_energy_ratio"], 0.05,
             "the run is not quasi-static, slow the tools down"),
            ("hourglass over internal energy", found["hourglass_energy_ratio"], 0.05, "refine the mesh"),
            ("damping loss over supplied work", found["damping_loss_ratio"], damping_limit, "lower the damping"),
            ("the added mass over the blank's", found["added_mass_ratio"], 0.05, "it changes the dynamics"),
            ("the deepest node in a tool [mm]", found["penetration_at_nodes_mm"], 0.05 * 1e3 * thickness,
             "tools move too fast, or meet through the sheet"),
            ("the number of failed unit cells", found["unit_cell_failures"], 0, "see unit_cell_failed"),
        )
        if not value <= limit
    ]  # fmt: skip
    if not 0.9 < found["min_stretch"] <= found["max_stretch"] < 1.1:
        result.append(
            f"yarn stretches range from {found['min_stretch']:.3f} to {found['max_stretch']:.3f}: yarns of a woven "
            "fabric do not bear that"
        )
    return result
