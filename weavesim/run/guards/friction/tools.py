"""Friction laws of tools: viscosities that the step cannot carry, tables that are used beyond their ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from ....process.friction import law_of
from ....process.friction_device import viscous_share
from ..guard import Doubt, Guard, Level, Start
from .tables import LEAST_VISCOUS_SHARE, BeyondTables

if TYPE_CHECKING:
    from ...frame import Frame
    from ...ledger import Ledger
    from ...verdict import Judged


class ToolFriction(Guard):
    """Friction laws between sheets and tools."""

    lasting = True
    name = "tool_friction"
    watches = "friction laws of tools: their tables and films"

    def __init__(self) -> None:
        self._beyond = BeyondTables()

    def before(self, start: Start) -> Iterable[Doubt]:
        """Viscosities that the time step cannot carry."""
        rates, told = start.model.carried_rates(), set[tuple[str, float]]()
        for phase in start.phases:
            for tool, rate in zip(phase.setup.tools, rates, strict=True):
                share = viscous_share(law_of(tool.friction), rate)
                if share < LEAST_VISCOUS_SHARE and (tool.name, share) not in told:
                    told.add((tool.name, share))
                    yield self.doubt(
                        Level.WARNING,
                        f"tool {tool.name}: the time step can carry {share:.0%} of the viscosity at high speed",
                        "take a smaller time step, or a lower viscosity",
                        value=share,
                    )

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Note the first use of a friction table beyond its ends."""
        for sheet in ledger.sheets:
            for index, tool in enumerate(sheet.tools):
                for places, low, high in sheet.friction_arguments(index):
                    # tools of two worlds may share a name
                    name = f"{sheet.name}\n{sheet.first_tool + index}"
                    self._beyond.note(name, law_of(tool.friction), low, high, places, frame.time)

    def memory(self) -> Mapping[str, Any]:
        """Uses beyond tables so far."""
        return self._beyond.memory()

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take them back."""
        self._beyond.recall(memory)

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Uses beyond tables."""
        for text, found in self._beyond.told():
            sheet, index = found["name"].split("\n")
            yield self.doubt(
                Level.WARNING,
                f"tool {run.run.setup.tools[int(index)].name}: {text}",
                "measure farther, or accept the coefficient at the end of the table",
                sheet=sheet,
                place=tuple(found["place"]),
                time=float(found["time"]),
                value=found["excess"],
            )
