"""Blank holders in segments against the whole ring, and spacers that hold them."""

import numpy as np
import pytest

from weavesim import Simulation
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

COARSE = {"mesh_size": 0.015, "frame_count": 1, "threads": 1}


@pytest.fixture(scope="module")
def formed():
    """The whole ring, and eight segments: with its pressure, with other forces, and on spacers."""

    def run(**given):
        simulation = Simulation(double_dome(DoubleDomeParameters(**COARSE, **given)))
        simulation.run()
        return simulation

    return {
        "whole": run(),
        "equal": run(blank_holder_segments=8),
        "unequal": run(blank_holder_segments=8, blank_holder_loads="2000, 20"),
        "spacers": run(blank_holder_segments=8, blank_holder_stop=1.0e-4),
    }


def drawn_in(simulation) -> tuple[float, float]:
    """Draw-in at the ends of the long and of the short axis [m]."""
    flat, now = simulation.model.sheet.blank.node_position, simulation.frame.position
    long = int(np.argmax(flat[:, 0] - 1e3 * flat[:, 1]))
    short = int(np.argmax(flat[:, 1] - 1e3 * flat[:, 0]))
    return float(flat[long, 0] - now[long, 0]), float(flat[short, 1] - now[short, 1])


def test_equal_segments_are_the_whole_ring(formed, manual):
    whole = formed["whole"].frame
    rows = []
    for name, text in (
        ("equal", "20 kPa on each"),
        ("unequal", "2 kN, 20 N"),
        ("spacers", "20 kPa, spacers at 0.1 mm"),
    ):
        frame, energies = formed[name].frame, formed[name].frame.energies
        apart = float(np.linalg.norm(frame.position - whole.position, axis=1).max())
        angle = float(np.abs(np.degrees(frame.fields["shear_angle"] - whole.fields["shear_angle"])).max())
        force = float(frame.tool_reaction[2:, 2].sum() / whole.tool_reaction[2, 2])
        balance = abs(energies["balance_error"]) / energies["supplied"]
        ways = [f"{1e3 * way:.2f}" for way in drawn_in(formed[name])]
        rows.append([text, f"{1e3 * apart:.3g}", f"{angle:.2g}", *ways, f"{force:.3f}", f"{balance:.1e}"])
        assert balance < 1.0e-3
        if name == "equal":
            assert apart < 5.0e-4 and angle < 1.0
            assert force == pytest.approx(1.0, rel=0.05)
    long, short = drawn_in(formed["whole"])
    rows.insert(0, ["whole ring", "0", "0", f"{1e3 * long:.2f}", f"{1e3 * short:.2f}", "1",
                    f"{abs(whole.energies['balance_error']) / whole.energies['supplied']:.1e}"])  # fmt: skip
    # a firm hold at the end of the long axis keeps the blank there; a loose one beside lets go
    held, loose = drawn_in(formed["unequal"])
    assert held < long - 5e-4 and loose > short
    case = manual(
        "Process", "A blank holder in eight segments",
        known="Double dome with elements of 15 mm: segments with the pressure of the whole ring form what it forms; "
        "one that presses harder at the end of the long axis keeps the blank there. The segments of a quarter are two.",
    )  # fmt: skip
    case.table(
        ["holder", "furthest from the ring's [mm]", "largest change of angle [°]", "draw-in, long axis [mm]",
         "short axis", "force / ring's", "balance error / work"],
        rows,
    )  # fmt: skip


def test_segments_do_not_go_below_their_spacers(formed):
    simulation = formed["spacers"]
    frame = simulation.frame
    # down is along their axis: they stand on the spacers, or wrinkles lift them
    assert np.all(frame.tool_displacement[2:] <= 1e-15)
    carried = simulation.watch.extremes.tools["wanted_impulse"][2:]
    assert np.all(carried < formed["equal"].watch.extremes.tools["wanted_impulse"][2:])
