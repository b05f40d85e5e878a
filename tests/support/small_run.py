"""A small run: the one place where the unit tests turn its parts into a simulation."""

from tests.support.runs import one_sheet_run
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


def small_run(**given: object) -> Simulation:
    """A free square of 20 mm of the preset, 4 x 4 elements, 10 us in double precision, but for what is ``given``."""
    settings = {
        "name": "small", "blank": Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005), "fabric": glass_polypropylene(),
        "duration": 1e-5, "precision": "float64", "lane_count": 1, "threads": 1, "frame_count": 2,
    }  # fmt: skip
    return one_sheet_run(**(settings | given))
