"""Supports: groups of nodes that are held and possibly moved, such as grips and frames, and the force on each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, Self

import numpy as np
from pydantic import SerializeAsAny, field_validator, model_validator

from ..arrays import FloatArray, IntArray
from ..checks import Parameters
from ..names import Label
from .strokes import Motion


class Drive(Parameters):
    """One prescribed motion of a support.

    Attributes:
        motion: s(t) [m]; the speed of a ``Stroke`` jumps at every knot, that of a ``SmoothStroke`` is continuous.
        direction: displacement of the nodes over s: one vector (3,) for all, or (node_count, 3), one per node of the
            support. Not scaled to length one: a node with direction (0, 0.5, 0) moves by s/2 along y.
    """

    positional = ("motion", "direction")

    motion: SerializeAsAny[Motion]
    direction: FloatArray

    @field_validator("motion")
    @classmethod
    def _moves_nodes(cls, value: Motion) -> Motion:
        if not value.moves_supports:
            kinds = [name for name, kind in Motion.kinds().items() if kind.moves_supports]
            raise ValueError(f"it must be one of {', '.join(kinds)}")
        return value

    @field_validator("direction")
    @classmethod
    def _are_finite(cls, value: np.ndarray) -> np.ndarray:
        if value.ndim not in (1, 2) or value.shape[-1] != 3 or not np.isfinite(value).all():
            raise ValueError(f"shape {value.shape}; finite values of shape (3,) or (node_count, 3) are needed")
        return value

    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """``Motion.pieces`` of the motion."""
        return self.motion.pieces()

    def at(self, time: float) -> float:
        """s [m] at ``time`` [s]."""
        start, pieces = self.pieces()
        k = max(int(np.searchsorted(start, time, side="right")) - 1, 0)
        return float(np.polynomial.polynomial.polyval(max(time - start[k], 0.0), pieces[k]))

    @property
    def largest_displacement(self) -> float:
        """Largest distance from zero at any knot [m]."""
        return float(np.abs(self.pieces()[1][:, 0]).max())

    @property
    def initial_speed(self) -> float:
        """ds/dt just after time zero [m/s]."""
        start, pieces = self.pieces()
        k = int(np.searchsorted(start, 0.0, side="right")) - 1
        if k < 0:
            return 0.0
        return float(np.polynomial.Polynomial(pieces[k]).deriv()(0.0 - start[k]))


class Support(Parameters):
    """Nodes that follow x = x0 + sum of s_k(t) times direction_k; the force that holds them is an output.

    Without a drive they do not move. Every frame has the force of the support on the sheet and the force along each
    drive (work per unit of s, over all nodes): ``Frame.support_force`` and ``Frame.drive_force``.

    Attributes:
        name: used in outputs.
        nodes: indices, each once (k,).
        drives: their displacements add up.
        displacements: the components that are held or driven, any of "xyz".
        rotations: the axes about which the directors must not turn, any of "xyz".
    """

    positional = ("name", "nodes", "drives", "displacements", "rotations")

    name: Label
    nodes: IntArray
    drives: tuple[Drive, ...] = ()
    displacements: str = "xyz"
    rotations: str = "xyz"

    @field_validator("nodes", mode="before")
    @classmethod
    def _are_indices(cls, value: Any) -> Any:
        if isinstance(value, Mapping):
            return value
        nodes = np.array(value)
        if nodes.ndim != 1 or not len(nodes) or not np.issubdtype(nodes.dtype, np.integer):
            raise ValueError("indices of one or more nodes are needed (np.flatnonzero makes them from a mask)")
        return nodes

    @field_validator("displacements", "rotations")
    @classmethod
    def _are_axes(cls, value: str) -> str:
        if set(value) - set("xyz"):
            raise ValueError('give some of "xyz", or ""')
        return value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not self.name:
            raise ValueError("support: the name is empty; outputs use it")
        if self.nodes.ndim != 1 or not len(self.nodes):
            raise ValueError(f"support {self.name}: indices of one or more nodes are needed")
        if len(np.unique(self.nodes)) < len(self.nodes):
            raise ValueError(f"support {self.name}: a node is listed twice; list each node once")
        for k, drive in enumerate(self.drives):
            self._check_drive(k, drive)
        return self

    def _check_drive(self, k: int, drive: Drive) -> None:
        if drive.direction.ndim == 2 and len(drive.direction) != len(self.nodes):
            raise ValueError(
                f"support {self.name}: drive {k} has {len(drive.direction)} directions for {len(self.nodes)} nodes; "
                "one per node, or one for all, is needed"
            )
        for axis, component in zip("xyz", np.atleast_2d(drive.direction).T, strict=True):
            if component.any() and axis not in self.displacements:
                raise ValueError(
                    f"support {self.name}: drive {k} moves nodes along {axis}, but its displacements "
                    f"({self.displacements!r}) leave {axis} free; a component is driven or free"
                )
        if abs(drive.at(0.0)) > 1.0e-12 * drive.largest_displacement:
            raise ValueError(
                f"support {self.name}: drive {k} is at {drive.at(0.0):.4g} m at time zero; it must start from 0, where "
                "the nodes of the blank are"
            )

    @property
    def held(self) -> np.ndarray:
        """The components that are held: x, y, z and the rotations about them, (6,) bool."""
        return np.array([axis in held for held in (self.displacements, self.rotations) for axis in "xyz"])

    def directions(self, k: int) -> np.ndarray:
        """Direction of drive ``k`` at every node of the support, (node_count, 3)."""
        return np.broadcast_to(self.drives[k].direction, (len(self.nodes), 3))


def prescribe_start(supports: Sequence[Support], velocity: np.ndarray | None, node_count: int) -> np.ndarray | None:
    """Initial velocities (node_count, 3) [m/s], with the supports' own in the components that they hold."""
    if not supports:
        return velocity
    velocity = np.zeros((node_count, 3)) if velocity is None else velocity.copy()
    for support in supports:
        start = sum((d.initial_speed * support.directions(k) for k, d in enumerate(support.drives)), np.zeros(3))
        held = support.held[:3]
        velocity[np.ix_(support.nodes, held)] = np.broadcast_to(start, (len(support.nodes), 3))[:, held]
    return velocity


class HoldsNodes(Protocol):
    """What holds nodes of a sheet, each of which may be held once."""

    @property
    def name(self) -> str:
        """For messages."""

    @property
    def nodes(self) -> np.ndarray:
        """Indices of the nodes, (k,) int."""


def check_held_once(kind: str, holders: Sequence[HoldsNodes], node_count: int, allowed: str) -> None:
    """Check the nodes of all supports, or of all grippers, of a sheet.

    Args:
        kind: what holds them, for messages.
        holders: with the indices of their nodes, (k,) each.
        node_count: of the blank.
        allowed: how many may hold one node, for messages.

    Raises:
        ValueError: a node that the blank does not have, or that two of them hold.
    """
    owner = np.full(node_count, -1)
    for index, holder in enumerate(holders):
        nodes = holder.nodes
        if nodes.min() < 0 or nodes.max() >= node_count:
            raise ValueError(
                f"{kind} {holder.name}: nodes go from {nodes.min()} to {nodes.max()}; the blank has {node_count} "
                "nodes, counted from 0"
            )
        if (owner[nodes] >= 0).any():
            node = nodes[np.argmax(owner[nodes] >= 0)]
            raise ValueError(
                f"{kind} {holder.name}: node {node} is also held by {holders[owner[node]].name}; {allowed}"
            )
        owner[nodes] = index
