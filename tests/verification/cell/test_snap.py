"""A cell that jumps to another equilibrium frees energy: exactly that is booked, and nothing else."""

import numpy as np
import pytest

from weavesim.fabric.cell.weaves import FloatWeave, PlainWeave
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank


def loss_and_booking(sheet, corners: list[tuple[float, float]], increment_count: int) -> tuple[float, float]:
    """Work done on one element minus its energy at the end, and the snap loss in the ledger [J].

    ``corners`` are the stretches of warp and weft, gone through in straight lines.
    """
    blank = sheet.simulation.setup.sheet.blank
    legs = [np.linspace(a, b, increment_count + 1)[1:] for a, b in zip(corners[:-1], corners[1:], strict=True)]
    position, work = blank.node_position, 0.0
    force, _ = sheet.forces(position, blank.initial_director)
    for stretch in np.concatenate(legs):
        new_position = blank.node_position * [*stretch, 1.0]
        new_force, _ = sheet.forces(new_position, blank.initial_director, fresh=False)
        work -= 0.5 * float(((force + new_force) * (new_position - position)).sum())
        position, force = new_position, new_force
    energies = sheet.simulation.ledger.frame(0).energies
    return work - energies["internal"], energies["snap_loss"]


@pytest.fixture(params=["by hand", "from its energy"])
def element(request, sheet, fabric):
    """``element(share)``: one element whose yarns keep ``share`` of their stiffness in compression, or the default.

    The plain weave, and once more from its energy, as any cell can be made.
    """
    kind, more = {"by hand": (PlainWeave, {}), "from its energy": (FloatWeave, {"repeat": 2})}[request.param]
    given = glass_polypropylene().unit_cell

    def make(share: float | None):
        axial = share and share * given.axial_stiffness[0]
        stiff = {"warp_compressive_stiffness": axial, "weft_compressive_stiffness": axial}
        cell = kind(**(given.model_dump() | stiff | more))
        return sheet(Blank.rectangle((0.0, 0.0), (0.005, 0.005), 0.005), fabric(unit_cell=cell))

    return make


@pytest.mark.parametrize(
    ("share", "corners"),
    [(0.5, [(1.0, 1.0), (0.8, 0.8), (1.01, 0.8)]), (0.1, [(1.0, 1.0), (0.8, 1.0), (1.0, 0.8)])],
)
def test_snap_loss_is_what_the_snap_frees(share, corners, element):
    lost, booked = loss_and_booking(element(share), corners, 400)
    assert lost > 0.05
    assert booked == pytest.approx(lost, rel=0.02)


@pytest.mark.parametrize("end", [(1.03, 0.9), (1.03, 1.0), (0.8, 1.01)], ids=str)
def test_fast_but_steady_change_is_no_snap(end, element):
    """The same path in small and in large increments: no energy is lost, so none is booked."""
    for increment_count in (400, 8):
        lost, booked = loss_and_booking(element(None), [(1.0, 1.0), end], increment_count)
        assert booked == 0.0
        if increment_count == 400:
            assert abs(lost) < 1e-4 * element(None).energies(*at(end))["internal"]


def at(stretch: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions and directors of the element at a stretch."""
    blank = Blank.rectangle((0.0, 0.0), (0.005, 0.005), 0.005)
    return blank.node_position * [*stretch, 1.0], blank.initial_director
