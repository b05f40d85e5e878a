"""A mesh in no order that is put in order forms as the same mesh in rows does, and its results have its own numbers."""

import h5py
import meshio
import numpy as np
import pytest

from tests.support.mesh_files import elements_of_deck, nodes_of_deck
from weavesim import (
    Drive,
    Dynamics,
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
)
from weavesim.fabric.presets import glass_polypropylene
from weavesim.output.export.exporting import Export, export_run
from weavesim.output.folder import ResultFolder
from weavesim.output.stored.file import read_results
from weavesim.process.stages import Trim
from weavesim.sheet.blank import Blank

SIDE, COUNT = 0.08, 8
ROWS = Blank.rectangle((0.0, 0.0), (SIDE, SIDE), SIDE / COUNT, distortion=0.2)
FIRST_NODE, FIRST_ELEMENT = 301, 7001
LEFT = [(-1.0, -1.0), (0.051, -1.0), (0.051, 1.0), (-1.0, 1.0)]
RANDOM = np.random.default_rng(8)
# row in ROWS of every node and element of the deck, in its sequence
NODES, ELEMENTS = RANDOM.permutation(ROWS.node_count), RANDOM.permutation(ROWS.element_count)


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    """The mesh of ROWS as a deck in no order, in mm."""
    path = tmp_path_factory.mktemp("deck") / "blank.inp"
    quads = np.argsort(NODES)[ROWS.quads[ELEMENTS]]
    nodes = nodes_of_deck(1e3 * ROWS.node_position[NODES], FIRST_NODE).replace("0.00000", "0.")
    path.write_text(f"*NODE\n{nodes}*ELEMENT, TYPE=S4\n{elements_of_deck(quads, FIRST_ELEMENT, FIRST_NODE)}")
    return path


def rows_of(blank: Blank) -> tuple[np.ndarray, np.ndarray]:
    """Rows in ROWS of the nodes and elements of a blank, by their numbers."""
    if blank.node_number is None:
        return np.arange(blank.node_count), np.arange(blank.element_count)
    return NODES[blank.node_number - FIRST_NODE], ELEMENTS[blank.element_number - FIRST_ELEMENT]


def setup_with(blank: Blank, left: np.ndarray, right: np.ndarray, **given) -> Setup:
    """A ball under a sheet between two supports, one of which pulls; trimmed in its second stage."""
    fabric = glass_polypropylene()
    pull = Drive(SmoothStroke((0.0, 1e-3), (0.0, 1e-4), (0.0, 0.0)), (1.0, 0.0, 0.0))
    ball = Sphere(0.02, origin=(0.02, 0.04, -0.02 - 0.5 * fabric.thickness))
    stages = (Stage("form", 4e-4, frame_count=2), Stage("trim", 1e-4, trims=[Trim(LEFT)], frame_count=1))
    return Setup(
        "numbered", sheets=[Sheet(blank, fabric, supports=(Support("left", left), Support("right", right, (pull,))))],
        stages=stages, tools=[Tool("ball", ball, Stroke((0.0, 4e-4), (0.0, 4e-4)))], dynamics=Dynamics(damping=100.0),
        solver=Solver(lane_count=1, threads=1, precision="float64"), **given,
    )  # fmt: skip


def formed(folder, blank: Blank, left: np.ndarray, right: np.ndarray) -> Simulation:
    simulation = Simulation(setup_with(blank, left, right))
    results = ResultFolder(folder, writers=["paraview", "results", "summary", "tables"])
    simulation.run([results])
    results.write(simulation.summary())
    return simulation


def ends() -> tuple[np.ndarray, np.ndarray]:
    """Rows in ROWS of the nodes at both ends."""
    x = ROWS.node_position[:, 0]
    return np.flatnonzero(x < 1e-9), np.flatnonzero(x > SIDE - 1e-9)


@pytest.fixture(scope="module")
def both(tmp_path_factory, deck):
    """Folder and run of the mesh in rows, and of that in no order, whose supports are given by its numbers."""
    blank = Blank.from_file(deck, unit_scale=0.001, numbering="neighbouring")
    number = FIRST_NODE + np.argsort(NODES)
    folders = [tmp_path_factory.mktemp(name) for name in ("rows", "deck")]
    runs = [
        formed(folders[0], ROWS, *ends()),
        formed(folders[1], blank, *(blank.nodes_numbered(number[rows]) for rows in ends())),
    ]
    return list(zip(folders, runs, strict=True))


def test_the_answer_is_the_same_to_rounding(both):
    (_, rows), (_, deck) = both
    frames = [run.frame.sheet for run in (rows, deck)]
    assert 3e-4 < np.abs(frames[0].position - ROWS.node_position).max() < 1e-3
    nodes, elements = rows_of(deck.info.sheets[0].blank)
    assert (nodes != np.arange(len(nodes))).mean() > 0.8
    # coordinates of the deck have nine digits: 1e-10 m
    assert np.abs(frames[1].position - frames[0].position[nodes]).max() < 2e-9
    assert np.array_equal(frames[1].kept, frames[0].kept[elements]) and frames[0].kept.sum() < len(elements)
    for name in ("shear_angle", "warp_stretch", "weft_stretch"):
        there = frames[1].kept
        values, wanted = frames[1].fields[name][there], frames[0].fields[name][elements][there]
        assert np.abs(values - wanted).max() < 1e-8 and np.ptp(wanted) > 1e-4
    forces = [run.frame.support_force for run in (rows, deck)]
    assert forces[1] == pytest.approx(forces[0], rel=1e-4, abs=1e-4)


def test_results_carry_the_numbers_of_the_deck(both):
    (plain, _), (folder, run) = both
    with h5py.File(folder / "results.h5") as file:
        about = file["sheets/0/reference"]
        nodes, elements = about["node_number"][()], about["element_number"][()]
        assert np.allclose(about["node_position"][()], ROWS.node_position[NODES[nodes - FIRST_NODE]], atol=1e-9)
        corners = NODES[nodes[about["quads"][()]] - FIRST_NODE]
        assert np.array_equal(corners, ROWS.quads[ELEMENTS[elements - FIRST_ELEMENT]])
        assert len(elements) < ROWS.element_count
    with h5py.File(plain / "results.h5") as file:
        assert "node_number" not in file["sheets/0/reference"]
    (stored,) = read_results(folder).sheets
    assert np.array_equal(stored.blank.node_number, nodes)
    assert np.array_equal(stored.blank.element_number, elements)


def test_files_for_paraview_carry_them(both):
    (plain, _), (folder, _) = both
    for name in ("frame_0000_sheet.vtu", "frame_0003_sheet.vtu", "final_state.vtu"):
        mesh = meshio.read(folder / "paraview" / name)
        flat = mesh.point_data["flat_coordinates_m"]
        nodes = NODES[mesh.point_data["node_number"] - FIRST_NODE]
        assert np.allclose(flat, ROWS.node_position[nodes], atol=1e-8)
        elements = ELEMENTS[mesh.cell_data["element_number"][0] - FIRST_ELEMENT]
        assert np.array_equal(nodes[mesh.cells[0].data], ROWS.quads[elements])
        assert "node_number" not in meshio.read(plain / "paraview" / name).point_data


def test_the_table_of_draw_in_names_both(both):
    (plain, _), (folder, run) = both
    head, *lines = (folder / "draw_in.csv").read_text().splitlines()
    assert head.startswith("node,node_number,flat_x_mm")
    table = np.array([line.split(",") for line in lines], dtype=float)
    place = ROWS.node_position[NODES[table[:, 1].astype(int) - FIRST_NODE]]
    assert np.allclose(table[:, 2:4], 1e3 * place[:, :2], atol=1e-5)
    assert (plain / "draw_in.csv").read_text().startswith("node,flat_x_mm")


def test_exported_decks_have_the_numbers(both, tmp_path):
    _, (folder, run) = both
    done = export_run(
        read_results(folder), Export(["abaqus", "lsdyna", "nastran", "openradioss", "hdf5", "csv"], tmp_path)
    )
    files = {path.suffix: path for path in done.files}
    there, nodes_there = run.frame.sheet.kept, np.unique(run.info.sheets[0].blank.quads[run.frame.sheet.kept])
    blank = run.info.sheets[0].blank
    wanted_nodes = set(blank.node_number[nodes_there].tolist())
    wanted = {
        int(number): blank.node_number[corners].tolist()
        for number, corners in zip(blank.element_number[there], blank.quads[there], strict=True)
    }
    lines = files[".inp"].read_text().splitlines()
    begin = next(k for k, line in enumerate(lines) if line.startswith("*ELEMENT"))
    found = (list(map(int, line.split(","))) for line in lines[begin + 1 : begin + 1 + len(wanted)])
    assert {element: corners for element, *corners in found} == wanted
    assert len(meshio.read(files[".inp"]).points) == len(wanted_nodes)
    lines = files[".k"].read_text().splitlines()
    begin = lines.index("*ELEMENT_SHELL_COMPOSITE")
    rows = [line for line in lines[begin + 1 : -1] if len(line) == 48 and "." not in line]
    assert {int(row[:8]): [int(row[k : k + 8]) for k in range(16, 48, 8)] for row in rows} == wanted
    rows = [line.split() for line in files[".bdf"].read_text().splitlines() if line.startswith("CQUAD4")]
    assert {int(row[1]): list(map(int, row[3:])) for row in rows} == wanted
    text = files[".rad"].read_text()
    assert all(f"\n{number:10d}" in text for number in wanted)
    with h5py.File(files[".h5"]) as file:
        assert set(file["mesh/node_numbers"][()].tolist()) == wanted_nodes
        assert set(file["mesh/element_numbers"][()].tolist()) == set(wanted)
    column = [int(line.split(",")[0]) for line in files[".csv"].read_text().splitlines()[1:]]
    assert set(column) == set(wanted)


def test_the_set_up_of_its_folder_gives_the_same_bits(both):
    _, (folder, run) = both
    setup = Setup.from_json((folder / "setup.json").read_text())
    assert setup == run.setup and setup.sheet.blank.node_number is not None
    again = Simulation(setup)
    again.run()
    assert np.array_equal(again.frame.sheet.position, run.frame.sheet.position)
