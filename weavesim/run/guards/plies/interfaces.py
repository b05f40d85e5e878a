"""Contacts between plies that were late, deep, or beyond their tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ....kernels.pass_entries import PassEntry
from ....process.friction import Friction
from ...diagnosis import CROWDED, CROWDED_ADVICE, LARGEST_PLY_PENETRATION
from ..friction.tables import LEAST_VISCOUS_SHARE, BeyondTables
from ..guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ....engine.plies.pass_model import PassModel
    from ...frame import Frame
    from ...ledger import Ledger
    from ...verdict import Judged


class Deepest(NamedTuple):
    """The deepest that a node was in the other ply [m]: its number, and when [s]."""

    depth: float
    node: int
    time: float


class Interfaces(Guard):
    """Contact between plies."""

    lasting = True
    name = "interfaces"
    watches = "plies that touch: their penetration, search and friction tables"

    def __init__(self) -> None:
        self._beyond = BeyondTables()
        self._passes: tuple[PassModel, ...] = ()
        self._deepest: dict[int, Deepest] = {}

    def before(self, start: Start) -> Iterable[Doubt]:
        """Viscosities that the time step cannot carry."""
        self._passes = start.model.passes
        for model in self._passes:
            share = min(map(model.carried_share, self._laws(start, model)), default=1.0)
            if share < LEAST_VISCOUS_SHARE:
                yield self.doubt(
                    Level.WARNING,
                    f"{model.name}: the time step can carry {share:.0%} of the viscosity at high speed",
                    "take a smaller time step, or a lower viscosity",
                    value=share,
                )

    @staticmethod
    def _laws(start: Start, model: PassModel) -> Iterator[Friction]:
        """Of a contact in all stages."""
        yield model.interface.friction
        for phase in start.phases:
            yield from (each.friction for each in phase.setup.interfaces if f"interface {each.name}" == model.name)

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Note the deepest that plies are in each other, and the first use of a friction table beyond its ends."""
        for k, model in enumerate(ledger.interfaces.passes):
            friction = model.interface.friction
            rows, places = ledger.interfaces.rows(k), model.slave.blank.material_coordinates
            self._see(k, model, rows["push"], frame.time)
            if friction.argument_name is None:
                continue
            self._beyond.note(str(k), friction, rows["low"], rows["high"], places, frame.time)

    def _see(self, k: int, model: PassModel, push: np.ndarray, time: float) -> None:
        """Keep the deepest node of a pass, if it is deeper than those before; ``push`` is its force per node."""
        depth = push / model.stiffness
        node = int(np.argmax(depth))
        if depth[node] > (self._deepest[k].depth if k in self._deepest else 0.0):
            self._deepest[k] = Deepest(float(depth[node]), node, time)

    def memory(self) -> Mapping[str, Any]:
        """Deepest nodes and uses beyond tables so far."""
        return {**self._beyond.memory(), "deepest": [[k, *found] for k, found in self._deepest.items()]}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._beyond.recall(memory)
        self._deepest = {k: Deepest(*found) for k, *found in memory["deepest"]}

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Late searches, deep penetration, use beyond tables."""
        for k, model in enumerate(self._passes):
            yield from self._of_pass(run, k, model)

    def _of_pass(self, run: Judged, k: int, model: PassModel) -> Iterator[Doubt]:
        own = run.run.state.passes[k]
        name, rows = model.name, own.read_rows(model)
        creases = zip(run.run.model.creases, run.run.state.creases, strict=True)
        if any(each.own_pass is model and kept.is_crowded() for each, kept in creases):
            yield self.doubt(Level.DO_NOT_USE, f"{name}: {CROWDED}", CROWDED_ADVICE)
        elif own.entry.numpy()[PassEntry.late] > 0.0:
            yield self.doubt(
                Level.DO_NOT_USE,
                f"{name}: a node went past the facets on which it was looked for, so that a contact may have "
                "been missed",
                "elements have turned over, or plies slide faster than the search allows: refine the mesh, or move the "
                "tools more slowly",
            )
        self._see(k, model, rows["push"], run.run.state.time)
        found = self._deepest.get(k)
        if found is not None and found.depth > LARGEST_PLY_PENETRATION * model.thickness:
            yield self.doubt(
                Level.DO_NOT_USE,
                f"{name}: the plies are pressed {1e3 * found.depth:.3g} mm into each other, more than "
                f"{LARGEST_PLY_PENETRATION:.0%} of the distance at which they touch",
                "lower the pressure, or raise stiffness_share",
                sheet=model.slave.name,
                place=tuple(model.slave.blank.material_coordinates[found.node].tolist()),
                time=found.time,
                value=found.depth,
                limit=LARGEST_PLY_PENETRATION * model.thickness,
            )
        for text, beyond in self._beyond.told():
            if beyond["name"] != str(k):
                continue
            yield self.doubt(
                Level.WARNING,
                f"{name}: {text}",
                "measure farther, or accept the coefficient at the end of the table",
                sheet=model.slave.name,
                place=tuple(beyond["place"]),
                time=float(beyond["time"]),
                value=beyond["excess"],
            )
