"""The recipes of CONTRIBUTING for a writer and an output field, verbatim: each adds one and uses it."""

import sys

import meshio
import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.support.kinds import imported
from tests.support.recipes import written_recipe
from tests.support.runs import small_run
from weavesim.app.options import RunOptions
from weavesim.output import Film, ParaViewSeries, ResultFolder, known_writers
from weavesim.output import writer as writer_module
from weavesim.output import writers as writers_folder
from weavesim.run import fields
from weavesim.run.frame import Outcome


@pytest.fixture
def fields_forgotten():
    """What is added during a test is unknown afterwards."""
    before = list(fields.FIELDS)
    yield
    fields.FIELDS[:] = before


@pytest.fixture
def writer_folder(tmp_path, monkeypatch):
    """A folder that counts as part of ``weavesim/output/writers``; what is found in it is unknown afterwards."""
    before = dict(known_writers())
    monkeypatch.setattr(writers_folder, "__path__", [*writers_folder.__path__, str(tmp_path)])
    yield tmp_path
    for name in [name for name, module in sys.modules.items() if str(tmp_path) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]
    writer_module._known.clear()
    writer_module._known.update(before)


def play(observer, run):
    info, frames = run
    observer.start(info)
    for frame in frames:
        observer.frame(frame)
    observer.finish(Outcome.FINISHED)


def test_the_recipe_of_a_writer(writer_folder, tmp_path, coarse_run, stack):
    written_recipe("obj.py", writer_folder)
    assert "obj" in known_writers()
    assert RunOptions(write="obj").writers == ("obj",) and "obj" in RunOptions(without="film").writers
    for run, names in ((coarse_run, ("formed.obj",)), (stack, ("formed_upper.obj", "formed_lower.obj"))):
        out = tmp_path / run[0].name
        folder = ResultFolder(out, writers=["obj"])
        play(folder, run)
        folder.write({})
        for name, sheet, state in zip(names, run[0].sheets, run[1][-1].sheets, strict=True):
            mesh = meshio.read(out / name)
            assert mesh.points == pytest.approx(state.position, abs=1e-9)
            assert np.array_equal(mesh.cells_dict["quad"], sheet.blank.quads)


def test_the_recipe_of_an_output_field(fields_forgotten, tmp_path, coarse_run):
    imported(written_recipe("current_density.py", tmp_path), pytest.MonkeyPatch())
    info, frames = coarse_run
    fabric, count = info.sheet.fabric, info.sheet.blank.element_count
    run = small_run()
    density = run.frame.fields["current_areal_density"]
    assert density == pytest.approx(run.setup.sheets[0].fabric.areal_density / run.frame.fields["area_ratio"])

    rows = {name: np.full(count, 1.25) for name in fields.ElementField.names()}
    report = {name: np.zeros(count) for name in ("iterations", "snap_loss", "worst_residual")}
    values = fields.complete(fabric, rows, report)
    assert values["current_areal_density"] == pytest.approx(np.full(count, fabric.areal_density / 1.25))

    frames[0].fields["current_areal_density"] = values["current_areal_density"]
    try:
        play(Film(tmp_path / "film.usdc"), (info, frames[:1]))
        play(ParaViewSeries(tmp_path), (info, frames[:1]))
    finally:
        del frames[0].fields["current_areal_density"]
    stage = Usd.Stage.Open(str(tmp_path / "film.usdc"))
    filmed = (
        UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/sheets/sheet")).GetPrimvar("current_areal_density").Get(0.0)
    )
    assert np.array(filmed) == pytest.approx(values["current_areal_density"])
    stored = meshio.read(tmp_path / "final_state.vtu").cell_data["current_areal_density_kg_per_m2"][0]
    assert np.array_equal(stored, values["current_areal_density"])


def test_the_recipe_of_a_permeability(fields_forgotten, tmp_path):
    from weavesim.output.stored.file import read_results

    imported(written_recipe("permeability.py", tmp_path), pytest.MonkeyPatch())
    folder = ResultFolder(tmp_path / "run", writers=["results"])
    small_run().run([folder])
    value = read_results(tmp_path / "run").sheets[0].values["permeability_1"]
    assert value.unit == "m^2" and value.values == pytest.approx(np.full(16, 0.667e-10 * 0.6028), rel=1e-3)


def test_recipes_leave_nothing_behind():
    assert "obj" not in known_writers()
    assert not {"current_areal_density", "permeability_1"} & {field.name for field in fields.FIELDS}
