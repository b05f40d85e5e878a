"""Contact of plies at a free edge, and of a stack that is turned (docs/plies.md)."""

import numpy as np
import pytest

from tests.support.stacked_plies import THICKNESS, momentum, nodal_areas, pass_rows, ply, square, stack_setup
from weavesim import Drive, NodalLoads, Observer, Sheet, Simulation, Support
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Fabric, Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.kernels.pass_entries import PassEntry
from weavesim.process import Coulomb
from weavesim.process.strokes import SmoothStroke, Stroke
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.sheet.blank import Blank

# Stages of the turned stack: pressed, shifted, turned, and a rest [s].
STAGE, TURNING = 5.0e-4, 3.0e-3
PRESSURE, SHIFT = 1.0e4, 2.0e-7
# Thickness of the strips [m], load at the tip [N/m], speed of the pull [m/s].
THIN, TIP_LOAD, SPEED = 3.0e-4, 4.0, 1.0


def turned(blank: Blank, sunk: float, carried: float) -> Support:
    """All nodes: pressed down by ``sunk`` [m], shifted by ``carried`` [m] along x, and turned by 90 degrees."""
    start = 2.5 * STAGE
    time = np.append(np.linspace(0.0, start, 26)[:-1], np.linspace(start, start + TURNING, 400))
    angle = 0.5 * np.pi * np.clip((time - start) / TURNING, 0.0, 1.0)
    x, y, none = (*blank.node_position[:, :2].T, np.zeros(blank.node_count))
    drives = [
        Drive(Stroke(time, np.cos(angle) - 1.0), np.column_stack([x, y, none])),
        Drive(Stroke(time, np.sin(angle)), np.column_stack([-y, x, none])),
    ]
    if sunk:
        moved = carried * np.clip(time / STAGE - 1.0, 0.0, 1.0)
        drives.append(Drive(Stroke(time, sunk * np.clip(time / STAGE, 0.0, 1.0)), (0.0, 0.0, -1.0)))
        drives.append(Drive(Stroke(time, moved * np.cos(angle)), (1.0, 0.0, 0.0)))
        drives.append(Drive(Stroke(time, moved * np.sin(angle)), (0.0, 1.0, 0.0)))
    return Support(f"nodes {sunk:g}", np.arange(blank.node_count), tuple(drives))


def test_the_friction_of_a_stuck_stack_turns_with_it(manual):
    """Known answer G: two plies that stick are turned by a right angle about their normal, pressed as before."""
    lower, upper = square(0.02, 0.005), square(0.02, 0.005, THICKNESS, angle=20.0)
    probe = Simulation(stack_setup([ply("lower", lower), ply("upper", upper)], Coulomb(0.5), duration=1e-3))
    depth = PRESSURE / probe.model.passes[0].area_stiffness
    sheets = [
        ply("lower", lower, supports=(turned(lower, 0.0, 0.0),)),
        ply("upper", upper, supports=(turned(upper, depth, SHIFT),)),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.5), duration=3.0 * STAGE + TURNING, frame_count=18))
    drags: list[np.ndarray] = []

    class Watch(Observer):
        def frame(self, frame):
            passes = enumerate(run.model.passes)
            drags.append(sum(each.place.side * pass_rows(run, k)["drag"].sum(axis=1) for k, each in passes))

    run.run([Watch()])
    # the fourth frame is that at the end of the shift
    before, after = drags[4], drags[-1]
    size = np.linalg.norm(before)
    assert size > 0.5
    (x, y, _), (u, v, _) = before, after
    angle = np.degrees(np.arctan2(x * v - y * u, x * u + y * v))
    growth = np.linalg.norm(after) / size - 1.0
    assert angle == pytest.approx(90.0, abs=1.0)
    assert abs(growth) < 1e-3
    case = manual(
        "Contact", "Friction turns with a stack",
        known="Two plies that stick under 10 kPa are turned together by a right angle about their normal: the force of "
        "their friction turns along, and keeps its size.",
    )  # fmt: skip
    case.table(["force before [N]", "turned by [degrees]", "change of size"], [[size, angle, f"{growth:+.1e}"]])


def pulled_back(size: float) -> tuple[Simulation, CrossingRecord]:
    """A strip that hangs over the free edge of another with a load at its tip, and is pulled back over it.

    Args:
        size: of the elements over the thickness.
    """
    step = size * THIN
    fabric = Fabric(
        name="strip", areal_density=0.5, thickness=THIN,
        unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=4.0e7), transverse_shear_modulus=2.0e6, shear=LinearShear(modulus=4.0e6),
        stabilisation=Stabilisation(),
    )  # fmt: skip
    below = Blank.rectangle((-24.0 * THIN, 0.0), (0.0, 5.0 * step), step)
    above = Blank.rectangle((-16.0 * THIN, step), (12.0 * THIN, 4.0 * step), step, height=THIN)
    x = above.node_position[:, 0]
    tip = np.flatnonzero(x > x.max() - 1e-9)
    width = np.full(len(tip), step)
    width[[0, -1]] *= 0.5
    force = np.zeros((above.node_count, 3))
    force[tip, 2] = -TIP_LOAD * width
    start, way = 6.0e-3, 14.0 * THIN
    pull = Drive(SmoothStroke.ramped(way, SPEED, 0.1, start_time=start), (-1.0, 0.0, 0.0))
    upper = Sheet(
        above, fabric, name="upper", supports=(Support("grip", np.flatnonzero(x < x.min() + 1e-9), (pull,)),),
        loads=NodalLoads(force, None, (0.0, 4.0e-3), (0.0, 1.0)),
    )  # fmt: skip
    lower = ply("lower", below, free=np.zeros((below.node_count, 6), dtype=bool), fabric=fabric)
    run = Simulation(
        stack_setup([lower, upper], Coulomb(0.0), duration=start + 1.15 * way / SPEED + 3.0e-3, frame_count=40,
                    dynamics={"damping": 2000.0, "contact_damping_ratio": 0.2})
    )  # fmt: skip
    record = CrossingRecord()
    run.run([record])
    return run, record


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_a_strip_is_pulled_back_over_a_free_edge(size, manual):
    """Known answer D: it never passes through, begins its contacts without a push, and ends up on the other."""
    run, record = pulled_back(size)
    assert record.total == 0
    entry = max(pass_rows(run, k)["largest_entry"].max() for k in (0, 1)) / THIN
    assert 0.0 < entry < 0.15
    position = run.frame.sheets[1].position
    tip = position[run.setup.sheets[1].blank.node_position[:, 0] > 12.0 * THIN - 1e-9]
    height = tip[:, 2].mean() / THIN
    assert tip[:, 0].max() < 0.0 and height == pytest.approx(1.0, abs=0.05)
    last = run.history[-1]
    error = last["balance_error"] / last["supplied"]
    assert abs(error) < 0.01
    case = manual(
        "Contact", f"A strip is pulled back over a free edge, elements of {size:g} thicknesses",
        known="A strip hangs over the free edge of another by 12 thicknesses, a load at its tip, and is pulled back by "
        "14: it never passes through the other, contacts begin without a force (the entry offset stays below 0.15 "
        "thicknesses), its tip ends a thickness above the other, and the ledger closes within 1 % of the work.",
    )  # fmt: skip
    case.table(
        ["crossing triangles", "largest entry / thickness", "height of the tip / thickness", "balance error / work"],
        [[record.total, entry, height, f"{error:+.1e}"]],
    )


def test_plies_that_start_inside_each_other_are_not_pushed_apart(manual):
    """Known answer D: started 0.2 t overlapped, no force, and the kinetic energy stays 0, on three meshes."""
    rows = []
    for size in (0.01, 0.005, 0.0025):
        plies = [ply("lower", square(0.01, size)), ply("upper", square(0.01, size, 0.8 * THICKNESS, 20.0))]
        run = Simulation(stack_setup(plies, Coulomb(0.2), duration=1e-4))
        run.run()
        found = [pass_rows(run, k) for k in range(len(run.model.passes))]
        entry = max(each["largest_entry"].max() for each in found) / THICKNESS
        push, kinetic = max(each["push"].max() for each in found), run.history[-1]["kinetic"]
        assert push == 0.0 and kinetic < 1e-25 and entry == pytest.approx(0.2, rel=1e-6)
        rows.append([1e3 * size, entry, push, kinetic])
    case = manual(
        "Contact", "Plies that start inside each other",
        known="Two free squares overlap by a fifth of their thickness at the start, which is refused unless it is "
        "accepted: contact begins without a force, and nothing moves.",
    )  # fmt: skip
    case.table(["element size [mm]", "entry / thickness", "largest force of a node [N]", "kinetic energy [J]"], rows)


def carried(blank: Blank, name: str, time: list[float], path: list[tuple[float, float, float]]) -> Support:
    """All nodes, along a path [m] with corners at these times [s]."""
    drives = [
        Drive(Stroke(np.array(time), along), axis) for along, axis in zip(np.transpose(path), np.eye(3), strict=True)
    ]
    return Support(name, np.arange(blank.node_count), tuple(drives))


def set_down(
    upper: Blank, time: list[float], path: list[tuple[float, float, float]], below: Blank | None = None
) -> tuple[int, int]:
    """Nodes that were pressed at an update while a ply is carried over one that is held, and those not listed there."""
    lower = square(0.05, 0.005) if below is None else below
    sheets = [
        ply("lower", lower, supports=(carried(lower, "held", [0.0, time[-1]], [(0.0, 0.0, 0.0)] * 2),)),
        ply("upper", upper, supports=(carried(upper, "carried", time, path),)),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=time[-1]))
    pressed = missing = 0
    while run.state.time < time[-1]:
        run.stepper.advance(1)
        for model, own in zip(run.model.passes, run.state.passes, strict=True):
            assert own.entry.numpy()[PassEntry.late] == 0.0
            if below is None:
                assert own.read_rows(model)["largest_entry"].max() < 0.01 * THICKNESS
            listed, count, standing = own.listed.numpy(), own.listed_count.numpy(), own.standing.numpy()
            for node in np.flatnonzero(standing >= 0):
                facet = standing[node]
                pressed += 1
                missing += count[facet] >= 0 and node not in listed[: count[facet], facet]
    return pressed, missing


def test_a_ply_that_is_lifted_off_and_set_down_elsewhere_pushes_what_it_stands_on():
    """Its nodes follow facets from far away, and sleep there: none is missing from the lists where it comes down."""
    high, aside, pressed = 0.03, (0.02, 0.006), -0.12 * THICKNESS
    path = [(0.0, 0.0, 0.0), (0.0, 0.0, high), (*aside, high), (*aside, 0.0), (*aside, pressed)]
    found = set_down(square(0.01, 0.005, 1.1 * THICKNESS, 20.0), [0.0, 2e-3, 4e-3, 6e-3, 7e-3], path)
    assert found[0] > 100 and found[1] == 0


@pytest.mark.parametrize("speed", [5.0, 40.0])
def test_a_ply_that_rocks_over_a_free_edge_goes_on(speed):
    """It loses its feet beyond the edge, finds them again, and is pressed before the next update."""
    way, start = 0.0035, 0.0562
    blank = square(0.005, 0.005, 1.02 * THICKNESS, centre=(start, 0.0008))
    turns = np.cumsum([0.0, way, way + 0.0012, 0.001]) / speed
    path = [(0.0, 0.0, 0.0), (way, 0.0, 0.0), (-0.0012, 0.0, 0.0), (-0.0022, 0.0, -0.1 * THICKNESS)]
    found = set_down(blank, turns.tolist(), path)
    assert found[0] > 0 and found[1] == 0


@pytest.mark.parametrize("speed", [5.0, 20.0])
def test_a_ply_thrown_aslant_from_far_away_keeps_momentum(speed, manual):
    """Its nodes have no feet at the start; the nearest facet is often not the one on which a node will stand."""
    sheets = [
        ply("lower", square(0.03, 0.005)),
        ply("upper", square(0.02, 0.005, 0.015, 34.0), (1.0, 0.3, -speed)),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=0.0225 / speed))
    before, angular = momentum(run)
    run.run()
    after, turned = momentum(run)
    pressed = max(pass_rows(run, k)["slip"].max() for k in (0, 1))
    size, twist = np.linalg.norm(before), np.linalg.norm(angular)
    error, spin = np.abs(after - before).max() / size, np.abs(turned - angular).max() / twist
    assert pressed > 0.0 and error < 1e-12
    case = manual(
        "Contact", f"A ply thrown aslant from far away, {speed:g} m/s",
        known="A free square is thrown onto another from 15 mm, three elements, aslant, with its mesh turned by 34 "
        "degrees: linear momentum is kept to round-off.",
    )  # fmt: skip
    case.table(
        ["change of momentum, relative", "of that about the origin, without the directors' own"], [[error, spin]]
    )


def graded(half: float, size: float, fine: float) -> Blank:
    """A square of half side ``half`` and elements of ``size`` [m], half of whose columns are narrower by ``fine``."""
    flat = Blank.rectangle((-half, -half), (half, half), size)
    columns = np.linspace(-half, half, round(2.0 * half / size) + 1)
    place = np.searchsorted(columns, flat.node_position[:, 0] - 1e-9)
    count = len(columns) - 1
    width = np.full(count, size)
    width[count // 4 : 3 * count // 4] *= fine
    edges = np.append(0.0, np.cumsum(width))
    position = flat.node_position.copy()
    position[:, 0] = (edges - 0.5 * edges[-1])[place]
    return Blank.from_mesh(position, flat.quads)


def test_a_ply_that_slides_over_narrow_elements_keeps_momentum():
    """Lists are made from those of the facets around: it must not pass a whole facet between two of them."""
    lower, upper = graded(0.032, 0.004, 0.1), square(0.004, 0.004, 0.95 * THICKNESS, 20.0, centre=(-0.007, 0.0))
    pressure, share = 3.0e3, nodal_areas(upper).sum() / nodal_areas(lower).sum()
    sheets = [
        ply("lower", lower, pressure=pressure * share),
        ply("upper", upper, (10.0, 0.0, -0.1), -pressure),
    ]
    run = Simulation(stack_setup(sheets, Coulomb(0.0), duration=1.4e-3))
    before, _ = momentum(run)
    run.run()
    after, _ = momentum(run)
    slid = max(pass_rows(run, k)["slip"].max() for k in (0, 1))
    error = np.abs(after - before).max() / np.linalg.norm(before)
    late = [own.entry.numpy()[PassEntry.late] for own in run.state.passes]
    assert slid > 0.005 and error < 1e-12 and not any(late)


@pytest.mark.parametrize("fine", [0.2, 0.1])
def test_no_node_is_missing_where_a_ply_is_carried_over_narrow_elements(fine):
    """Also where it hovers before it is pressed. Nodes that its edge passes over begin without force, at its depth."""
    way, sunk, speed = 0.016, -0.1 * THICKNESS, 10.0
    times = np.cumsum([0.0, 0.006 / speed, 1e-4, way / speed])
    path = [(0.0, 0.0, 0.0), (0.006, 0.0, 0.0), (0.006, 0.0, sunk), (0.006 + way, 0.0, sunk)]
    upper = square(0.004, 0.004, 1.02 * THICKNESS, 20.0, centre=(-0.01, 0.0))
    found = set_down(upper, times.tolist(), path, graded(0.032, 0.004, fine))
    assert found[0] > 1000 and found[1] == 0
