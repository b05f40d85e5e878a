"""Shear and bending with a history: loops against the law's own path, what they lose against work minus energy."""

import math

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import MomentCurve, ShearFriction
from weavesim.fabric.weaves import PlainWeave
from weavesim.kernels.rows import SLIP_ROWS
from weavesim.run.ledger import LOST
from weavesim.sheet.blank import Blank

SQUARE = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.05)
UP = np.tile([0.0, 0.0, 1.0], (SQUARE.node_count, 1))
CURVE = MomentCurve(angle=(0.0, 0.2, 0.5, 1.0), moment_values=(0.0, 3.0, 5.0, 20.0))
FRICTION = ShearFriction(stiffness=60.0, angle=(0.0, 0.8), limit=(1.5, 3.0))


def sheared(angle: float, stretch: float = 1.0) -> np.ndarray:
    """Positions of the square with unit warp and weft vectors at 90 degrees minus ``angle``."""
    gradient = stretch * np.array([[1.0, math.sin(angle), 0.0], [0.0, math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return SQUARE.node_position @ gradient.T


def rolled(curvature: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and directors of the square, bent along x into an arc of the curvature [1/m], chords kept."""
    x, y, _ = SQUARE.node_position.T
    size = np.ptp(x) / 2.0
    turn = curvature * x
    # nodes at equal chords of the element size, so that neither stretch nor transverse shear changes
    steps = np.unique(np.round(x / size).astype(int))
    middle = curvature * size * (steps[1:] - 0.5)
    along = np.concatenate([[0.0], np.cumsum(size * np.cos(middle))])
    height = np.concatenate([[0.0], np.cumsum(size * np.sin(middle))])
    index = np.round(x / size).astype(int)
    director = np.column_stack([-np.sin(turn), np.zeros_like(x), np.cos(turn)])
    return np.column_stack([along[index], y, height[index]]), director


def walk(shell, states) -> list[dict[str, float]]:
    """The ledger along a path of (position, director), with the work done on the nodes; histories are kept."""
    entries, work, last = [], 0.0, None
    for position, director in states:
        force, conjugate = shell.forces(position, director, fresh=last is None)
        if last is not None:
            moved, turned = position - last[0], director - last[1]
            work -= 0.5 * float(((force + last[2]) * moved).sum() + ((conjugate + last[3]) * turned).sum())
        last = (position, director, force, conjugate)
        frame = shell.simulation.ledger.frame(0)
        entries.append(frame.energies | {"work": work, "fields": frame.fields})
    return entries


def cycle(largest: float, count: int) -> np.ndarray:
    """0, up, down to the opposite, and back to 0."""
    corners = [0.0, largest, -largest, 0.0]
    return np.concatenate(
        [[0.0], *(np.linspace(a, b, count + 1)[1:] for a, b in zip(corners, corners[1:], strict=False))]
    )


def test_shear_loop_is_the_laws_own_path_and_books_what_it_loses(sheet, fabric, manual):
    shell = sheet(SQUARE, fabric(shear=CURVE, shear_friction=FRICTION))
    path = cycle(0.7, 150)
    entries = walk(shell, [(sheared(angle), UP) for angle in path])
    moment = np.array([entry["fields"]["shear_moment"][0] for entry in entries])
    expected = CURVE.moment(path) + FRICTION.moment_along(path)
    assert np.abs(moment - expected).max() < 1e-4 * np.abs(expected).max()
    lost, stored = entries[-1]["shear_friction_loss"], entries[-1]["shear"]
    area = 0.01
    loop = area * np.trapezoid(expected, path)
    assert lost + stored == pytest.approx(loop, rel=2e-3)
    assert lost + stored == pytest.approx(entries[-1]["work"], rel=2e-3)
    assert shell.simulation.state.slip.numpy()[SLIP_ROWS.index("shear_spring"), 0] != 0.0
    assert lost > 0.5 * entries[150]["shear"]
    case = manual(
        "Shear", "Unloading hysteresis of a homogeneous sheet",
        known="the law's own path on the host (`ShearFriction.moment_along`), and the area of its loop",
    )  # fmt: skip
    case.table(
        ["quantity", "known", "weavesim"],
        [
            ["largest moment [N/m]", expected.max(), moment.max()],
            ["moment back at zero angle [N/m]", expected[-1], moment[-1]],
            ["lost and stored in the loop [J]", loop, lost + stored],
        ],
    )
    case.figure(loop_figure(np.degrees(path), expected, moment, "shear angle [°]", "moment per area [N/m]"))


def loop_figure(x, expected, found, x_label, y_label):
    """Known and computed loop."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 2.8))
    axes = figure.add_subplot()
    axes.plot(x, expected, "k-", lw=2.5, alpha=0.3, label="known")
    axes.plot(x, found, "tab:blue", lw=1.0, label="weavesim")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.legend(fontsize=7)
    axes.grid(lw=0.3)
    return figure


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_looking_twice_is_no_slip(precision, sheet, fabric):
    shell = sheet(SQUARE, fabric(shear=CURVE, shear_friction=FRICTION), precision=precision)
    walk(shell, [(sheared(angle), UP) for angle in (0.0, 0.3, 0.1, 0.2)])
    before = shell.simulation.state.slip.numpy().copy()
    assert np.abs(before[0]).max() > 0.01
    shell.simulation.stepper.evaluate()
    assert np.array_equal(before, shell.simulation.state.slip.numpy())


def test_yarn_tension_raises_the_resistance_to_shear(sheet, fabric, manual):
    """Crimped yarns under equal stretch press on each other; the friction of the crossovers takes that pressure."""
    cell = glass_polypropylene().unit_cell
    length = 1.7e-4  # friction 0.2 on a round patch of radius 1.3 mm
    friction = ShearFriction(stiffness=3000.0, limit=(0.2,), crossover_friction_length=length)
    shell = sheet(SQUARE, fabric(unit_cell=cell, shear=CURVE, shear_friction=friction))
    path = np.linspace(0.0, 0.5, 200)
    rows, resistance = [], []
    for stretch in (1.0, 1.0005, 1.001, 1.002):
        entries = walk(shell, [(sheared(angle, stretch), UP) for angle in path])
        fields = entries[-1]["fields"]
        # a crossover has four quarters of L_1 x L_2
        area = 4.0 * cell.warp_half_spacing * cell.weft_half_spacing
        pressure = fields["crossover_force"][0] / area
        expected = CURVE.moment(path[-1]) + 0.2 + length * max(pressure, 0.0)
        assert fields["shear_moment"][0] == pytest.approx(expected, rel=1e-6)
        resistance.append(fields["shear_moment"][0])
        rows.append([f"{stretch:.4f}", fields["warp_force"][0], fields["crossover_force"][0], expected, resistance[-1]])
        stored = entries[-1]["internal"] - entries[0]["internal"]
        assert entries[-1]["shear_friction_loss"] + stored == pytest.approx(entries[-1]["work"], rel=5e-3)
    assert np.all(np.diff(resistance) > 0.0)
    assert resistance[-1] > 1.5 * resistance[0]
    manual(
        "Shear", "Tension-shear coupling of a homogeneous sheet",
        known="elastic moment + limit + crossover friction length × crossover force per area of a crossover",
    ).table(
        ["yarn stretch", "yarn force [N/m]", "crossover force [N]", "known moment at 28.6° [N/m]", "weavesim"], rows
    )  # fmt: skip


@pytest.mark.parametrize("step_count", [1, 10])
def test_yarns_that_slacken_lose_what_their_friction_held(step_count, sheet, fabric):
    """The limit falls with the tension, at one angle: all that leaves the spring is lost, however fast."""
    friction = ShearFriction(stiffness=3000.0, limit=(0.2,), crossover_friction_length=1.7e-4)
    shell = sheet(SQUARE, fabric(unit_cell=glass_polypropylene().unit_cell, shear=CURVE, shear_friction=friction))
    loading = [sheared(angle, 1.002) for angle in np.linspace(0.0, 0.3, 60)]
    release = [sheared(0.3, stretch) for stretch in np.linspace(1.002, 1.0, step_count + 1)[1:]]
    entries = walk(shell, [(position, UP) for position in [*loading, *release]])
    held, freed = entries[59], entries[-1]
    given_up = held["shear"] - freed["shear"]
    assert given_up > 1e-7
    lost = freed["shear_friction_loss"] - held["shear_friction_loss"]
    assert lost == pytest.approx(given_up, rel=1e-6)


def test_bending_loop_follows_the_curve_and_books_what_it_loses(sheet, fabric, manual):
    """Softening and hysteresis of one family; the other family and the membrane stay silent."""
    law = BendingCurve(
        curvature=(0.0, 2.0, 5.0, 15.0), moment_values=(0.0, 0.03, 0.05, 0.07), friction_limit=0.01,
        friction_stiffness=0.02,
    )  # fmt: skip
    shell = sheet(SQUARE, fabric(bending=YarnBending(warp=law, weft=1e-3, twist=1e-3)))
    path = cycle(4.0, 100)
    entries = walk(shell, [rolled(curvature) for curvature in path])
    friction, slip = np.empty_like(path), 0.0
    # the curvature that one element sees between two directors: a chord of the arc
    size = 0.05
    seen = 2.0 / size * np.sin(0.5 * path * size)
    for i, kappa in enumerate(seen):
        slip = kappa - np.clip(kappa - slip, -law.friction_limit / 0.02, law.friction_limit / 0.02)
        friction[i] = 0.02 * (kappa - slip)
    expected = law.moment(seen) + friction
    area = 0.01
    work = np.array([entry["work"] for entry in entries])
    found = np.gradient(work, seen, edge_order=1)[[30, 99, 130, 199, 250]] / area
    assert found == pytest.approx(expected[[30, 99, 130, 199, 250]], rel=0.03, abs=3e-4)
    lost, stored = entries[-1]["bending_friction_loss"], entries[-1]["bending"]
    assert lost + stored == pytest.approx(area * np.trapezoid(expected, seen), rel=5e-3)
    assert lost + stored == pytest.approx(work[-1], rel=5e-3)
    assert entries[-1]["shear_friction_loss"] == 0.0
    case = manual(
        "Bending", "Softening and hysteresis of one yarn family",
        known="the moment-curvature table plus a spring-slider followed on the host, and the area of its loop",
    )  # fmt: skip
    case.table(
        ["quantity", "known", "weavesim"],
        [["lost and stored in the loop [J]", area * np.trapezoid(expected, seen), lost + stored]],
    )
    moving = np.flatnonzero(np.abs(np.diff(seen)) > 0.0)
    rate = np.diff(work)[moving] / np.diff(seen)[moving] / area
    case.figure(loop_figure(seen[moving], expected[moving], rate, "curvature [1/m]", "moment per width [N]"))


def test_kawabata_numbers_come_back():
    """B and 2HB: slope and height of the loop, measured on the law as the tester does, between 0.5 and 1.5 /cm."""
    law = BendingCurve.from_kawabata(rigidity=8e-6, hysteresis=6e-4, slip_curvature=10.0)
    path = np.concatenate([np.linspace(0.0, 250.0, 500), np.linspace(250.0, -250.0, 1000)])
    spring, slip, moments = law.friction_stiffness, 0.0, []
    for kappa in path:
        slip = kappa - np.clip(kappa - slip, -law.friction_limit / spring, law.friction_limit / spring)
        moments.append(float(law.moment(np.array(kappa))) + spring * (kappa - slip))
    up, down = (
        np.interp([50.0, 150.0], path[:500], moments[:500]),
        np.interp([50.0, 150.0], path[500:][::-1], moments[500:][::-1]),
    )
    assert (up[1] - up[0]) / 100.0 == pytest.approx(8e-6, rel=1e-3)
    assert up - down == pytest.approx(6e-4, rel=1e-3)


def test_balance_is_closed_in_a_run_with_friction_inside():
    """A thrown sheet: what the yarns rub away is missing from the vibration, and nothing else is."""

    blank = Blank.rectangle((-0.02, -0.015), (0.02, 0.015), 0.005, yarn_angle=20.0, distortion=0.2)
    straight = PlainWeave.straight(stiffness_per_width=2.0e5)
    rubbing = BendingCurve.from_kawabata(rigidity=3e-3, hysteresis=2e-2, slip_curvature=2.0)
    fabric = glass_polypropylene().model_copy(
        update={
            "unit_cell": straight, "shear": CURVE, "in_plane_bending_stiffness": 0.0,
            "shear_friction": ShearFriction(stiffness=3000.0, limit=(20.0,)),
            "bending": YarnBending(warp=rubbing, weft=rubbing, twist=1e-3),
        }
    )  # fmt: skip
    x, y, _ = blank.node_position.T
    waves = np.column_stack([np.sin(100.0 * y), np.cos(120.0 * x), np.sin(150.0 * x) + np.cos(90.0 * y)])
    simulation = one_sheet_run(
        name="rubbing", blank=blank, fabric=fabric, duration=5e-3, initial_velocity=3.0 * waves, precision="float64",
        lane_count=1, threads=1, frame_count=20,
    )  # fmt: skip
    simulation.run()
    energies = simulation.frame.energies
    assert simulation.stepper.step_count > 500
    for name in ("shear_friction_loss", "bending_friction_loss"):
        assert energies[name] > 0.02 * energies["initial_kinetic"], name
    assert sum(energies[name] for name in LOST) > 0.1 * energies["initial_kinetic"]
    error = np.array([entry["balance_error"] for entry in simulation.history]) / energies["initial_kinetic"]
    assert np.abs(error).max() < 0.02


def test_picture_frame_conventions_agree():
    """One test, three ways to write it down: raw force, force per side of the frame, force per area of the fabric."""
    law = MomentCurve(
        angle=tuple(np.linspace(0.0, 0.8, 30)), moment_values=tuple(np.linspace(0.0, 0.8, 30) ** 2 * 50.0)
    )
    angle, frame, specimen = np.linspace(0.0, 0.8, 30), 0.25, 0.2
    moment = law.moment(angle)
    half_angle = 0.25 * np.pi - 0.5 * angle
    force = specimen**2 * moment / (frame * np.sin(half_angle))
    # the power of the machine, by differences of the diagonal
    diagonal = 2.0 * frame * np.cos(half_angle)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(diagonal))])
    assert work[-1] == pytest.approx(specimen**2 * np.trapezoid(moment, angle), rel=2e-3)
    side_force = force / (2.0 * np.cos(half_angle))
    readings = (
        MomentCurve.from_picture_frame(angle, force, frame_side=frame, fabric_side=specimen),
        MomentCurve.from_normalised_force(
            angle, side_force / frame, convention="frame side", frame_side=frame, fabric_side=specimen
        ),
        MomentCurve.from_normalised_force(angle, side_force * frame / specimen**2, convention="fabric area"),
    )
    for reading in readings:
        assert reading.moment(angle) == pytest.approx(moment, rel=1e-12)
