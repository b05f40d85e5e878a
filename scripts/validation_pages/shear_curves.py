"""What forming owes to the shear curve: the double dome and a cloth on a ball with the frame of every laboratory."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from scripts.shared.report import table
from scripts.validation_pages.double_dome import Variant, angle_change, angle_row, run
from scripts.validation_pages.laboratories import NAMES, rubbing, sheared_as_by_all, sheared_as_in
from weavesim.fabric.fabric import LARGEST_LOCKING_SHARE, Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.scenes.hemisphere import HemisphereParameters, cloth, hemisphere, wrinkles

FRICTION = 10.0  # of the polynomial's variant [N/m]
Change = Callable[[Fabric], Fabric]
# Everything but shear is that of the default fabric.
CURVES: dict[str, tuple[str, Change]] = {
    "polynomial": ("the polynomial (default)", lambda fabric: fabric),
    **{
        laboratory: (name, lambda fabric, own=laboratory: sheared_as_in(own, fabric))
        for laboratory, name in NAMES.items()
    },
    "elastic": ("all laboratories, elastic", lambda fabric: sheared_as_by_all(fabric, with_friction=False)),
    "friction": ("all laboratories, jump as friction", lambda fabric: sheared_as_by_all(fabric, with_friction=True)),
    "polynomial, friction": (
        f"the polynomial and friction of {FRICTION:g} N/m", lambda fabric: rubbing(fabric, FRICTION)
    ),
}  # fmt: skip
BALL = {"mesh_size": 0.01}
# Yarns of the sheet on the ball: as soft as those of the scene's cloth [N/m].
YARNS = 5.0e3


def forming_part() -> tuple[list[str], list[str]]:
    """Text, and the requirements that are not met."""
    runs = {key: run(Variant(title, change=change)) for key, (title, change) in CURVES.items()}
    base = runs["polynomial"]
    header = [
        "shear", *map(str, range(1, 11)), "largest", "draw-in long [mm]", "short [mm]", "punch force [N]",
        "min. stretch",
    ]  # fmt: skip
    rows = [angle_row(CURVES[key][0], result) for key, result in runs.items()]
    changes = {key: angle_change(base, result) for key, result in runs.items() if key != "polynomial"}
    widest = max(changes, key=lambda key: changes[key][1])
    spread = np.ptp([runs[key]["angles"] for key in NAMES], axis=0)
    split = angle_change(runs["elastic"], runs["friction"])[1]
    lowest = {key: result["min_stretch"] for key, result in runs.items()}
    drapes = {key: on_a_ball(change) for key, (_, change) in CURVES.items()}
    ball_rows = [
        [CURVES[key][0], f"{d['fold_count']}", f"{d['wrinkle_amplitude_mm']:.1f}", f"{d['max_shear_angle_deg']:.1f}",
         f"{d['mean_shear_angle_deg']:.2f}", f"{d['kinetic_energy_ratio']:.0e}"]
        for key, d in drapes.items()
    ]  # fmt: skip
    most = {name: [d[name] for d in drapes.values()] for name in ("max_shear_angle_deg", "wrinkle_amplitude_mm")}
    text = [
        "## What forming owes to the shear curve",
        "The same fabric with the frame of each laboratory as its elastic shear, and with what all see together, to "
        "45°: once all elastic, once with the jump within the first degree as friction (an assumption: no unloading "
        "was published). Beyond its data each curve goes on with its end slope; that of UT ends at 34°.",
        "**The double dome** at 5 mm, angles in degrees at the ten points (`docs/validation.md`):",
        table(header, rows),
        f"The five laboratories differ by {spread.max():.1f}° at most (point {int(np.argmax(spread)) + 1}); from the "
        f"polynomial the largest change is {changes[widest][1]:.1f}° ({CURVES[widest][0]}), "
        f"{max(mean for mean, _ in changes.values()):.1f}° on average at most. Whether the jump is elastic or friction "
        f"changes {split:.1f}°. The yarns, not the curve, decide these angles: a holder keeps the sheet taut. Nor does "
        f"the curve decide how far yarns are pushed together: the smallest stretch lies between "
        f"{min(lowest.values()):.3f} and {max(lowest.values()):.3f}.",
        "**On a ball**, under nothing but its weight (the scene `hemisphere`, 10 mm, with the glass/polypropylene's "
        "weight, bending and shear, and yarns of 5 kN/m to keep the step long), where shear moments are some N/m and "
        "the soft start matters:",
        table(["shear", "folds", "amplitude [mm]", "largest shear [°]", "mean shear [°]", "kinetic ratio"], ball_rows),
        f"Here the curve decides: the largest angle lies between {min(most['max_shear_angle_deg']):.1f}° and "
        f"{max(most['max_shear_angle_deg']):.1f}°, the amplitude of the folds between "
        f"{min(most['wrinkle_amplitude_mm']):.1f} and {max(most['wrinkle_amplitude_mm']):.1f} mm. A cloth whose shear "
        "begins with a jump of some N/m hardly shears under its weight. Which of these is right for a new cloth can "
        "only be told by a measurement below 5°, with unloading.",
    ]  # fmt: skip
    return text, []


def on_a_ball(change: Change) -> dict[str, Any]:
    """Folds and angles of the glass/polypropylene on the ball."""
    parameters = HemisphereParameters(**BALL)
    fabric = change(glass_polypropylene())
    soft, friction = cloth("high-bending"), fabric.shear_friction
    largest = 0.99 * LARGEST_LOCKING_SHARE * YARNS
    values: dict[str, Any] = {
        "unit_cell": soft.unit_cell, "shear": fabric.shear.locking_at_most(largest), "compressive_stiffness": 0.0,
        "shear_friction": friction and friction.model_copy(update={"stiffness": min(friction.stiffness, largest)}),
    }  # fmt: skip
    simulation = Simulation(hemisphere(parameters, "high-bending", fabric.model_copy(update=values)))
    simulation.run()
    angle = np.degrees(np.abs(simulation.frame.fields["shear_angle"]))
    found = {**simulation.summary(), **wrinkles(parameters, simulation), "mean_shear_angle_deg": float(angle.mean())}
    print({key: found[key] for key in ("fold_count", "wrinkle_amplitude_mm", "max_shear_angle_deg")}, flush=True)
    return found
