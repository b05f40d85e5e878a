"""Jobs as subjects: one key for one set-up, repeats that change nothing that is meant, and the numbers of a run."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.support.studies import SMALL, write_small_job
from weavesim.app.command_line import SCENES
from weavesim.app.jobs.form import run_job
from weavesim.errors import InputError
from weavesim.study.factors import factor_of
from weavesim.study.job_subject import JobSubject, uneven
from weavesim.study.measures import flattened
from weavesim.study.plans.trials import Trial
from weavesim.study.schema import NoiseTable, VaryTable
from weavesim.study.subject import compute

STIFFNESS = (factor_of(VaryTable(key="spring.corner.stiffness", range=("0.5 N/mm", "2 N/mm"))),)


@pytest.fixture(scope="module")
def subject(tmp_path_factory) -> JobSubject:
    return JobSubject(write_small_job(tmp_path_factory.mktemp("job")), threads=1)


def test_one_set_up_has_one_key_however_it_is_written(subject):
    other = (factor_of(VaryTable(key="spring.corner.stiffness", range=(500.0, 2000.0))),)
    one, same = subject.case(STIFFNESS, Trial((1.0,))), subject.case(other, Trial((1000.0,)))
    assert one.key == same.key and one.setup_hash == one.task.setups[0][1].content_hash
    assert subject.case(STIFFNESS, Trial((1.5,))).key != one.key


@pytest.mark.parametrize(
    ("settings", "other", "message"),
    [
        (("spring.corner.stiffness=900",), None, "spring.corner.stiffness is varied, and set for all runs"),
        (("spring.corner.stiffness=1.0 N/mm",), None, "spring.corner.stiffness is varied, and set for all runs"),
        (("springs.corner.stiffness=900",), None, "is varied, and set for all runs, as springs.corner.stiffness too"),
        ((), "spring.stiffness", "spring.stiffness is varied twice, as spring.corner.stiffness too"),
    ],
)
def test_a_value_is_given_in_one_place(subject, settings, other, message):
    more = () if other is None else (factor_of(VaryTable(key=other, range=(500.0, 2000.0))),)
    given = replace(subject, settings=settings)
    with pytest.raises(InputError, match=message):
        given.case((*STIFFNESS, *more), Trial((1.0, 700.0)[: 1 + len(more)]))


def test_other_limits_are_other_measures_of_the_same_set_up(subject):
    strict = replace(subject, limits=subject.limits.model_copy(update={"wrinkle_amplitude": 1.0e-4}))
    one, other = (each.case(STIFFNESS, Trial((1.0,))) for each in (subject, strict))
    assert one.setup_hash == other.setup_hash and one.key != other.key


def test_repeats_are_other_runs_by_unevenness_or_mesh(subject):
    keys = {subject.case(STIFFNESS, Trial((1.0,), repeat=k)).key for k in range(4)}
    assert len(keys) == 4
    meshes = replace(subject, noise=NoiseTable(by="mesh", repeats=4, spread=0.2))
    sizes = [meshes._share(k) for k in range(1, 5)]
    assert sorted(sizes) == pytest.approx([0.8, 0.9, 1.1, 1.2])
    counts = {
        meshes.case(STIFFNESS, Trial((1.0,), repeat=k)).task.setups[0][1].sheet.blank.element_count for k in range(5)
    }
    assert len(counts) > 1


def test_unevenness_is_small_smooth_and_the_same_on_every_mesh(subject):
    setup = subject.case(STIFFNESS, Trial((1.0,))).task.setups[0][1]
    thrown = uneven(setup, 3, 0.02)
    velocity = thrown.sheet.initial_velocity
    assert np.sqrt(np.mean(velocity[:, 2] ** 2)) == pytest.approx(0.02) and not velocity[:, :2].any()
    assert thrown == uneven(setup, 3, 0.02) != uneven(setup, 4, 0.02)
    assert thrown.sheet.blank == setup.sheet.blank


def test_a_run_has_the_numbers_of_the_command(subject, tmp_path):
    found = compute(subject.case(STIFFNESS, Trial((1.0,))).task)
    settings = STIFFNESS[0].settings(1.0) + ['output.write=["summary"]']
    summary = flattened(run_job(subject.file(settings), tmp_path / "out"))
    assert {name: found.numbers[name] for name in summary} == summary
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["verdict"] == found.verdict
    assert found.numbers["wrinkle_count"] >= 0 and found.numbers["largest_bridging_gap_mm"] >= 0.0


def test_the_names_of_all_numbers_are_known_before_a_run(subject):
    case = subject.case(STIFFNESS, Trial((1.0,)))
    names, complete = subject.known_numbers(case)
    assert complete and {"max_shear_p99_deg", "peak_tool_force_n.ball", "max_shear_angle_deg"} <= names


def test_a_scene_is_a_subject_with_its_own_findings(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('[scene]\nname = "picture-frame"\nmesh_size = "50 mm"\n[solver]\nthreads = 1\n')
    speed = (factor_of(VaryTable(key="scene.speed", range=(0.5, 1.0))),)
    case = JobSubject(path).case(speed, Trial((1.0,)))
    found = compute(case.task)
    assert "picture-frame" in SCENES and case.task.scene == "picture-frame"
    assert found.status == "finished" and len(found.numbers) > 40


def test_another_mesh_of_a_ply_with_its_own_is_refused(tmp_path):
    job = write_small_job(tmp_path)
    text = job.read_text().replace('rectangle = ["60 mm", "60 mm"]', 'outline = "blank.inp"\nunit = "mm"')
    job.write_text(text)
    with pytest.raises(InputError):
        JobSubject(job, noise=NoiseTable(by="mesh")).case((), Trial((), repeat=1))


def test_numbers_of_stages_are_known_at_the_end(tmp_path):
    stages = '\n[[stage]]\nname = "lift"\nduration = "1 ms"\n\n[[stage]]\nname = "rest"\nduration = "1 ms"\n'
    subject = JobSubject(write_small_job(tmp_path, SMALL + stages), threads=1)
    case = subject.case((), Trial(()))
    names, complete = subject.known_numbers(case)
    assert not complete and "max_shear_angle_deg" in names
    assert compute(case.task).numbers.keys() - names
