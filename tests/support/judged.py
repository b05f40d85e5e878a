"""Runs as guards see them, with numbers that a test chooses."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import ExtremeRow, ToolWatchRow
from weavesim.run.frame import Outcome
from weavesim.run.guards import Doubt, known_guards
from weavesim.run.sheet_ledger import NO_PENETRATION
from weavesim.run.watch.condition import Tally
from weavesim.run.watch.extremes import Extreme

SOUND = {
    "gravity_work_ratio": 0.0, "energy_balance_error": 0.01, "kinetic_energy_ratio": 0.01,
    "hourglass_energy_ratio": 0.01, "damping_loss_ratio": 0.01, "added_mass_ratio": 0.0,
    "penetration_at_element_centres_mm": 0.01, "penetration_of_surface_mm": 0.01,
    "unit_cell_failures": 0, "element_count": 100,
}  # fmt: skip
THICKNESS = 1.0e-3
TALLIES = ("crossings", "folded", "inverted", "beyond")


def judged(
    *,
    extremes: dict[str, Extreme] | None = None,
    tallies: dict[str, Tally] | None = None,
    stacks: tuple[Any, ...] = (),
    setup: Any = None,
    fabric: Any = None,
    **numbers: Any,
) -> Any:
    """A sound run of a sheet 1 mm thick without tools, but for these numbers, extremes, tallies, stacks."""
    own = {
        "min_stretch": Extreme(0.99), "max_stretch": Extreme(1.01), "angle": Extreme(0.5), "depth": Extreme(1e-5),
        "rows": np.zeros((ExtremeRow.row_count(), 1)), "times": np.zeros(ExtremeRow.row_count()),
    }  # fmt: skip
    fabric = fabric or glass_polypropylene().model_copy(update={"thickness": THICKNESS})
    sheet = SimpleNamespace(name="sheet", fabric=fabric, tools=())
    return SimpleNamespace(
        number=(SOUND | numbers).__getitem__,
        values=lambda name: [np.zeros(1)],
        thickness=THICKNESS,
        stored=[],
        last_quarter=[],
        balance_errors=[],
        damping_rates=[],
        shares=lambda name, entries: [],
        extremes=SimpleNamespace(
            sheets=[SimpleNamespace(**(own | (extremes or {})))],
            tools={name: np.zeros(0) for name in ToolWatchRow.names()},
            touched=np.zeros(0, dtype=bool),
        ),
        stacks=list(stacks),
        conditions=[SimpleNamespace(**({name: Tally() for name in TALLIES} | (tallies or {})))],
        run=SimpleNamespace(
            outcome=Outcome.FINISHED,
            failed=None,
            setup=SimpleNamespace(stages=()),
            stages=SimpleNamespace(ended=[], trimmed=[]),
            frame=SimpleNamespace(sheets=[SimpleNamespace(fields={"shear_angle": np.zeros(1)})]),
            penetration=NO_PENETRATION,
            model=SimpleNamespace(
                setup=SimpleNamespace(tools=(), solver=SimpleNamespace(mass_scaling=None)),
                sheets=[SimpleNamespace(name="sheet", added_mass_ratio=0.0)],
            ),
            info=SimpleNamespace(sheets=[sheet], tools=(), tool_names=(), setup=setup),
        ),
    )


def said(name: str, **given: Any) -> list[Doubt]:
    """What one guard says about ``judged``."""
    return list(known_guards()[name]().after(judged(**given)))
