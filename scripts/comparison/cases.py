"""Cases that run in both versions: calls of the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

REFERENCE_COMMIT = "4add259"


@dataclass(frozen=True)
class Case:
    """One call of the command line.

    Attributes:
        words: arguments; ``{inputs}`` stands for the folder of ``write_inputs``.
        quick: whether ``--quick`` runs it.
        changed: what was changed deliberately; differences are then shown but not counted.
    """

    words: str
    quick: bool = False
    changed: str = ""

    def arguments(self, inputs: Path) -> list[str]:
        return [word.format(inputs=inputs) for word in self.words.split()]


COARSE_DOME = "double-dome --mesh-size 0.01 "
RUBBING_DOME = COARSE_DOME + "--fabric {inputs}/rubbing.toml "
RUBBING_FRAME = "picture-frame --mesh-size 0.025 --cycle --fabric {inputs}/rubbing.toml --precision float64 "
# With a fixed step, runs show that only the choice of the step was changed.
FIXED_STEP = "--time-step 2e-6"
YARN_STEP = "the stable step of bending per yarn family (docs/decisions/0021-bounds-of-coupled-terms.md)"
CREASES = "distances at creases of meshes: largest shear 46.33 to 46.35 degrees (docs/decisions/0023-tool-meshes.md)"
MESH_TOOLS = "--punch {inputs}/punch.stl --die {inputs}/die.stl --binder {inputs}/binder.stl --unit-scale 0.001"

CASES = {
    "double-dome-quarter": Case("double-dome", quick=True),
    "double-dome-quarter-float64": Case("double-dome --precision float64"),
    "double-dome-full": Case("double-dome --part full"),
    "double-dome-full-float64": Case("double-dome --part full --precision float64"),
    "hemisphere-low-bending": Case("hemisphere --case low-bending"),
    "hemisphere-high-bending": Case("hemisphere --case high-bending"),
    "hemisphere-float64": Case("hemisphere --case low-bending --mesh-size 0.01 --precision float64"),
    "picture-frame": Case("picture-frame --mesh-size 0.02"),
    "picture-frame-cycle": Case("picture-frame --cycle"),
    "picture-frame-arms": Case("picture-frame --mesh-size 0.02 --arm-length 0.04 --misalignment 3 --shear-law linear"),
    "picture-frame-friction-float64": Case(RUBBING_FRAME, changed=YARN_STEP),
    "picture-frame-friction-float64-fixed-step": Case(RUBBING_FRAME + FIXED_STEP),
    "bias-extension": Case("bias-extension"),
    "bias-extension-float64": Case("bias-extension --mesh-size 0.0125 --precision float64"),
    "cantilever": Case("cantilever", quick=True),
    "cantilever-weft-float32": Case("cantilever --yarn weft --precision float32"),
    "dome-rubbing-fabric": Case(RUBBING_DOME, changed=YARN_STEP),
    "dome-rubbing-fabric-float64": Case(RUBBING_DOME + "--precision float64", changed=YARN_STEP),
    "dome-rubbing-fabric-fixed-step": Case(RUBBING_DOME + FIXED_STEP, quick=True),
    "dome-rubbing-fabric-float64-fixed-step": Case(RUBBING_DOME + FIXED_STEP + " --precision float64"),
    "dome-twill": Case(COARSE_DOME + "--fabric assumed-twill"),
    "dome-satin-half": Case(COARSE_DOME + "--fabric assumed-satin-5 --part half --blank-holder-gap 0.0001"),
    "dome-stitched-tape": Case(COARSE_DOME + "--fabric assumed-stitched-tape"),
    "dome-membrane-turned": Case(COARSE_DOME + "--fabric assumed-linear-membrane --part full --yarn-angle 30"),
    "dome-current-thickness": Case(COARSE_DOME + "--contact-thickness current"),
    "dome-mesh-tools": Case(COARSE_DOME + MESH_TOOLS, quick=True, changed=CREASES),
    "dome-mass-scaling": Case(COARSE_DOME + "--target-step 4e-6"),
}
