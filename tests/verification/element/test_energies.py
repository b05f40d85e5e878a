"""Every force is the derivative of an energy; rigid motion costs nothing; momentum is kept."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.registered_laws import CURVE, LOCKING, TERMS
from weavesim.fabric.bending import IsotropicBending, YarnBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LinearShear
from weavesim.sheet.blank import Blank

CELL = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact")


def numerical_forces(sheet, position, director, entries, change=2e-7):
    """Minus the derivatives of the sum of ledger entries by positions and directors, (n, 3) each."""

    def energy(x, d):
        energies = sheet.energies(x, d)
        return sum(energies[name] for name in entries)

    result = np.zeros((2, *position.shape))
    for kind, node, component in np.ndindex(result.shape):
        ends = []
        for sign in (1.0, -1.0):
            state = np.array([position, director])
            state[kind, node, component] += sign * change
            ends.append(energy(*state))
        result[kind, node, component] = (ends[1] - ends[0]) / (2.0 * change)
    return result


def agree(forces, numerical, tolerance):
    """Both kinds, each relative to its largest entry."""
    for kind in range(2):
        scale = np.abs(numerical[kind]).max()
        assert np.abs(forces[kind] - numerical[kind]).max() <= tolerance * scale


def test_membrane_force_is_the_derivative_of_the_cells_energy(sheet, fabric, curved_blank, deformed):
    cell = glass_polypropylene().unit_cell
    membrane = sheet(curved_blank, fabric(unit_cell=cell))
    forces = np.array(membrane.forces(*deformed))
    assert np.abs(forces[0]).max() > 0.1
    agree(forces, numerical_forces(membrane, *deformed, CELL), 1e-6)


def worst_error(name, sheet, fabric, curved_blank, deformed) -> float:
    """Of the forces and director gradients that a term adds, against differences of its own entry of the ledger.

    Each relative to the largest of its kind.
    """
    added, entry = TERMS[name]
    with_term = fabric(**added)
    without = fabric() if entry != "hourglass" else fabric(**{k: v for k, v in added.items() if k != "stabilisation"})
    with_term, without = sheet(curved_blank, with_term), sheet(curved_blank, without)
    energies = with_term.energies(*deformed)
    assert energies[entry] > 1e-9
    forces = np.array(with_term.forces(*deformed)) - np.array(without.forces(*deformed))
    numerical = numerical_forces(with_term, *deformed, (entry,))
    assert max(np.abs(numerical[0]).max(), np.abs(numerical[1]).max()) > 1e-5
    sizes = [np.abs(numerical[kind]).max() for kind in range(2)]
    # a membrane term does not know the directors: then both must be nothing
    return max(
        float(np.abs(forces[kind] - numerical[kind]).max() / (size or max(sizes))) for kind, size in enumerate(sizes)
    )


@pytest.mark.parametrize("name", TERMS)
def test_force_is_the_derivative_of_the_energy(name, sheet, fabric, curved_blank, deformed):
    assert worst_error(name, sheet, fabric, curved_blank, deformed) < 2e-6


@pytest.mark.verification
def test_forces_of_all_terms(sheet, fabric, curved_blank, deformed, manual):
    case = manual(
        "Element", "Forces against differences of the energy",
        known="Every force is minus the derivative of an entry of the ledger with respect to positions and "
        "directors: central differences on a warped, distorted mesh with yarns at 20 degrees, strained by 15 %, "
        "sheared, bent and rotated. The worst error of any node, relative to the largest force, is that of the "
        "differences. Every term of the list `TERMS` is tested; unit cells have their own chapter.",
    )  # fmt: skip
    errors = {name: worst_error(name, sheet, fabric, curved_blank, deformed) for name in TERMS}
    case.table(
        ["term", "entry of the ledger", "worst error"], [[n, TERMS[n][1], f"{e:.1e}"] for n, e in errors.items()]
    )
    assert max(errors.values()) < 2e-6


def test_locking_is_met_in_the_test_of_locking(sheet, fabric, curved_blank, deformed):
    locked = sheet(curved_blank, fabric(shear=LOCKING))
    locked.place(*deformed)
    angle = np.abs(locked.simulation.ledger.frame(0).fields["shear_angle"])
    assert (angle > LOCKING.locking_angle + LOCKING.locking_width).any()
    unlocked = sheet(curved_blank, fabric(shear=CURVE))
    assert locked.energies(*deformed)["shear"] > 1.5 * unlocked.energies(*deformed)["shear"]


def test_warped_reference_is_at_rest(sheet, curved_blank):
    shell = sheet(curved_blank, glass_polypropylene())
    rest = shell.forces(curved_blank.node_position, curved_blank.initial_director)
    energies = shell.energies(curved_blank.node_position, curved_blank.initial_director)
    assert energies["internal"] < 1e-20
    assert max(np.abs(rest[0]).max(), np.abs(rest[1]).max()) < 1e-9


@pytest.mark.parametrize("bending", ["isotropic", "yarns"])
def test_rigid_motion_gives_no_force(bending, sheet, curved_blank, deformed):
    fabric = glass_polypropylene()
    if bending == "yarns":
        # with kernels that the terms above have compiled
        fabric = fabric.with_linear_shear(1e5).model_copy(
            update={"bending": YarnBending(warp=3e-3, weft=1e-3, twist=5e-4)}
        )
    shell = sheet(curved_blank, fabric)
    rotation = Rotation.from_rotvec([1.1, -2.0, 0.7]).as_matrix()
    moved = curved_blank.node_position @ rotation.T + [0.3, -0.2, 0.5]
    forces = shell.forces(moved, curved_blank.initial_director @ rotation.T)
    typical = shell.forces(*deformed)
    for kind in range(2):
        assert np.abs(forces[kind]).max() < 1e-9 * np.abs(typical[kind]).max()


def test_forces_turn_with_the_sheet(sheet, curved_blank, deformed, manual):
    position, director = deformed
    shell = sheet(curved_blank, glass_polypropylene())
    rotation = Rotation.from_rotvec([-0.4, 1.3, 2.0]).as_matrix()
    turned = shell.forces(position @ rotation.T + 0.1, director @ rotation.T)
    errors = [
        np.abs(force @ rotation.T - other).max() / np.abs(force).max()
        for force, other in zip(shell.forces(position, director), turned, strict=True)
    ]
    assert max(errors) < 1e-9
    before, after = (
        shell.energies(position, director),
        shell.energies(position @ rotation.T + 0.1, director @ rotation.T),
    )
    change = abs(after["internal"] / before["internal"] - 1.0)
    assert change < 1e-10
    case = manual(
        "Element", "Objectivity",
        known="A strained, sheared, bent and warped sheet of the preset is rotated by 139 degrees and moved: forces "
        "and director gradients rotate with it and its energy is unchanged, to round-off.",
    )  # fmt: skip
    case.table(["quantity", "largest relative difference"], [["forces", f"{errors[0]:.1e}"],
               ["director gradients", f"{errors[1]:.1e}"], ["energy", f"{change:.1e}"]])  # fmt: skip


def test_internal_forces_have_no_resultant_and_no_moment(sheet, curved_blank, deformed):
    position, director = deformed
    strong = Stabilisation(in_plane=1.0, warping=1.0, director=1.0)
    fabric = glass_polypropylene().model_copy(update={"stabilisation": strong})
    force, conjugate = sheet(curved_blank, fabric).forces(position, director)
    couple, moment = np.cross(director, conjugate), np.cross(position, force)
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()
    assert np.abs((couple + moment).sum(axis=0)).max() < 1e-12 * (np.abs(couple).sum() + np.abs(moment).sum())
    # the couples matter: without them the sum would not vanish
    assert np.abs(couple.sum(axis=0)).max() > 1e-6 * np.abs(couple).sum()


def test_internal_energy_is_the_sum_of_its_entries(sheet, curved_blank, deformed):
    shell = sheet(curved_blank, glass_polypropylene())
    energies, names = shell.energies(*deformed), shell.simulation.ledger.internal
    assert set(CELL) < set(names)
    assert energies["internal"] == pytest.approx(sum(energies[name] for name in names), rel=1e-12)
    assert min(energies[name] for name in names) >= 0.0


def test_uniform_stretch_and_shear_have_their_closed_form(sheet, fabric):
    """Homogeneous deformation of a distorted mesh: energy density times area, and no force inside."""
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=30.0, distortion=0.3)
    laws = fabric(
        unit_cell=PlainWeave.straight(stiffness_per_width=800.0), shear=LinearShear(modulus=2.0e5),
        stabilisation=Stabilisation(),
    )  # fmt: skip
    yarn = np.column_stack([blank.warp_direction[0], blank.weft_direction[0]])[:2]
    wanted = np.array([[1.05, 0.3], [0.0, 0.94]])  # images of warp and weft
    gradient = wanted @ np.linalg.inv(yarn)
    position = blank.node_position.copy()
    position[:, :2] = position[:, :2] @ gradient.T
    patch = sheet(blank, laws)
    energies = patch.energies(position, blank.initial_director)
    area = 0.03 * 0.02
    stretch = np.linalg.norm(wanted, axis=0)
    assert energies["warp_axial"] == pytest.approx(0.5 * 800.0 * (stretch[0] - 1.0) ** 2 * area, rel=1e-9)
    assert energies["weft_axial"] == pytest.approx(0.5 * 800.0 * (stretch[1] - 1.0) ** 2 * area, rel=1e-9)
    green_lagrange = 0.5 * wanted[:, 0] @ wanted[:, 1]
    assert energies["shear"] == pytest.approx(1e-3 * 2.0e5 * green_lagrange**2 * area, rel=1e-9)
    assert energies["hourglass"] < 1e-20
    # the patch test: nothing pulls at the inner nodes
    force, _ = patch.forces(position, blank.initial_director)
    inner = np.setdiff1d(np.arange(blank.node_count), blank.boundary_loop())
    assert np.abs(force[inner]).max() < 1e-12 * np.abs(force).max()


def test_cylinder_has_the_bending_energy_of_a_plate(sheet, fabric):
    """Nodes on a cylinder of radius R, directors normal to it: D / 2 R^2 per area, from either Poisson's ratio."""
    radius, modulus = 0.2, 3.0e7
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.002, yarn_angle=25.0)
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    position = np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)])
    director = np.column_stack([np.sin(x / radius), 0.0 * y, np.cos(x / radius)])
    for ratio in (0.0, 0.4):
        law = IsotropicBending(modulus=modulus, poisson_ratio=ratio)
        energies = sheet(blank, fabric(bending=law, stabilisation=Stabilisation())).energies(position, director)
        stiffness = modulus * 1e-9 / (12.0 * (1.0 - ratio**2))
        assert energies["bending"] == pytest.approx(0.5 * stiffness / radius**2 * 0.04**2, rel=1e-4)
        assert energies["transverse_shear"] < 1e-4 * energies["bending"]
        assert energies["hourglass"] < 1e-4 * energies["bending"]


def test_twist_costs_at_most_one_per_cent_more_than_exact(sheet, fabric, manual):
    """w = c x y with directors normal to it: M = D (1 - nu) c, twice."""
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), (0.005, 0.004), yarn_angle=25.0)
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    twist, ratio, modulus = 0.5, 0.3, 3.0e7
    position = np.column_stack([x, y, twist * x * y])
    director = np.column_stack([-twist * y, -twist * x, np.ones_like(x)])
    director /= np.linalg.norm(director, axis=1)[:, None]
    law = IsotropicBending(modulus=modulus, poisson_ratio=ratio)
    laws = fabric(bending=law, transverse_shear_modulus=1.0e7, stabilisation=Stabilisation())
    energies = sheet(blank, laws).energies(position, director)
    exact = law.stiffness(1e-3) * (1.0 - ratio) * twist**2 * 0.04**2
    total = energies["bending"] + energies["transverse_shear"] + energies["hourglass"]
    assert total == pytest.approx(exact, rel=0.01)
    case = manual(
        "Element", "A pure twist", known="z = 0.5 xy on 40 mm, directors normal to it: D (1 - nu) c^2 per area."
    )
    case.table(["expected [J]", "got [J]", "deviation"], [[exact, total, f"{100 * (total / exact - 1):+.2g} %"]])
