"""Thickness and fibre content: fields against the law, and tools that meet the current thickness."""

import math

import numpy as np
import pytest

from tests.support.loops import SQUARE, UP
from tests.support.runs import one_sheet_run
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.compaction import Compaction
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import MomentCurve
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import SmoothStroke
from weavesim.process.supports import Drive, Support
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, rotation_matrix
from weavesim.tools.tool import Tool


def fields_at(shell, angle: float, stretch: float) -> dict[str, float]:
    gradient = stretch * np.array([[1.0, math.sin(angle), 0.0], [0.0, math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    shell.place(SQUARE.node_position @ gradient.T, UP)
    return {name: values[0] for name, values in shell.simulation.ledger.frame(0).fields.items()}


def test_sheared_sheet_thickens_and_keeps_its_fibre_content(sheet):
    """Fully thickening, unstretched: t cos(gamma) is constant; not thickening: the fibres pack by 1/cos(gamma)."""
    for thickening in (1.0, 0.5, 0.0):
        compaction = Compaction(thickening=thickening, fibre_areal_density=0.45, fibre_density=2550.0)
        fabric = glass_polypropylene().model_copy(update={"compaction": compaction})
        shell = sheet(SQUARE, fabric)
        rest = fields_at(shell, 0.0, 1.0)
        assert rest["thickness"] == pytest.approx(fabric.thickness, rel=1e-9)
        assert rest["fibre_volume_fraction"] == pytest.approx(0.45 / (2550.0 * 1.2e-3), rel=1e-9)
        sheared = fields_at(shell, 0.7, 1.0)
        # without stretch the crossovers press by what rounding leaves
        assert sheared["thickness"] == pytest.approx(fabric.thickness * math.cos(0.7) ** -thickening, rel=1e-6)
        packed = sheared["fibre_volume_fraction"] / rest["fibre_volume_fraction"]
        assert packed == pytest.approx(math.cos(0.7) ** (thickening - 1.0), rel=1e-6)


def test_tension_flattens_the_crossovers_by_what_the_contact_element_gives(sheet):
    """Of a plain weave, p/E_c is the closing of the contact element over L_3: the cell's own w says so."""
    fabric = glass_polypropylene()
    cell: PlainWeave = fabric.unit_cell
    shell = sheet(SQUARE, fabric)
    stretched = fields_at(shell, 0.0, 1.003)
    closing = -shell.simulation.state.sheet.cell_unknowns.numpy()[:, 0].sum() / cell.crossover_height
    assert closing > 0.005
    expected = fabric.thickness / stretched["area_ratio"] / (1.0 + closing)
    assert stretched["thickness"] == pytest.approx(expected, rel=1e-6)


def squeezed(contact_thickness: str, **given) -> Simulation:
    """A square that is sheared to 40 degrees between two planes whose gap is its initial thickness and a little."""
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.01)
    fabric = glass_polypropylene().model_copy(
        update={"shear": MomentCurve(angle=(0.0, 1.0), moment_values=(0.0, 5.0)), "compressive_stiffness": 0.0}
    )
    half = 0.5 * fabric.thickness
    gap = half + 0.05e-3
    tools = (
        Tool("lower", Plane(origin=(0.0, 0.0, -gap)), friction=0.0),
        Tool("upper", Plane(origin=(0.0, 0.0, gap), rotation=rotation_matrix((1.0, 0.0, 0.0), math.pi)), friction=0.0),
    )
    x, y, _ = blank.node_position.T
    end = math.radians(40.0)
    sine = SmoothStroke.ramped(math.sin(end), 200.0, 2e-3)
    lowered = sine.mapped(lambda s: np.sqrt(1.0 - s**2) - 1.0, lambda s: -s / np.sqrt(1.0 - s**2))
    drives = (
        Drive(sine, np.column_stack([y, 0.0 * y, 0.0 * y])),
        Drive(lowered, np.column_stack([0.0 * y, y, 0.0 * y])),
    )
    everywhere = Support("frame", np.arange(blank.node_count), drives, displacements="xy", rotations="xyz")
    settings = {"precision": "float64", "lane_count": 1, "threads": 1, "frame_count": 10} | given
    return one_sheet_run(
        name="squeezed", blank=blank, fabric=fabric, tools=tools, supports=(everywhere,), duration=sine.duration,
        dynamics=Dynamics(contact_thickness=contact_thickness), accept_unusual=True, **settings,
    )  # fmt: skip


@pytest.mark.slow
def test_tools_meet_the_current_thickness(frames):
    """The sheet thickens by 1/cos 40: it fills the gap and presses, and the balance includes that work."""
    plain = squeezed("initial")
    plain.run()
    assert np.abs(plain.frame.tool_reaction).max() == 0.0
    assert plain.frame.energies["thickness_work"] == 0.0

    simulation = squeezed("current")
    simulation.run([frames])
    frame = simulation.frame
    thick = frame.fields["thickness"]
    assert thick == pytest.approx(1.2e-3 / math.cos(math.radians(40.0)), rel=2e-3)
    # each face is pressed by the half thickness that is beyond its half of the gap, at every node's own stiffness
    overlap = 0.5 * thick.mean() - 0.65e-3
    expected = simulation.model.sheet.contact_stiffness.sum() * overlap
    assert -frame.tool_reaction[0, 2] == pytest.approx(expected, rel=0.02)
    assert frame.tool_reaction[1, 2] == pytest.approx(expected, rel=0.02)
    assert frame.energies["contact"] == pytest.approx(expected * overlap, rel=0.02)
    assert frame.energies["thickness_work"] == pytest.approx(frame.energies["contact"], rel=0.02)
    used = frame.energies["used"]
    assert abs(frame.energies["balance_error"]) < 2e-3 * used
    assert simulation.ledger.penetration(frame).at_nodes == pytest.approx(overlap, rel=0.02)
    # the same with as many lanes as in a run
    lanes = squeezed("current", lane_count=16)
    lanes.run()
    assert lanes.frame.tool_reaction == pytest.approx(frame.tool_reaction, rel=1e-9, abs=1e-9)
