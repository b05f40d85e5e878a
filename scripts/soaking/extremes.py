"""Extreme but legal runs: each ends finite, with just the guards of its row, or is refused with the right message.

Each throws a square of a fabric: its nodes move so that yarns stretch or shear by a given amount, or fall on a ball or
a table. Times and speeds follow from the stable step, so that a row needs no numbers but its extreme.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from weavesim.engine.setup import Setup, Solver
from weavesim.errors import InputError, RunError
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.compaction import Compaction
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LinearShear, MomentCurve
from weavesim.process.dynamics import Dynamics
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Capsule, Plane, Shape, Sphere, Torus
from weavesim.tools.tool import Tool

STEP_COUNT = 2000
# The sheets fly freely: they never store more than they move with, and vibrate at all frequencies, of which the fastest
# are damped.
ALWAYS = {"kinetic_energy", "damping_loss"}
# Amplitudes: of the strain, and of the shear angle [rad].
STRAIN, ANGLE = 5.0e-3, 0.22


# What guards have to say, and no others; where nothing stands, nothing.
CRUMPLED = {"folded_elements", "inverted_elements", "self_intersection"}
NARROW = {"narrow_tool", "tool_radius"}
# What goes through itself in a moment is found only by a look in it: the expectations are those of so many.
LOOKS = 100
EXPECTED: dict[str, set[str]] = {
    "sheared: yarns a thousand times stiffer": CRUMPLED | {"law_range"},
    "sheared: membrane 1000 : 1": CRUMPLED,
    "sheared: hardly any shear stiffness": CRUMPLED,
    "stretched: shear as stiff as the yarns": {"hourglass_energy"},
    "sheared: shear as stiff as the yarns": {"hourglass_energy"},
    "falls on a table with 100 m/s": {"penetration_at_nodes"},
    "stretched: one element": {"energy_balance"},
    "stretched: one element, largest step": {"energy_balance"},
    "stretched: hardly any crimp, largest step": {"energy_balance"},
}
for _friction in "01":
    EXPECTED[f"falls on a ball of 0.5 mm, friction {_friction}"] = NARROW | {"hourglass_energy"}
    EXPECTED[f"falls on a rod of 0.5 mm, friction {_friction}"] = NARROW
    EXPECTED[f"falls on a ring, friction {_friction}"] = NARROW | {"hourglass_energy"}
# Words of the message of those that are refused.
REFUSED = {
    f"{motion}: yarns a thousand times softer": "locking_stiffness = .* a tenth of the yarn stiffness per width"
    for motion in ("stretched", "sheared")
}
# Of those that stop in single precision alone: the sheet is crumpled in both, its elements sheared by 75 degrees,
# folded and turned over; there it loses a node too.
STOPPED_IN_SINGLE = {
    "sheared: membrane 1000 : 1": "the state became non-finite after .* is the first suspect: shear angle 7",
}
# Of the stable step: at the largest that is allowed, fast vibrations have errors of their energy that the guard sees.
STEP_SAFETY, LARGEST_STEP_SAFETY = 0.6, 0.9


class Row(NamedTuple):
    """One run.

    Attributes:
        name: of it.
        make: the fabric and the blank, tools and friction as keywords of ``thrown``.
    """

    name: str
    make: Callable[[], dict[str, Any]]


def with_cell(shear: Any = None, **given: float) -> Fabric:
    """The preset with other values of its unit cell, and another shear law; factors are named ``times_...``."""
    fabric = glass_polypropylene()
    cell = fabric.unit_cell
    values = {name.removeprefix("times_"): value for name, value in given.items()}
    for name, value in given.items():
        if name.startswith("times_"):
            values[name.removeprefix("times_")] = value * getattr(cell, name.removeprefix("times_"))
    changed = {"unit_cell": cell.model_copy(update=values)} | ({"shear": shear} if shear else {})
    return fabric.model_copy(update=changed)


def of(**given: Any) -> Fabric:
    """The preset with other values."""
    return glass_polypropylene().model_copy(update=given)


def both(factor: float, **given: Any) -> Fabric:
    """The preset with both yarn moduli and that of the contact times a factor."""
    return with_cell(times_warp_modulus=factor, times_weft_modulus=factor, times_contact_modulus=factor, **given)


def thick(thickness: float) -> Fabric:
    """A sheet of the preset's materials of another thickness: mass and stiffness follow."""
    scale = thickness / glass_polypropylene().thickness
    membrane = LinearMembrane(warp_stiffness=1.0e6 * scale, weft_stiffness=1.0e6 * scale)
    return of(
        thickness=thickness, areal_density=0.743 * scale, unit_cell=membrane, compressive_stiffness=2.4e4 * scale,
        in_plane_bending_stiffness=5.0e-3 * scale, shear=LinearShear(modulus=0.25e6), compaction=Compaction(),
    )  # fmt: skip


def locking(angle: float) -> Fabric:
    """Shear that locks from a small angle on [rad]."""
    curve = MomentCurve(angle=(0.0, 1.0), moment_values=(0.0, 50.0), locking_angle=angle, locking_stiffness=1.0e4)
    return of(shear=curve)


FABRICS: dict[str, Callable[[], Fabric]] = {
    "the preset": glass_polypropylene,
    "yarns a thousand times softer": lambda: both(1.0e-3),
    "the same with a soft shear law": lambda: both(1.0e-3, shear=LinearShear(modulus=250.0)),
    "yarns a thousand times stiffer": lambda: both(1.0e3),
    "warp a thousand times stiffer than weft": lambda: with_cell(
        times_weft_modulus=1.0e-3, shear=LinearShear(modulus=250.0)
    ),
    "contact a thousand times softer": lambda: with_cell(times_contact_modulus=1.0e-3),
    "contact a thousand times stiffer": lambda: with_cell(times_contact_modulus=1.0e3),
    "hardly any crimp": lambda: with_cell(times_crossover_height=0.01),
    "steep crimp": lambda: with_cell(times_crossover_height=3.0),
    "no crimp at all": lambda: of(unit_cell=LinearMembrane(warp_stiffness=1.0e6, weft_stiffness=1.0e6)),
    "membrane 1000 : 1": lambda: of(
        unit_cell=LinearMembrane(warp_stiffness=1.0e7, weft_stiffness=1.0e4), shear=LinearShear(modulus=250.0)
    ),
    "10 um thin": lambda: thick(1.0e-5),
    "10 mm thick": lambda: thick(1.0e-2),
    "1 g/m^2": lambda: of(areal_density=1.0e-3, compaction=Compaction()),
    "20 kg/m^2": lambda: of(areal_density=20.0, compaction=Compaction()),
    "hardly any shear stiffness": lambda: of(shear=LinearShear(modulus=1.0)),
    "shear as stiff as the yarns": lambda: of(shear=LinearShear(modulus=1.0e9)),
    "locks from half a degree on": lambda: locking(math.radians(0.5)),
    "limp": lambda: of(bending=IsotropicBending(modulus=1.0e3), transverse_shear_modulus=1.0e4),
    "stiff as a board": lambda: of(bending=IsotropicBending(modulus=1.0e10), transverse_shear_modulus=1.0e9),
    "no stiffness in compression": lambda: of(compressive_stiffness=0.0),
}


def square(count: int = 8, **given: Any) -> Blank:
    """A square of 40 mm."""
    return Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.04 / count, **given)


def thrown(
    fabric: Fabric, blank: Blank | None = None, *, motion: str = "stretch", amount: float = STRAIN, speed: float = 0.0,
    shape: Shape | None = None, friction: float = 0.3, precision: str = "float64", steps: int = STEP_COUNT,
    step_safety: float = STEP_SAFETY,
) -> Simulation:  # fmt: skip
    """A prepared run.

    Args:
        fabric, blank: of the sheet.
        motion: "stretch" or "shear" by ``amount``, or "fall" with ``speed`` [m/s].
        amount: strain or angle [rad].
        speed: of the fall.
        shape, friction: of a tool below it.
        precision: of the run.
        steps: of the run, about.
        step_safety: share of the stable step.
    """
    blank = square() if blank is None else blank
    tools = (Tool("below", shape, friction=friction),) if shape is not None else ()

    def setup(step: float, velocity: np.ndarray) -> Setup:
        sheet = Sheet(blank, fabric, initial_velocity=velocity)
        return Setup(
            "extreme", sheets=(sheet,), tools=tools, duration=steps * step, frame_count=4, accept_unusual=True,
            dynamics=Dynamics(damping=0.0), solver=Solver(precision=precision, threads=1, step_safety=step_safety),
        )  # fmt: skip

    still = np.zeros((blank.node_count, 3))
    first = Simulation(setup(1.0e-6, still))
    step = first.stepper.stable_step()
    velocity = still.copy()
    x, y = blank.node_position[:, :2].T
    if motion == "fall":
        velocity[:, 2] = -speed
        return Simulation(setup(max(step, 3.0e-3 / speed / steps), velocity), watch_count=LOOKS)
    rate = amount / (0.25 * steps * step)
    velocity[:, 0], velocity[:, 1] = (rate * y, rate * x) if motion == "shear" else (rate * x, rate * y)
    return Simulation(setup(step, velocity), watch_count=LOOKS)


def rows() -> Iterator[Row]:
    """All runs."""
    for name, fabric in FABRICS.items():
        yield Row(f"stretched: {name}", lambda fabric=fabric: {"fabric": fabric()})
        yield Row(f"sheared: {name}", lambda fabric=fabric: {"fabric": fabric(), "motion": "shear", "amount": ANGLE})
    half = 0.5 * glass_polypropylene().thickness
    below: dict[str, Shape] = {
        "a ball of 0.5 mm": Sphere(0.5e-3, origin=(0.0, 0.0, -0.5e-3 - half)),
        "a ball of 10 m": Sphere(10.0, origin=(0.0, 0.0, -10.0 - half)),
        "a rod of 0.5 mm": Capsule(0.5e-3, 0.03, origin=(0.0, 0.0, -0.5e-3 - half)),
        "a ring": Torus(0.5e-3, 0.01, origin=(0.0, 0.0, -0.5e-3 - half)),
        "a table": Plane(origin=(0.0, 0.0, -half)),
    }
    for name, shape in below.items():
        for friction in (0.0, 1.0):
            yield Row(
                f"falls on {name}, friction {friction:g}",
                lambda shape=shape, friction=friction: {
                    "fabric": glass_polypropylene(), "motion": "fall", "speed": 1.0, "shape": shape,
                    "friction": friction,
                },
            )  # fmt: skip
    yield Row("falls on a table with 10 m/s", lambda: {
        "fabric": glass_polypropylene(), "motion": "fall", "speed": 10.0, "shape": below["a table"]})  # fmt: skip
    yield Row("falls on a table with 100 m/s", lambda: {
        "fabric": glass_polypropylene(), "motion": "fall", "speed": 100.0, "shape": below["a table"]})  # fmt: skip
    meshes: dict[str, Callable[[], Blank]] = {
        "one element": lambda: square(1),
        "one row": lambda: Blank.rectangle((-0.02, -0.001), (0.02, 0.001), 0.002),
        "a distorted mesh": lambda: square(distortion=0.39),
        "yarns at 45 degrees": lambda: square(yarn_angle=45.0),
        "elements 1 : 20": lambda: Blank.rectangle((-0.02, -0.02), (0.02, 0.02), (0.02, 0.001)),
    }
    for name, blank in meshes.items():
        yield Row(f"stretched: {name}", lambda blank=blank: {"fabric": glass_polypropylene(), "blank": blank()})
    largest = {"step_safety": LARGEST_STEP_SAFETY}
    yield Row("stretched: one element, small step", lambda: {
        "fabric": glass_polypropylene(), "blank": square(1), "step_safety": 0.15})  # fmt: skip
    one, crimp = "stretched: one element, largest step", "stretched: hardly any crimp, largest step"
    yield Row(one, lambda: {"fabric": glass_polypropylene(), "blank": square(1), **largest})
    yield Row(crimp, lambda: {"fabric": FABRICS["hardly any crimp"](), **largest})
    yield Row("stretched: single precision", lambda: {"fabric": glass_polypropylene(), "precision": "float32"})
    yield Row("sheared: single precision", lambda: {
        "fabric": glass_polypropylene(), "precision": "float32", "motion": "shear", "amount": ANGLE})  # fmt: skip
    yield Row("stretched: 500,000 elements", lambda: {
        "fabric": glass_polypropylene(), "precision": "float32", "blank": square(707), "steps": 100})  # fmt: skip


def judged(row: Row, precision: str | None = None) -> tuple[bool, str]:
    """Whether a run ends as its row says, and how it ended; in another precision than the row's, if one is given."""
    refused = (REFUSED | (STOPPED_IN_SINGLE if precision == "float32" else {})).get(row.name)
    try:
        simulation = thrown(**(row.make() | ({} if precision is None else {"precision": precision})))
        simulation.run()
    except (InputError, RunError) as error:
        return bool(refused) and re.search(refused, str(error)) is not None, str(error)[:200]
    if refused:
        return False, f"it was not refused: {refused}"
    finite = all(np.isfinite(state.motion.numpy()).all() for state in simulation.state.sheets)
    said = {doubt.guard for doubt in simulation.doubts() if doubt.level > 0} - ALWAYS
    wanted = EXPECTED.get(row.name, set())
    balance = simulation.summary()["energy_balance_error"] or 0.0
    text = f"{simulation.state.step_count} steps, energy balance {balance:.1e}, {', '.join(sorted(said)) or 'quiet'}"
    if said != wanted:
        text += f" instead of {', '.join(sorted(wanted)) or 'quiet'}"
    return finite and said == wanted, text if finite else f"not finite in silence; {text}"


def extremes(folder: Path, count: int, seed: int) -> bool:
    """The first ``count`` rows, each as it says; see ``extremes_in_single`` for the other precision."""
    return _all_well(count, None)


def extremes_in_single(folder: Path, count: int, seed: int) -> bool:
    """The first ``count`` rows in single precision, the default of a run."""
    return _all_well(count, "float32")


def _all_well(count: int, precision: str | None) -> bool:
    well = True
    for row in list(rows())[:count]:
        started = time.monotonic()
        good, text = judged(row, precision)
        well = well and good
        print(f"{'' if good else 'FAILED: '}{row.name}: {text} ({time.monotonic() - started:.1f} s)", flush=True)
    return well
