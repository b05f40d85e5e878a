"""The recipes of CONTRIBUTING for a unit cell and a law, verbatim: each adds one and runs it."""

import numpy as np
import pytest

from tests.support.kinds import imported, kinds_forgotten
from tests.support.recipes import written_recipe
from tests.support.runs import one_sheet_run
from tests.support.sheet import Sheet, plain_fabric
from weavesim.errors import InputError
from weavesim.fabric import Fabric, UnitCell, load_fabric
from weavesim.fabric.response import respond
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


@pytest.fixture
def recipe(tmp_path):
    """Writes and imports the file of a recipe, by its name; its kinds are forgotten afterwards."""

    def module(name: str):
        return imported(written_recipe(name, tmp_path), patch)

    with pytest.MonkeyPatch.context() as patch, kinds_forgotten():
        yield module


def pulled(fabric: Fabric, strain: float = 0.02) -> Simulation:
    """A square of 50 mm whose right half moves to the right, after a moment; one lane, double precision."""
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.05), 0.025)
    velocity = np.zeros((blank.node_count, 3))
    velocity[:, 0] = 100.0 * strain * blank.node_position[:, 0]
    simulation = one_sheet_run(
        name="recipe", blank=blank, fabric=fabric, duration=2.0e-4, initial_velocity=velocity, precision="float64",
        lane_count=1, threads=1,
    )  # fmt: skip
    simulation.run()
    return simulation


def test_the_recipe_of_a_unit_cell(recipe, tmp_path):
    cords = recipe("cords.py").Cords
    assert UnitCell.kinds()["Cords"] is cords
    cell = cords.examples()["cords"]()
    response = respond(cell, [[1.01, 1.0]])
    assert response.force_per_width[0] == pytest.approx([2.0e4 * 0.01, 0.0], rel=1e-9)

    path = tmp_path / "net.toml"
    path.write_text(
        'based_on = "glass-polypropylene"\n[unit_cell]\nkind = "Cords"\nwarp_stiffness = 2e4\nweft_stiffness = 1e4\n'
        '[shear]\nkind = "LinearShear"\nmodulus = 1e5\n'
    )
    assert load_fabric(path).unit_cell == cell
    assert Fabric.from_json(plain_fabric(unit_cell=cell).to_json()).unit_cell == cell

    frame = pulled(plain_fabric(unit_cell=cell)).frame
    assert frame.energies["unit_cell"] > 0.0


def test_the_recipe_of_a_law(recipe, tmp_path):
    law = recipe("stiffening_shear.py").StiffeningShear(stiffness=20.0, stiffening=300.0)
    recipe("stiffening_shear_device.py")
    path = tmp_path / "net.toml"
    path.write_text(
        'based_on = "glass-polypropylene"\n[shear]\nkind = "StiffeningShear"\nstiffness = 20.0\nstiffening = 300.0\n'
    )
    assert load_fabric(path).shear == law
    fabric = plain_fabric(shear=law)
    assert Fabric.from_json(fabric.to_json()).shear == law

    # a square of 1 cm in simple shear: all energy and all work are the law's
    blank = Blank.rectangle((0.0, 0.0), (0.01, 0.01), 0.01)
    sheet, director = Sheet(blank, fabric), np.tile([0.0, 0.0, 1.0], (blank.node_count, 1))

    def sheared(angle: float) -> np.ndarray:
        """Turned yarns of their old lengths."""
        turned = np.array([[1.0, 0.0, 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        return blank.node_position @ turned

    angle, change = 0.4, 1.0e-5
    psi = 0.5 * 20.0 * angle**2 + 0.25 * 300.0 * angle**4
    assert sheet.energies(sheared(angle), director)["shear"] == pytest.approx(1.0e-4 * psi, rel=1e-9)
    moving = (sheared(angle + change) - sheared(angle - change)) / (2.0 * change)
    work = -(sheet.forces(sheared(angle), director)[0] * moving).sum()
    assert work == pytest.approx(1.0e-4 * float(law.moment(np.array(angle), 1e-3)), rel=1e-6)
    # the stable step, which asks for the tangent, lets it run
    assert pulled(fabric).frame.energies["shear"] >= 0.0


def test_a_recipe_leaves_nothing_behind(tmp_path):
    assert "Cords" not in UnitCell.kinds()
    path = tmp_path / "net.toml"
    path.write_text('based_on = "glass-polypropylene"\n[unit_cell]\nkind = "Cords"\n')
    with pytest.raises(InputError, match="kind = 'Cords': one of"):
        load_fabric(path)
