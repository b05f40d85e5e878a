"""A mass scaling that is chosen on a coarser mesh keeps its stated error on the mesh of the run."""

import numpy as np
import pytest

from weavesim.measures.border import outline
from weavesim.process.scaling.mass import KEPT_SHARE
from weavesim.run.scaling.mass import choose_mass_scaling, with_mass_scaling
from weavesim.run.simulation import Simulation
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

# Seven forming runs each.
pytestmark = pytest.mark.slow

SIZE = 0.005
ANGLE, DRAW_IN = 0.5, 0.5e-3
# At nodes on both meshes: "auto" depends on the size of the elements.
COMMON = {"frame_count": 4, "threads": 1, "contact_samples": "nodes"}
# One that the tolerances were first tried on, and two others.
SETUPS = {
    "default": {},
    "friction 0.1, holder 2 kN": {"friction": 0.1, "blank_holder_force": 2000.0},
    "assumed-twill": {"fabric": "assumed-twill"},
}
# In every run of the tests; the others only for the manual.
HELD = "friction 0.1, holder 2 kN"


def formed(setup):
    simulation = Simulation(setup)
    simulation.run()
    return simulation


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == HELD else pytest.mark.verification) for name in SETUPS]
)
def test_the_chosen_scaling_keeps_its_tolerances(name, manual):
    def make(mesh_size, target_step):
        return double_dome(DoubleDomeParameters(mesh_size=mesh_size, target_step=target_step, **COMMON, **SETUPS[name]))

    found = choose_mass_scaling(
        make, SIZE, angle_tolerance=ANGLE, draw_in_tolerance=DRAW_IN, factors=(3.0, 4.0, 6.0, 8.0)
    )
    assert found.factor >= 3.0
    unscaled, scaled = formed(make(SIZE, None)), formed(with_mass_scaling(make(SIZE, None), found))
    assert scaled.summary()["mass_scaling"]["factor"] == found.factor
    angle = np.degrees(np.abs(scaled.frame.fields["shear_angle"] - unscaled.frame.fields["shear_angle"]))
    # of the whole blank: planes of symmetry are none of it
    border = outline(unscaled.setup.sheet.blank, unscaled.setup.worlds[0].symmetry).node
    moved = np.linalg.norm((scaled.frame.position - unscaled.frame.position)[border], axis=1).max()
    most = float(np.quantile(angle, KEPT_SHARE))
    assert most <= ANGLE and moved <= DRAW_IN
    fewer = unscaled.state.step_count / scaled.state.step_count
    assert fewer > 0.9 * found.factor
    (tried,) = (each for each in found.tries if each.factor == found.factor)
    case = manual(
        "Process", f"Mass scaling by a stated error, {name}",
        known=f"The double dome, {name}: the largest scaling that keeps {ANGLE:g} degrees at {KEPT_SHARE:.0%} of the "
        f"elements and {1e3 * DRAW_IN:g} mm of the border on elements of 7.5 mm keeps them on elements of 5 mm.",
    )  # fmt: skip
    case.table(
        ["", "tried on 7.5 mm", "on 5 mm"],
        [["change of the shear angle at 95 % [degrees], at most 0.5", f"{tried.angle_error:.2g}", f"{most:.2g}"],
         ["largest change of any element [degrees]", "", f"{angle.max():.2g}"],
         ["change of the border [mm], at most 0.5", f"{1e3 * tried.draw_in_error:.2g}", f"{1e3 * moved:.2g}"],
         ["step over that without scaling", f"{found.factor:g}", f"{found.factor:g}"],
         ["times fewer steps", f"{tried.speed_up:.2g}", f"{fewer:.2g}"]],
    )  # fmt: skip
