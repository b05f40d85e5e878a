"""Shear of the glass/polypropylene weave as each laboratory's picture frame has it; all else of the fabric stays."""

from __future__ import annotations

import numpy as np

from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets.cao2008 import FRAME_LABORATORIES, consensus_moment, frame_curve
from weavesim.fabric.presets.glass import HKUST_NOISE, glass_polypropylene_consensus
from weavesim.fabric.shear import MomentCurve, ShearFriction

NAMES = {"hkust": "HKUST", "kul_1st": "KUL, first loading", "lmsp": "LMSP", "uml": "UML", "ut": "UT"}
assert set(NAMES) == set(FRAME_LABORATORIES)


def sheared_as_in(laboratory: str, fabric: Fabric, smoothing: float | None = None) -> Fabric:
    """The fabric with the whole curve of a laboratory's frame as elastic shear; its locking branch stays.

    Args:
        laboratory: by its name in the data.
        fabric: all else.
        smoothing: root mean square distance from the points [N/m]; by default the noise of HKUST's, none for others.
    """
    angle, force = frame_curve(laboratory)
    if smoothing is None:
        smoothing = HKUST_NOISE if laboratory == "hkust" else 0.0
    shear = MomentCurve.from_normalised_force(
        angle, force, convention="fabric area", smoothing=smoothing, **_locking(fabric)
    )
    return fabric.model_copy(update={"shear": shear, "shear_friction": None})


def sheared_as_by_all(fabric: Fabric, *, with_friction: bool) -> Fabric:
    """The fabric with the consensus to 45 degrees: all elastic, or the jump within the first degree as friction."""
    if with_friction:
        whole = glass_polypropylene_consensus()
        return fabric.model_copy(update={"shear": whole.shear, "shear_friction": whole.shear_friction})
    angle, moment = consensus_moment()
    shear = MomentCurve(angle=(0.0, *angle.tolist()), moment_values=(0.0, *moment.tolist()), **_locking(fabric))
    return fabric.model_copy(update={"shear": shear, "shear_friction": None})


def rubbing(fabric: Fabric, limit: float) -> Fabric:
    """The fabric with friction of the crossovers that slips at ``limit`` [N/m] after one degree."""
    friction = ShearFriction(stiffness=limit / np.radians(1.0), limit=(limit,))
    return fabric.model_copy(update={"shear_friction": friction})


def _locking(fabric: Fabric) -> dict[str, float]:
    assert isinstance(fabric.shear, MomentCurve)
    return {"locking_angle": fabric.shear.locking_angle, "locking_stiffness": fabric.shear.locking_stiffness}
