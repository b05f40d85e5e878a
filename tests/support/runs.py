"""Set-ups and simulations of one sheet, all in one call: the one place where tests put a ``Setup`` together."""

from typing import Any

from weavesim.engine.setup import Setup, Solver
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

OF_THE_SHEET = ("free", "initial_velocity", "supports", "loads", "pressures", "grippers", "orientation")


def one_sheet_setup(*, blank: Any, fabric: Any, **given: Any) -> Setup:
    """The set-up of one sheet; ``given`` are fields of ``Sheet``, ``World``, ``Solver`` and ``Setup``."""
    sheet = Sheet(blank, fabric, **{name: given.pop(name) for name in OF_THE_SHEET if name in given})
    solver = Solver(**{name: given.pop(name) for name in Solver.model_fields if name in given})
    return Setup(sheets=(sheet,), solver=solver, **given)


def one_sheet_run(**given: Any) -> Simulation:
    """A ready simulation of ``one_sheet_setup``."""
    simulation = Simulation(one_sheet_setup(**given))
    simulation.prepare()
    return simulation


def small_run(**given: object) -> Simulation:
    """A free square of 20 mm of the preset, 4 x 4 elements, 10 us in double precision, but for what is ``given``."""
    settings = {
        "name": "small", "blank": Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005), "fabric": glass_polypropylene(),
        "duration": 1e-5, "precision": "float64", "lane_count": 1, "threads": 1, "frame_count": 2,
    }  # fmt: skip
    return one_sheet_run(**(settings | given))
