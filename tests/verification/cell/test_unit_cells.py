"""What every unit cell must do: a new one is tested by being added to ``registered_cells.CELLS``.

A cell stands there beside its energy written once more, in NumPy, from the theory: that alone is what the kernels'
forces, tangents, unknowns and equilibria are compared with.
"""

import math

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from scipy.spatial.transform import Rotation

from tests.support.registered_cells import CELLS, Registered
from tests.support.runs import one_sheet_run
from weavesim.engine.stepper import STEP_SAFETY
from weavesim.fabric.cell import UnitCell
from weavesim.fabric.presets import UNIT_CELLS, assumed_fabric, glass_polypropylene
from weavesim.fabric.response import respond
from weavesim.kernels.rows import MotionRow
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.sheet.blank import Blank

# One of each law: the others share the kernels.
SHELL_CELLS = ("plain-weave", "twill", "stitched-tape", "linear-membrane", "user's net")


@pytest.mark.parametrize("name", ["twill", "satin-5"])
def test_pulled_cells_keep_their_step(name):
    """Where floats go slack a tangent by differences means nothing; the step stays near that of straight yarns."""
    blank = Blank.rectangle((-0.06, -0.06), (0.06, 0.06), 0.01, yarn_angle=30.0)
    x = blank.node_position[:, 0]
    pull = Drive(SmoothStroke.ramped(0.003, 1.5, 0.0005), np.array([1.0, 0.0, 0.0]))
    supports = (
        Support("clamp", np.flatnonzero(x < -0.0599)),
        Support("moving_clamp", np.flatnonzero(x > 0.0599), (pull,)),
    )
    simulation = one_sheet_run(
        name="pulled", blank=blank, fabric=assumed_fabric(name), duration=2e-3, supports=supports,
        precision="float64", lane_count=1, threads=1, frame_count=2,
    )  # fmt: skip
    steps = []
    while simulation.state.time < 2.0e-3:
        simulation.stepper.advance(1)
        steps.append(simulation.state.step)
    assert simulation.ledger.frame(1).fields["warp_stretch"].max() > 1.01
    assert min(steps) > 0.9 * simulation.model.reference_step


def test_every_built_in_cell_is_tested():
    assert set(UNIT_CELLS) <= set(CELLS)


@pytest.fixture(params=CELLS)
def registered(request) -> Registered:
    return CELLS[request.param]


def random_strains(count: int, seed: int = 1, low: float = 0.85, high: float = 1.08) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (n, 2) and angles (n,) up to 50 degrees."""
    rng = np.random.default_rng(seed)
    return rng.uniform(low, high, (count, 2)), rng.uniform(-0.9, 0.9, count)


def forces(response) -> np.ndarray:
    """n_1, n_2, m, (n, 3) [N/m]."""
    return np.column_stack([response.force_per_width, response.moment])


def again(cell, response, stretch, angle):
    """The response next to one that is known."""
    return respond(cell, stretch, angle, increment_count=1, start=response.unknowns)


def differences(cell, response, stretch, angle, change, quantity) -> np.ndarray:
    """Central differences of a quantity by the stretches and the angle, (n, ..., 3)."""
    columns = []
    for k in range(3):
        ends = []
        for sign in (change, -change):
            moved = np.column_stack([stretch, angle])
            moved[:, k] += sign
            ends.append(quantity(again(cell, response, moved[:, :2], moved[:, 2])))
        columns.append((ends[0] - ends[1]) / (2 * change))
    return np.stack(columns, axis=-1)


def size_of(cell: UnitCell) -> float:
    """A force that is small in any state but the ones near rest [N/m]."""
    return 1e-6 * max(cell.yarn_stiffness_per_width)


# --- the cell alone ---------------------------------------------------------------------------------------------------


def test_rest_is_free_of_force(registered):
    response = respond(registered.make(), [1.0, 1.0])
    assert np.abs(forces(response)).max() == 0.0
    assert response.crossover_force[0] == 0.0
    assert np.abs(response.energy).max() == 0.0


@pytest.mark.slow
def test_energy_is_the_reference_energy_at_its_minimum(registered):
    """SciPy minimises the NumPy energy along the same path."""
    cell = registered.make()
    stretch, angle = random_strains(6)
    response = respond(cell, stretch, angle, increment_count=20)
    unit = max(cell.yarn_stiffness_per_width) * 1e-2
    for i in range(len(stretch)):
        q = np.array(cell.initial_unknowns)
        for share in np.linspace(0.05, 1.0, 20) if len(q) else ():
            s, a = 1 + share * (stretch[i] - 1), share * angle[i]
            found = scipy.optimize.minimize(
                lambda x, s=s, a=a: registered.reference(cell, s, a, x * registered.unknown_scale) / unit,
                q / registered.unknown_scale, method="Nelder-Mead" if share < 1 else "Powell",
                options={"xatol": 1e-9, "fatol": 1e-14, "maxiter": 4000} if share < 1 else
                {"xtol": 1e-11, "ftol": 1e-15, "maxiter": 4000},
            )  # fmt: skip
            q = found.x * registered.unknown_scale
        least = registered.reference(cell, stretch[i], angle[i], q)
        there = registered.reference(cell, stretch[i], angle[i], response.unknowns[i])
        assert response.energy[i].sum() == pytest.approx(there, rel=1e-9, abs=1e-9 * unit)
        assert there <= least * (1 + 1e-7) + 1e-9 * unit
        assert least <= there * (1 + 1e-4) + 1e-6 * unit


def test_forces_are_the_derivative_of_the_energy(registered):
    cell = registered.make()
    stretch, angle = random_strains(200)
    response = respond(cell, stretch, angle)
    change = 1e-6
    numerical = differences(cell, response, stretch, angle, change, lambda r: r.energy.sum(axis=1))
    # the difference quotient's own rounding
    rounding = 1e-15 * response.energy.sum(axis=1) / change
    error = np.abs(forces(response) - numerical).max(axis=1) - 10 * rounding
    assert (error / (np.abs(numerical).max(axis=1) + size_of(cell))).max() < 2e-6


def test_tangent_is_the_derivative_of_the_forces(registered):
    cell, change = registered.make(), 1e-6
    stretch, angle = random_strains(200)
    response = respond(cell, stretch, angle)
    here, ends = forces(response), []
    for k in range(3):
        for sign in (change, -change):
            moved = np.column_stack([stretch, angle])
            moved[:, k] += sign
            ends.append((forces(again(cell, response, moved[:, :2], moved[:, 2])) - here) / sign)
    ahead, behind = np.stack(ends[::2], axis=-1), np.stack(ends[1::2], axis=-1)
    scale = np.abs(ahead).max(axis=(1, 2)) + size_of(cell)
    # where a member is just becoming taut there are two derivatives: such states are left out, and are few
    smooth = np.abs(ahead - behind).max(axis=(1, 2)) < 1e-3 * scale
    assert smooth.mean() > 0.95
    error = np.abs(response.tangent - 0.5 * (ahead + behind)).max(axis=(1, 2)) / scale
    assert error[smooth].max() < 1e-5
    assert np.abs(response.tangent - response.tangent.transpose(0, 2, 1)).max() == 0.0


def test_equilibrium_is_reached(registered):
    """The residual that is reported, and the slope of the NumPy energy by every unknown."""
    cell = registered.make()
    stretch, angle = random_strains(40)
    response = respond(cell, stretch, angle)
    assert response.residual.max() < 1e-9
    change, scale = 1e-6, registered.unknown_scale
    for i in range(len(stretch)):
        size = np.abs(forces(response)[i]).max() + 1e-3 * max(cell.yarn_stiffness_per_width)
        for k in range(response.unknowns.shape[1]):
            ends = []
            for sign in (change, -change):
                q = response.unknowns[i].copy()
                q[k] += sign * scale
                ends.append(registered.reference(cell, stretch[i], angle[i], q))
            assert abs(ends[0] - ends[1]) / (2 * change) < 1e-5 * size


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_finite_for_every_strain(registered, precision):
    cell = registered.make()
    axis = np.linspace(0.5, 1.3, 9)
    grid = np.stack(np.meshgrid(axis, axis, np.radians([-60, -25, 0, 25, 60])), axis=-1).reshape(-1, 3)
    response = respond(cell, grid[:, :2], grid[:, 2], precision=precision)
    for name in ("unknowns", "force_per_width", "moment", "energy", "tangent", "crossover_force"):
        assert np.isfinite(getattr(response, name)).all(), name
    assert response.residual.max() < 1e-3
    assert (response.energy >= 0.0).all()


def test_precisions_agree(registered):
    cell = registered.make()
    stretch, angle = random_strains(200)
    single, double = respond(cell, stretch, angle, precision="float32"), respond(cell, stretch, angle)
    # a stretch of one is rounded to 6e-8
    floor = 1e-3 * max(cell.yarn_stiffness_per_width)
    assert (
        np.abs(forces(single) - forces(double)).max(axis=1) / (np.abs(forces(double)).max(axis=1) + floor)
    ).max() < 1e-3


def test_path_is_reversible(registered):
    """A closed path does no work and ends at rest: the built-in cells have one equilibrium."""
    cell = registered.make()
    corners = np.array([[1.0, 1.0, 0.0], [0.9, 1.03, 0.4], [1.04, 0.92, 0.7], [1.02, 1.02, -0.5], [1.0, 1.0, 0.0]])
    path = np.concatenate([np.linspace(a, b, 61)[1:] for a, b in zip(corners[:-1], corners[1:], strict=True)])
    q, before, work, positive, lost = np.array([cell.initial_unknowns]), np.zeros(3), 0.0, 0.0, 0.0
    position = corners[0]
    for point in path:
        response = respond(cell, point[:2], point[2], increment_count=1, start=q)
        here = forces(response)[0]
        step = 0.5 * (before + here) @ (point - position)
        work, positive, lost = work + step, positive + max(step, 0.0), lost + response.snap_loss[0]
        q, before, position = response.unknowns, here, point
    assert np.abs(before).max() < 1e-6 * size_of(cell) * 1e6 * 1e-3
    assert lost == 0.0
    assert abs(work) < 2e-3 * positive


# --- the cell in the shell --------------------------------------------------------------------------------------------


@pytest.fixture(params=SHELL_CELLS)
def shell_cell(request) -> UnitCell:
    return CELLS[request.param].make()


def test_nodal_forces_are_the_derivative_of_the_energy(shell_cell, sheet, fabric, curved_blank, deformed):
    membrane = sheet(curved_blank, fabric(unit_cell=shell_cell))
    position, director = deformed
    force, _ = membrane.forces(position, director)
    names = membrane.simulation.model.sheet.cell_law.energy_names
    rng, change = np.random.default_rng(2), 2e-7
    for node in rng.choice(len(position), 6, replace=False):
        for component in range(3):
            ends = []
            for sign in (change, -change):
                moved = position.copy()
                moved[node, component] += sign
                energies = membrane.energies(moved, director)
                ends.append(sum(energies[name] for name in names))
            numerical = (ends[1] - ends[0]) / (2 * change)
            assert force[node, component] == pytest.approx(numerical, abs=2e-6 * np.abs(force).max())


def test_forces_of_a_sheet_are_those_of_its_cell(shell_cell, sheet, fabric):
    """The fields of a homogeneously deformed sheet against the cell alone; the sheet's own shear law is zero."""
    blank = Blank.rectangle((0.0, 0.0), (0.01, 0.01), 0.005, yarn_angle=30.0)
    yarn = np.column_stack([blank.warp_direction[0], blank.weft_direction[0]])[:2]
    wanted = np.array([[1.01, 0.99 * math.sin(0.4)], [0.0, 0.99 * math.cos(0.4)]])
    position = blank.node_position.copy()
    position[:, :2] = position[:, :2] @ (wanted @ np.linalg.inv(yarn)).T
    patch = sheet(blank, fabric(unit_cell=shell_cell))
    patch.place(position, blank.initial_director)
    fields = patch.simulation.ledger.frame(0).fields
    assert ("crossover_force" in fields) == (shell_cell.crossover_area > 0.0)
    fields["crossover_force"] = fields["crossover_pressure"] * shell_cell.crossover_area
    alone = respond(shell_cell, [1.01, 0.99], 0.4)
    expected = [*alone.force_per_width[0], alone.moment[0], alone.crossover_force[0]]
    for name, value in zip(("warp_force", "weft_force", "shear_moment", "crossover_force"), expected, strict=True):
        assert fields[name] == pytest.approx(value, rel=1e-6, abs=size_of(shell_cell)), name


def test_rigid_motion_gives_no_force(shell_cell, sheet, fabric, curved_blank, deformed):
    membrane = sheet(curved_blank, fabric(unit_cell=shell_cell))
    rotation = Rotation.from_rotvec([1.1, -2.0, 0.7]).as_matrix()
    moved = curved_blank.node_position @ rotation.T + [0.3, -0.2, 0.5]
    force, _ = membrane.forces(moved, curved_blank.initial_director @ rotation.T)
    typical, _ = membrane.forces(*deformed)
    assert np.abs(force).max() < 1e-9 * np.abs(typical).max()


def test_resultant_and_moment_vanish(shell_cell, sheet, fabric, curved_blank, deformed):
    position, director = deformed
    force, _ = sheet(curved_blank, fabric(unit_cell=shell_cell)).forces(position, director)
    moment = np.cross(position, force)
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()
    assert np.abs(moment.sum(axis=0)).max() < 1e-12 * np.abs(moment).sum()


def test_time_step_is_below_the_limit(shell_cell, sheet, fabric, manual):
    """Against the highest frequency of the finite-difference tangent, for a sheet that is a membrane only."""
    case = manual(
        "Unit cell", f"Stable step of a membrane: {type(shell_cell).__name__}",
        known=r"$2/\omega_{\max}$ of the sheet's tangent, from differences of the nodal forces and with lumped masses",
    )  # fmt: skip
    blank = Blank.rectangle((0.0, 0.0), (0.015, 0.015), 0.005, yarn_angle=10.0)
    patch = sheet(blank, fabric(unit_cell=shell_cell))
    yarn = np.column_stack([blank.warp_direction[0], blank.weft_direction[0]])[:2]
    model = patch.simulation.model.sheet
    mass = np.column_stack([np.tile(model.node_mass, (3, 1)).T, np.tile(model.node_inertia, (2, 1)).T]).ravel()
    root, rows = 1.0 / np.sqrt(mass), []
    for warp, weft, angle in ((1.0, 1.0, 0.0), (1.004, 1.003, 0.0), (1.006, 1.004, 0.5), (1.02, 0.98, 0.3)):
        wanted = np.array([[warp, weft * math.sin(angle)], [0.0, weft * math.cos(angle)]])
        position = blank.node_position.copy()
        position[:, :2] = position[:, :2] @ (wanted @ np.linalg.inv(yarn)).T
        stiffness = patch.stiffness(position, blank.initial_director, 1e-7)
        squared = scipy.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * np.outer(root, root))[-1]
        patch.place(position, blank.initial_director)
        patch.simulation.stepper.evaluate()
        patch.simulation.stepper.refresh_step()
        ratio = patch.simulation.stepper.stable_step() / STEP_SAFETY / (2.0 / math.sqrt(squared))
        assert ratio <= 1.0
        # slack yarns are taken as pulled
        assert ratio >= (0.6 if min(warp, weft) > 1.0 else 0.4)
        rows.append([warp, weft, math.degrees(angle), ratio])
    case.table(["warp stretch", "weft stretch", "shear angle [degrees]", "estimate over the limit"], rows)


def test_thrown_sheet_keeps_momentum_and_energy(shell_cell):
    """Free flight of a whole fabric with this cell.

    The kinetic energy is half a step older than the elastic one: a small step keeps the balance from swinging.
    """
    flat = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, yarn_angle=15.0, distortion=0.2)
    x, y, _ = flat.node_position.T
    # slightly curved, with a linear law: kernels that the tests above have too
    blank = Blank.from_mesh(np.column_stack([x, y, 2.0 * x * y]), flat.quads, yarn_angle=15.0)
    rng = np.random.default_rng(0)
    velocity = 0.3 * rng.normal(size=blank.node_position.shape)
    velocity[:, 0] += 20.0 * blank.node_position[:, 1]
    # in-plane bending takes the angles from the step before, and books what that costs: not what is tested here
    laws = {"unit_cell": shell_cell, "in_plane_bending_stiffness": 0.0}
    fabric = glass_polypropylene().with_linear_shear(5.0e4).model_copy(update=laws)
    settings = {"name": "thrown", "blank": blank, "fabric": fabric}
    settings |= {"duration": 5e-4, "precision": "float64", "lane_count": 1, "threads": 1}
    step = 0.1 * one_sheet_run(**settings).model.reference_step
    simulation = one_sheet_run(**settings, initial_velocity=velocity, frame_count=40, time_step=step)
    mass = simulation.model.sheet.node_mass[:, None]
    before = (mass * velocity).sum(axis=0)
    simulation.run()
    after = (
        mass
        * simulation.model.sheet.read_motion(simulation.state.sheet.motion)[
            MotionRow.velocity.vector, : blank.node_count
        ]
    ).sum(axis=0)
    assert np.abs(after - before).max() < 1e-12 * np.abs(mass * velocity).sum()
    energies = simulation.frame.energies
    assert energies["internal"] > 0.05 * energies["initial_kinetic"]
    assert energies["snap_loss"] == 0.0
    errors = np.array([entry["balance_error"] for entry in simulation.history]) / energies["initial_kinetic"]
    assert np.abs(errors).max() < 0.02
    assert abs(errors[-10:].mean()) < 1e-3
    assert simulation.summary()["unit_cell_max_residual"] < 1e-9


@pytest.mark.slow
def test_lanes_and_precisions_agree_in_the_shell(sheet, fabric, curved_blank, deformed):
    """Sixteen lanes of single precision, as a run on a CPU has them, against one of double precision."""
    laws = fabric(unit_cell=CELLS["twill"].make())
    exact, _ = sheet(curved_blank, laws).forces(*deformed)
    single, _ = sheet(curved_blank, laws, precision="float32", lane_count=16).forces(*deformed)
    assert np.abs(single - exact).max() < 1e-4 * np.abs(exact).max()
