"""Free edges of a sheet that meet edge-on, between their nodes, where no node comes near to a facet (decision 81)."""

import numpy as np
import pytest

from tests.support.stacked_plies import FABRIC, THICKNESS, momentum
from weavesim import Dynamics, SelfContact, Setup, Sheet, Simulation, Solver
from weavesim.engine.creases import crease_model
from weavesim.process import Coulomb
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.sheet.blank import Blank

# Elements over the thickness, around and across a band; gap between its ends over the thickness; speed of one end onto
# the other [m/s]; time [s].
SIZE, AROUND, ACROSS, GAP, SPEED, DURATION = 4.0, 36, 3, 1.5, 4.0, 7e-4


def closing_band() -> tuple[Blank, np.ndarray]:
    """A band around a circle that twists by a right angle, so that its ends meet crosswise; velocities of its nodes.

    Either end crosses the other in the middle of an edge: nodes are two thicknesses from the other's plane.
    """
    size = SIZE * THICKNESS
    radius = (AROUND * size + GAP * THICKNESS) / (2.0 * np.pi)
    along, across = np.meshgrid(
        np.arange(AROUND + 1) * size, (np.arange(ACROSS + 1) - 0.5 * ACROSS) * size, indexing="ij"
    )
    s, w = along.ravel(), across.ravel()
    angle = s / radius
    outward, zero = np.column_stack([np.cos(angle), np.zeros_like(s), np.sin(angle)]), np.zeros_like(s)
    # no twist near the ends
    turn = 0.5 * np.pi * np.clip((s / s.max() - 0.1) / 0.8, 0.0, 1.0)
    wide = np.cos(turn)[:, None] * np.array([0.0, 1.0, 0.0]) + np.sin(turn)[:, None] * outward
    node = np.arange(s.size).reshape(along.shape)
    quads = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    position = radius * outward + w[:, None] * wide
    corner = position[quads]
    blank = Blank.from_mesh(
        position, quads, material_coordinates=np.column_stack([s, w]),
        warp_direction=corner[:, 1] + corner[:, 2] - corner[:, 0] - corner[:, 3],
    )  # fmt: skip
    forward = np.column_stack([-np.sin(angle), zero, np.cos(angle)])
    # winding up without stretch: what the ends gain along the circle, it loses in radius
    return blank, SPEED * ((s / s.max())[:, None] * forward - outward / (2.0 * np.pi))


def thrown() -> tuple[Simulation, int]:
    """The run, and the pairs of triangles that cross in all frames."""
    blank, velocity = closing_band()
    sheet = Sheet(blank, FABRIC, name="band", initial_velocity=velocity, self_contact=SelfContact(Coulomb(0.0)))
    run = Simulation(
        Setup("edges", sheets=(sheet,), duration=DURATION, frame_count=30, accept_unusual=True,
              dynamics=Dynamics(contact_damping_ratio=0.3), solver=Solver(precision="float64", threads=1))
    )  # fmt: skip
    record = CrossingRecord()
    run.run([record])
    return run, record.total


@pytest.mark.verification
def test_free_edges_that_meet_between_their_nodes_do_not_pass_through_each_other(manual, monkeypatch):
    """Without their contact they do; momentum is that at the start, and the ledger closes."""
    run, crossings = thrown()
    last = run.history[-1]
    error = last["balance_error"] / last["initial_kinetic"]
    linear, _ = momentum(run)
    start = run.model.sheet.node_mass @ run.setup.sheet.initial_velocity
    assert crossings == 0 and abs(error) < 1e-3
    np.testing.assert_allclose(linear, start, atol=1e-9 * np.abs(start).max())
    assert run.state.creases[0].deepest.numpy().max() > 1e-3 * THICKNESS
    monkeypatch.setattr(crease_model, "free_edges", lambda blank, symmetry: np.zeros((0, 6), dtype=int))
    _, without = thrown()
    assert without > 0
    case = manual(
        "Contact", "Free edges that meet edge-on",
        known="A band around a circle twists by a right angle, and one of its ends is thrown onto the other, edge-on "
        "and crosswise, with elements of four thicknesses, so that the edges meet in their middles. They do not pass "
        "through each other, momentum is kept, and the ledger closes within 0.1 % of the energy; nodes on facets alone "
        "let them through.",
    )  # fmt: skip
    case.table(
        ["crossing triangles in all frames", "without contact of free edges", "balance error"],
        [[crossings, without, f"{error:+.1e}"]],
    )
