"""The picture frame as a user runs it, on a coarse mesh: files, summary, and numbers that are known."""

import json

import numpy as np
import pytest

from tests.support.tables import columns
from weavesim.engine.setup import Solver
from weavesim.errors import InputError
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import assumed_fabric, glass_polypropylene
from weavesim.fabric.shear import ShearFriction
from weavesim.run.simulation import Simulation
from weavesim.scenes import picture_frame
from weavesim.scenes.picture_frame import PictureFrameParameters


@pytest.fixture(scope="module")
def frame_test(tmp_path_factory):
    out = tmp_path_factory.mktemp("picture_frame")
    parameters = PictureFrameParameters(out=out, mesh_size=0.05, speed=1.0, cycle=True, frame_count=41, threads=1)
    return out, picture_frame.SCENE.run(parameters)


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
    assert "support frame" in report and "16 nodes" in report


def test_picture_frame_shows_a_friction_loop_that_yarn_tension_widens():
    """Crossover friction in addition to the elastic law: the area of the loop is what the ledger books as lost."""
    friction = ShearFriction(stiffness=500.0, limit=(5.0,), crossover_friction_length=2.0e-4)
    fabric = glass_polypropylene().model_copy(update={"shear_friction": friction})
    works = []
    for tension in (100.0, 400.0):
        parameters = PictureFrameParameters(
            mesh_size=0.05, speed=1.0, cycle=True, frame_count=80, threads=1, yarn_tension=tension
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
    """Stitches of a tape resist shear by themselves, with almost no contribution from the sheet's own law."""
    fabric = assumed_fabric("stitched-tape").with_linear_shear(100.0)
    parameters = PictureFrameParameters(
        mesh_size=0.1, speed=0.5, frame_count=30, threads=1, largest_angle=20.0, accept_unusual=True
    )
    curves = picture_frame.record(parameters, fabric)
    setup = picture_frame.picture_frame(parameters, fabric)
    # kernels that tests of this cell have too
    Simulation(setup.model_copy(update={"solver": Solver(precision="float64", lane_count=1, threads=1)})).run([curves])
    found = picture_frame.findings(curves)
    without_cell = 0.04 * fabric.shear.moment(np.radians(20.0), fabric.thickness)
    assert found["closed_form_peak_force_n"] > 100.0 * without_cell
    assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.02)
    assert found["largest_force_error_ratio"] < 0.05


def test_picture_frame_with_arms_pulls_for_all_its_fabric():
    parameters = PictureFrameParameters(mesh_size=0.05, side=0.2, arm_length=0.05, speed=1.0, frame_count=20, threads=1)
    fabric = glass_polypropylene()
    simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
    # 4 x 4 elements inside, 4 in each arm
    assert simulation.setup.sheet.blank.element_count == 32
    assert len(simulation.setup.supports[0].nodes) == 20
    curves = picture_frame.record(parameters, fabric)
    simulation.run([curves])
    found = picture_frame.findings(curves)
    assert found["mean_shear_angle_deg"] == pytest.approx(40.0, abs=0.5)
    assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.04)


def test_a_fabric_smaller_than_its_frame_behind_a_mechanism_gives_the_same_law():
    """The frame of HKUST's size with a mechanism: machine force and way change, the normalised force does not."""
    fabric = glass_polypropylene()
    given = {"side": 0.14, "mesh_size": 0.035, "speed": 0.5, "frame_count": 20, "threads": 1}
    found = {}
    for name, frame in (("own", {}), ("larger", {"frame_side": 0.18}), ("geared", {"frame_side": 0.18,
                                                                                   "load_factor": 4.25})):  # fmt: skip
        parameters = PictureFrameParameters(**given, **frame)
        curves = picture_frame.record(parameters, fabric)
        Simulation(picture_frame.picture_frame(parameters, fabric)).run([curves])
        found[name] = curves.columns
        assert found[name]["frame_angle_deg"][-1] == pytest.approx(40.0, abs=0.1)
        assert found[name]["mean_shear_angle_deg"][-1] == pytest.approx(40.0, abs=0.1)
        # written out: F = A m / (L sin(theta)), and F_s L / A = m / cos(gamma)
        moment, theta = float(fabric.shear.moment(np.radians(40.0), fabric.thickness)), np.radians(25.0)
        side, factor = frame.get("frame_side", 0.14), frame.get("load_factor", 1.0)
        expected = factor * 0.14**2 * moment / (side * np.sin(theta))
        assert found[name]["force_n"][-1] == pytest.approx(expected, rel=0.02)
        normalised = found[name]["normalised_shear_force_n_per_m"][-1]
        assert normalised == pytest.approx(moment / np.cos(np.radians(40.0)), rel=0.02)
        way = 1e3 * side * (2.0 * np.cos(theta) - np.sqrt(2.0)) / factor
        assert found[name]["displacement_mm"][-1] == pytest.approx(way, rel=1e-3)


def test_a_measured_curve_stands_beside_the_computed_one(tmp_path):
    """Another laboratory's table of the same law, with an error of 10 %: the difference is 10 %."""
    fabric = glass_polypropylene()
    angle = np.linspace(2.0, 38.0, 19)
    force = fabric.shear.moment(np.radians(angle), fabric.thickness) / np.cos(np.radians(angle))
    rows = "".join(f"{a:g};{1e-3 * f / 1.1:.6g}\n" for a, f in zip(angle, force, strict=True)).replace(".", ",")
    (tmp_path / "frame.csv").write_text("Angle [°];Normalised force [N/mm]\n" + rows, encoding="utf-8")
    parameters = PictureFrameParameters(
        out=tmp_path / "out", mesh_size=0.05, speed=0.25, frame_count=40, threads=1, measured=tmp_path / "frame.csv",
        write="summary,pictures",
    )  # fmt: skip
    summary = picture_frame.SCENE.run(parameters)
    (label,) = summary["measured_rms_difference_ratio"]
    assert summary["measured_largest_difference_ratio"][label] == pytest.approx(0.1, abs=0.02)
    assert 0.02 < summary["measured_rms_difference_ratio"][label] < 0.1
    assert summary["measured_compared_share"][label] == 1.0
    assert (tmp_path / "out" / "pictures" / "normalised_force.png").exists()


def test_misaligned_yarns_are_stretched_as_the_frame_says():
    """Yarns at 2 degrees to the sides: force and tension from the even deformation of a linear membrane."""
    stiffness, misalignment = 2.0e4, np.radians(2.0)
    bending = 1.001 * stiffness * 0.005 * 0.0025**2 / 3.0
    cell = PlainWeave.straight(stiffness_per_width=stiffness, bending=bending)
    fabric = glass_polypropylene().with_linear_shear(0.25e6)
    fabric = fabric.model_copy(update={"unit_cell": cell, "compressive_stiffness": 0.0})
    parameters = PictureFrameParameters(
        mesh_size=0.05, misalignment=2.0, yarn_tension=0.0, speed=0.5, frame_count=20, threads=1, precision="float64"
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


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: picture_frame.picture_frame(PictureFrameParameters(fabric="cotton")), "cotton.*choose one of"),
        (lambda: picture_frame.picture_frame(PictureFrameParameters(yarn_tension=9e5)), "a stretch of 5 % gives only"),
        (lambda: PictureFrameParameters(largest_angle=85.0), "largest_angle"),
        (lambda: PictureFrameParameters(frame_side=0.1), "clamped square of 0.2 m, .*must fit in"),
        (lambda: PictureFrameParameters(load_factor=0.0), "load_factor"),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
