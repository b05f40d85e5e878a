"""Relaxation reports why it gives up."""

import pytest

from tests.support.runs import one_sheet_run
from weavesim.errors import InputError, RunError
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.run.relaxation import relax
from weavesim.sheet.blank import Blank


def test_relaxation_gives_up_with_a_reason(fabric):
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    laws = fabric(shear=LinearShear(modulus=1e6), bending=IsotropicBending(modulus=1e6), transverse_shear_modulus=1e6)
    simulation = one_sheet_run(
        name="fall", blank=blank, fabric=laws, duration=1.0, dynamics=Dynamics(gravity=(0.0, 0.0, -9.81)),
        threads=1, precision="float64",
    )  # fmt: skip
    with pytest.raises(RunError, match="after 2000 steps .* move freely never comes to rest"):
        relax(simulation, largest_step_count=2000)
    with pytest.raises(InputError, match="tolerance = 0"):
        relax(simulation, tolerance=0.0)
