"""A run whose sheet is trimmed and whose tool is then taken away: what all outputs show of it."""

import json

import numpy as np
import pytest

from tests.support.summary_keys import keys_without_unit
from weavesim import (
    Drive,
    Dynamics,
    Fixed,
    Setup,
    Sheet,
    Simulation,
    SmoothStroke,
    Solver,
    Sphere,
    Stage,
    Stroke,
    Support,
    Tool,
    Trim,
)
from weavesim.fabric.presets import glass_polypropylene
from weavesim.output.film.reading import StoredFilm
from weavesim.output.folder import ResultFolder
from weavesim.output.stored.file import read_results
from weavesim.run.staging.part import Part, part_of
from weavesim.run.verdict import Judged
from weavesim.sheet.blank import Blank

SIDE, SIZE = 0.08, 0.01
LEFT = [(-1.0, -1.0), (0.051, -1.0), (0.051, 1.0), (-1.0, 1.0)]


@pytest.fixture(scope="module")
def trimmed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trimmed")
    fabric = glass_polypropylene()
    blank = Blank.rectangle((0.0, 0.0), (SIDE, SIDE), SIZE)
    x = blank.node_position[:, 0]
    pull = Drive(SmoothStroke((0.0, 1e-3), (0.0, 1e-4), (0.0, 0.0)), (1.0, 0.0, 0.0))
    supports = [Support("left", np.flatnonzero(x < 1e-9)), Support("right", np.flatnonzero(x > SIDE - 1e-9), (pull,))]
    ball = Sphere(0.02, origin=(0.02, 0.04, -0.02 - 0.5 * fabric.thickness))
    stages = (
        Stage("form", 1e-3, frame_count=2),
        Stage("trim", 5e-4, trims=[Trim(LEFT)], moves={"ball": Fixed()}, frame_count=2),
        Stage("release", 5e-4, tools=(), frame_count=2),
    )
    setup = Setup(
        "trimmed", sheets=[Sheet(blank, fabric, supports=supports)], stages=stages, symmetry=("y",),
        tools=[Tool("ball", ball, Stroke((0.0, 1e-3), (0.0, 5e-4)))], dynamics=Dynamics(damping=100.0),
        solver=Solver(lane_count=1, threads=1),
    )  # fmt: skip
    simulation = Simulation(setup)
    results = ResultFolder(folder, writers=["film", "paraview", "report", "results", "pictures", "summary", "tables"])
    simulation.run([results])
    results.write(simulation.summary())
    return folder, simulation


def test_frames_have_no_values_of_waste(trimmed):
    _, simulation = trimmed
    info, frame = simulation.info.sheets[0], simulation.frame.sheet
    assert frame.kept.sum() == 40 and len(frame.fields["shear_angle"]) == 64
    # no tool acts any longer: there is no gap to one
    fields = {name: values for name, values in frame.fields.items() if name != "tool_gap"}
    for values in (*fields.values(), *frame.resultants.values()):
        assert np.isnan(values[~frame.kept]).all() and np.isfinite(values[frame.kept]).all()
    part, there = part_of(info, frame)
    nodes = Part(info, frame.kept).nodes
    assert part.blank.element_count == 40 and np.array_equal(there.position, frame.position[nodes])
    assert Judged(simulation).sheets[0].blank.element_count == 40
    assert simulation.summary()["trims"][0]["element_count"] == 24
    (doubt,) = [doubt for doubt in simulation.doubts() if doubt.guard == "trims"]
    assert 0.9e-3 < doubt.value < 1e-3 and "mm off its curves" in doubt.message
    assert simulation.summary()["unit_cell_failures"] == 0


def test_the_film_loses_faces_and_the_tool(trimmed):
    folder, _ = trimmed
    film = StoredFilm(folder / "trimmed.usdc")
    (sheet,), (ball,) = film.sheets, film.tools
    counts = {frame: len(film.faces(sheet, frame)) for frame in film.frames}
    assert counts == {0: 64, 1: 64, 2: 64, 3: 40, 4: 40, 5: 40, 6: 40}
    assert {frame: len(film.values(sheet, "shear_angle_deg", frame)) for frame in film.frames} == counts
    assert all(np.isfinite(film.values(sheet, "shear_angle_deg", frame)).all() for frame in film.frames)
    assert [film.is_shown(ball, frame) for frame in film.frames] == [True] * 5 + [False] * 2
    assert film.is_trimmed(sheet) and not film.is_trimmed(ball)


def test_paraview_has_neither(trimmed):
    pyvista = pytest.importorskip("pyvista")
    folder, _ = trimmed
    cells = [pyvista.read(folder / f"paraview/frame_{k:04d}_sheet.vtu").n_cells for k in range(7)]
    assert cells == [128, 128, 128, 80, 80, 80, 80]  # with its mirror image
    tools = ["ball" in (folder / f"paraview/frame_{k:04d}.vtm").read_text() for k in range(7)]
    assert tools == [True] * 5 + [False] * 2
    assert pyvista.read(folder / "paraview/final_state.vtu").n_cells == 40


def test_results_are_those_of_what_stays(trimmed):
    folder, simulation = trimmed
    stored = read_results(folder).sheets[0]
    frame = simulation.frame.sheet
    assert stored.blank.element_count == 40
    assert np.array_equal(stored.fields["warp_stretch"], frame.fields["warp_stretch"][frame.kept])
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["missing"] == [] and summary["trims"][0]["stage"] == "trim"
    assert not keys_without_unit(summary)
    assert summary["max_shear_angle_deg"] == pytest.approx(
        np.rad2deg(np.abs(frame.fields["shear_angle"][frame.kept]).max()), rel=1e-4
    )
    assert (folder / "history.csv").read_text().splitlines()[0].count("trimmed_energy_j") == 1


def test_the_page_hides_both(trimmed, browser):
    folder, _ = trimmed
    with browser.open(folder / "report.html") as opened:
        opened.page.wait_for_function("weavesim.page && weavesim.page.view && weavesim.page.view.tools.length")
        counts = opened.page.evaluate(
            """async () => {
              const { page } = weavesim;
              const found = [];
              page.view.showTool(page.view.tools[0], true);
              for (let k = 0; k < page.frameCount; k += 1) {
                await page.setFrame(k);
                const [sheet] = page.sheets;
                let count = 0;
                for (let e = 0; e < sheet.elementCount; e += 1) if (sheet.has(e)) count += 1;
                found.push([count, page.view.tools[0].mesh.visible]);
              }
              return found;
            }"""
        )
        assert counts == [[64, True]] * 3 + [[40, True]] * 2 + [[40, False]] * 2
        assert opened.errors == []
