"""Examples of all kinds of unit cells, for trials, tests and benchmarks. All except the plain weave are assumed."""

from __future__ import annotations

from collections.abc import Callable

from ..cell import UnitCell
from ..fabric import LARGEST_LOCKING_SHARE, Fabric
from .glass import glass_polypropylene
from .origins import all_assumed

UNIT_CELLS: dict[str, Callable[[], UnitCell]] = {
    name: make for kind in UnitCell.kinds().values() for name, make in sorted(kind.examples().items())
}


def assumed_fabric(unit_cell: str) -> Fabric:
    """The glass/polypropylene fabric with another of ``UNIT_CELLS``; no such fabric was measured."""
    fabric, cell = glass_polypropylene(), UNIT_CELLS[unit_cell]()
    # locking stiffness is limited to a tenth of that of the softer yarns
    largest = LARGEST_LOCKING_SHARE * min(cell.yarn_stiffness_per_width)
    fabric = fabric.model_copy(
        update={
            "name": f"assumed {unit_cell.replace('-', ' ')} of glass/polypropylene", "unit_cell": cell,
            "shear": fabric.shear.locking_at_most(0.1 * largest),
            "source": f"none; all but the unit cell as in {fabric.name!r}", "assumed": ("everything",),
        }
    )  # fmt: skip
    why = "assumed: an example of a unit cell; all else is of the glass/polypropylene plain weave"
    return fabric.model_copy(update={"provenance": all_assumed(fabric, why)})
