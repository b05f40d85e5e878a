"""Every scene exists as a job, and its parameters are those of the scene."""

from pathlib import Path

import pytest

from weavesim import InputError
from weavesim.job.read import read_job
from weavesim.job.scenes import known_scenes, scene_of


def job_of(folder, text):
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return read_job(path)


@pytest.mark.parametrize("name", known_scenes())
def test_every_scene_is_a_job_with_the_same_set_ups(tmp_path, name):
    scene, parameters = scene_of(job_of(tmp_path, f'[scene]\nname = "{name}"\n'), out=Path("out"))
    assert parameters == scene.parameters(out=Path("out"))
    assert scene.setups(parameters) == known_scenes()[name].load().setups(scene.parameters())


def test_options_may_have_units_and_stand_in_the_tables_of_every_job(tmp_path):
    text = """
accept_unusual = true
[scene]
name = "double-dome"
mesh_size = "10 mm"
stroke = "61.2 mm"
punch_speed = "500 mm/s"
part = "half"
[solver]
precision = "float64"
[output]
frame_count = 7
without = ["film", "report"]
"""
    scene, parameters = scene_of(job_of(tmp_path, text), out=Path("there"), overwrite=True)
    wanted = scene.parameters(
        mesh_size=0.01, part="half", precision="float64", frame_count=7, without="film,report", out=Path("there"),
        overwrite=True, accept_unusual=True,
    )  # fmt: skip
    assert parameters == wanted


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('name = "double-dom"', "name = 'double-dom': one of .* is needed; did you mean 'double-dome'"),
        ('name = "double-dome"\nmesh_siz = 5', "line 3, .scene.: mesh_siz = 5: the scene has no such option; did you "),
        ('name = "double-dome"\nmesh_size = "5 kg"', "line 3, .scene.: mesh_size = '5 kg': 'kg' is no unit of it"),
        ('name = "double-dome"\nmesh_size = 5', "line 3, .scene.: mesh_size = 5.*write 0.005 for 5 mm"),
        ('name = "double-dome"\nout = "x"', "out: give --out to the command"),
        ('name = "double-dome"\nprecision = "float64"', r"precision: write it in \[solver\]"),
        ('name = "double-dome"\npunch = "../punch.stl"', "leads out of the folder"),
        ('name = "double-dome"\npunch = "punch.stl"', "there is no such file in the folder of the job"),
        ('name = "double-dome"\npart = "third"', "line 3, .scene.: part = 'third'"),
        ('name = "cantilever"\n[output]\nframe_count = 5\nwrite = ["nothing"]', "nothing"),
    ],
)
def test_mistakes_are_told_with_their_place(tmp_path, text, message):
    with pytest.raises(InputError, match=f"(?s)^job .*{message}"):
        scene_of(job_of(tmp_path, f"[scene]\n{text}\n"), out=Path("out"))


def test_limits_of_a_strict_job_are_those_of_its_report(tmp_path):
    file = job_of(tmp_path, '[scene]\nname = "double-dome"\n')
    (tmp_path / "limits.toml").write_text("gap = 1e-3\n")
    _, parameters = scene_of(file, out=tmp_path / "out", limits=tmp_path / "limits.toml")
    assert parameters.strict and parameters.limits == tmp_path / "limits.toml"
    assert not scene_of(file, out=tmp_path / "out")[1].strict
