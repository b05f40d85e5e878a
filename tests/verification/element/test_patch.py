"""Patch tests on distorted meshes: uniform strains and curvatures have their exact energy, and nothing pulls inside."""

import numpy as np
import pytest

from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.sheet.blank import Blank

LENGTH, WIDTH, SIZE = 0.03, 0.02, 0.005
YARN_STIFFNESS, SHEAR_MODULUS, THICKNESS = 800.0, 2.0e5, 1.0e-3
BENDING, RATIO = IsotropicBending(modulus=3.0e7, poisson_ratio=0.3), 0.3
MEMBRANE = {
    "warp stretch": [[1.05, 0.0], [0.0, 1.0]],
    "weft stretch": [[1.0, 0.0], [0.0, 0.94]],
    "shear": [[1.0, 0.3], [0.0, 1.0]],
    "all, and a rotation": [[0.9, 0.1], [0.55, 1.1]],
}
# curvatures along x, along y, and twist [1/m], so small that only the linear terms count
CURVATURE = {"bending along x": (1e-3, 0.0, 0.0), "bending along y": (0.0, 1e-3, 0.0), "twist": (0.0, 0.0, 1e-3)}


def patch(sheet, fabric, distortion: float):
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), SIZE, yarn_angle=30.0, distortion=distortion, seed=3)
    laws = fabric(
        thickness=THICKNESS, unit_cell=PlainWeave.straight(stiffness_per_width=YARN_STIFFNESS),
        shear=LinearShear(modulus=SHEAR_MODULUS), bending=BENDING, transverse_shear_modulus=1.0e7,
        stabilisation=Stabilisation(in_plane=1.0, warping=1.0, director=1.0),
    )  # fmt: skip
    return blank, sheet(blank, laws)


def largest_inside(blank: Blank, vectors: np.ndarray) -> float:
    """Largest of the inner nodes over the largest of all."""
    inner = np.setdiff1d(np.arange(blank.node_count), blank.boundary_loop())
    size = np.linalg.norm(vectors, axis=1)
    return float(size[inner].max() / size.max())


def membrane_patch(sheet, fabric, image, distortion) -> tuple[float, float]:
    """Energy over the exact one, and the largest force inside over that at the edge."""
    blank, shell = patch(sheet, fabric, distortion)
    image = np.array(image)
    yarn = np.column_stack([blank.warp_direction[0], blank.weft_direction[0]])[:2]
    position = blank.node_position.copy()
    position[:, :2] = position[:, :2] @ (image @ np.linalg.inv(yarn)).T
    energies = shell.energies(position, blank.initial_director)
    force, _ = shell.forces(position, blank.initial_director)
    stretch = np.linalg.norm(image, axis=0)
    exact = 0.5 * YARN_STIFFNESS * np.square(stretch - 1.0).sum()
    exact += THICKNESS * SHEAR_MODULUS * (0.5 * image[:, 0] @ image[:, 1]) ** 2
    return energies["internal"] / (exact * LENGTH * WIDTH), largest_inside(blank, force)


def bending_patch(sheet, fabric, curvature, distortion) -> tuple[float, float, float]:
    """Energy over the exact one, and the largest force across and couple inside over those at the edge."""
    blank, shell = patch(sheet, fabric, distortion)
    k_x, k_y, k_xy = curvature
    x, y, _ = blank.node_position.T
    position = np.column_stack([x, y, 0.5 * (k_x * x**2 + k_y * y**2) + k_xy * x * y])
    director = np.column_stack([-k_x * x - k_xy * y, -k_y * y - k_xy * x, np.ones_like(x)])
    director /= np.linalg.norm(director, axis=1)[:, None]
    energies = shell.energies(position, director)
    force, conjugate = shell.forces(position, director)
    couple = np.cross(director, conjugate)
    stiffness = BENDING.stiffness(THICKNESS)
    exact = 0.5 * stiffness * (k_x**2 + k_y**2 + 2.0 * RATIO * k_x * k_y + 2.0 * (1.0 - RATIO) * k_xy**2)
    # across the sheet: in it the stretch of a bent sheet pulls, of second order. There should be none, so it is
    # measured by the couples over an element
    scale = np.abs(couple).max() / SIZE
    inner = np.setdiff1d(np.arange(blank.node_count), blank.boundary_loop())
    return (
        energies["internal"] / (exact * LENGTH * WIDTH),
        float(np.abs(force[inner, 2]).max() / scale),
        largest_inside(blank, couple),
    )


@pytest.mark.parametrize("distortion", [0.0, 0.35])
def test_patches(distortion, sheet, fabric, manual):
    case = manual(
        "Element", f"Patch tests on a {'distorted' if distortion else 'regular'} mesh",
        known=f"6 x 4 elements, inner nodes shifted by up to {100 * distortion:.0f} % of the element size, yarns at "
        "30 degrees to the edges, all stabilisation at full strength. Uniform strains have the energy of the closed "
        "form, uniform curvatures that of the plate (in the linear range), and there is no force or couple on any "
        "inner node.",
    )  # fmt: skip
    rows = []
    for name, image in MEMBRANE.items():
        energy, force = membrane_patch(sheet, fabric, image, distortion)
        rows.append([name, f"{energy:.9f}", force, "none"])
        assert energy == pytest.approx(1.0, abs=1e-9)
        assert force < 1e-12
    for name, curvature in CURVATURE.items():
        energy, force, couple = bending_patch(sheet, fabric, curvature, distortion)
        rows.append([name, f"{energy:.9f}", force, couple])
        assert energy == pytest.approx(1.0, abs=1e-6)
        assert force < 1e-6
        assert couple < 1e-6
    case.table(["state", "energy over exact", "largest force inside", "largest couple inside"], rows)
