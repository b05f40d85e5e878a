"""Tools that overlap the sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .limit import LimitGuard

if TYPE_CHECKING:
    from ..verdict import Judged


class PenetrationAtNodes(LimitGuard):
    """Nodes deep in a tool."""

    name = "penetration_at_nodes"
    watches = "the depth of the nodes in the tools"
    key = "penetration_at_nodes_mm"
    text = "the deepest node in a tool [mm]"
    advice = "tools move too fast, or meet through the sheet"

    def limit(self, run: Judged) -> float:
        """A twentieth of the thinnest sheet [mm]."""
        return 0.05 * (1e3 * run.thickness)
