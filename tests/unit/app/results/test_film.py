"""``weavesim film``."""

import json

import pytest
from typer.testing import CliRunner

from weavesim.app.command_line import application
from weavesim.errors import InputError
from weavesim.output import Film
from weavesim.run.frame import Outcome


@pytest.fixture(scope="module")
def folder(tmp_path_factory, coarse_run):
    folder = tmp_path_factory.mktemp("run")
    info, frames = coarse_run
    film = Film(folder / f"{info.name}.usdc")
    film.start(info)
    for frame in (frames[0], frames[-1]):
        film.frame(frame)
    film.finish(Outcome.FINISHED)
    (folder / "run.json").write_text(json.dumps({"name": info.name}))
    return folder


def called(*arguments):
    result = CliRunner().invoke(application, ["film", *map(str, arguments)])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def test_a_movie_and_pictures_of_a_field(folder, tmp_path):
    pytest.importorskip("pyvista")
    pytest.importorskip("imageio_ffmpeg")
    small = ("--size", 96, 64, "--fps", 2, "--out", tmp_path)
    result = called(folder, "--field", "thickness", "--mirror", "--mp4", "--png", *small)
    assert result.exit_code == 0
    assert "double_dome_thickness.mp4: 2 frames, 1 s" in result.output
    assert (tmp_path / "double_dome_thickness.mp4").stat().st_size > 1000
    assert len(list((tmp_path / "double_dome_thickness").glob("*.png"))) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("--no-mp4",), "nothing to write"), (("--field", "colour"), "the film has .*shear_angle_deg")],
)
def test_what_cannot_be_drawn_is_refused(folder, tmp_path, arguments, words):
    with pytest.raises(InputError, match=words):
        called(folder, *arguments, "--out", tmp_path)
    with pytest.raises(InputError, match="no run wrote its results"):
        called(tmp_path)
