"""Contact: how deep a known force goes, one tool in three descriptions, and a symmetric press."""

import numpy as np
import pytest
import trimesh

from tests.support.runs import one_sheet_run
from weavesim.engine.sheet_model import CONTACT_SHARE
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import Stroke
from weavesim.run.relaxation import relax
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.sampling import exact_distance, sampled_distance
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

RADIUS = 0.02


@pytest.fixture
def cloth(fabric):
    """Soft, so that a tenth of a second takes few steps."""
    return fabric(
        areal_density=0.5, thickness=1.0e-3, unit_cell=PlainWeave.straight(stiffness_per_width=2000.0),
        shear=LinearShear(modulus=1.0e5), bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e5,
        stabilisation=Stabilisation(),
    )  # fmt: skip


def test_indentation_under_a_known_weight(cloth, manual):
    case = manual(
        "Contact", "Indentation of a resting sheet",
        known="A node of mass m has the contact stiffness k = s m/dt0^2, dt0 the reference step of the sheet and s "
        "the contact share, so that a sheet at rest on a plane sinks in by m g/k = g dt0^2/s everywhere, which falls "
        "with the square of the element size. Contact energy: half the work of the weight; the rest is lost in "
        "damping.",
    )  # fmt: skip
    rows, depths = [], []
    for size in (0.01, 0.005, 0.0025):
        blank = Blank.rectangle((-0.02, -0.01), (0.02, 0.01), size, height=0.5 * cloth.thickness)
        simulation = one_sheet_run(
            name="rest", blank=blank, fabric=cloth, tools=[Tool("plane", Plane())], duration=1.0, precision="float64",
            threads=1, dynamics=Dynamics(gravity=(0.0, 0.0, -9.81)),
        )  # fmt: skip
        relax(simulation, tolerance=1e-5)
        depth = 0.5 * cloth.thickness - simulation.frame.position[:, 2]
        expected = 9.81 * simulation.model.reference_step**2 / CONTACT_SHARE
        assert depth == pytest.approx(expected, rel=1e-4)
        energies = simulation.frame.energies
        assert energies["contact"] == pytest.approx(0.5 * energies["gravity_work"], rel=1e-3)
        weight = 9.81 * simulation.model.sheet.node_mass.sum()
        assert energies["gravity_work"] == pytest.approx(weight * expected, rel=1e-4)
        assert simulation.frame.tool_reaction[0] == pytest.approx([0.0, 0.0, -weight], rel=1e-4, abs=1e-9)
        depths.append(depth.mean())
        rows.append([f"{1e3 * size:g}", 1e6 * expected, 1e6 * depth.mean(), np.ptp(depth) / expected])
    assert np.log2(depths[0] / depths[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(depths[1] / depths[2]) == pytest.approx(2.0, abs=0.1)
    case.table(["element size [mm]", "expected depth [um]", "depth [um]", "spread over the nodes"], rows)


def pressed_by(shape, cloth, size: float) -> Simulation:
    """A sheet whose edge is held, and a ball that comes 12 mm down into it."""
    blank = Blank.rectangle((-0.04, -0.04), (0.04, 0.04), size, yarn_angle=30.0)
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[blank.boundary_loop(), :3] = False
    simulation = one_sheet_run(
        name="ball", blank=blank, fabric=cloth, free=free, duration=0.1, precision="float64", threads=1, frame_count=5,
        tools=[Tool("ball", shape, Stroke.smooth(-0.012, 0.2, 0.04), friction=0.2)],
        dynamics=Dynamics(damping=100.0, director_damping=100.0),
    )  # fmt: skip
    simulation.run()
    assert abs(simulation.frame.energies["balance_error"]) < 0.01 * simulation.frame.energies["tool_work"]
    return simulation


def ball_meshes(spacing: float) -> dict[str, MeshShape]:
    """The ball as a closed mesh and as an open one, its lower half, that faces the sheet."""
    ball = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
    origin = (0.0, 0.0, RADIUS + 0.5e-3)
    lower = ball.faces[ball.triangles_center[:, 2] < 0.25 * RADIUS]
    options = {"origin": origin, "spacing": spacing, "reach": 0.003}
    return {
        "closed mesh": MeshShape.from_triangles(ball.vertices, ball.faces, **options),
        "open mesh": MeshShape.from_triangles(ball.vertices, lower, side=(0.0, 0.0, -1.0), **options),
    }


@pytest.mark.slow
def test_three_descriptions_of_a_ball_drape_alike(cloth, manual):
    case = manual(
        "Contact", "One ball as analytic distance, closed mesh, and open mesh",
        known="A sheet of 80 mm, held at its edge, and a ball of 20 mm radius pressed 12 mm into it, friction 0.2. "
        "The closed mesh (20,480 facets) is sampled every 0.5 mm, the open one is its lower part with the side of "
        "the sheet given. The drapes may differ by the errors of the distances: facets lie up to 11 um inside the "
        "ball, sampling adds up to h^2/4R = 3 um; the reaction of a stretched sheet follows the depth.",
    )  # fmt: skip
    size = 0.004
    exact = pressed_by(Sphere(RADIUS, origin=(0.0, 0.0, RADIUS + 0.5e-3)), cloth, size)
    lift = np.abs(exact.frame.position[:, 2]).max()
    force = exact.frame.tool_reaction[0, 2]
    assert lift > 0.011
    rows = [["analytic", force, "", ""]]
    for name, shape in ball_meshes(0.0005).items():
        other = pressed_by(shape, cloth, size)
        difference = np.abs(other.frame.position - exact.frame.position).max()
        angle = np.degrees(np.abs(other.frame.fields["shear_angle"] - exact.frame.fields["shear_angle"]).max())
        found = other.frame.tool_reaction[0, 2]
        rows.append([name, found, f"{1e6 * difference:.2g} um", f"{angle:.2g} degrees"])
        assert difference < 25e-6
        assert angle < 0.2
        assert found == pytest.approx(force, rel=0.01)
    case.table(["tool", "reaction [N]", "largest difference of a node", "of a shear angle"], rows)


@pytest.mark.slow
def test_sampled_distance_converges_with_its_spacing(manual):
    case = manual(
        "Contact", "Error of a sampled distance against its spacing",
        known="The error of trilinear samples of a smooth distance falls with the square of their spacing. A ball of "
        "20 mm radius, 20,480 facets; the error is against the exact distance to the facets, at random points up to "
        "1 mm off the surface, and its mean is compared with the error that the tool reports.",
    )  # fmt: skip
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(4000, 3))
    points = direction / np.linalg.norm(direction, axis=1)[:, None] * (RADIUS + rng.uniform(-1e-3, 1e-3, (4000, 1)))
    spacings = (0.002, 0.001, 0.0005)
    rows, means = [], []
    ball = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
    for spacing in spacings:
        shape = MeshShape.from_triangles(ball.vertices, ball.faces, spacing=spacing, reach=0.012)
        error = np.abs(Tool("ball", shape).distance(points)[0] - exact_distance(shape.surface, points))
        means.append(np.sqrt(np.mean(error**2)))
        # curved by 1/R in two directions, the innermost points most; and kinked at the edges of the facets,
        # where linear interpolation errs by a quarter of the kink times the spacing in either direction
        kink = ball.face_adjacency_angles.max()
        assert error.max() < spacing**2 / (4.0 * (RADIUS - 1e-3)) + 0.5 * kink * spacing
        reported = sampled_distance(shape.surface).mean_error
        assert means[-1] == pytest.approx(reported, rel=0.3)
        rows.append([f"{1e3 * spacing:g}", 1e6 * means[-1], 1e6 * error.max(), 1e6 * reported])
    orders = np.log2(np.array(means[:-1]) / means[1:])
    for row, order in zip(rows, ["", *(f"{order:.2f}" for order in orders)], strict=True):
        row.append(order)
    case.table(
        ["spacing [mm]", "root mean square error [um]", "largest [um]", "reported by the tool [um]", "order"], rows
    )
    # at the finest, single precision of the volume and the facets' edges begin to count
    assert orders[0] > 1.7
    assert orders.min() > 1.2


def test_symmetric_press_has_equal_reactions(cloth, manual):
    """Two balls squeeze a free sheet from both sides."""
    case = manual(
        "Contact", "A symmetric press",
        known="Two equal balls squeeze a free sheet from both sides by 50 um each: their reactions are equal and "
        "opposite, the sheet stays in its plane, and each is the penalty stiffness times the depth.",
    )  # fmt: skip
    gap = 0.5 * cloth.thickness + RADIUS
    squeeze = Stroke((0.0, 0.02), (0.0, 5e-5))
    tools = [
        Tool("lower", Sphere(RADIUS, origin=(0.0, 0.0, -gap)), squeeze, friction=0.2),
        Tool("upper", Sphere(RADIUS, origin=(0.0, 0.0, gap)), squeeze, friction=0.2, axis=(0.0, 0.0, -1.0)),
    ]
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, yarn_angle=20.0)
    simulation = one_sheet_run(
        name="press", blank=blank, fabric=cloth, tools=tools, duration=0.05, precision="float64", threads=1,
        frame_count=5, dynamics=Dynamics(damping=50.0), accept_unusual=True,
    )  # fmt: skip
    simulation.run()
    lower, upper = simulation.frame.tool_reaction
    middle = np.linalg.norm(blank.node_position, axis=1) < 1e-9
    expected = float(simulation.model.sheet.contact_stiffness[middle][0]) * 5e-5
    assert lower[2] == pytest.approx(-expected, rel=1e-6)
    assert upper[2] == pytest.approx(expected, rel=1e-6)
    assert np.abs(lower + upper).max() < 1e-9 * expected
    assert np.abs(simulation.frame.position[:, 2]).max() < 1e-12
    case.table(
        ["tool", "expected [N]", "reaction [N]"], [["lower", -expected, lower[2]], ["upper", expected, upper[2]]]
    )
