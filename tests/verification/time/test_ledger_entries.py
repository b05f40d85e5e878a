"""Every entry of the ledger against a case that can be worked out by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.engine.sheet_model import CONTACT_SHARE, TANGENTIAL_RATIO
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear, MomentCurve
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.run.relaxation import relax
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

SIDE, SIZE, AREA = 0.02, 0.005, 4e-4
GRAVITY = 9.81
# entry of the ledger, the case in words, expected [J], got [J]
Found = tuple[str, str, float, float]


def flat() -> Blank:
    return Blank.rectangle((0.0, 0.0), (SIDE, SIDE), SIZE)


def at(sheet, laws, entry: str, *, position=None, director=None, blank=None) -> float:
    blank = blank or flat()
    position = blank.node_position if position is None else position
    director = blank.initial_director if director is None else director
    return sheet(blank, laws).energies(position, director)[entry]


def stretched(sheet, fabric) -> list[Found]:
    laws = fabric(unit_cell=PlainWeave.straight(stiffness_per_width=800.0), compressive_stiffness=300.0)
    position = flat().node_position * [1.03, 0.96, 1.0]
    return [
        ("warp_axial", "3 % longer", 0.5 * 800.0 * 0.03**2 * AREA, at(sheet, laws, "warp_axial", position=position)),
        ("weft_axial", "4 % shorter", 0.5 * 800.0 * 0.04**2 * AREA, at(sheet, laws, "weft_axial", position=position)),
        ("compression", "weft 4 % shorter", 0.5 * 300.0 * 0.04**2 * AREA,
         at(sheet, laws, "compression", position=position)),
    ]  # fmt: skip


def crimped(sheet, fabric) -> list[Found]:
    """Yarns that do not stretch keep their chord: heights and angles follow from the stretches alone."""
    half, height, bending, contact = np.array([2.6e-3, 2.6e-3]), 3e-4, 1e-5, 3e4
    cell = PlainWeave(
        warp_modulus=1e16, weft_modulus=1e16, contact_modulus=1e6, warp_cross_section=1e-6, weft_cross_section=1e-6,
        contact_cross_section=1e-6, warp_second_moment=bending / 1e16, weft_second_moment=bending / 1e16,
        warp_half_spacing=half[0], weft_half_spacing=half[1], crossover_height=2.0 * height,
        contact_stiffness_value=contact, warp_compressive_stiffness=1e10, weft_compressive_stiffness=1e10,
    )  # fmt: skip
    stretch = np.array([1.002, 0.999])
    chord = np.hypot(half, height)
    new_height = np.sqrt(chord**2 - (half * stretch) ** 2)
    turn = np.arctan2(new_height, half * stretch) - np.arctan2(height, half)
    cells = AREA / (2.0 * half[0] * half[1])
    position = flat().node_position * [*stretch, 1.0]
    laws = fabric(unit_cell=cell)
    return [
        ("yarn_bending", "crimped yarns that do not stretch", cells * (0.5 * 3.0 * bending / chord * turn**2).sum(),
         at(sheet, laws, "yarn_bending", position=position)),
        ("crossover_contact", "the same", cells * 0.5 * contact * (new_height - height).sum() ** 2,
         at(sheet, laws, "crossover_contact", position=position)),
    ]  # fmt: skip


def sheared(sheet, fabric) -> list[Found]:
    blank = flat()
    angle = 0.3
    position = blank.node_position.copy()
    position[:, :2] = position[:, :2] @ np.array([[1.0, 0.0], [np.sin(angle), np.cos(angle)]])
    laws = fabric(shear=MomentCurve(angle=(0.0, 1.0), moment_values=(0.0, 50.0)))
    # an angle g x: every element differs from the mean around a node by g h/2, the nodes at both ends see one column
    gradient, stiffness = 0.5, 5e-3
    bent = blank.node_position.copy()
    bent[:, 1] += 0.5 * gradient * bent[:, 0] ** 2
    return [
        ("shear", "a moment of 50 gamma N/m, gamma = 0.3", 0.5 * 50.0 * angle**2 * AREA,
         at(sheet, laws, "shear", position=position)),
        ("in_plane_bending", "an angle that grows by 0.5 per metre",
         0.5 * stiffness * gradient**2 * AREA * (1.0 - SIZE / SIDE),
         at(sheet, fabric(in_plane_bending_stiffness=stiffness), "in_plane_bending", position=bent)),
    ]  # fmt: skip


def bent(sheet, fabric) -> list[Found]:
    blank = flat()
    x, y, _ = blank.node_position.T
    radius, tilt = 0.5, 0.02
    law = IsotropicBending(modulus=3e7, poisson_ratio=0.2)
    position = np.column_stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)])
    director = np.column_stack([np.sin(x / radius), 0.0 * y, np.cos(x / radius)])
    leaning = np.tile([np.sin(tilt), 0.0, np.cos(tilt)], (blank.node_count, 1))
    return [
        ("bending", "a cylinder of radius 0.5 m", 0.5 * law.stiffness(1e-3) / radius**2 * AREA,
         at(sheet, fabric(bending=law), "bending", position=position, director=director)),
        ("transverse_shear", "directors that lean by 0.02", 0.5 * (5.0 / 6.0 * 1e6 * 1e-3) * np.sin(tilt) ** 2 * AREA,
         at(sheet, fabric(transverse_shear_modulus=1e6), "transverse_shear", director=leaning)),
    ]  # fmt: skip


def hourglassed(sheet, fabric) -> list[Found]:
    """At a share of one the hourglass energy is that of the bilinear field, integrated by hand."""
    blank = Blank.rectangle((0.0, 0.0), (SIZE, SIZE), SIZE)
    amplitude = 1e-5
    odd = np.zeros((4, 3))
    odd[blank.quads[0], 0] = amplitude * np.array([1.0, -1.0, 1.0, -1.0])
    one = {"in_plane": 0.0, "warping": 0.0, "director": 0.0}
    sheared = fabric(
        shear=MomentCurve(angle=(0.0, 1.0), moment_values=(0.0, 50.0)),
        stabilisation=Stabilisation(**one | {"in_plane": 1}),
    )
    warped = fabric(transverse_shear_modulus=1e6, stabilisation=Stabilisation(**one | {"warping": 1}))
    return [
        ("hourglass", "in-plane mode, 10 um", 2.0 / 3.0 * 50.0 * amplitude**2,
         at(sheet, sheared, "hourglass", blank=blank, position=blank.node_position + odd)),
        ("hourglass", "warping mode, 10 um", 4.0 / 3.0 * (5.0 / 6.0 * 1e6 * 1e-3) * amplitude**2,
         at(sheet, warped, "hourglass", blank=blank, position=blank.node_position + odd[:, [1, 2, 0]])),
    ]  # fmt: skip


def run(laws, **given) -> Simulation:
    """A short run in double precision."""
    settings = {"blank": flat(), "duration": 1e-2, "frame_count": 4, "precision": "float64", "threads": 1}
    simulation = one_sheet_run(name="entry", fabric=laws, **(settings | given))
    simulation.run()
    return simulation


def moving(sheet, fabric) -> list[Found]:
    laws = fabric()
    mass = laws.areal_density * AREA
    speed = np.zeros((flat().node_count, 3))
    speed[:, 2] = 2.0
    thrown = run(laws, initial_velocity=speed, dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY)))
    time, rise = thrown.frame.time, 2.0 * thrown.frame.time - 0.5 * GRAVITY * thrown.frame.time**2
    damped = run(laws, initial_velocity=speed, dynamics=Dynamics(damping=50.0))
    left = np.exp(-2.0 * 50.0 * damped.frame.time)
    held = run(
        laws, initial_velocity=speed, dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY)),
        free=np.zeros((flat().node_count, 6), dtype=bool),
    )  # fmt: skip
    tool = Tool("weight", Plane(origin=(0.0, 0.0, -0.1)), ForceDriven.constant(-0.5, mass=0.02))
    pushed = run(laws, tools=[tool])
    fall = pushed.frame.time**2 * 0.5 / 0.02 / 2.0
    return [
        ("kinetic", "thrown upwards at 2 m/s", 0.5 * mass * (2.0 - GRAVITY * time) ** 2,
         thrown.frame.energies["kinetic"]),
        ("initial_kinetic", "the same", 0.5 * mass * 4.0, thrown.frame.energies["initial_kinetic"]),
        ("gravity_work", "the same", -mass * GRAVITY * rise, thrown.frame.energies["gravity_work"]),
        ("damping_loss", "at 2 m/s, damped at 50/s", 0.5 * mass * 4.0 * (1.0 - left),
         damped.frame.energies["damping_loss"]),
        ("support_work", "lifted at 2 m/s", mass * GRAVITY * 2.0 * held.frame.time,
         held.frame.energies["support_work"]),
        ("tool_kinetic", "0.5 N on 0.02 kg", 0.5 * fall, pushed.frame.energies["tool_kinetic"]),
        ("driving_force_work", "the same", 0.5 * fall, pushed.frame.energies["driving_force_work"]),
    ]  # fmt: skip


def touching(sheet, fabric) -> list[Found]:
    """On a plane that rises 5 mm, and on one that leans below the friction angle."""
    laws = fabric(
        unit_cell=PlainWeave.straight(stiffness_per_width=500.0), shear=LinearShear(modulus=1e5),
        bending=IsotropicBending(modulus=1e6), transverse_shear_modulus=1e5, stabilisation=Stabilisation(),
    )  # fmt: skip
    mass, rise, lean = laws.areal_density * AREA, 5e-3, 0.1
    resting = Blank.rectangle((0.0, 0.0), (SIDE, SIDE), SIZE, height=0.5 * laws.thickness)
    settings = {"blank": resting, "duration": 0.2}
    lift = Tool("table", Plane(), Stroke.smooth(rise, 0.05, 0.05), friction=0.3)
    lifted = run(laws, tools=[lift], **settings, dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY)))
    relax(lifted, tolerance=1e-5)
    sunk = GRAVITY * lifted.model.reference_step**2 / CONTACT_SHARE
    leaning = run(
        laws, tools=[Tool("table", Plane(), friction=0.3)], **settings,
        dynamics=Dynamics(gravity=(GRAVITY * np.sin(lean), 0.0, -GRAVITY * np.cos(lean)), damping=200.0),
    )  # fmt: skip
    relax(leaning, tolerance=1e-5)
    stiffness = TANGENTIAL_RATIO * CONTACT_SHARE / leaning.model.reference_step**2
    return [
        ("tool_work", "a sheet lifted by 5 mm", mass * GRAVITY * rise, lifted.frame.energies["tool_work"]),
        ("contact", "the sheet's weight on the springs", 0.5 * mass * GRAVITY * sunk, lifted.frame.energies["contact"]),
        ("friction_spring", "a weight that sticks on a slope of 0.1",
         0.5 * mass * (GRAVITY * np.sin(lean)) ** 2 / stiffness, leaning.frame.energies["friction_spring"]),
    ]  # fmt: skip


CASES: dict[str, tuple[Callable[..., list[Found]], float]] = {
    "stretched": (stretched, 1e-9), "crimped": (crimped, 1e-3), "sheared": (sheared, 1e-3), "bent": (bent, 1e-3),
    "hourglassed": (hourglassed, 1e-6), "moving": (moving, 2e-3), "touching": (touching, 2e-3),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_entries(name, sheet, fabric, manual):
    found, tolerance = CASES[name]
    case = manual(
        "Energy and time step", f"Entries of the ledger: a sheet that is {name}",
        known="Each entry is calculated by hand; the cases of the incline cover friction loss, those of the shell "
        "load work, and `test_snap.py` snap loss.",
    )  # fmt: skip
    entries = found(sheet, fabric)
    case.table(
        ["entry", "case", "expected [J]", "got [J]", "deviation"],
        [[entry, words, a, b, f"{100 * (b / a - 1):+.2g} %"] for entry, words, a, b in entries],
    )
    for entry, words, expected, got in entries:
        assert got == pytest.approx(expected, rel=tolerance), (entry, words)
