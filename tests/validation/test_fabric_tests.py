"""The fabric tests as a user runs them, on coarse meshes: files, summary, and numbers that are known."""

import csv
import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.fabric.shear import ShearFriction
from weavesim.fabric.weaves import PlainWeave
from weavesim.run.simulation import Simulation
from weavesim.scenes import bias_extension, cantilever, picture_frame
from weavesim.scenes.bias_extension import BiasExtensionParameters
from weavesim.scenes.cantilever import CantileverParameters
from weavesim.scenes.picture_frame import PictureFrameParameters


def columns(path) -> dict[str, np.ndarray]:
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.fixture(scope="module")
def frame_test(tmp_path_factory):
    out = tmp_path_factory.mktemp("picture_frame")
    parameters = PictureFrameParameters(out=out, mesh_size=0.05, speed=1.0, cycle=True, frames=41, threads=1)
    return out, picture_frame.run(parameters)


def test_picture_frame_shears_as_its_frame_and_pulls_as_its_law(frame_test):
    _, summary = frame_test
    assert summary["frame_angle_deg"] == pytest.approx(40.0, abs=0.1)
    assert summary["largest_angle_error_deg"] < 1e-3
    # 1 m/s: the inertia of the start and the stop is some per cent of the largest force
    assert summary["largest_force_error_ratio"] < 0.05
    assert summary["peak_force_n"] == pytest.approx(summary["closed_form_peak_force_n"], rel=0.02)
    assert summary["energy_balance_error"] < 0.01
    assert summary["warnings"] == []
    # what the elastic law has taken it gives back
    assert abs(summary["work_of_a_cycle_j"]) < 0.01 * summary["peak_force_n"] * 0.08


def test_picture_frame_leaves_its_files(frame_test):
    out, summary = frame_test
    table = columns(out / "picture_frame.csv")
    assert len(table["force_n"]) == 42
    np.testing.assert_allclose(table["warp_tension_n_per_m"][5:], 100.0, rtol=0.01)
    # kinematics of the frame, written out
    half = np.arccos(np.sqrt(0.5) + 0.5e-3 * table["displacement_mm"] / 0.2)
    np.testing.assert_allclose(table["frame_angle_deg"], 90.0 - 2.0 * np.degrees(half), atol=2e-3)
    history = columns(out / "history.csv")
    assert {"frame_force_x_n", "frame_drive_1_displacement_m", "frame_drive_2_force_n", "support_work_j"} <= set(
        history
    )
    np.testing.assert_allclose(1e3 * history["stroke_m"], table["displacement_mm"], rtol=1e-6, atol=1e-9)
    names = {path.name for path in (out / "pictures").iterdir()}
    assert {"force.png", "angle.png", "tension.png", "formed_sheet.png", "drive_forces.png"} <= names
    assert "draw_in.png" not in names and not [name for name in summary if "draw_in" in name]
    assert json.loads((out / "summary.json").read_text())["peak_force_n"] == summary["peak_force_n"]
    report = (out / "report.html").read_text()
    assert "Supports" in report and "16 nodes with 3 drives" in report


def test_picture_frame_shows_a_friction_loop_that_yarn_tension_widens():
    """Friction of the crossovers beside the elastic law: the loop is what the ledger books as lost."""
    friction = ShearFriction(stiffness=500.0, limit=(5.0,), crossover_friction_length=2.0e-4)
    fabric = glass_polypropylene().model_copy(update={"shear_friction": friction})
    works = []
    for tension in (100.0, 400.0):
        parameters = PictureFrameParameters(
            mesh_size=0.05, speed=1.0, cycle=True, frames=80, threads=1, yarn_tension=tension
        )
        simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
        curves = picture_frame.record(parameters, fabric)
        simulation.run([curves])
        found = picture_frame.findings(curves)
        assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.03)
        assert found["largest_force_error_ratio"] < 0.05
        energies = simulation.frame.energies
        assert energies["shear_friction_loss"] > 0.9 * found["work_of_a_cycle_j"] > 0.1
        works.append(found["work_of_a_cycle_j"])
    assert works[1] > 1.1 * works[0]


def test_closed_form_counts_a_cell_that_resists_shear_and_has_no_crossovers():
    """Stitches of a tape resist shear by themselves, with nearly nothing from the sheet's own law beside them."""
    fabric = assumed_fabric("stitched-tape").with_linear_shear(100.0)
    parameters = PictureFrameParameters(mesh_size=0.1, speed=0.5, frames=30, threads=1, largest_angle=20.0)
    curves = picture_frame.record(parameters, fabric)
    Simulation(picture_frame.picture_frame(parameters, fabric)).run([curves])
    found = picture_frame.findings(curves)
    without_cell = 0.04 * fabric.shear.moment(np.radians(20.0), fabric.thickness)
    assert found["closed_form_peak_force_n"] > 100.0 * without_cell
    assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.02)
    assert found["largest_force_error_ratio"] < 0.05


def test_picture_frame_with_arms_pulls_for_all_its_fabric():
    parameters = PictureFrameParameters(mesh_size=0.05, side=0.2, arm_length=0.05, speed=1.0, frames=20, threads=1)
    fabric = glass_polypropylene()
    simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
    # 4 x 4 elements inside, 4 in each arm
    assert simulation.blank.element_count == 32
    assert len(simulation.supports[0].nodes) == 20
    curves = picture_frame.record(parameters, fabric)
    simulation.run([curves])
    found = picture_frame.findings(curves)
    assert found["mean_shear_angle_deg"] == pytest.approx(40.0, abs=0.5)
    assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.04)


def test_misaligned_yarns_are_stretched_as_the_frame_says():
    """Yarns at 2 degrees to the sides: force and tension from the even deformation of a linear membrane."""
    stiffness, misalignment = 2.0e4, np.radians(2.0)
    bending = 1.001 * stiffness * 0.005 * 0.0025**2 / 3.0
    cell = PlainWeave.straight(stiffness_per_width=stiffness, bending=bending)
    fabric = glass_polypropylene().with_linear_shear(0.25e6)
    fabric = fabric.model_copy(update={"unit_cell": cell, "compressive_stiffness": 0.0})
    parameters = PictureFrameParameters(
        mesh_size=0.05, misalignment=2.0, yarn_tension=0.0, speed=0.5, frames=20, threads=1, precision="float64"
    )
    simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
    curves = picture_frame.record(parameters, fabric)
    simulation.run([curves])

    def energy(displacement):
        half = np.arccos(np.sqrt(0.5) + displacement / 0.4)
        squeeze = np.sqrt(2.0) * np.array([np.sin(half), np.cos(half)])
        yarns = [squeeze * (np.cos(a), np.sin(a)) for a in np.pi / 4 + misalignment + np.array([0.0, np.pi / 2])]
        stretch = [np.linalg.norm(yarn) for yarn in yarns]
        shear = 0.25 * 1.2e-3 * 0.25e6 * (yarns[0] @ yarns[1]) ** 2
        return 0.04 * (0.5 * stiffness * sum((s - 1.0) ** 2 for s in stretch) + shear)

    for displacement, force in zip(
        1e-3 * curves.columns["displacement_mm"][5:], curves.columns["force_n"][5:], strict=True
    ):
        expected = (energy(displacement + 1e-6) - energy(displacement - 1e-6)) / 2e-6
        assert force == pytest.approx(expected, rel=0.01)
    assert force > 1.2 * curves.columns["closed_form_force_n"][-1]


@pytest.fixture(scope="module")
def bias_test(tmp_path_factory):
    out = tmp_path_factory.mktemp("bias_extension")
    return out, bias_extension.run(BiasExtensionParameters(out=out, mesh_size=0.0125, speed=0.5, frames=30, threads=1))


def test_bias_extension_has_its_three_zones(bias_test):
    out, summary = bias_test
    assert summary["kinematic_angle_deg"] == pytest.approx(40.0, abs=1e-3)
    # eight elements across: the zones' edges take one of them, the study of the verification manual refines
    assert 33.0 < summary["zone_c_angle_deg"] < 40.5
    assert summary["zone_b_angle_deg"] == pytest.approx(0.5 * summary["zone_c_angle_deg"], rel=0.05)
    assert abs(summary["zone_a_angle_deg"]) < 1.0
    assert 0.7 < summary["force_ratio"] < 1.1
    assert summary["energy_balance_error"] < 0.01
    table = columns(out / "bias_extension.csv")
    early = np.argmin(np.abs(table["kinematic_angle_deg"] - 10.0))
    assert table["zone_c_angle_deg"][early] == pytest.approx(table["kinematic_angle_deg"][early], rel=0.05)
    assert {path.name for path in (out / "pictures").iterdir()} >= {"force.png", "zones.png"}


def test_zones_of_the_bias_extension_fill_the_strip():
    parameters = BiasExtensionParameters(length=0.25, width=0.1)
    x, y = np.meshgrid(np.linspace(-0.125, 0.125, 1001), np.linspace(-0.05, 0.05, 401), indexing="ij")
    zone = bias_extension.zones(parameters, np.stack([x, y], axis=-1))
    areas = [np.mean(zone == k) * 0.25 * 0.1 for k in range(3)]
    np.testing.assert_allclose(areas, bias_extension.zone_areas(parameters), rtol=0.02)
    assert sum(bias_extension.zone_areas(parameters)) == pytest.approx(0.025)


@pytest.mark.parametrize("yarn", ["warp", "weft"])
def test_cantilever_gives_the_bending_stiffness_back(tmp_path, yarn):
    summary = cantilever.run(CantileverParameters(out=tmp_path, mesh_size=0.01, width=0.02, yarn=yarn, threads=1))
    assert summary["elastica_over_input"] == pytest.approx(1.0, abs=0.01)
    # the formula itself is about 5 % off the elastica at this angle
    assert summary["peirce_over_input"] == pytest.approx(1.057, abs=0.012)
    assert summary["chord_angle_deg"] == pytest.approx(41.5, abs=0.2)
    # at rest the clamp carries the weight, in the double precision that is this scene's default
    weight = 0.743 * 9.81 * 1e-3 * summary["overhang_mm"] * 0.02
    assert summary["support_force_n"]["clamp"][2] == pytest.approx(weight, rel=1e-3)
    assert summary["outcome"] == "finished" and (tmp_path / "pictures" / "chord_angle.png").exists()


def test_cantilever_compares_no_stiffness_where_the_moment_is_a_curve_or_has_friction():
    """Along the weft, whose stiffness is one number, it still does."""
    rubbing = BendingCurve.from_kawabata(1.0e-3, 2.0e-2)
    softening = BendingCurve(curvature=(0.0, 5.0, 20.0), moment_values=(0.0, 5.0e-3, 1.0e-2))
    for along, across, yarn, comparable in (
        (rubbing, 1.0e-3, "warp", False), (softening, 1.0e-3, "warp", False), (softening, 1.0e-3, "weft", True),
        (BendingCurve.straight(1.0e-3), softening, "warp", True), (1.0e-3, rubbing, "weft", False),
    ):  # fmt: skip
        fabric = glass_polypropylene().model_copy(
            update={"bending": YarnBending(warp=along, weft=across, twist=1.0e-3)}
        )
        parameters = CantileverParameters(mesh_size=0.02, width=0.02, yarn=yarn, threads=1, length=0.06)
        simulation = Simulation(cantilever.cantilever(parameters, fabric))
        x = simulation.blank.node_position
        hanging = SimpleNamespace(
            blank=simulation.blank, frame=SimpleNamespace(position=x - np.outer(x[:, 0], [0, 0, 0.5]))
        )
        found = cantilever.findings(parameters, fabric, hanging)
        for name in ("peirce_over_input", "elastica_over_input"):
            assert (found[name] is not None) == comparable
        assert found["elastica_bending_stiffness_nm"] > 0.0


@pytest.mark.parametrize("load", [1.0, 8.0, 50.0])
def test_heavy_elastica_against_a_boundary_value_problem(load):
    """theta'' = -load (1 - s) cos(theta), clamped at s = 0, no moment at s = 1."""
    s = np.linspace(0.0, 1.0, 401)
    guess = np.zeros((4, len(s)))
    for part in np.linspace(0.1, 1.0, 10) * load:
        solution = solve_bvp(
            lambda s, y, part=part: np.array([y[1], -part * (1.0 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
            lambda a, b: np.array([a[0], b[1], a[2], a[3]]), s, guess, tol=1e-9, max_nodes=50_000,
        )  # fmt: skip
        assert solution.success
        s, guess = solution.x, solution.y
    angle = float(np.arctan2(solution.y[3, -1], solution.y[2, -1]))
    assert cantilever.elastica_stiffness(angle, 1.0, 1.0) == pytest.approx(1.0 / load, rel=1e-5)
    found_load, found_angle = cantilever.heavy_elastica(float(solution.y[0, -1]))
    assert found_load == pytest.approx(load, rel=1e-5)
    assert found_angle == pytest.approx(angle, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BiasExtensionParameters(length=0.15, width=0.1), "at least twice the width"),
        (lambda: BiasExtensionParameters(mesh_size=0.02), "at least 8 elements across .* at most 0.0125 m"),
        (lambda: picture_frame.picture_frame(PictureFrameParameters(fabric="cotton")), "cotton.*choose one of"),
        (lambda: picture_frame.picture_frame(PictureFrameParameters(yarn_tension=1e9)), "a stretch of 5 % gives only"),
        (lambda: PictureFrameParameters(largest_angle=85.0), "largest_angle"),
        (lambda: CantileverParameters(yarn="bias"), "yarn"),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
