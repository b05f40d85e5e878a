"""What a step writes of the contact of creases of one sheet."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
import warp as wp

from ...kernels.creases.data import creases_struct
from ...kernels.creases.pair_rows import CreaseCount, CreaseWorkRow, PairRow
from ..sheet_model import TANGENTIAL_RATIO
from .crease_model import CreaseModel


@dataclass(frozen=True)
class CreaseState:
    """What the kernels write of the creases of one sheet: see ``creases_struct``."""

    number: wp.array
    quiet: wp.array
    crease: wp.array
    weight: wp.array
    inward: wp.array
    first: wp.array
    count: wp.array
    partner: wp.array
    rows: wp.array
    works: wp.array
    force: wp.array
    deepest: wp.array
    largest_entry: wp.array

    @classmethod
    def initial(cls, model: CreaseModel) -> Self:
        """At time zero, without lists: the first search makes them."""
        edges, entries, device = model.edge_count, model.entry_count, model.device
        vec3 = wp.types.vector(3, model.real)

        def zeros(shape: int | tuple[int, int], dtype: Any = model.real) -> wp.array:
            return wp.zeros(shape, dtype=dtype, device=device)

        return cls(
            number=zeros(CreaseCount.row_count(), wp.int32),
            quiet=zeros(1),
            crease=zeros(edges, wp.int32),
            weight=zeros(edges),
            inward=zeros((2, edges), vec3),
            first=zeros(edges, wp.int32),
            count=zeros(edges, wp.int32),
            partner=zeros(entries, wp.int32),
            rows=zeros((PairRow.row_count(), entries)),
            works=zeros((CreaseWorkRow.row_count(), edges), wp.float64),
            force=zeros((2, edges), vec3),
            deepest=zeros(edges),
            largest_entry=zeros(edges),
        )

    def creases(self, model: CreaseModel) -> Any:
        """As a struct."""
        creases = creases_struct(model.real)()
        for field in fields(self):
            setattr(creases, field.name, getattr(self, field.name))
        return creases

    def pairs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Both edges of every pair, the lower first, (n,) each, and their rows, (rows, n); waits for the device."""
        count, first = self.count.numpy(), self.first.numpy()
        edge = np.repeat(np.arange(len(count)), count)
        within = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
        entry = np.repeat(first, count) + within
        partner = self.partner.numpy()[entry]
        once = edge < partner
        return edge[once], partner[once], self.rows.numpy()[:, entry[once]].astype(np.float64)

    def is_crowded(self) -> bool:
        """Whether there was ever no room for all pairs; waits for the device."""
        return bool(self.number.numpy()[CreaseCount.late])

    def deepest_node(self, model: CreaseModel, above: float, other: int) -> int:
        """A node of the edge that has ever been deepest, if deeper than ``above`` [m]; else ``other``."""
        deepest = self.deepest.numpy()
        if not len(deepest) or deepest.max() <= above:
            return other
        return int(model.nodes[int(deepest.argmax()), 0])

    def entries(self, model: CreaseModel, started: bool) -> dict[str, float]:
        """Entries of the ledger [J], and the ``force`` of all springs [N]; waits for the device.

        Without a step that is ``started`` no work has been done yet.
        """
        edge, other, rows = self.pairs()
        stiffness = np.minimum(model.stiffness[edge], model.stiffness[other])
        push = stiffness * rows[PairRow.weight] * rows[PairRow.press]
        spring = 0.5 * TANGENTIAL_RATIO * float(stiffness @ np.square(rows[PairRow.spring.span]).sum(axis=0))
        sums = float(started) * self.works.numpy().sum(axis=1)
        works = dict(zip(CreaseWorkRow.names(), sums.tolist(), strict=True))
        return {
            "force": float(push.sum()),
            "ply_contact": 0.5 * float(push @ rows[PairRow.press]),
            "ply_friction_spring": spring,
            "ply_friction_loss": works["friction_work"] - spring,
            "ply_damping_loss": works["damping_loss"],
            "ply_thickness_work": works["thickness_work"],
        }
