"""Stresses and resultants: virtual work, nodal reactions of a uniform strip, a bent strip."""

import numpy as np
import pytest

from tests.support.sheet import NO_STABILISATION, Sheet, plain_fabric
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LinearShear
from weavesim.measures.stresses import STRESS_FIELDS, Convected, stress_fields
from weavesim.sheet.blank import Blank

PARTS = ("unit_cell_force", "shear_force", "in_plane_bending_force", "bending_force")


def whole_fabric() -> Fabric:
    """Every part of equation (1), by different laws, and nothing that is only stabilisation."""
    return plain_fabric(
        shear=LinearShear(modulus=4.0e5),
        bending=IsotropicBending(modulus=2.0e7, poisson_ratio=0.3),
        transverse_shear_modulus=3.0e5,
        in_plane_bending_stiffness=1.0e-3,
    )


@pytest.fixture(scope="module")
def sheet() -> Sheet:
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.01, yarn_angle=30.0, distortion=0.2)
    return Sheet(blank, whole_fabric())


def read(sheet: Sheet, position: np.ndarray, director: np.ndarray) -> dict[str, np.ndarray]:
    """Stress fields of a sheet whose nodes are put there."""
    sheet.place(position, director)
    frame, info = sheet.simulation.ledger.frame(0).sheet, sheet.simulation.info.sheet
    return stress_fields(info.blank, info.fabric, position, director, frame.fields, frame.resultants)


def curved(blank: Blank, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A sheet that is sheared, stretched, bent, and a little irregular, with directors that are not its normals."""
    x, y, _ = blank.node_position.T
    position = np.column_stack([1.02 * x + 0.3 * y, 0.97 * y, 3.0 * x**2 - 2.0 * y**2 + 4.0 * x * y])
    normal = np.column_stack([-(6.0 * x + 4.0 * y), 4.0 * y - 4.0 * x, np.ones_like(x)])
    director = normal + 0.03 * rng.normal(size=position.shape)
    return position + 2.0e-4 * rng.normal(size=position.shape), director / np.linalg.norm(director, axis=1)[:, None]


def test_virtual_work_of_the_pushed_forward_resultants_is_the_change_of_energy(sheet):
    blank, rng = sheet.simulation.info.sheet.blank, np.random.default_rng(3)
    position, director = curved(blank, rng)
    by_position, by_director = rng.normal(size=(2, blank.node_count, 3))
    by_director -= np.einsum("ij,ij->i", by_director, director)[:, None] * director
    # without in-plane bending: its mean angles are those of other elements, so it is no function of one element alone
    names = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact", "shear", "bending", "transverse_shear")
    step, ends = 1.0e-7, []
    for sign in (1.0, -1.0):
        turned = director + sign * step * by_director
        turned /= np.linalg.norm(turned, axis=1)[:, None]
        moved = position + sign * step * by_position
        energies = sheet.energies(moved, turned)
        ends.append((sum(energies[name] for name in names), Convected.of(blank, moved, turned)))
    change = (ends[0][0] - ends[1][0]) / (2.0 * step)

    x, out = Convected.of(blank, position, director), read(sheet, position, director)
    rate = {
        name: (value(ends[0][1]) - value(ends[1][1])) / (2.0 * step)
        for name, value in {
            "metric": lambda c: c.metric,
            "curvature": curvature,
            "shear": lambda c: np.einsum("eai,ei->ea", c.by_yarn, c.director) + skew(blank, curvature(c)),
        }.items()
    }
    # rates of covariant components, in the frame of each element
    inverse = np.linalg.inv(x.components)
    strain = 0.5 * np.einsum("eka,eab,elb->ekl", inverse, rate["metric"], inverse)
    bend = np.einsum("eka,eab,elb->ekl", inverse, rate["curvature"], inverse)
    slide = np.einsum("eka,ea->ek", inverse, rate["shear"])
    force = sum(out[name] for name in ("unit_cell_force", "shear_force", "bending_force"))
    density = (
        contracted(force, strain)
        + contracted(out["bending_moment"], bend)
        + np.einsum("ek,ek->e", out["transverse_force"], slide)
    )
    assert density @ (flat_area(blank) * x.area_ratio) == pytest.approx(change, rel=2e-6)
    # each part counts
    for name in (*PARTS, "bending_moment", "transverse_force"):
        assert np.abs(out[name]).max() > 0.0


def curvature(c: Convected) -> np.ndarray:
    k = np.einsum("eai,ebi->eab", c.by_yarn, c.director_by_yarn)
    return 0.5 * (k + k.transpose(0, 2, 1))


def skew(blank: Blank, k: np.ndarray) -> np.ndarray:
    """The correction of the transverse shear of elements that are no parallelograms (docs/theory.md, section 4)."""
    corner = blank.node_position[blank.quads]
    frame = np.stack([blank.warp_direction, blank.weft_direction], axis=1)
    p, q, odd = (
        np.einsum("eaj,ej->ea", frame, v)
        for v in (
            corner[:, 0] - corner[:, 2],
            corner[:, 1] - corner[:, 3],
            corner[:, 0] - corner[:, 1] + corner[:, 2] - corner[:, 3],
        )
    )
    inverse = np.linalg.inv(np.stack([p, q], axis=1))
    along_p, along_q = (np.einsum("ea,eab,eb->e", v, k, odd) for v in (p, q))
    return 0.25 * (inverse[:, :, 0] * along_p[:, None] - inverse[:, :, 1] * along_q[:, None])


def contracted(components: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    """s_ij e_ij of 11, 22, 12 and a symmetric tensor."""
    s11, s22, s12 = components.T
    return s11 * tensor[:, 0, 0] + s22 * tensor[:, 1, 1] + 2.0 * s12 * tensor[:, 0, 1]


def flat_area(blank: Blank) -> np.ndarray:
    corner = blank.node_position[blank.quads]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1)


def test_reactions_of_a_uniform_strip_are_the_stress_over_its_ends(sheet):
    """Forces at the nodes of an end, summed, against stress times current thickness, width and normal of that end."""
    blank = sheet.simulation.info.sheet.blank
    gradient = np.array([[1.05, 0.25, 0.0], [0.02, 0.98, 0.0], [0.0, 0.0, 1.0]])
    position = blank.node_position @ gradient.T
    director = np.tile([0.0, 0.0, 1.0], (blank.node_count, 1))
    out = read(sheet, position, director)
    force, _ = sheet.forces(position, director)
    end = np.isclose(blank.node_position[:, 0], 0.04)
    edge = gradient @ [0.0, 0.02, 0.0]
    outward = np.array([edge[1], -edge[0]])  # times the length of the edge
    frame = Convected.of(blank, position, director).frame[0]
    thickness = sheet.simulation.ledger.frame(0).sheet.fields["thickness"][0]
    s11, s22, s12 = out["stress_middle"][0] * thickness
    in_frame = np.array([[s11, s12], [s12, s22]])
    traction = frame[:2, :2].T @ in_frame @ frame[:2, :2] @ outward
    # internal forces pull the end back
    np.testing.assert_allclose(-force[end].sum(axis=0)[:2], traction, rtol=1e-9)
    assert np.ptp(out["stress_middle"], axis=0).max() < 1e-9 * np.abs(out["stress_middle"]).max()
    # the same from the line forces: a line across x has the reference normal (cos 30, -sin 30) in yarns
    across = np.cos(np.pi / 6) * out["line_force_warp"][0] - np.sin(np.pi / 6) * out["line_force_weft"][0]
    np.testing.assert_allclose(0.02 * across[:2], traction, rtol=1e-9)


def test_a_strip_bent_to_an_arc_has_the_stress_of_a_plate():
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.01), 0.0025)
    modulus, radius = 2.0e7, 0.05
    sheet = Sheet(blank, plain_fabric(bending=IsotropicBending(modulus=modulus)))
    angle = blank.node_position[:, 0] / radius
    director = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
    position = radius * director
    position[:, 1] = blank.node_position[:, 1]
    out, thickness = read(sheet, position, director), 1.0e-3
    # directors spread: the upper face is stretched
    wanted, stiffness = modulus * thickness / (2.0 * radius), modulus * thickness**3 / 12.0
    upper, lower = out["bending_stress_upper"], out["bending_stress_lower"]
    np.testing.assert_allclose(0.5 * (upper - lower)[:, 0], wanted, rtol=1e-3)
    np.testing.assert_allclose(out["bending_moment"][:, 0], stiffness / radius, rtol=1e-3)
    np.testing.assert_allclose((upper - lower)[:, 1:], 0.0, atol=1e-6 * wanted)
    # psi = J D/2 (k11/m11)^2: what a stretch changes of it is T^11 = (1/2 - 2) D k^2
    np.testing.assert_allclose(out["bending_force"][:, 0], -1.5 * stiffness / radius**2, rtol=2e-3)


def test_friction_counts_in_shear_and_bending():
    """Of a fabric with both: moment and stress are those of the springs, as the energies' own field says."""
    from weavesim.fabric.bending import BendingCurve, YarnBending
    from weavesim.fabric.shear import ShearFriction

    curve = BendingCurve(curvature=(0.0, 50.0), moment_values=(0.0, 0.05), friction_limit=0.01, friction_stiffness=0.01)
    fabric = plain_fabric(
        shear_friction=ShearFriction(stiffness=20.0, limit=(5.0,)),
        bending=YarnBending(warp=curve, weft=1e-3, twist=5e-4),
    )
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    sheet, radius = Sheet(blank, fabric), 0.1
    angle = blank.node_position[:, 0] / radius
    director = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
    position = radius * director
    position[:, 1] = blank.node_position[:, 1] + 0.1 * blank.node_position[:, 0]
    sheet.place(position, director)
    sheet.simulation.stepper.evaluate()
    frame, info = sheet.simulation.ledger.frame(0).sheet, sheet.simulation.info.sheet
    out = stress_fields(blank, info.fabric, position, director, frame.fields, frame.resultants)
    x = Convected.of(blank, position, director)
    k = curvature(x)[:, 0, 0] / x.metric[:, 0, 0]
    moment = 1e-3 * k + np.minimum(0.01 * k, 0.01)
    # M^11 = M(kappa)/m_11 and 1/J M^11 a_1 a_1
    np.testing.assert_allclose(out["bending_moment"][:, 0], moment / x.area_ratio, rtol=1e-6)
    tangential = out["shear_force"][:, 2] * x.area_ratio
    np.testing.assert_allclose(frame.fields["shear_moment"], 20.0 * frame.fields["shear_angle"], rtol=1e-6)
    assert np.all(np.sign(tangential) == np.sign(frame.fields["shear_moment"]))


def test_every_part_is_a_field_with_unit_and_shape(sheet):
    blank = sheet.simulation.info.sheet.blank
    out = read(sheet, blank.node_position, blank.initial_director)
    assert tuple(out) == tuple(STRESS_FIELDS)
    assert all(values.shape[0] == blank.element_count and values.ndim == 2 for values in out.values())
    assert all(np.abs(values).max() < 1e-6 for values in out.values())


def test_the_preset_is_free_of_stress_when_flat():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    sheet = Sheet(blank, glass_polypropylene().model_copy(update={"stabilisation": NO_STABILISATION}))
    out = read(sheet, blank.node_position, blank.initial_director)
    assert np.abs(out["stress_upper"]).max() < 1e-3
