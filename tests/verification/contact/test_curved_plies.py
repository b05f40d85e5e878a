"""Contact on plies of flat facets that stand for curved ones: an orbit, and a strip over a drum (docs/plies.md)."""

import math

import numpy as np
import pytest

from tests.support.capstan import THICKNESS, drawn, drum, strip
from tests.support.stacked_plies import pass_rows, ply, stack_setup
from weavesim import Interface, Observer, Simulation
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process import Coulomb, Gripper
from weavesim.sheet.blank import Blank

RING, FACET_COUNT, TURN_COUNT = 0.05, 40, 6
# Penetration over the radius, and side of the mass [m].
DEPTH_SHARE, MASS_SIZE = 2.0e-4, 0.001


def ring() -> Blank:
    """A closed ring about the y axis, one element wide."""
    angle = 2.0 * np.pi * np.arange(FACET_COUNT) / FACET_COUNT + 0.03
    half = np.pi * RING / FACET_COUNT
    nodes = np.array([[RING * np.sin(a), y, RING * np.cos(a)] for a in angle for y in (-half, half)])
    number = np.arange(2 * FACET_COUNT).reshape(FACET_COUNT, 2)
    ahead = np.roll(number, -1, axis=0)
    quads = np.column_stack([number[:, 0], ahead[:, 0], ahead[:, 1], number[:, 1]])
    corner = nodes[quads]
    return Blank.from_mesh(nodes, quads, warp_direction=corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3])


def orbit(fabric, inside: bool, stiffness: float | None = None) -> tuple[Simulation, float]:
    """A run of a small plate that goes around on a ring without friction, and the contact force that it needs [N]."""
    thickness = 0.05 * RING
    cloth = fabric(
        thickness=thickness, unit_cell=LinearMembrane(warp_stiffness=2.0e3, weft_stiffness=2.0e3),
        bending=IsotropicBending(modulus=1.0e-3), transverse_shear_modulus=1.0e4,
    )  # fmt: skip
    radius = RING - thickness if inside else RING + thickness
    corners = 0.5 * MASS_SIZE * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plate = Blank.from_mesh(np.column_stack([corners, np.full(4, radius)]), [[0, 1, 2, 3]])
    load = DEPTH_SHARE * RING * (stiffness or 1.0e9) * MASS_SIZE**2
    mass = cloth.areal_density * MASS_SIZE**2
    speed = 0.5 * math.sqrt(load * RING / mass)
    centre = Gripper("centre", np.arange(4), (0.0, 0.0, -1.0), 1.0e-3 * load / RING, length=radius, pretension=load)
    track = ply("ring", ring(), free=np.zeros((2 * FACET_COUNT, 6), dtype=bool), fabric=cloth)
    sheets = [track, ply("mass", plate, (speed, 0.0, 0.0), fabric=cloth, grippers=() if inside else (centre,))]
    setup = stack_setup(
        sheets[::-1] if inside else sheets, Coulomb(0.0), interface={"passes": "one"}, frame_count=240,
        dynamics={"contact_damping_ratio": 0.1}, solver={"lane_count": 1},
        duration=TURN_COUNT * 2.0 * np.pi * radius / speed,
    )  # fmt: skip
    run = Simulation(setup)
    if stiffness is None:  # of the pass, which sets the load
        return orbit(fabric, inside, run.model.passes[0].area_stiffness)
    return run, mass * speed**2 / radius if inside else load - mass * speed**2 / radius


@pytest.mark.parametrize("inside", [True, False], ids=["inside", "outside"])
def test_a_mass_orbits_on_a_polygon_without_loss(inside, fabric, manual):
    """Known answer B: facets that do not know their sagitta knock, and take 87 % of the energy."""
    run, expected = orbit(fabric, inside)
    force: list[float] = []

    class Watch(Observer):
        def frame(self, frame):
            force.append(float(np.linalg.norm(pass_rows(run, 0)["force"].sum(axis=1))))

    run.run([Watch()])
    first, last = run.history[0], run.history[-1]
    change = last["kinetic"] / first["kinetic"] - 1.0
    settled = np.array(force[5:])
    assert abs(change) < 2e-3
    assert settled.mean() == pytest.approx(expected, rel=0.01)
    ripple = settled.std() / settled.mean()
    assert ripple < 0.05
    assert abs(last["balance_error"]) < 1e-3 * first["kinetic"]
    case = manual(
        "Contact", f"An orbit on a ring of 40 facets, {'inside' if inside else 'outside'}",
        known="A mass goes around six times on a ring of 40 flat facets, without friction, with a dashpot of a tenth "
        "of critical: its kinetic energy is kept, and the force is that of the circle. Contact with the flat facets "
        "themselves would take most of the energy (87 % in a prototype with the closest point).",
    )  # fmt: skip
    case.table(
        ["change of the kinetic energy", "mean force over that of the circle", "ripple of the force, rms"],
        [[f"{change:+.1e}", f"{settled.mean() / expected:.4f}", f"{ripple:.1e}"]],
    )


@pytest.mark.parametrize(
    "size", [pytest.param(0.002, marks=pytest.mark.verification), 0.004], ids=["a tenth", "a fifth"]
)
def test_the_tension_of_a_strip_over_a_ply_grows_exponentially(size, fabric, frames, manual):
    """Euler and Eytelwein, over facets of a tenth and a fifth of the drum's radius."""
    coefficient, turn = 0.2, math.radians(120.0)
    cloth = fabric(
        areal_density=0.5, thickness=THICKNESS, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=1.0e4), transverse_shear_modulus=1.0e5,
        shear=LinearShear(modulus=4.0e6), stabilisation=Stabilisation(),
    )  # fmt: skip
    sheets = drum(cloth, turn, size), strip(cloth, turn)
    forces, run = drawn(frames, sheets, interfaces=(Interface("drum", "strip", Coulomb(coefficient)),))
    expected = math.exp(coefficient * turn)
    ratio, ripple = float(forces.mean()), float(forces.std() / forces.mean())
    energies = run.frame.energies
    error = abs(energies["balance_error"]) / energies["support_work"]
    assert ratio == pytest.approx(expected, rel=0.003)
    assert ripple < 0.005 and error < 0.01
    case = manual(
        "Contact", f"A strip drawn over a ply, facets of {1e3 * size:g} mm on a radius of 20 mm",
        known="Euler and Eytelwein: the tension grows by exp(mu theta), with mu = 0.2 and 120 degrees. The drum is a "
        "ply of flat facets that is held.",
    )  # fmt: skip
    case.table(
        ["expected ratio of tensions", "got", "deviation", "ripple, rms", "balance error / work"],
        [[f"{expected:.5g}", f"{ratio:.5g}", f"{100.0 * (ratio / expected - 1.0):+.2g} %", f"{ripple:.1e}",
          f"{error:.1e}"]],
    )  # fmt: skip
