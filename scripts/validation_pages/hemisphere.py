"""The page of the cloth on a ball: folds and shear, and what they depend on."""

from __future__ import annotations

from datetime import date

from scripts.shared.report import table
from weavesim import __version__
from weavesim.run.simulation import Simulation
from weavesim.scenes.hemisphere import CASES, HemisphereParameters, hemisphere, wrinkles

HEMISPHERE_VARIANTS = {
    "default": {},
    "10 mm": {"mesh_size": 0.01},
    "6.7 mm": {"mesh_size": 0.4 / 60},
    "6.7 mm, different unevenness": {"mesh_size": 0.4 / 60, "seed": 1},
    "6.7 mm, damping halved": {"mesh_size": 0.4 / 60, "damping": 7.5},
}


def hemisphere_page() -> tuple[str, list[str]]:
    """The page of the hemisphere, and the requirements that are not met."""
    rows, results = [], {}
    for case in CASES:
        for title, values in HEMISPHERE_VARIANTS.items():
            parameters = HemisphereParameters(**values)
            simulation = Simulation(hemisphere(parameters, case))
            simulation.run()
            result = {**simulation.summary(), **wrinkles(parameters, simulation)}
            results[case, title] = result
            rows.append([
                case, title, f"{result['fold_count']}", f"{result['wrinkle_amplitude_mm']:.1f}",
                f"{result['max_shear_angle_deg']:.1f}", f"{result['close_pair_count']}",
                f"{result['kinetic_energy_ratio']:.1e}", f"{result['hourglass_energy_ratio']:.3f}",
                f"{result['min_stretch']:.3f}",
            ])  # fmt: skip
            print(*rows[-1], flush=True)
    low, high = (results[case, "default"] for case in CASES)
    gates = [
        ("both come to rest: kinetic below 2 % of internal energy",
         max(low["kinetic_energy_ratio"], high["kinetic_energy_ratio"]) < 0.02),
        ("both wrinkle: folds above 2 % of the rim's mean distance from the axis",
         min(low["fold_count"], high["fold_count"]) > 0),
        ("they differ in the number of folds", low["fold_count"] != high["fold_count"]),
        ("the second shears at least twice as much", high["max_shear_angle_deg"] >= 2.0 * low["max_shear_angle_deg"]),
    ]  # fmt: skip
    header = [
        "case", "run", "folds", "amplitude [mm]", "largest shear [°]", "close pairs", "kinetic ratio",
        "hourglass ratio", "min. stretch",
    ]  # fmt: skip
    paragraphs = [
        "# Validation: a cloth on a ball",
        f"Written by `python scripts/validation.py hemisphere` on {date.today().isoformat()} with weavesim "
        f"{__version__}. The default mesh is 5 mm. Nothing here is compared with measurements; the paper shows "
        "pictures without numbers (its Figure 5).",
        table(["requirement", "holds"], [[what, "yes" if holds else "**no**"] for what, holds in gates]),
        table(header, rows),
        "Folds are maxima of the rim's distance from the vertical axis, less that of a cloth that lies on the ball "
        "without folds; the amplitude is half the range of that difference. Close pairs are nodes and elements that "
        "come closer than half the thickness without being neighbours: the scene has no self-contact, so they pass "
        "through each other. The largest shear angles agree between the meshes. The folds of the soft, shear-stiff "
        "cloth do not: wrinkling is unstable, so their number depends on mesh, unevenness and damping, and they are as "
        "sharp as the mesh allows.",
    ]
    text = "\n\n".join(paragraphs) + "\n"
    return text, [what for what, holds in gates if not holds]
