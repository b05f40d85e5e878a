"""The recipes of CONTRIBUTING for a unit cell and a law, as they stand there: each adds one and runs it."""

import numpy as np
import pytest

from tests.support.kinds import imported, kinds_forgotten
from tests.support.recipes import written_recipe
from tests.support.runs import one_sheet_run
from tests.support.sheet import plain_fabric
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


def test_a_recipe_leaves_nothing_behind(tmp_path):
    assert "Cords" not in UnitCell.kinds()
    path = tmp_path / "net.toml"
    path.write_text('based_on = "glass-polypropylene"\n[unit_cell]\nkind = "Cords"\n')
    with pytest.raises(InputError, match="kind = 'Cords': one of"):
        load_fabric(path)
