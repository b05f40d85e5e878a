"""What a step writes of one pass of an interface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import warp as wp

from ...kernels.contact.friction import UNMET
from ...kernels.pass_entries import PassEntry
from ...kernels.plies.data import NO_DEPTH, TOO_MANY, UNSOUGHT
from ...kernels.rows import PlyRow, PlyWorkRow
from .feet import Feet
from .pass_model import PassModel


@dataclass(frozen=True)
class PassState:
    """What the kernels write of one pass; rows as in ``kernels/rows.py``, padded as the arrays of the sheets."""

    facet: wp.array  # (nodes,) int32: facet of the foot of each node
    standing: wp.array  # (nodes,) int32: the same where it is pressed, else -1
    rows: wp.array  # flat, ``PassModel.rows``
    works: wp.array  # (rows, nodes), PlyWorkRow, of the last steps [J]
    works_sum: wp.array  # (rows, node blocks) float64, of all steps before [J]
    way: wp.array  # (node blocks,) [m]
    last_step: wp.array  # (node blocks,) [s]
    listed: wp.array  # (slots, facets) int32: nodes that may stand on each facet
    listed_count: wp.array  # (facets,) int32
    block_count: wp.array  # (facet blocks,) int32: slots in use
    entry: wp.array  # PassEntry, float64

    def read_rows(self, model: PassModel) -> dict[str, np.ndarray]:
        """Rows by name without padding, in double precision, (node_count,) or (3, node_count); waits for the device."""
        values = model.rows.read(self.rows)[:, : model.slave.blank.node_count].astype(np.float64)
        return {row.name: values[row.span] if row.width > 1 else values[row] for row in PlyRow}

    def total_works(self) -> dict[str, float]:
        """Works of all steps by name, up to the instant of the positions [J]; waits for the device."""
        totals = self.works_sum.numpy().sum(axis=1) + self.works.numpy().sum(axis=1, dtype=np.float64)
        return dict(zip(PlyWorkRow.names(), totals.tolist(), strict=True))

    @classmethod
    def initial(cls, model: PassModel) -> Self:
        """The pass at time zero."""
        feet = model.feet
        real, device, slave, master = model.real, model.device, model.slave, model.master
        node_count, facet_count, count = slave.node_count, master.element_count, slave.blank.node_count
        rows = np.zeros((PlyRow.row_count(), node_count))
        rows[PlyRow.xi, :count], rows[PlyRow.eta, :count] = feet.xi, feet.eta
        rows[PlyRow.depth] = float(NO_DEPTH)
        rows[PlyRow.stray] = float(UNSOUGHT)
        rows[PlyRow.stray, :count] = np.maximum(feet.way, 0.0)
        rows[PlyRow.low] = float(UNMET)
        # the first search makes the lists
        rows[PlyRow.travel] = 0.75 * model.skin
        facet = np.zeros(node_count, dtype=np.int32)
        facet[:count] = feet.facet
        listed, listed_count = _listed(feet, model)

        def integers(values: np.ndarray) -> wp.array:
            return wp.array(np.ascontiguousarray(values), dtype=wp.int32, device=device)

        entry = np.zeros(PassEntry.row_count())
        entry[[PassEntry.watched, PassEntry.followed, PassEntry.busy]] = 1.0
        return cls(
            facet=integers(facet),
            standing=integers(np.full(node_count, -1)),
            rows=wp.array(model.rows.flat(rows), dtype=real, device=device),
            works=wp.zeros((PlyWorkRow.row_count(), node_count), dtype=real, device=device),
            works_sum=wp.zeros((PlyWorkRow.row_count(), slave.block_count), dtype=wp.float64, device=device),
            way=wp.zeros(slave.block_count, dtype=real, device=device),
            last_step=wp.zeros(slave.block_count, dtype=real, device=device),
            listed=integers(listed),
            listed_count=integers(listed_count),
            block_count=wp.zeros(facet_count // model.lane_count, dtype=wp.int32, device=device),
            entry=wp.array(entry, dtype=wp.float64, device=device),
        )


def forget_arguments(state: PassState, model: PassModel) -> None:
    """Extremes of the argument of a law of friction begin anew."""
    rows = model.rows.read(state.rows)
    rows[PlyRow.low], rows[PlyRow.high] = float(UNMET), 0.0
    state.rows.assign(model.rows.flat(rows))


def _listed(feet: Feet, model: PassModel) -> tuple[np.ndarray, np.ndarray]:
    """Nodes on each facet and their numbers, as the first search expects them."""
    tracked = np.flatnonzero(feet.way <= 0.0)
    order = tracked[np.argsort(feet.facet[tracked], kind="stable")]
    facet = feet.facet[order]
    place = np.arange(len(order)) - np.searchsorted(facet, facet)
    count = np.bincount(facet, minlength=model.master.element_count)
    listed = np.full((model.slot_count, model.master.element_count), -1, dtype=np.int32)
    fits = place < model.slot_count
    listed[place[fits], facet[fits]] = order[fits]
    return listed, np.where(count > model.slot_count, int(TOO_MANY), count)
