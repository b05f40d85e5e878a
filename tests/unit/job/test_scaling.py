"""Jobs that ask for mass scaling by a stated error: what is searched, what a run tells, and what is refused."""

import json

import pytest

from tests.support.jobs import TRAY, write_tray
from weavesim import InputError
from weavesim.app.jobs.form import run_job
from weavesim.engine.setup import Setup
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.scaling import scaled_setup_of
from weavesim.process.scaling.mass import MassScaling
from weavesim.run.scaling import mass
from weavesim.run.simulation import Simulation

BALL = """
name = "pushed"

[[ply]]
fabric = "glass-polypropylene"
rectangle = ["36 mm", "36 mm"]
centre = ["18 mm", "18 mm"]
mesh_size = "6 mm"
height = "0 mm"

[[tool]]
name = "ball"
shape = { kind = "Sphere", radius = "20 mm", origin = [0, 0, "20.6 mm"] }
faces = "down"
stroke = "6 mm"
speed = "0.5 m/s"

[process]
symmetry = ["x", "y"]

[solver]
threads = 1
SOLVER

[output]
frame_count = 2
write = ["results"]
"""
WANTED = 'mass_scaling_angle = "5 deg"\nmass_scaling_draw_in = "20 mm"'


def job(folder, solver, text=BALL):
    path = folder / "pushed.toml"
    path.write_text(text.replace("SOLVER", solver))
    return read_job(path)


@pytest.fixture
def one_factor(monkeypatch):
    """Only the first factor is tried."""
    monkeypatch.setattr(mass.choose_mass_scaling, "__kwdefaults__", {
        **mass.choose_mass_scaling.__kwdefaults__, "factors": (2.0,)
    })  # fmt: skip


def test_a_run_looks_for_its_scaling_tells_it_and_repeats(tmp_path, one_factor):
    out = tmp_path / "out"
    summary = run_job(job(tmp_path, WANTED), out)
    told = summary["mass_scaling"]
    assert told["factor"] == 2.0 and told["coarse_mesh_size_m"] == pytest.approx(0.009)
    assert told["angle_tolerance_deg"] == 5.0 and told["draw_in_tolerance_m"] == 0.02
    stored = Setup.from_json((out / "setup.json").read_text())
    assert stored.solver.target_step == told["target_step_s"] and stored.solver.mass_scaling.factor == 2.0
    assert "mass scaling for 5 degrees" in (out / "run.log").read_text()
    options = json.loads((out / "run.json").read_text())["options"]
    assert options["solver.mass_scaling_angle"] == "5 deg"
    # with the step of its summary instead of the search, the same run
    again = setup_of(job(tmp_path, f"target_step = {told['target_step_s']!r}"))
    simulation = Simulation(again)
    simulation.run()
    assert simulation.state.step_count == summary["step_count"]
    assert simulation.summary()["max_shear_angle_deg"] == summary["max_shear_angle_deg"]


def test_one_tolerance_is_enough_and_without_any_nothing_is_sought(tmp_path, monkeypatch):
    asked = []

    def chosen(make, mesh_size, **tolerances):
        asked.append((make(0.009, 2e-6), mesh_size, tolerances))
        return MassScaling(factor=2.0, target_step=4e-6, mesh_size=mesh_size, coarse_size=0.009, angle_tolerance=0.5,
                           draw_in_tolerance=tolerances["draw_in_tolerance"])  # fmt: skip

    monkeypatch.setattr("weavesim.job.scaling.choose_mass_scaling", chosen)
    assert scaled_setup_of(job(tmp_path, "")).solver.target_step is None and not asked
    setup = scaled_setup_of(job(tmp_path, 'mass_scaling_draw_in = "0.2 mm"'))
    ((coarse, mesh_size, tolerances),) = asked
    assert mesh_size == 0.006 and tolerances == {"angle_tolerance": 0.5, "draw_in_tolerance": 2e-4}
    assert coarse.sheet.blank.element_count == 16 and coarse.solver.target_step == 2e-6
    assert setup.solver.target_step == 4e-6 and setup.sheet.blank.element_count == 36


@pytest.mark.parametrize(
    ("solver", "message"),
    [
        ('mass_scaling_angle = "0.5 deg"\ntarget_step = "0.001 ms"', "target_step: it is what a search by"),
        ('mass_scaling_angle = "0.5 deg"\ntime_step = "0.001 ms"', "time_step: it is what a search by"),
        ('mass_scaling_angle = "0 deg"', "mass_scaling_angle = 0.0"),
        ('mass_scaling_draw_in = "2 m"', "at most 1 m is allowed"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, solver, message):
    with pytest.raises(InputError, match=message):
        job(tmp_path, solver)


def test_a_ply_with_its_own_mesh_cannot_be_coarser(tmp_path):
    import numpy as np

    x, y = (values.ravel() for values in np.meshgrid(np.arange(4), np.arange(4)))
    corner = [k for k in range(12) if k % 4 < 3]
    lines = [f"v {10 * a} {10 * b} 0" for a, b in zip(x, y, strict=True)]
    lines += [f"f {k + 1} {k + 2} {k + 6} {k + 5}" for k in corner]
    (tmp_path / "ply.obj").write_text("\n".join(lines) + "\n")
    text = BALL.replace(
        'rectangle = ["36 mm", "36 mm"]\ncentre = ["18 mm", "18 mm"]', 'outline = "ply.obj"\nunit = "mm"'
    )
    with pytest.raises(InputError, match=r"\[solver\]: mass_scaling_angle: sheet ply: its mesh does not depend"):
        scaled_setup_of(job(tmp_path, 'mass_scaling_angle = "0.5 deg"', text))


def test_a_scene_in_a_job_takes_the_tolerances(tmp_path):
    from weavesim.job.scenes import scene_of

    path = tmp_path / "dome.toml"
    path.write_text('[scene]\nname = "double-dome"\n[solver]\nmass_scaling_angle = "0.5 deg"\n')
    _, parameters = scene_of(read_job(path), out=tmp_path / "out")
    assert parameters.tolerances == {"angle_tolerance": 0.5, "draw_in_tolerance": 0.5e-3}
    path.write_text('[scene]\nname = "double-dome"\nmass_scaling_angle = 0.5\n')
    with pytest.raises(InputError, match=r"mass_scaling_angle: write it in \[solver\]"):
        scene_of(read_job(path), out=tmp_path / "out")


def test_a_study_does_not_search(tmp_path):
    from weavesim.study.factors import Factor  # noqa: F401
    from weavesim.study.job_subject import JobSubject

    path = write_tray(tmp_path, TRAY + '\n[solver]\nmass_scaling_angle = "0.5 deg"\n')
    with pytest.raises(InputError, match="every run of a study would look for a scaling of its own"):
        JobSubject(path).with_common_points(10)
