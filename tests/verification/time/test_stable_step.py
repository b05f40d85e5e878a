"""The time step: below the true limit, not far below it, and what happens beyond it."""

import numpy as np
import pytest
import scipy.linalg

from tests.support.runs import one_sheet_run
from weavesim.engine.stepper import STEP_SAFETY
from weavesim.errors import InputError
from weavesim.fabric.bending import IsotropicBending, YarnBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LinearShear, MomentCurve
from weavesim.kernels.rows import MotionRow
from weavesim.sheet.blank import Blank


def plate(fabric, **given):
    """Linear in every term, so that the tangent at rest is the tangent for any small motion."""
    values = {
        "unit_cell": PlainWeave.straight(stiffness_per_width=2.0e4), "shear": LinearShear(modulus=2.0e6),
        "bending": IsotropicBending(modulus=3.0e7, poisson_ratio=0.3), "transverse_shear_modulus": 5.0e6,
        "stabilisation": Stabilisation(),
    }  # fmt: skip
    return fabric(**(values | given))


def highest_frequency(sheet, position, director) -> float:
    """Largest angular frequency of the finite-difference tangent with the lumped masses [rad/s]."""
    stiffness = sheet.stiffness(position, director, 1e-7)
    model = sheet.simulation.model.sheet
    mass = np.column_stack([np.tile(model.node_mass, (3, 1)).T, np.tile(model.node_inertia, (2, 1)).T]).ravel()
    root = 1.0 / np.sqrt(mass)
    return float(np.sqrt(scipy.linalg.eigvalsh(0.5 * (stiffness + stiffness.T) * np.outer(root, root))[-1]))


def estimate(sheet) -> float:
    """The limit that the run would take for the present state, without its safety [s]."""
    stepper = sheet.simulation.stepper
    stepper.refresh_step()
    return stepper.stable_step() / STEP_SAFETY


PATCHES = {
    "square": {"element_size": 0.005},
    "turned yarns": {"element_size": 0.005, "yarn_angle": 33.0},
    "distorted": {"element_size": 0.005, "yarn_angle": 20.0, "distortion": 0.2},
    "oblong": {"element_size": (0.005, 0.01), "yarn_angle": 10.0},
}
FABRICS = {
    "membrane governs": {},
    "shear governs": {"shear": LinearShear(modulus=8.0e7)},
    "transverse shear is stiff": {"transverse_shear_modulus": 2.0e7},
    "thick": {"bending": IsotropicBending(modulus=5.0e9, poisson_ratio=0.3)},
    "yarn bending": {"bending": YarnBending(warp=0.05, weft=0.01, twist=0.005)},
    "in-plane bending": {"in_plane_bending_stiffness": 0.05},
    "stabilisation is stiff": {"stabilisation": Stabilisation(in_plane=1.0, warping=1.0, director=1.0)},
}


@pytest.mark.parametrize("patch", PATCHES)
@pytest.mark.parametrize("name", FABRICS)
def test_estimate_is_a_sharp_bound_at_rest(patch, name, sheet, fabric):
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), **PATCHES[patch])
    patch = sheet(blank, plate(fabric, **FABRICS[name]))
    limit = 2.0 / highest_frequency(patch, blank.node_position, blank.initial_director)
    patch.place(blank.node_position, blank.initial_director)
    assert 0.6 * limit <= estimate(patch) <= limit


LOCKING = MomentCurve(
    angle=(0.0, 0.2, 0.5, 1.0), moment_values=(0.0, 30.0, 50.0, 200.0), locking_angle=0.6, locking_width=0.1,
    locking_stiffness=1500.0,
)  # fmt: skip
# yarn strain up to, shear angle up to [rad], curvature up to [1/m], random shift of nodes and directors up to
STATES = {
    "taut": (0.02, 0.0, 0.0, 0.0),
    "sheared": (0.02, 0.8, 0.0, 0.0),
    "bent": (0.02, 0.0, 50.0, 0.0),
    "sheared and bent": (0.02, 0.8, 50.0, 0.0),
    "crumpled": (0.10, 0.9, 300.0, 0.3),
}


def random_state(blank, rng, strain, shear, curvature, noise):
    """Positions and directors of a sheet that is stretched along its yarns, sheared, and bent to a cylinder."""
    stretch, angle = 1.0 + rng.uniform(0.0, strain, 2), rng.uniform(-shear, shear)
    yarn = np.column_stack([blank.warp_direction[0], blank.weft_direction[0]])[:2]
    image = np.array([[stretch[0], stretch[1] * np.sin(angle)], [0.0, stretch[1] * np.cos(angle)]])
    plan = blank.node_position[:, :2] @ (image @ np.linalg.inv(yarn)).T
    k, turn = rng.uniform(-curvature, curvature) + 1e-9, rng.uniform(0.0, np.pi)
    around, along = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    s, across = plan @ around, plan @ along
    position = np.column_stack([np.outer(np.sin(k * s) / k, around) + np.outer(across, along), (np.cos(k * s) - 1) / k])
    director = np.column_stack([np.outer(np.sin(k * s), around), np.cos(k * s)])
    position += noise * 0.005 * rng.normal(size=position.shape)
    director += noise * rng.normal(size=director.shape)
    return position, director / np.linalg.norm(director, axis=1)[:, None]


def share_of_limit(sheet, laws, blank, state) -> float:
    """Estimate over the limit 2/omega_max of the tangent that differences of the forces give."""
    patch = sheet(blank, laws)
    limit = 2.0 / highest_frequency(patch, *state)
    patch.place(*state)
    patch.simulation.stepper.evaluate()
    return estimate(patch) / limit


def random_shares(sheet, fabric, state, count, seed) -> dict[str, list[float]]:
    """Shares of the limit for ``count`` random states of a kind, for every fabric and the preset."""
    laws = {name: plate(fabric, **given) for name, given in FABRICS.items()}
    laws |= {"locking": plate(fabric, shear=LOCKING), "preset": glass_polypropylene()}
    rng = np.random.default_rng(seed)
    result = {}
    for name, law in laws.items():
        result[name] = []
        for _ in range(count):
            blank = Blank.rectangle(
                (0.0, 0.0), (0.015, 0.015), 0.005, yarn_angle=rng.uniform(0.0, 45.0), distortion=rng.choice([0.0, 0.2])
            )
            result[name].append(share_of_limit(sheet, law, blank, random_state(blank, rng, *STATES[state])))
    return result


def check_shares(shares: dict[str, list[float]], state: str) -> None:
    for name, values in shares.items():
        # looser for a plate that bends twenty times harder than its membrane would let it; a crumpled ball is asked
        # for stability alone
        least = 0.0 if state == "crumpled" else 0.35 if name == "thick" and "bent" in state else 0.6
        assert least <= min(values) <= max(values) <= 1.0, (name, values)


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES)
def test_estimate_is_a_bound_for_deformed_sheets(state, sheet, fabric):
    check_shares(random_shares(sheet, fabric, state, 1, 7), state)


@pytest.mark.verification
def test_estimate_over_many_states(sheet, fabric, manual):
    case = manual(
        "Energy and time step", "Estimate of the stable step over the true limit",
        known="2/omega_max of the assembled tangent (differences of the forces, lumped masses): the estimate may never "
        "be above it, and should not be below 0.6 of it for taut, sheared and bent sheets. 3 x 3 elements of 5 mm, "
        "regular and distorted, yarns at any angle; curvature radii down to 20 mm at a thickness of 1 mm. *Thick* has "
        "twenty times the bending stiffness that its membrane would give; *crumpled* is noise of 30 %.",
    )  # fmt: skip
    rows = {}
    for state in STATES:
        shares = random_shares(sheet, fabric, state, 12, 11)
        check_shares(shares, state)
        for name, values in shares.items():
            rows.setdefault(name, [name]).append(f"{min(values):.2f} to {max(values):.2f}")
    case.table(["fabric", *STATES], list(rows.values()))


@pytest.mark.parametrize("stretch", [(1.004, 1.003), (1.02, 1.0), (1.01, 0.97)], ids=str)
@pytest.mark.parametrize("shear", [0.0, 0.5])
def test_estimate_is_a_bound_for_crimped_yarns(stretch, shear, sheet):
    """The preset, stretched and sheared: the cell's own tangent, tension and the moment curve count."""
    blank = Blank.rectangle((0.0, 0.0), (0.015, 0.015), 0.005)
    patch = sheet(blank, glass_polypropylene())
    position = blank.node_position.copy()
    position[:, :2] *= stretch
    position[:, 0] += shear * position[:, 1]
    position[:, :2] /= 1.0, np.hypot(1.0, shear)  # the weft keeps its length
    limit = 2.0 / highest_frequency(patch, position, blank.initial_director)
    patch.place(position, blank.initial_director)
    patch.simulation.stepper.evaluate()
    found = estimate(patch)
    assert 0.6 * limit <= found <= limit


def swing(fabric, step: float | None, limit: float) -> np.ndarray:
    """Largest displacement after every block of steps of a plate with a tiny random velocity."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005, yarn_angle=20.0, distortion=0.2)
    velocity = 1e-6 * np.random.default_rng(0).normal(size=blank.node_position.shape)
    simulation = one_sheet_run(
        name="swing", blank=blank, fabric=fabric, duration=1.0, initial_velocity=velocity, precision="float64",
        lane_count=1, threads=1, accept_unusual=True,
    )  # fmt: skip
    result = []
    for _ in range(20):
        # the step is computed again after each block: restore ours
        simulation.state.clock.assign(np.array([0.0, step * limit, step * limit]))
        simulation.stepper.advance(1)
        position = simulation.model.sheet.read_motion(simulation.state.sheet.motion)[
            MotionRow.position.vector, : blank.node_count
        ]
        result.append(np.abs(position - blank.node_position).max())
    return np.array(result)


def test_limit_is_where_the_run_blows_up(sheet, fabric, manual):
    laws = plate(fabric)
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005, yarn_angle=20.0, distortion=0.2)
    limit = 2.0 / highest_frequency(sheet(blank, laws), blank.node_position, blank.initial_director)
    case = manual(
        "Energy and time step", "Beyond the limit",
        known="Central differences are stable up to 2/omega_max. A plate of 4 x 4 distorted elements, linear in every "
        "term, with a random velocity of 1 um/s; omega_max from the assembled tangent.",
    )  # fmt: skip
    quiet, loud = swing(laws, 0.99, limit), swing(laws, 1.1, limit)
    assert np.isfinite(quiet).all()
    assert quiet[-1] < 1e-6
    assert not (loud[:5] < 1e-4).all()
    case.table(
        ["step over the limit", "largest displacement after 20 steps [m]", "after 100 steps [m]"],
        [[0.99, quiet[0], quiet[4]], [1.1, loud[0], loud[4]]],
    )


def test_step_follows_the_fabric_through_a_run():
    """Crimped yarns are softer at rest than straight ones, and the step stays below the estimate of every state."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    velocity = np.zeros_like(blank.node_position)
    velocity[:, 0] = 200.0 * (blank.node_position[:, 0] - 0.01)
    simulation = one_sheet_run(
        name="pull", blank=blank, fabric=glass_polypropylene(), duration=2e-4, initial_velocity=velocity,
        precision="float64", lane_count=1, threads=1,
    )  # fmt: skip
    for _ in range(20):
        simulation.stepper.advance(1)
        assert simulation.state.step <= simulation.stepper.stable_step() * (1.0 + 1e-12)
    straight = simulation.model.reference_step
    assert simulation.state.step > 0.7 * straight


def test_unstable_step_is_refused_without_yarn_bending(fabric):
    """Straight yarns without bending stiffness: nothing holds their height, the tangent must still be a number."""
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    settings = {"name": "step", "blank": blank, "fabric": plate(fabric), "duration": 1e-5}
    settings |= {"precision": "float64", "lane_count": 1, "threads": 1}
    stable = one_sheet_run(**settings).stepper.stable_step()
    assert np.isfinite(stable)
    with pytest.raises(InputError, match="unstable"):
        one_sheet_run(**settings, time_step=2.0 * stable)


def test_mass_scaling_reaches_its_step_and_reports_the_mass():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005, yarn_angle=20.0, distortion=0.2)
    settings = {"name": "mass", "blank": blank, "fabric": glass_polypropylene(), "duration": 1e-5}
    settings |= {"precision": "float64", "lane_count": 1, "threads": 1}
    plain = one_sheet_run(**settings)
    assert plain.model.sheet.added_mass_ratio == 0.0
    assert plain.model.sheet.node_mass.sum() == pytest.approx(0.743 * 0.02**2, rel=1e-12)
    target = 1.5 * plain.model.reference_step
    scaled = one_sheet_run(**settings, target_step=target)
    assert scaled.model.reference_step >= target * (1.0 - 1e-9)
    assert scaled.stepper.stable_step() >= 0.9 * target
    ratio = scaled.model.sheet.added_mass_ratio
    assert 0.1 < ratio < 1.5**2
    scaled.run()
    assert scaled.summary()["added_mass_ratio"] == ratio
    assert scaled.model.sheet.node_mass.sum() == pytest.approx(
        (1.0 + ratio) * plain.model.sheet.node_mass.sum(), rel=1e-12
    )
    # only small elements get mass: a coarse target leaves all as it is
    assert one_sheet_run(**settings, target_step=0.5 * plain.model.reference_step).model.sheet.added_mass_ratio == 0.0
