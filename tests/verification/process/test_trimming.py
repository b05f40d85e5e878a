"""A sheet is trimmed while it is strained: what stays moves as the smaller sheet would, and the ledger closes."""

import numpy as np
import pytest

from weavesim.engine.model import Model
from weavesim.engine.setup import Setup, Solver
from weavesim.engine.state import State
from weavesim.engine.stepper import Stepper
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.kernels.rows import MotionRow
from weavesim.process.dynamics import Dynamics
from weavesim.process.stages import AtRest, Stage
from weavesim.process.strokes import SmoothStroke, Stroke
from weavesim.process.supports import Drive, Support
from weavesim.process.trims import Trim
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools import Sphere
from weavesim.tools.tool import Tool

LENGTH, WIDTH, SIZE = 0.1, 0.04, 0.005
THICKNESS = 5.0e-4
PULL, REST = 5.0e-3, 5.0e-3
STRETCH = 1.0e-3
CUT = 0.061
BEFORE = [(-1.0, -1.0), (CUT, -1.0), (CUT, 1.0), (-1.0, 1.0)]


@pytest.fixture
def strip(fabric):
    return fabric(
        areal_density=0.5, thickness=THICKNESS, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=1.0e8), transverse_shear_modulus=1.0e6,
    )  # fmt: skip


def pulled(blank, strip, stages, right):
    """A strip that is held at its left end, pulled at its right one, and pressed by a ball from below."""
    x = blank.node_position[:, 0]
    supports = [Support("left", np.flatnonzero(x < 1e-9))]
    if right:
        pull = Drive(SmoothStroke((0.0, PULL), (0.0, STRETCH * LENGTH), (0.0, 0.0)), (1.0, 0.0, 0.0))
        supports.append(Support("right", np.flatnonzero(x > LENGTH - 1e-9), (pull,)))
    ball = Sphere(0.02, origin=(0.03, 0.5 * WIDTH, -0.02 - 0.5 * THICKNESS))
    rising = Tool("ball", ball, Stroke((0.0, PULL), (0.0, 1.0e-3)), friction=0.3)
    return Setup(
        "pulled", sheets=[Sheet(blank, strip, supports=supports)], tools=[rising], stages=stages,
        duration=None if stages else PULL + REST, dynamics=Dynamics(damping=100.0), frame_count=10,
        solver=Solver(precision="float64", lane_count=1, threads=1),
    )  # fmt: skip


def smaller(state, model, small, nodes, kept):
    """The state of a part of a sheet, from that of the whole, with nothing of what trims a sheet."""
    begun, own, whole = State.initial(small), small.sheet, model.sheet
    for name, array in begun.arrays():
        if array.size and not name.startswith(("sheets/", "reaction")):
            array.assign(state.content()[name])
    rows, old = own.motion_layout.read(begun.sheet.motion), whole.motion_layout.read(state.sheet.motion)
    rows[:, : len(nodes)] = old[:, nodes]
    begun.sheet.motion.assign(own.motion_layout.flat(rows))
    springs, before = own.friction_layout.read(begun.sheet.friction), whole.friction_layout.read(state.sheet.friction)
    springs[:, : len(nodes)] = before[:, nodes]
    begun.sheet.friction.assign(own.friction_layout.flat(springs))
    for name in ("cell_unknowns", "cell_report"):
        values = getattr(begun.sheet, name).numpy()
        values[:, : kept.sum()] = getattr(state.sheet, name).numpy()[:, np.flatnonzero(kept)]
        getattr(begun.sheet, name).assign(values)
    return begun


def test_what_stays_is_the_smaller_sheet_from_the_same_state(strip, frames, manual):
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), SIZE)
    trims = (Trim(BEFORE, view="blank"),)
    setup = pulled(blank, strip, (Stage("pull", PULL), Stage("trim", REST, trims=trims)), right=True)
    trimmed = Simulation(setup)
    trimmed.run([frames])

    begun = Simulation(pulled(blank, strip, (Stage("pull", PULL),), right=True))
    begun.run()
    kept = blank.element_centres()[:, 0] < CUT
    part, nodes = blank.part(kept)
    small = Model(pulled(part, strip, (), right=False))
    state = smaller(begun.state, begun.model, small, nodes, kept)
    stepper = Stepper(small, state)
    stepper.refresh_step()
    stepper.advance_to(trimmed.frame.time)

    vectors = small.sheet.read_motion(state.sheet.motion)[:, : len(nodes)]
    found = vectors[MotionRow.position.vector] + vectors[MotionRow.remainder.vector]
    moved = np.abs(found - part.node_position).max()
    difference = np.abs(found - trimmed.frame.position[nodes]).max()
    assert np.array_equal(trimmed.frame.sheet.kept, kept)
    assert moved > 1e-4 and difference < 1e-9 * moved
    # half an element at most, and the waste takes away what it has
    (told,) = trimmed.stages.trimmed
    assert told["off_curve_mm"] == pytest.approx(1e3 * abs(CUT - 0.06)) and told["off_curve_mm"] <= 0.5e3 * SIZE
    assert told["mass_kg"] == pytest.approx(0.5 * WIDTH * (LENGTH - 0.06))
    last = [frame for frame in frames.all if frame.stage == "pull"][-1]
    energies = trimmed.frame.energies
    assert 0.0 < told["energy_j"] < last.energies["internal"]
    error = max(abs(frame.energies["balance_error"]) for frame in frames.all) / energies["supplied"]
    assert error < 0.01
    case = manual(
        "Process", "A sheet that is trimmed",
        known="A strip is pulled, pressed by a ball, and cut through at 61 mm with elements of 5 mm: what stays moves "
        "as the smaller strip that begins in the same state, and what the waste stored leaves the ledger.",
    )  # fmt: skip
    case.table(
        ["", "expected", "got"],
        [["largest difference from the smaller strip, of its displacement", "0", f"{difference / moved:.1e}"],
         ["border off the curve [mm]", "1, at most 2.5", f"{told['off_curve_mm']:.4g}"],
         ["mass of the waste [g]", f"{1e3 * 0.5 * WIDTH * (LENGTH - 0.06):.4g}", f"{1e3 * told['mass_kg']:.4g}"],
         ["energy of the waste, of all that was stored", "", f"{told['energy_j'] / last.energies['internal']:.3g}"],
         ["largest error of the balance, of the work", "< 1 %", f"{error:.2%}"]],
    )  # fmt: skip


def test_half_a_stretched_strip_springs_back_by_its_strain(strip, manual):
    """Held at one end and free at the cut, it comes to rest at the length that it had on the blank."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), SIZE)
    half = [(-1.0, -1.0), (0.5 * LENGTH * (1.0 + STRETCH), -1.0), (0.5 * LENGTH * (1.0 + STRETCH), 1.0), (-1.0, 1.0)]
    stages = (
        Stage("pull", PULL),
        Stage("trim", 0.1, AtRest(1.0e-6, 1.0e-4), tools=(), trims=(Trim(half),), damping=400.0),
    )
    setup = pulled(blank, strip, stages, right=True)
    setup = Setup(
        "half", sheets=setup.sheets, stages=stages, dynamics=setup.worlds[0].dynamics, frame_count=10,
        tools=[Tool("far", Sphere(0.01, origin=(0.0, 0.0, -0.1)), Stroke((0.0,), (0.0,)))], solver=setup.solver,
    )  # fmt: skip
    simulation = Simulation(setup)
    simulation.run()
    x = blank.node_position[:, 0]
    end = np.abs(x - 0.5 * LENGTH) < 1e-9
    held = simulation.stages.frames["pull"].position[end, 0].mean() - 0.5 * LENGTH
    left = simulation.frame.position[end, 0].mean() - 0.5 * LENGTH
    assert simulation.stages.ended[-1]["ended_by"] == "rest"
    assert held == pytest.approx(0.5 * LENGTH * STRETCH, rel=0.02)
    assert abs(left) < 0.01 * held
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["support_work"]
    # half of what was stored goes with the waste, and the rest is damped
    share = simulation.stages.trimmed[0]["energy_j"] / energies["support_work"]
    assert share == pytest.approx(0.5, abs=0.02)
    case = manual(
        "Process", "Half a stretched strip",
        known="A strip is stretched by 0.1 % and cut in half while it is held: half of its energy goes with the waste, "
        "and the half that stays springs back to its length on the blank.",
    )  # fmt: skip
    case.table(
        ["", "expected", "got"],
        [["displacement of the cut, held [µm]", f"{1e6 * 0.5 * LENGTH * STRETCH:.4g}", f"{1e6 * held:.4g}"],
         ["at rest [µm]", "0", f"{1e6 * left:.2g}"],
         ["energy of the waste, of the work", "0.5", f"{share:.3g}"]],
    )  # fmt: skip


@pytest.mark.parametrize("thickness", ["initial", "current"])
def test_each_of_several_trims_has_its_own_energy_and_depths_stay_numbers(strip, thickness):
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), SIZE)
    after = [(-1.0, -1.0), (CUT - 2.0 * SIZE, -1.0), (CUT - 2.0 * SIZE, 1.0), (-1.0, 1.0)]
    nothing = [(-1.0, -1.0), (CUT, -1.0), (CUT, 1.0), (-1.0, 1.0)]
    trims = [Trim(BEFORE), Trim(nothing), Trim(after)]
    setup = pulled(blank, strip, [Stage("pull", PULL), Stage("trim", REST, trims=trims)], right=True)
    world = setup.worlds[0]
    dynamics = world.dynamics.model_copy(update={"contact_thickness": thickness, "contact_samples": "surface"})
    simulation = Simulation(setup.model_copy(update={"worlds": (world.model_copy(update={"dynamics": dynamics}),)}))
    simulation.run()
    told = simulation.stages.trimmed
    energies = [each["energy_j"] for each in told]
    assert energies[0] > 0.0 == energies[1] and energies[2] > 0.0 and told[1]["element_count"] == 0
    assert sum(energies) == pytest.approx(simulation.frame.energies["trimmed_energy"])
    depths = simulation.penetration
    assert np.isfinite([depths.at_nodes, depths.at_surface, depths.at_element_centres, depths.time]).all()


def test_the_same_bits_for_any_number_of_threads(strip):
    """Through a cut, and with elements that are gone."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), SIZE)
    stages = (Stage("pull", PULL), Stage("trim", REST, trims=[Trim(BEFORE, view="blank")], supports=("left",)))
    ends = []
    for threads in (1, 3):
        setup = pulled(blank, strip, stages, True)
        solver = setup.solver.model_copy(update={"threads": threads})
        simulation = Simulation(setup.model_copy(update={"solver": solver}))
        simulation.run()
        assert simulation.stages.trimmed and simulation.stepper.thread_count == threads
        ends.append({name: array.numpy().tobytes() for name, array in simulation.state.arrays()})
    assert ends[0] == ends[1]
