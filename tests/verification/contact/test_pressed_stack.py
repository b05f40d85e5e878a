"""A stack of thin plies between plates: its height, and how evenly it presses (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.stacked_plies import nodes, ply, run_stack, square
from weavesim import Tool
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process import Coulomb
from weavesim.process.strokes import Fixed, Stroke
from weavesim.tools import Plane, rotation_matrix

THIN, SIZE, APPROACH = 3.0e-4, 0.01, 2.4e-5
# In the plane, so that the reference step is about a microsecond [N/m].
STIFFNESS = 3.3e7
# Of the middle ply: size of its elements over that of the others, and angle between the meshes [degrees].
MESHES = {"equal": (1.0, 0.0), "at 45 degrees": (1.0, 45.0), "1:1.7 at 30 degrees": (1.0 / 1.7, 30.0)}


def thin_fabric() -> Fabric:
    return Fabric(
        name="thin ply", areal_density=0.5, thickness=THIN,
        unit_cell=LinearMembrane(warp_stiffness=STIFFNESS, weft_stiffness=STIFFNESS),
        bending=IsotropicBending(modulus=4.0e7), transverse_shear_modulus=2.0e6, shear=LinearShear(modulus=4.0e6),
        stabilisation=Stabilisation(),
    )  # fmt: skip


def pressed(share: float, angle: float):
    """Three plies, the middle one with another mesh, after plates have come nearer by ``APPROACH``."""
    cloth = thin_fabric()
    sheets = [
        ply("1", square(0.03, SIZE), fabric=cloth),
        ply("2", square(0.05, SIZE * share, THIN, angle), fabric=cloth),
        ply("3", square(0.03, SIZE, 2.0 * THIN), fabric=cloth),
    ]
    turned = rotation_matrix((1.0, 0.0, 0.0), np.pi)
    down = Stroke((0.0, 5e-4, 1.0), (0.0, APPROACH, APPROACH))
    plates = (
        Tool("table", Plane(origin=(0.0, 0.0, -0.5 * THIN)), Fixed(), friction=0.0),
        Tool("press", Plane(origin=(0.0, 0.0, 2.5 * THIN), rotation=turned), down, axis=(0.0, 0.0, -1.0), friction=0.0),
    )
    dynamics = {"contact_damping_ratio": 0.5, "damping": 2.0e4}
    return run_stack(sheets, Coulomb(0.0), duration=2e-3, dynamics=dynamics, tools=plates)


@pytest.mark.verification
def test_a_stack_of_thin_plies_is_pressed_evenly(manual):
    """Known answer E: height by the penalties, and the pressure on the plates, for three meshes of the middle ply."""
    rows = []
    for name, (share, angle) in MESHES.items():
        run = pressed(share, angle)
        outer = [(run.model.sheets[k], run.state.sheets[k]) for k in (0, 2)]
        lower, upper = (nodes(*each)[0][:, 2] for each in outer)
        # the middle ply reaches farther and bends around the edges of the others
        inner = np.abs(outer[0][0].blank.node_position[:, :2]).max(axis=1) < 0.025
        depth = np.array([-lower[inner], upper[inner] - 2.0 * THIN + APPROACH])
        pressure = np.array([
            0.05 * model.fabric.areal_density * own / model.reference_step**2
            for (model, _), own in zip(outer, depth, strict=True)
        ])  # fmt: skip
        mean = pressure.mean()
        sunk = depth.mean(axis=1).sum() + 2.0 * mean / run.model.passes[0].area_stiffness
        rms, most = pressure.std() / mean, np.abs(pressure / mean - 1.0).max()
        assert sunk == pytest.approx(APPROACH, abs=1e-6)
        assert rms < 0.06 and most < 0.2
        assert pressure.mean(axis=1) == pytest.approx(mean, rel=0.005)
        height = 1e6 * (3.0 * THIN - APPROACH)
        rows.append([name, 1e-6 * mean, 1e6 * (3.0 * THIN - sunk), height, f"{100 * rms:.1f} %", f"{100 * most:.1f} %"])
    case = manual(
        "Contact", "Thin plies between plates, how evenly",
        known="Three plies of 0.3 mm are pressed to 0.876 mm: p dt0^2/(s_c rho) at each plate and p/k_a at each "
        "interface, within a micrometre; the pressure on the plates varies by 6 % rms and 20 % at most. The middle ply "
        "has the mesh of the others, one at 45 degrees, or one that is finer by 1:1.7 at 30 degrees.",
    )  # fmt: skip
    case.table(
        ["middle ply", "pressure [MPa]", "height by the penalties [um]", "height [um]", "pressure, rms", "largest"],
        rows,
    )
