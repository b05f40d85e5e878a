"""Shear with a history: loops against the law's own path, what they lose against work minus energy."""

import numpy as np
import pytest

from tests.support.loops import FRICTION, SQUARE, UP, cycle, loop_figure, sheared, walk
from tests.support.registered_laws import CURVE
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import ShearFriction
from weavesim.kernels.rows import SlipRow


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
    assert shell.simulation.state.sheet.slip.numpy()[SlipRow.shear_spring, 0] != 0.0
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


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_looking_twice_is_no_slip(precision, sheet, fabric):
    shell = sheet(SQUARE, fabric(shear=CURVE, shear_friction=FRICTION), precision=precision)
    walk(shell, [(sheared(angle), UP) for angle in (0.0, 0.3, 0.1, 0.2)])
    before = shell.simulation.state.sheet.slip.numpy().copy()
    assert np.abs(before[0]).max() > 0.01
    shell.simulation.stepper.evaluate()
    assert np.array_equal(before, shell.simulation.state.sheet.slip.numpy())


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
